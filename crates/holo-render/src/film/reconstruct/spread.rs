//! The light of pixels from the nodes around them.

use super::super::guides::CHANNELS;
use super::cells::MAX_PARTING_PX;
use super::estimate::Finished;
use super::{Grid, SPREAD_REACH, Steps, is_within};
use crate::simd::Kernel;

/// The pixels of a lens row in one row of views.
pub(super) struct SpreadLine<'a> {
    pub grid: Grid,
    pub steps: &'a Steps,
    /// The lens row and the view row.
    pub place: [usize; 2],
    /// The color of the samples, which is replaced; `None` if only the error is estimated.
    pub color: Option<&'a mut [[f32; 3]]>,
    pub guides: &'a [[f32; CHANNELS]],
    pub error: &'a mut [f32],
}

/// Two nodes along an axis with their weights.
#[derive(Clone, Copy)]
struct Between {
    nodes: [usize; 2],
    weights: [f32; 2],
}

/// The nodes at these views on both sides of a view.
#[inline(always)]
fn between(nodes: &[usize], view: usize) -> Between {
    let after = nodes.partition_point(|&node| node <= view);
    if after == 0 || after == nodes.len() {
        let k = after.saturating_sub(1);
        return Between { nodes: [k; 2], weights: [1.0, 0.0] };
    }
    let [low, high] = [nodes[after - 1], nodes[after]];
    let part = (view - low) as f32 / (high - low) as f32;
    Between { nodes: [after - 1, after], weights: [1.0 - part, part] }
}

/// A column of nodes at the row of views of a line: means of the nodes above and below.
#[derive(Clone, Copy, Default)]
struct Mean {
    color: [f32; 3],
    /// The change of the color per disparity, without and with each view to the right.
    change: [[f32; 3]; 2],
    level: f32,
    error: f32,
}

/// Where the pixels of a line lie between nodes.
struct Places<'a> {
    rows: Between,
    columns: &'a [Between],
}

impl Kernel for SpreadLine<'_> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        let [_, lens_columns, _, view_columns] = self.grid.shape;
        let [along_t, along_s] = [self.steps.views.along(0), self.steps.views.along(1)];
        let columns: Vec<Between> = (0..view_columns).map(|s| between(along_s, s)).collect();
        let places = Places { rows: between(along_t, self.place[1]), columns: &columns };
        let mut means = vec![Mean::default(); along_s.len()];
        let farthest = self.steps.views.farthest_movement(&self.grid);
        for u in 0..lens_columns {
            let is_still =
                self.steps.cells.row(self.place[0])[u].is_still(farthest) && !self.has_sharp_nodes(u, &places);
            let known = self.known_lens(u);
            if is_still || self.color.is_none() {
                self.own_nodes(u, known, &places, &mut means);
            } else {
                self.any_nodes(u, known, &places);
            }
        }
    }
}

