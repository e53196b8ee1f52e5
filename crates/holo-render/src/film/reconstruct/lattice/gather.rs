//! Means over the pixels that see a point: of the microlenses around, those whose rays pass near to it.

use std::ops::Range;

use super::super::REACH;
use super::super::cells::{MAX_PARTING_PX, Sums};
use super::{Lattice, MAX_SPOT_RATIO, Source};

/// The number of windows.
pub(super) const WINDOW_COUNT: usize = 5;

/// Of the windows: the largest distance from a viewpoint to that of the pixel, px along an axis, and the largest distance
/// of the point from what a pixel sees, in spots. Tuned on grass.
const WINDOWS: [(usize, f32); WINDOW_COUNT] = [(0, 0.0), (2, 0.1), (4, 0.15), (7, 0.15), (usize::MAX, 0.2)];

/// The largest distance of a viewpoint in a window, px along an axis.
const FARTHEST: usize = 10;

/// The largest number of pixels along an axis that a window may have of a microlens.
const CANDIDATES: usize = 2 * FARTHEST + 2;

/// The mark of a pixel that belongs to no window.
const OUTSIDE: usize = WINDOW_COUNT;

/// The sums of the samples of a pixel's nested windows.
pub(super) type Gathered = [Sums; WINDOW_COUNT];

/// The point that a pixel sees, and how far windows reach from it.
struct Point {
    disparity: f32,
    /// The width of the spot that the pixel sees, in pitches.
    spot: f32,
    /// The largest window.
    largest: usize,
}

/// The pixels behind a microlens along an axis that see near to a point.
struct Line {
    /// The first of them.
    first: usize,
    count: usize,
    /// The smallest windows that they belong to.
    levels: [u8; CANDIDATES],
    /// How far their viewpoints are from that of the pixel, px.
    apart: [f32; CANDIDATES],
}

/// The largest distance of viewpoints in a window, px along an axis. They may be half a pixel from a whole number.
fn radius(level: usize) -> f32 {
    WINDOWS[level].0.min(FARTHEST) as f32 + 0.5
}

impl Line {
    /// Of the pixels `owned`, whose viewpoints are `pixel - origin` from that of the pixel, through a microlens that is
    /// `lens_apart` pitches away; `None`: there are none.
    #[inline(always)]
    fn new(point: &Point, owned: &Range<usize>, origin: f64, lens_apart: f32) -> Option<Self> {
        let (beside, farthest) = (WINDOWS[point.largest].1 * point.spot, radius(point.largest));
        // Infinite without a disparity; then all viewpoints of the microlens see the point, or none.
        let ends = [-beside, beside].map(|beside| (beside - lens_apart) / point.disparity);
        let low = f64::from(ends[0].min(ends[1]).max(-farthest));
        let high = f64::from(ends[0].max(ends[1]).min(farthest));
        let first = (origin + low).ceil().max(owned.start as f64);
        let last = (origin + high).floor().min(owned.end as f64 - 1.0);
        if first > last {
            return None;
        }
        let first = first as usize;
        let mut out = Self { first, count: 0, levels: [OUTSIDE as u8; CANDIDATES], apart: [0.0; CANDIDATES] };
        for k in (out.first..=last as usize).take(CANDIDATES) {
            let apart = (k as f64 - origin) as f32;
            let beside = (point.disparity * apart + lens_apart).abs();
            let belongs = |level: &usize| apart.abs() <= radius(*level) && beside <= WINDOWS[*level].1 * point.spot;
            out.levels[out.count] = (1..=point.largest).find(belongs).unwrap_or(OUTSIDE) as u8;
            out.apart[out.count] = apart;
            out.count += 1;
        }
        Some(out)
    }
}

/// The means around the pixel at `row` and `column` of the sensor, which `lens` owns, over the windows up to `largest`.
#[inline(always)]
pub(super) fn gather(
    lattice: &Lattice,
    sources: &[Source],
    lens: usize,
    [row, column]: [usize; 2],
    largest: usize,
) -> Gathered {
    let own = &lattice.lenses[lens];
    let own_place = lattice.place(row, column);
    let Source { disparity, .. } = sources[own_place];
    let point = Point { disparity, spot: lattice.spot(own.lens_type, disparity), largest };
    let mut sums = [Sums::default(); WINDOW_COUNT];
    // The smallest window is the pixel alone.
    if sources[own_place].has_samples() {
        sums[0] = sources[own_place].sums();
    }
    let reach = if largest == 0 { 0.0 } else { disparity.abs() * radius(largest) + WINDOWS[largest].1 * point.spot };
    let reach = reach.min(REACH as f32);
    let lines = if largest == 0 { 0 } else { (f64::from(reach) * lattice.lines_per_pitch).ceil() as usize + 1 };
    for other in lattice.around(lens, lines) {
        let theirs = &lattice.lenses[other];
        let [across, down] = [0, 1].map(|k| (theirs.place[k] - own.place[k]) as f32);
        let spot = lattice.spot(theirs.lens_type, disparity);
        let is_comparable = spot <= MAX_SPOT_RATIO * point.spot && point.spot <= MAX_SPOT_RATIO * spot;
        if largest == 0 || across.abs().max(down.abs()) > reach || !is_comparable || theirs.rows.is_empty() {
            continue;
        }
        // Where their pixel of the same viewpoint lies.
        let [x, y] = [0, 1].map(|k| [column, row][k] as f64 - own.center[k] + theirs.center[k]);
        let Some(rows) = Line::new(&point, &theirs.rows, y, down) else { continue };
        let Some(columns) = Line::new(&point, &theirs.columns, x, across) else { continue };
        for i in 0..rows.count {
            for k in 0..columns.count {
                let level = usize::from(rows.levels[i].max(columns.levels[k]));
                let place = lattice.place(rows.first + i, columns.first + k);
                if level == OUTSIDE || lattice.owners[place] as usize != other || place == own_place {
                    continue;
                }
                let source = &sources[place];
                let apart = rows.apart[i].abs().max(columns.apart[k].abs());
                let parting = (source.disparity - disparity).abs() * apart;
                if !source.has_samples() || parting > MAX_PARTING_PX * point.spot {
                    continue;
                }
                sums[level].add(&source.sums());
            }
        }
    }
    for level in 1..=largest {
        let smaller = sums[level - 1];
        sums[level].add(&smaller);
    }
    sums
}
