//! The estimates of a node at all levels, and what is left of them once a level is chosen.

use super::super::guides::luminance;
use super::choice::{self, Choice, Estimate, Evidence, LEVELS};
use super::fit::{Moments, Plane, RADII};
use super::nodes::Node;
use super::rows::Rows;

/// The planes of a node, by radius.
pub(super) type Planes = [Plane; RADII.len()];

/// A node whose level is chosen.
#[derive(Clone, Copy, Debug)]
pub(super) struct Finished {
    pub disparity: f32,
    pub color: [f32; 3],
    /// The change of the color per microlens down and to the right.
    pub gradient: [[f32; 3]; 2],
    /// The level; below 1 the rest is the share of the pixel's own samples.
    pub level: f32,
    /// The estimated relative squared error.
    pub error: f32,
}

/// The surface at a node: its disparity, which of a plane changes evenly from microlens to microlens.
struct Surface {
    disparity: f32,
    change: [f32; 2],
    /// The squared difference from it that another surface has.
    tolerance: f32,
}

/// The relative difference of the inverse depth that another surface has.
const OTHER_SURFACE: f32 = 0.02;

impl Surface {
    #[inline(always)]
    fn around(
        nodes: &Rows<Node>,
        [v, u]: [usize; 2],
        (node, per_lens): (usize, usize),
        lens_columns: usize,
        infinite: f32,
    ) -> Self {
        let at = |row: usize, column: usize| nodes.row(row)[column * per_lens + node].disparity;
        let disparity = at(v, u);
        let rows = nodes.near(v, 1);
        let above = if rows.start < v { disparity - at(v - 1, u) } else { f32::INFINITY };
        let below = if rows.end > v + 1 { at(v + 1, u) - disparity } else { f32::INFINITY };
        let left = if u > 0 { disparity - at(v, u - 1) } else { f32::INFINITY };
        let right = if u + 1 < lens_columns { at(v, u + 1) - disparity } else { f32::INFINITY };
        // An edge lies on one side.
        let smaller = |a: f32, b: f32| if a.abs() < b.abs() { a } else { b };
        let change = [smaller(above, below), smaller(left, right)].map(|x| if x.is_finite() { x } else { 0.0 });
        let tolerance = OTHER_SURFACE * (disparity - infinite);
        Self { disparity, change, tolerance: tolerance * tolerance }
    }

    /// How far a node so many microlenses down and to the right is on the surface: 0 to 1.
    #[inline(always)]
    fn part(&self, disparity: f32, [down, across]: [f32; 2]) -> f32 {
        let apart = disparity - self.disparity - self.change[0] * down - self.change[1] * across;
        let part = 1.0 - apart * apart / self.tolerance;
        // Also where disparities are no numbers.
        if part > 0.0 {
            part * part
        } else if apart == 0.0 || !self.tolerance.is_finite() {
            1.0
        } else {
            0.0
        }
    }
}

/// Fits planes through the nodes around node number `node` of `per_lens` behind microlens (v, u) of so many columns.
#[inline(always)]
pub(super) fn planes(
    nodes: &Rows<Node>,
    [v, u]: [usize; 2],
    (node, per_lens): (usize, usize),
    lens_columns: usize,
    (count, infinite): (usize, f32),
) -> Planes {
    let mut out = Planes::default();
    let (mut moments, mut colors) = (Moments::default(), Moments::default());
    let mut inside = 0;
    let own = &nodes.row(v)[u * per_lens + node];
    let own_tint = own.windows[count - 1].tint;
    let surface = Surface::around(nodes, [v, u], (node, per_lens), lens_columns, infinite);
    for (k, &radius) in RADII.iter().enumerate() {
        for row in nodes.near(v, radius) {
            let line = nodes.row(row);
            for column in u.saturating_sub(radius)..(u + radius + 1).min(lens_columns) {
                let is_inside = k > 0 && row.abs_diff(v).max(column.abs_diff(u)) <= inside;
                let window = &line[column * per_lens + node].windows[count - 1];
                if is_inside || window.weight == 0.0 {
                    continue;
                }
                let apart = [row as f32 - v as f32, column as f32 - u as f32];
                if k == 0 {
                    colors.add(window, apart, 1.0);
                }
                let part = surface.part(line[column * per_lens + node].disparity, apart);
                if part > 0.0
                    && let Some(window) = window.tinted(&own_tint)
                {
                    moments.add(&window, apart, part);
                }
            }
        }
        inside = radius;
        out[k] = moments.plane_at([0.0; 2]);
    }
    // What lies beside the point has the change of color, with that of the tint.
    out[0].gradient = colors.plane_at([0.0; 2]).gradient;
    out
}

