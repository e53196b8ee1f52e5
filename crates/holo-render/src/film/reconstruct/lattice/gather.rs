//! Means over the pixels that see a point: of the microlenses around, those whose rays pass near to it.

use std::ops::Range;

use rayon::prelude::*;

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

/// Pixels are listed if one of so many, or fewer, has samples.
const FEW: usize = 4;

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

/// The pixels with samples, microlens by microlens, of a lattice where most pixels have none.
pub(super) struct Sampled(Vec<Vec<[u32; 2]>>);

/// A microlens and those around it that the windows of its pixels may reach.
pub(super) struct Neighborhood<'a> {
    lattice: &'a Lattice,
    sources: &'a [Source],
    sampled: Option<&'a Sampled>,
    lens: usize,
    others: Vec<Other>,
}

/// One of these microlenses, or the microlens itself.
struct Other {
    lens: usize,
    lens_type: usize,
    /// The rows or columns of the table to it, whichever are more.
    lines: usize,
    /// The way to it, in pitches.
    across: f32,
    down: f32,
}

/// The largest distance of viewpoints in a window, px along an axis. They may be half a pixel from a whole number.
fn radius(level: usize) -> f32 {
    WINDOWS[level].0.min(FARTHEST) as f32 + 0.5
}

impl Point {
    /// The pixels among `owned`, behind a microlens that is `lens_apart` pitches away, that may see near to the point;
    /// their viewpoints are `pixel - origin` from that of the pixel.
    #[inline(always)]
    fn candidates(&self, owned: &Range<usize>, origin: f64, lens_apart: f32) -> Range<usize> {
        let (beside, farthest) = (WINDOWS[self.largest].1 * self.spot, radius(self.largest));
        // Infinite without a disparity; then all viewpoints of the microlens see the point, or none.
        let ends = [(-beside - lens_apart) / self.disparity, (beside - lens_apart) / self.disparity];
        let low = f64::from(ends[0].min(ends[1]).max(-farthest));
        let high = f64::from(ends[0].max(ends[1]).min(farthest));
        let first = (origin + low).ceil().max(owned.start as f64);
        let last = (origin + high).floor().min(owned.end as f64 - 1.0);
        if first > last {
            return 0..0;
        }
        let first = first as usize;
        first..(last as usize + 1).min(first + CANDIDATES)
    }

    /// The smallest window that a pixel belongs to along an axis, and how far its viewpoint is from that of the pixel.
    #[inline(always)]
    fn level(&self, pixel: usize, origin: f64, lens_apart: f32) -> (usize, f32) {
        let apart = (pixel as f64 - origin) as f32;
        let beside = (self.disparity * apart + lens_apart).abs();
        for level in 1..=self.largest {
            if apart.abs() <= radius(level) && beside <= WINDOWS[level].1 * self.spot {
                return (level, apart);
            }
        }
        (OUTSIDE, apart)
    }

    /// Adds the samples of a pixel to a window, unless it shows something else; its viewpoint is `apart` from that of the pixel.
    #[inline(always)]
    fn add(&self, sums: &mut Gathered, source: &Source, level: usize, apart: f32) {
        let parting = (source.disparity - self.disparity).abs() * apart;
        let is_other = parting > MAX_PARTING_PX * self.spot;
        if level != OUTSIDE && source.has_samples() && !is_other {
            sums[level].add(&source.sums());
        }
    }
}

impl Line {
    /// Of these candidates.
    #[inline(always)]
    fn new(point: &Point, candidates: &Range<usize>, origin: f64, lens_apart: f32) -> Self {
        let mut out = Self {
            first: candidates.start,
            count: candidates.len(),
            levels: [OUTSIDE as u8; CANDIDATES],
            apart: [0.0; CANDIDATES],
        };
        for (number, pixel) in candidates.clone().enumerate() {
            let (level, apart) = point.level(pixel, origin, lens_apart);
            out.levels[number] = level as u8;
            out.apart[number] = apart;
        }
        out
    }
}

impl Sampled {
    /// `None` if more than one of `FEW` pixels has samples: then it is faster to look at all of them.
    pub fn find(lattice: &Lattice, sources: &[Source]) -> Option<Self> {
        let count = sources.par_iter().filter(|source| source.has_samples()).count();
        if count > sources.len() / FEW {
            return None;
        }
        let of_lens = |lens: usize| {
            let own = &lattice.lenses[lens];
            let mut out = Vec::new();
            for row in own.rows.clone() {
                for column in own.columns.clone() {
                    let place = lattice.place(row, column);
                    if lattice.owners[place] as usize == lens && sources[place].has_samples() {
                        // Numbers of rows and columns of sensors fit.
                        out.push([row as u32, column as u32]);
                    }
                }
            }
            out
        };
        Some(Self((0..lattice.lenses.len()).into_par_iter().map(of_lens).collect()))
    }
}

