//! Nodes: the pixels at which the light field is estimated: of n views along an axis about half the square root of n.
//!
//! A node takes the [cells](super::cells) that see its point of the scene: of its own microlens, and, where the image moves
//! from view to view, of others along the disparity. Their means over nested windows of views are its first estimates
//! ([`WINDOWS`]). A sample lies up to half a pixel beside the point; a window knows where its samples lie on average, so
//! that no shift is rounded.
//!
//! A cell is left out if its disparity says that it shows something else: if the two points move apart by more than a
//! quarter of a pixel between the two views.

use std::ops::Range;

use super::cells::{Cells, MAX_PARTING_PX, Sums};
use super::fit::Window;
use super::rows::Rows;
use super::{Grid, REACH, is_within};

/// The largest number of windows of a node.
pub(super) const WINDOW_COUNT: usize = 5;

/// Of the windows: the largest distance from a view to that of the node, in views along an axis, and the largest distance of
/// the point from the center of a microlens, px along an axis.
const WINDOWS: [(f32, f32); WINDOW_COUNT] = [(2.5, 0.1), (5.0, 0.15), (9.0, 0.15), (20.0, 0.2), (f32::INFINITY, 0.5)];

/// The first estimates of a node.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Node {
    pub disparity: f32,
    /// Whether some of the views behind its microlens have no samples.
    pub is_sparse: bool,
    pub windows: [Window; WINDOW_COUNT],
    /// The light of the microlens as it changes from view to view, at the view of the node.
    pub trend: Window,
}

impl Node {
    /// The window whose tint is that of the node: where there are more than about 20 views, those at most 20 views away,
    /// because over all views a texture may move by a pixel; otherwise, or without samples there, the window of all views.
    #[inline(always)]
    pub fn near(&self, count: usize) -> &Window {
        let near = if count == WINDOW_COUNT { &self.windows[count - 2] } else { &self.windows[count - 1] };
        if near.weight > 0.0 { near } else { &self.windows[count - 1] }
    }
}

/// The views of the nodes along the two axes, the same behind every microlens.
#[derive(Clone, Debug)]
pub(super) struct NodeViews {
    views: [usize; 2],
    axes: [Vec<usize>; 2],
}

impl NodeViews {
    /// Of this many rows and columns of views.
    pub fn new(views: [usize; 2]) -> Self {
        let axis = |views: usize| {
            let count = ((views as f64).sqrt() / 2.0).ceil().max(3.0).min(views as f64) as usize;
            (0..count).map(|k| ((2 * k + 1) * views / count - 1) / 2).collect()
        };
        Self { views, axes: views.map(axis) }
    }

    /// Along axis 0 (rows) or 1 (columns).
    pub fn along(&self, axis: usize) -> &[usize] {
        &self.axes[axis]
    }

    /// The largest distances of a view from a node between whose views it lies, or from the last node, in rows and columns.
    pub fn farthest(&self) -> [usize; 2] {
        [0, 1].map(|axis| {
            let nodes = &self.axes[axis];
            let between = nodes.windows(2).map(|pair| pair[1] - pair[0]).max().unwrap_or(0);
            let before = nodes.first().copied().unwrap_or(0);
            between.max(before).max(self.views[axis].saturating_sub(1) - nodes.last().copied().unwrap_or(0))
        })
    }

    /// The farther of these in views times the movement per disparity.
    #[inline(always)]
    pub fn farthest_movement(&self, grid: &Grid) -> f32 {
        let [down, across] = self.farthest();
        (grid.movement[0] * down as f32).max(grid.movement[1] * across as f32)
    }

    /// The number of nodes behind a microlens.
    pub fn count(&self) -> usize {
        self.axes[0].len() * self.axes[1].len()
    }

    /// A node and those beside it.
    pub fn around(&self, node: usize) -> impl Iterator<Item = usize> {
        let [rows, columns] = [0, 1].map(|axis| self.axes[axis].len());
        let near = |k: usize, count: usize| k.saturating_sub(1)..(k + 2).min(count);
        near(node / columns, rows).flat_map(move |row| near(node % columns, columns).map(move |k| row * columns + k))
    }