/// The values of a node at a level, 1 or more; `None` without samples.
#[inline(always)]
fn values(node: &Node, planes: &Planes, count: usize, level: usize) -> Option<[f32; 4]> {
    if level > count + 1 {
        let plane = &planes[level - count - 2];
        return (plane.weight > 0.0).then_some(plane.values);
    }
    // The trend has more noise than the mean of all views, and less than other windows.
    let window = if level < count {
        &node.windows[level - 1]
    } else if level == count {
        &node.trend
    } else {
        &node.windows[count - 1]
    };
    if window.weight == 0.0 {
        return None;
    }
    let mut out = window.values;
    for c in 0..3 {
        // From where the samples lie to the point.
        out[c] -= planes[0].gradient[0][c] * window.offset[0] + planes[0].gradient[1][c] * window.offset[1];
    }
    Some(out)
}

/// What a pixel tells of the estimates of a node: the one at its view, or one between it and others.
#[derive(Clone, Copy)]
pub(super) struct Witness {
    /// The luminance of the pixel and its variance, or those of the few views around a pixel between nodes; if they have
    /// samples.
    pub seen: Option<Estimate>,
    /// Whether the pixel lies between nodes.
    pub is_between: bool,
    /// Whether nothing moves much there. Elsewhere pixels between nodes have windows of their own.
    pub is_still: bool,
    /// Where the point of the pixel lies beside the center of the microlens at the view of the node, px down and to the right.
    pub offset: [f32; 2],
}

/// Adds what the estimates of a node tell, as a pixel sees them.
#[inline(always)]
pub(super) fn add_evidence(out: &mut Evidence, node: &Node, planes: &Planes, witness: &Witness, count: usize) {
    let mut estimates: [Option<Estimate>; LEVELS] = [None; LEVELS];
    estimates[0] = witness.seen;
    let [y, x] = witness.offset;
    let [down, across] = planes[0].gradient.map(luminance);
    let first = if witness.is_between && !witness.is_still { count } else { 1 };
    for level in first..choice::levels(count) {
        if let Some([r, g, b, noise]) = values(node, planes, count, level) {
            estimates[level] = Some([luminance([r, g, b]) + down * y + across * x, noise]);
        }
    }
    let [r, g, b, _] = planes[RADII.len() - 1].values;
    out.add(&estimates, choice::levels(count), luminance([r, g, b]), witness.is_between);
}

/// A node at its level.
#[inline(always)]
pub(super) fn finish(node: &Node, planes: &Planes, choice: Choice, count: usize) -> Finished {
    let last = choice::levels(count) - 1;
    let level = choice.level.clamp(0.0, last as f32);
    let at = |level: usize| (level.max(1)..=last).find_map(|level| values(node, planes, count, level));
    let (low, high) = (at(level.floor() as usize), at(level.ceil() as usize));
    let part = level - level.floor();
    let (low, high) = match (low, high) {
        (Some(low), Some(high)) => (low, high),
        (Some(one), None) | (None, Some(one)) => (one, one),
        (None, None) => ([0.0; 4], [0.0; 4]),
    };
    let mut color = [0.0; 3];
    for c in 0..3 {
        color[c] = if part > 0.0 { low[c] + (high[c] - low[c]) * part } else { low[c] };
    }
    Finished { disparity: node.disparity, color, gradient: planes[0].gradient, level, error: choice.error }
}

/// How many independent observations a node is at each level.
pub(super) fn observations(count: usize) -> [f32; LEVELS] {
    std::array::from_fn(|level| {
        let radius = if level > count + 1 { RADII.get(level - count - 2).copied().unwrap_or(0) } else { 0 };
        1.0 / ((2 * radius + 1) * (2 * radius + 1)) as f32
    })
}
