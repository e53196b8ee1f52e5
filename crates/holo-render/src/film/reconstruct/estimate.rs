//! The estimates of a node at all levels, and what is left of them once a level is chosen.

use super::super::guides::luminance;
use super::choice::{self, Choice, Estimate, Evidence, LEVELS};
use super::fit::{Moments, Plane, RADII};
use super::nodes::Node;
use super::rows::Rows;

/// What the nodes around one tell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Planes {
    /// By radius.
    fits: [Plane; RADII.len()],
    /// The change of the color per microlens down and to the right.
    gradient: [[f32; 3]; 2],
    /// The mean luminance, whatever they show.
    around: f32,
}

/// A node whose level is chosen.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Finished {
    pub disparity: f32,
    /// Whether there are samples around; without any there is no color.
    pub is_known: bool,
    pub color: [f32; 3],
    /// The change of the color per microlens down and to the right.
    pub gradient: [[f32; 3]; 2],
    /// The level; below 1 the rest is the share of the pixel's own samples.
    pub level: f32,
    /// The estimated relative squared error.
    pub error: f32,
}

/// Fits planes through the nodes around node number `node` of `per_lens` behind microlens (v, u) of so many columns.
#[inline(always)]
pub(super) fn planes(
    nodes: &Rows<Node>,
    [v, u]: [usize; 2],
    (node, per_lens): (usize, usize),
    lens_columns: usize,
    count: usize,
) -> Planes {
    let mut out = Planes::default();
    let (mut moments, mut colors) = (Moments::default(), Moments::default());
    let mut inside = 0;
    let own = &nodes.row(v)[u * per_lens + node];
    // Estimates everywhere around have no plane far beside them.
    let plane = |moments: &Moments| {
        if own.is_sparse { moments.plane_or_mean_at([0.0; 2]) } else { moments.plane_at([0.0; 2]) }
    };
    let near = own.near(count);
    let own_tint = (near.weight > 0.0).then_some(near.tint);
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
                let tinted = own_tint.map_or(Some((*window, 1.0)), |tint| window.tinted(&tint));
                if let Some((window, alike)) = tinted {
                    moments.add(&window, apart, alike);
                }
            }
        }
        inside = radius;
        out.fits[k] = plane(&moments);
    }
    // What lies beside the point has the change of color, with that of the tint.
    out.gradient = plane(&colors).gradient;
    out.around = luminance(colors.mean());
    out
}

/// The values of a node at a level, 1 or more; `None` without samples.
#[inline(always)]
fn values(node: &Node, planes: &Planes, count: usize, level: usize) -> Option<[f32; 4]> {
    if level > count + 1 {
        let plane = &planes.fits[level - count - 2];
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
    let (mut out, mut offset) = (window.values, window.offset);
    if level == count + 1 {
        // The light of all views on the surface of those near the node, whose texture is the one seen there.
        let near = node.near(count);
        if let Some((window, _)) = window.tinted(&near.tint) {
            (out, offset) = (window.values, near.offset);
        }
    }
    for c in 0..3 {
        // From where the samples lie to the point.
        out[c] -= planes.gradient[0][c] * offset[0] + planes.gradient[1][c] * offset[1];
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
    let [down, across] = planes.gradient.map(luminance);
    let first = if witness.is_between && !witness.is_still { count } else { 1 };
    for level in first..choice::levels(count) {
        if let Some([r, g, b, noise]) = values(node, planes, count, level) {
            estimates[level] = Some([luminance([r, g, b]) + down * y + across * x, noise]);
        }
    }
    out.add(&estimates, choice::levels(count), planes.around, witness.is_between);
}

/// A node at its level.
#[inline(always)]
pub(super) fn finish(node: &Node, planes: &Planes, choice: Choice, count: usize) -> Finished {
    let last = choice::levels(count) - 1;
    let level = choice.level.clamp(0.0, last as f32);
    let at = |level: usize| (level.max(1)..=last).find_map(|level| values(node, planes, count, level));
    let (low, high) = (at(level.floor() as usize), at(level.ceil() as usize));
    let part = level - level.floor();
    let is_known = low.or(high).is_some();
    let (low, high) = match (low, high) {
        (Some(low), Some(high)) => (low, high),
        (Some(one), None) | (None, Some(one)) => (one, one),
        (None, None) => ([0.0; 4], [0.0; 4]),
    };
    let mut color = [0.0; 3];
    for c in 0..3 {
        color[c] = if part > 0.0 { low[c] + (high[c] - low[c]) * part } else { low[c] };
    }
    let error = choice::relative_to_own(choice.error, luminance(color).max(0.0), planes.around);
    Finished { disparity: node.disparity, is_known, color, gradient: planes.gradient, level, error }
}

/// The squared relative error of what is taken from elsewhere.
const UNKNOWN: f32 = 1.0;

/// Gives nodes of one microlens without samples around them the light of the nearest in the list that has some.
pub(super) fn fill(nodes: &mut [Finished]) {
    if nodes.iter().all(|node| node.is_known) {
        return;
    }
    let known: Vec<usize> = (0..nodes.len()).filter(|&k| nodes[k].is_known).collect();
    for k in 0..nodes.len() {
        // The nearest to a known node is the node itself.
        if let Some(&nearest) = known.iter().min_by_key(|other| other.abs_diff(k))
            && nearest != k
        {
            let Finished { color, .. } = nodes[nearest];
            nodes[k] = Finished { is_known: true, color, gradient: [[0.0; 3]; 2], error: UNKNOWN, ..nodes[k] };
        }
    }
}

/// How many independent observations a node is at each level.
pub(super) fn observations(count: usize) -> [f32; LEVELS] {
    std::array::from_fn(|level| {
        let radius = if level > count + 1 { RADII.get(level - count - 2).copied().unwrap_or(0) } else { 0 };
        1.0 / ((2 * radius + 1) * (2 * radius + 1)) as f32
    })
}