    /// The view of a node.
    pub fn view(&self, node: usize) -> [usize; 2] {
        let columns = self.axes[1].len();
        [self.axes[0][node / columns], self.axes[1][node % columns]]
    }
}

/// The windows of a light field with this many rows and columns of views: all but those that differ only beside the views.
pub(super) fn window_count(views: [usize; 2]) -> usize {
    let farthest = views[0].max(views[1]).saturating_sub(1) as f32;
    WINDOWS.iter().filter(|(distance, _)| *distance < farthest).count() + 1
}

/// The limits of window `k` of `count`: the last one has all views.
pub(super) fn window(k: usize, count: usize) -> (f32, f32) {
    if k + 1 == count { WINDOWS[WINDOW_COUNT - 1] } else { WINDOWS[k] }
}

/// The rows or columns of cells of each window, in which the point of a node lies close to the center of a microlens.
type Lines = [Range<usize>; WINDOW_COUNT];

/// A node along an axis.
struct Axis {
    lens: usize,
    view: usize,
    /// By how much its point moves from view to view, px.
    speed: f32,
}

impl Axis {
    /// Finds them in the cells of microlens number `lens`.
    #[inline(always)]
    fn lines(&self, cells: &Cells, axis: usize, lens: usize, (count, wanted): (usize, &Range<usize>)) -> Lines {
        let Self { view, speed, .. } = *self;
        let apart = lens as f32 - self.lens as f32;
        let size = cells.size as f32;
        let last = cells.counts[axis];
        let mut out = [const { 0..0 }; WINDOW_COUNT];
        for k in wanted.clone() {
            let (distance, beside) = window(k, count);
            // Those with | apart + speed * away | below `beside`.
            let ends = [(-beside - apart) / speed, (beside - apart) / speed];
            let (mut low, mut high) = (ends[0].min(ends[1]).max(-distance), ends[0].max(ends[1]).min(distance));
            if speed == 0.0 {
                (low, high) = if apart.abs() <= beside { (-distance, distance) } else { (1.0, 0.0) };
            }
            if low > high {
                continue;
            }
            // The middle of a cell is ((2 k + 1) size - 1) / 2; that of the last one may lie before it.
            let place = |away: f32| (view as f32 + away - (size - 1.0) / 2.0) / size;
            let mut range = (place(low).ceil().max(0.0) as usize).min(last)
                ..(place(high).floor() + 1.0).clamp(0.0, last as f32) as usize;
            let of_last = cells.middle(axis, last - 1) - view as f32;
            if range.end + 1 == last && of_last <= high {
                range.end = last;
            }
            if range.end == last && of_last < low {
                range.end -= 1;
            }
            if range.start < range.end {
                out[k] = range;
            }
        }
        out
    }

    /// Those of the microlenses `near`, whose cells have the size of these.
    #[inline(always)]
    fn all_lines(
        &self,
        cells: &Cells,
        axis: usize,
        near: &Range<usize>,
        wanted: (usize, &Range<usize>),
    ) -> [Lines; 2 * REACH + 1] {
        let mut out = [const { [const { 0..0 }; WINDOW_COUNT] }; 2 * REACH + 1];
        for lens in near.clone() {
            out[lens - near.start] = self.lines(cells, axis, lens, wanted);
        }
        out
    }
}

