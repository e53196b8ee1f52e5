//! Means over neighboring views along the disparity of a pixel: from every view the sample of the microlens that is
//! nearest to where the same point of the scene is seen.
//!
//! The point lies up to half a pixel beside the center of that microlens. Only views where it lies close are taken, near
//! ones first: at a disparity of 0.17 px every sixth view shows a point within a few hundredths of a pixel.
//!
//! A sample is left out if its own disparity says that it shows something else: if the two points move apart by more
//! than a quarter of a pixel between the two views.

use super::windows::{LEVELS, VALUES};
use super::{Field, REACH};

/// The number of windows.
pub(super) const GATHER_LEVELS: usize = 5;

/// Of the windows: the largest distance from a view to its own, in views along an axis, and the largest distance of the
/// point from the center of a microlens, px along an axis. Tuned on grass at 20 x 20 views.
pub(super) const WINDOWS: [(usize, f32); GATHER_LEVELS] = [(0, 0.0), (2, 0.1), (4, 0.15), (7, 0.15), (usize::MAX, 0.2)];

/// About how many views each window has, at disparities around 0.15 px.
pub(super) const GATHERED_VIEWS: [f64; LEVELS] = [1.0, 7.0, 18.0, 38.0, 90.0, 90.0, 90.0, 90.0];

/// The largest movement, px, of a sample against the pixel between their views.
pub(super) const MAX_PARTING_PX: f32 = 0.25;

/// The largest distance of a view in a window, in views along an axis.
pub(super) const FARTHEST: usize = 10;

/// The number of views along an axis among which a window is sought.
const CANDIDATES: usize = 2 * FARTHEST + 1;

/// The means of a pixel over nested windows.
pub(super) type Means = [[f32; VALUES]; LEVELS];

/// A row or column of views in which the point of a pixel lies close to the center of a microlens.
#[derive(Clone, Copy, Default)]
struct Line {
    view: usize,
    lens: usize,
    /// The smallest window that it belongs to.
    level: usize,
    /// How far the views are apart, in multiples of the movement per disparity.
    distance: f32,
}

/// The lines of an axis.
struct Lines {
    lines: [Line; CANDIDATES],
    count: usize,
}

impl Lines {
    /// Of the axis with `views` views and `lenses` microlenses, around a pixel that moves by `speed` microlenses from view
    /// to view; up to window `largest`.
    #[inline(always)]
    fn new([view, views]: [usize; 2], [lens, lenses]: [usize; 2], speed: f32, movement: f32, largest: usize) -> Self {
        let mut out = Self { lines: [Line::default(); CANDIDATES], count: 0 };
        let length = CANDIDATES.min(views);
        let first = view.saturating_sub(FARTHEST).min(views - length);
        for other in first..first + length {
            let apart = other as f32 - view as f32;
            let shift = speed * apart;
            let nearest = shift.round_ties_even();
            let place = lens as f32 - nearest;
            let beside = (shift - nearest).abs();
            let distance = other.abs_diff(view);
            let mut level = GATHER_LEVELS;
            for k in (0..GATHER_LEVELS).rev() {
                level = if distance <= WINDOWS[k].0 && beside <= WINDOWS[k].1 { k } else { level };
            }
            if level <= largest && nearest.abs() <= REACH as f32 && place >= 0.0 && place < lenses as f32 {
                let line = Line { view: other, lens: place as usize, level, distance: (movement * apart).abs() };
                out.lines[out.count] = line;
                out.count += 1;
            }
        }
        out
    }

    #[inline(always)]
    fn all(&self) -> &[Line] {
        &self.lines[..self.count]
    }
}

/// The means around pixel (v, u, t, s) over the windows up to `largest`; v counts the lens rows of `field`.
pub(super) fn gather(field: &Field, [v, u, t, s]: [usize; 4], largest: usize) -> Means {
    let [lens_rows, lens_columns, view_rows, view_columns] = field.shape;
    let [difference, disparity] = field.guides(v, u, t, s);
    if !disparity.is_finite() {
        // Orthographic views of what is infinitely far away.
        let [r, g, b] = field.color(v, u, t, s);
        return [[r, g, b, difference]; LEVELS];
    }
    let [down, across] = field.movement;
    let rows = Lines::new([t, view_rows], [v, lens_rows], down * disparity, down, largest);
    let columns = Lines::new([s, view_columns], [u, lens_columns], across * disparity, across, largest);
    let mut sums = [[0.0f32; VALUES]; LEVELS];
    let mut counts = [0.0f32; LEVELS];
    for row in rows.all() {
        let (colors, guides) = field.line(row.lens, row.view);
        for column in columns.all() {
            let at = column.lens * view_columns + column.view;
            let [difference, found] = guides[at];
            if (found - disparity).abs() * row.distance.max(column.distance) > MAX_PARTING_PX {
                continue;
            }
            let [r, g, b] = colors[at];
            let level = row.level.max(column.level);
            for (sum, value) in sums[level].iter_mut().zip([r, g, b, difference]) {
                *sum += value;
            }
            counts[level] += 1.0;
        }
    }
    let mut means = [[0.0; VALUES]; LEVELS];
    let (mut sum, mut count) = ([0.0; VALUES], 0.0f32);
    for level in 0..=largest {
        count += counts[level];
        for (value, part) in sum.iter_mut().zip(sums[level]) {
            *value += part;
        }
        means[level] = sum.map(|value| value / count);
    }
    means
}