impl<'a> Neighborhood<'a> {
    /// Of microlens `lens`.
    pub fn new(lattice: &'a Lattice, sources: &'a [Source], sampled: Option<&'a Sampled>, lens: usize) -> Self {
        let columns = lattice.grid[1];
        let own = &lattice.lenses[lens];
        let is_wanted = |other: usize| match sampled {
            Some(Sampled(pixels)) => !pixels[other].is_empty(),
            None => !lattice.lenses[other].rows.is_empty(),
        };
        let other = |other: usize| {
            let theirs = &lattice.lenses[other];
            Other {
                lens: other,
                lens_type: theirs.lens_type,
                lines: (other / columns).abs_diff(lens / columns).max((other % columns).abs_diff(lens % columns)),
                across: (theirs.place[0] - own.place[0]) as f32,
                down: (theirs.place[1] - own.place[1]) as f32,
            }
        };
        let all = lattice.around(lens, lines(lattice, REACH as f32));
        Self { lattice, sources, sampled, lens, others: all.filter(|&other| is_wanted(other)).map(other).collect() }
    }

    /// The number of the microlens.
    pub fn lens(&self) -> usize {
        self.lens
    }

    /// The means around the pixel at `row` and `column` of the sensor, which the microlens owns, over the windows up to
    /// `largest`.
    #[inline(always)]
    pub fn gather(&self, [row, column]: [usize; 2], largest: usize) -> Gathered {
        let Self { lattice, sources, .. } = *self;
        let own = &lattice.lenses[self.lens];
        let own_place = lattice.place(row, column);
        let Source { disparity, .. } = sources[own_place];
        let point = Point { disparity, spot: lattice.spot(own.lens_type, disparity), largest };
        let mut sums = [Sums::default(); WINDOW_COUNT];
        // The smallest window is the pixel alone.
        if sources[own_place].has_samples() {
            sums[0] = sources[own_place].sums();
        }
        if largest == 0 {
            return sums;
        }
        let reach = disparity.abs() * radius(largest) + WINDOWS[largest].1 * point.spot;
        let reach = reach.min(REACH as f32);
        let lines = lines(lattice, reach);
        for other in &self.others {
            if other.lines > lines || other.across.abs().max(other.down.abs()) > reach {
                continue;
            }
            let is_alike = other.lens_type == own.lens_type;
            let spot = if is_alike { point.spot } else { lattice.spot(other.lens_type, disparity) };
            let is_comparable = spot <= MAX_SPOT_RATIO * point.spot && point.spot <= MAX_SPOT_RATIO * spot;
            if !is_comparable {
                continue;
            }
            let theirs = &lattice.lenses[other.lens];
            // Where their pixel of the same viewpoint lies.
            let x = column as f64 - own.center[0] + theirs.center[0];
            let y = row as f64 - own.center[1] + theirs.center[1];
            let rows = point.candidates(&theirs.rows, y, other.down);
            if rows.is_empty() {
                continue;
            }
            let columns = point.candidates(&theirs.columns, x, other.across);
            if columns.is_empty() {
                continue;
            }
            if let Some(Sampled(pixels)) = self.sampled {
                for pixel in &pixels[other.lens] {
                    let [row, column] = [pixel[0] as usize, pixel[1] as usize];
                    if !rows.contains(&row) || !columns.contains(&column) {
                        continue;
                    }
                    let (level, below) = point.level(row, y, other.down);
                    let (most, beside) = point.level(column, x, other.across);
                    let place = lattice.place(row, column);
                    if place != own_place {
                        point.add(&mut sums, &sources[place], level.max(most), below.abs().max(beside.abs()));
                    }
                }
                continue;
            }
            let rows = Line::new(&point, &rows, y, other.down);
            let columns = Line::new(&point, &columns, x, other.across);
            for i in 0..rows.count {
                for k in 0..columns.count {
                    let place = lattice.place(rows.first + i, columns.first + k);
                    if lattice.owners[place] as usize == other.lens && place != own_place {
                        let level = usize::from(rows.levels[i].max(columns.levels[k]));
                        let apart = rows.apart[i].abs().max(columns.apart[k].abs());
                        point.add(&mut sums, &sources[place], level, apart);
                    }
                }
            }
        }
        for level in 1..=largest {
            let smaller = sums[level - 1];
            sums[level].add(&smaller);
        }
        sums
    }
}

/// The rows or columns of the table that contain all microlenses up to `reach` pitches away.
#[inline(always)]
fn lines(lattice: &Lattice, reach: f32) -> usize {
    (f64::from(reach) * lattice.lines_per_pitch).ceil() as usize + 1
}