/// The `wanted` ones of `count` windows of the pixel at view (t, s) of microlens (v, u), which shows something of this
/// disparity.
#[inline(always)]
pub(super) fn gather(
    grid: &Grid,
    cells: &Rows<Cells>,
    [v, u, t, s]: [usize; 4],
    disparity: f32,
    count: usize,
    wanted: Range<usize>,
) -> [Window; WINDOW_COUNT] {
    let [lens_rows, lens_columns, view_rows, view_columns] = grid.shape;
    let [down, across] = grid.movement;
    let [speed_down, speed_across] = [down * disparity, across * disparity];
    let mut sums = [Sums::default(); WINDOW_COUNT];
    let mut offsets = [[0.0f32; 2]; WINDOW_COUNT];
    let (distance, _) = window(wanted.end - 1, count);
    let farthest = [t.max(view_rows - 1 - t) as f32, s.max(view_columns - 1 - s) as f32].map(|far| far.min(distance));
    let reach = |speed: f32, farthest: f32| ((speed.abs() * farthest + 0.5) as usize).min(REACH);
    let (reach_down, reach_across) = (reach(speed_down, farthest[0]), reach(speed_across, farthest[1]));
    let longest = (down * farthest[0]).max(across * farthest[1]);
    let near = [
        v.saturating_sub(reach_down)..(v + reach_down + 1).min(lens_rows),
        u.saturating_sub(reach_across)..(u + reach_across + 1).min(lens_columns),
    ];
    let largest = wanted.end - 1;
    let axes = [Axis { lens: v, view: t, speed: speed_down }, Axis { lens: u, view: s, speed: speed_across }];
    // Lines depend on the size of cells alone, which most microlenses around share with that of the node.
    let own = &cells.row(v)[u];
    let down_lines = axes[0].all_lines(own, 0, &near[0], (count, &wanted));
    let across_lines = axes[1].all_lines(own, 1, &near[1], (count, &wanted));
    for row in near[0].clone() {
        for column in near[1].clone() {
            let cells = &cells.row(row)[column];
            if cells.is_empty() {
                continue;
            }
            let others;
            let [rows, columns] = if cells.size == own.size {
                [&down_lines[row - near[0].start], &across_lines[column - near[1].start]]
            } else {
                let rows = axes[0].lines(cells, 0, row, (count, &wanted));
                others = [rows, axes[1].lines(cells, 1, column, (count, &wanted))];
                [&others[0], &others[1]]
            };
            if rows[largest].is_empty() || columns[largest].is_empty() {
                continue;
            }
            let apart = [row as f32 - v as f32, column as f32 - u as f32];
            let [low, high] = cells.disparity_range;
            let parting = (low - disparity).abs().max((high - disparity).abs()) * longest;
            let mut add = |k: usize, own: &Sums| {
                if own.weight > 0.0 {
                    sums[k].add(own);
                    let away = [cells.away(own, 0, t), cells.away(own, 1, s)];
                    offsets[k][0] += own.weight * (apart[0] + speed_down * away[0]);
                    offsets[k][1] += own.weight * (apart[1] + speed_across * away[1]);
                }
            };
            if parting <= MAX_PARTING_PX {
                for k in wanted.clone() {
                    add(k, &cells.sums(&rows[k], &columns[k]));
                }
            } else {
                for row in rows[largest].clone() {
                    let below = (cells.middle(0, row) - t as f32).abs() * down;
                    for column in columns[largest].clone() {
                        let beside = (cells.middle(1, column) - s as f32).abs() * across;
                        let found = cells.disparities[row * cells.counts[1] + column];
                        if !is_within((found - disparity).abs() * below.max(beside), MAX_PARTING_PX) {
                            continue;
                        }
                        let own = cells.sums(&(row..row + 1), &(column..column + 1));
                        for k in wanted.clone().filter(|&k| rows[k].contains(&row) && columns[k].contains(&column)) {
                            add(k, &own);
                        }
                    }
                }
            }
        }
    }
    windows(&sums, &offsets, wanted)
}

/// The `wanted` windows with these sums of samples and of their offsets.
#[inline(always)]
fn windows(
    sums: &[Sums; WINDOW_COUNT],
    offsets: &[[f32; 2]; WINDOW_COUNT],
    wanted: Range<usize>,
) -> [Window; WINDOW_COUNT] {
    let mut out = [Window::default(); WINDOW_COUNT];
    for k in wanted {
        let all = &sums[k];
        if all.weight > 0.0 {
            let offset = offsets[k].map(|sum| sum / all.weight);
            let tint = all.tint.map(|sum| sum / all.weight);
            out[k] = Window { values: all.means(), offset, weight: all.weight, tint };
        }
    }
    out
}