impl SpreadLine<'_> {
    /// Whether pixels between the rows of nodes of a line have windows of their own.
    #[inline(always)]
    fn has_sharp_nodes(&self, u: usize, places: &Places) -> bool {
        let views = &self.steps.views;
        let columns = views.along(1).len();
        let nodes = &self.steps.finished.row(self.place[0])[u * views.count()..][..views.count()];
        places
            .rows
            .nodes
            .iter()
            .any(|row| nodes[row * columns..][..columns].iter().any(|node| self.steps.has_own_windows(node.level, 0.0)))
    }

    /// The microlens whose nodes stand for those of microlens `u`: itself, or, if there are no samples around it, the nearest
    /// one with some. Far from all, it is itself.
    #[inline(always)]
    fn known_lens(&self, u: usize) -> [usize; 2] {
        let v = self.place[0];
        let count = self.steps.views.count();
        let is_known = |row: usize, column: usize| self.steps.finished.row(row)[column * count].is_known;
        if is_known(v, u) { [v, u] } else { self.nearest_known_lens(u, is_known) }
    }

    /// Searches squares of growing size around the microlens. Rows that are not in memory are left out.
    #[cold]
    fn nearest_known_lens(&self, u: usize, is_known: impl Fn(usize, usize) -> bool) -> [usize; 2] {
        let v = self.place[0];
        let columns = self.grid.shape[1];
        for far in 1..columns.max(SPREAD_REACH + 1) {
            let near = u.saturating_sub(far)..(u + far + 1).min(columns);
            for row in self.steps.finished.near(v, far.min(SPREAD_REACH)) {
                let is_end = row.abs_diff(v) == far;
                let found = near.clone().find(|&column| (is_end || column.abs_diff(u) == far) && is_known(row, column));
                if let Some(column) = found {
                    return [row, column];
                }
            }
        }
        [v, u]
    }

    /// The pixels behind a microlens that take their light from its own nodes, or those of `known`: nothing there moves by
    /// half a pixel between a pixel and a node.
    #[inline(always)]
    fn own_nodes(&mut self, u: usize, known: [usize; 2], places: &Places, means: &mut [Mean]) {
        let t = self.place[1];
        let [down, across] = self.grid.movement;
        let views = &self.steps.views;
        let [along_t, along_s] = [views.along(0), views.along(1)];
        let nodes = &self.steps.finished.row(known[0])[known[1] * views.count()..][..views.count()];
        for (k, mean) in means.iter_mut().enumerate() {
            *mean = Mean::default();
            for i in 0..2 {
                let (row, weight) = (places.rows.nodes[i], places.rows.weights[i]);
                let Finished { color, gradient, level, error, .. } = &nodes[row * along_s.len() + k];
                // Where the point of a pixel lies beside the center of the microlens at the node, per disparity.
                let above = down * (t as f32 - along_t[row] as f32);
                for c in 0..3 {
                    mean.color[c] += weight * color[c];
                    mean.change[0][c] += weight * gradient[0][c] * above;
                    mean.change[1][c] += weight * gradient[1][c] * across;
                }
                mean.level += weight * level;
                mean.error += weight * error;
            }
            for c in 0..3 {
                mean.change[0][c] -= mean.change[1][c] * along_s[k] as f32;
            }
        }
        for (s, between) in places.columns.iter().enumerate() {
            let place = u * places.columns.len() + s;
            let [left, right] = between.nodes.map(|k| &means[k]);
            let [a, b] = between.weights;
            self.error[place] = (a * left.error + b * right.error).max(0.0).sqrt();
            let Some(colors) = &mut self.color else { continue };
            let [_, disparity, samples, _] = self.guides[place];
            let mut value = [0.0; 3];
            for c in 0..3 {
                let mean = a * left.color[c] + b * right.color[c];
                let change = [0, 1].map(|k| a * left.change[k][c] + b * right.change[k][c]);
                value[c] = mean + disparity * (change[0] + change[1] * s as f32);
            }
            colors[place] = with_own(colors[place], samples, value, a * left.level + b * right.level);
        }
    }

    /// The pixels behind a microlens that take their light from the nodes that show the same.
    #[inline(always)]
    fn any_nodes(&mut self, u: usize, known: [usize; 2], places: &Places) {
        let [v, t] = self.place;
        let [lens_rows, lens_columns, ..] = self.grid.shape;
        let [down, across] = self.grid.movement;
        let views = &self.steps.views;
        let [along_t, along_s] = [views.along(0), views.along(1)];
        let count = views.count();
        let own_nodes = &self.steps.finished.row(known[0])[known[1] * count..][..count];
        let rows = places.rows;
        for (s, between) in places.columns.iter().enumerate() {
            let place = u * places.columns.len() + s;
            let [_, disparity, samples, _] = self.guides[place];
            // Of the nodes behind the microlens, and of those that show the same.
            let (mut error, mut level, mut seen) = (0.0, 0.0, [0.0f32; 2]);
            let (mut sum, mut accepted, mut moved) = ([0.0f32; 3], 0.0f32, 0.0f32);
            for (i, k) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let weight = rows.weights[i] * between.weights[k];
                if weight == 0.0 {
                    continue;
                }
                let node = rows.nodes[i] * along_s.len() + between.nodes[k];
                let own = &own_nodes[node];
                error += weight * own.error;
                level += weight * own.level;
                let away = [
                    down * (along_t[rows.nodes[i]] as f32 - t as f32),
                    across * (along_s[between.nodes[k]] as f32 - s as f32),
                ];
                let shift = away.map(|away| disparity * away);
                moved = moved.max(shift[0].abs()).max(shift[1].abs());
                let nearest = shift.map(|shift| -shift.round_ties_even());
                if !is_within(nearest[0].abs().max(nearest[1].abs()), SPREAD_REACH as f32) {
                    continue;
                }
                let [row, column] = [v as isize + nearest[0] as isize, u as isize + nearest[1] as isize];
                if row < 0 || column < 0 || row >= lens_rows as isize || column >= lens_columns as isize {
                    continue;
                }
                let found = &self.steps.finished.row(row as usize)[column as usize * count + node];
                let parting = (found.disparity - disparity).abs() * away[0].abs().max(away[1].abs());
                if !is_within(parting, MAX_PARTING_PX) || !found.is_known {
                    continue;
                }
                let offset = [0, 1].map(|axis| -shift[axis] - nearest[axis]);
                let Finished { color, gradient, .. } = found;
                seen[0] += weight * found.error;
                seen[1] += weight * found.level;
                for c in 0..3 {
                    sum[c] += weight * (color[c] + gradient[0][c] * offset[0] + gradient[1][c] * offset[1]);
                }
                accepted += weight;
            }
            if accepted > 0.0 {
                [error, level] = seen.map(|sum| sum / accepted);
            }
            self.error[place] = error.max(0.0).sqrt();
            let Some(colors) = &mut self.color else { continue };
            let mut value = sum.map(|sum| sum / accepted);
            if accepted == 0.0 || self.steps.has_own_windows(level, moved) {
                let alone = self.steps.alone(&self.grid, [v, u, t, s], disparity, level);
                let node = rows.nodes[0] * along_s.len() + between.nodes[0];
                let other = if accepted > 0.0 { value } else { own_nodes[node].color };
                value = alone.unwrap_or(other);
            }
            colors[place] = with_own(colors[place], samples, value, level);
        }
    }
}

/// The light of a pixel from that of nodes and, below level 1, from its own samples.
#[inline(always)]
fn with_own(own: [f32; 3], samples: f32, value: [f32; 3], level: f32) -> [f32; 3] {
    let part = if samples > 0.0 { level.min(1.0) } else { 1.0 };
    let mut out = [0.0; 3];
    for c in 0..3 {
        let mixed = if part < 1.0 { own[c] + (value[c] - own[c]) * part } else { value[c] };
        // A plane may fall below nothing.
        out[c] = mixed.max(0.0);
    }
    out
}
