//! The steps of a reconstruction, row by row of microlenses.

use rayon::prelude::*;

use super::super::guides::luminance;
use super::cells::Cells;
use super::choice::{self, Choice, Evidence, LENSES};
use super::estimate::{self, Finished, Planes, Witness};
use super::nodes::{self, Node, NodeViews};
use super::rows::Rows;
use super::{AHEAD, Field, Grid, SMOOTHED, is_within};
use crate::simd::{self, Kernel};

/// What the steps have found of the rows around the one that is reconstructed.
pub(super) struct Steps {
    pub views: NodeViews,
    /// The number of windows.
    windows: usize,
    /// The level of the first window that reaches from a node to the next.
    first_wide: usize,
    pub cells: Rows<Cells>,
    nodes: Rows<Node>,
    evidence: Rows<(Planes, Evidence)>,
    choices: Rows<Option<Choice>>,
    pub finished: Rows<Finished>,
}

/// A step of what is behind one microlens.
#[derive(Clone, Copy)]
struct OfLens<'a, S> {
    step: S,
    /// Where nodes are, and how many windows they have.
    views: &'a NodeViews,
    windows: usize,
    lenses: usize,
    lens: [usize; 2],
}

/// Finds cells.
#[derive(Clone, Copy)]
struct ToCells<'a>(&'a Field<'a>);

/// Finds nodes.
#[derive(Clone, Copy)]
struct ToNodes<'a>(&'a Field<'a>, &'a Rows<Cells>);

/// Finds the planes through nodes, and what their estimates tell.
#[derive(Clone, Copy)]
struct ToEvidence<'a>(&'a Field<'a>, &'a Rows<Cells>, &'a Rows<Node>);

/// Adds up the evidence of the neighbors above and below.
#[derive(Clone, Copy)]
struct ToColumns<'a>(&'a Rows<(Planes, Evidence)>);

/// Chooses among this many levels, from such columns of evidence of the neighbors on both sides, and of the nodes around.
#[derive(Clone, Copy)]
struct ToChoices<'a>(&'a [Evidence], usize);

/// Finishes nodes at the levels that they and their neighbors have chosen.
#[derive(Clone, Copy)]
struct ToFinished<'a>(&'a Rows<Node>, &'a Rows<(Planes, Evidence)>, &'a Rows<Option<Choice>>);

impl Steps {
    /// Nothing is found yet; `first` is the first row that will be reconstructed.
    pub fn new(shape: [usize; 4], first: usize) -> Self {
        let views = [shape[2], shape[3]];
        let windows = nodes::window_count(views);
        let [down, across] = NodeViews::new(views).farthest();
        let farthest = down.max(across);
        let starting = |step: usize| first.saturating_sub(AHEAD[step]);
        Self {
            views: NodeViews::new(views),
            windows,
            first_wide: (0..windows).find(|&k| nodes::window(k, windows).0 >= farthest as f32).unwrap_or(0) + 1,
            cells: Rows::starting_at(starting(4)),
            nodes: Rows::starting_at(starting(3)),
            evidence: Rows::starting_at(starting(2)),
            choices: Rows::starting_at(starting(1)),
            finished: Rows::starting_at(starting(0)),
        }
    }

    /// Finds what the pixels of row `v` need, and forgets what only those before it did.
    pub fn advance(&mut self, field: &Field, v: usize, filters: bool) {
        let [lens_rows, lenses, ..] = field.grid.shape;
        let Self { views, windows, cells, nodes, evidence, choices, finished, .. } = self;
        let (views, windows) = (&*views, *windows);
        let end = |step: usize| (v + AHEAD[step] + 1).min(lens_rows);
        let levels = if filters { choice::levels(windows) } else { 1 };
        let all = OfLens { step: (), views, windows, lenses, lens: [0; 2] };
        cells.extend_to(end(4), |row| all.row(row, ToCells(field)));
        nodes.extend_to(end(3), |row| all.row(row, ToNodes(field, cells)));
        evidence.extend_to(end(2), |row| all.row(row, ToEvidence(field, cells, nodes)));
        choices.extend_to(end(1), |row| {
            let columns = all.row(row, ToColumns(evidence));
            all.row(row, ToChoices(&columns, levels))
        });
        finished.extend_to(end(0), |row| all.row(row, ToFinished(nodes, evidence, choices)));
        let start = |step: usize| (v + 1).saturating_sub(AHEAD[step]);
        cells.forget_before(start(4));
        nodes.forget_before(start(3));
        evidence.forget_before(start(2));
        choices.forget_before(start(1));
        finished.forget_before(v.saturating_sub(AHEAD[0]));
    }

    /// Whether pixels at a level, whose nodes see its point `moved` px away, have windows of their own: these are smaller than
    /// the distance of nodes, or the point lies elsewhere between microlenses than that of a node, and light is not smooth.
    #[inline(always)]
    pub fn has_own_windows(&self, level: f32, moved: f32) -> bool {
        level < self.first_wide as f32 || moved > 0.25 && level < self.windows as f32
    }

    /// The light of a pixel from windows of its own, at about this level or the next with samples; `None` without any.
    #[inline(always)]
    pub fn alone(&self, grid: &Grid, pixel: [usize; 4], disparity: f32, level: f32) -> Option<[f32; 3]> {
        let last = self.windows - 1;
        let level = (level - 1.0).clamp(0.0, last as f32);
        let (low, part) = (level.floor() as usize, level - level.floor());
        let wanted = low..(low + 2).min(self.windows);
        let windows = nodes::gather(grid, &self.cells, pixel, disparity, self.windows, wanted.clone());
        let color = |k: usize| (windows[k].weight > 0.0).then(|| [0, 1, 2].map(|c| windows[k].values[c]));
        match (color(low), color(wanted.end - 1)) {
            (Some(low), Some(high)) => Some(std::array::from_fn(|c| low[c] + (high[c] - low[c]) * part)),
            (None, Some(one)) | (Some(one), None) => Some(one),
            (None, None) => {
                let windows =
                    nodes::gather(grid, &self.cells, pixel, disparity, self.windows, wanted.end - 1..self.windows);
                let found = windows.iter().find(|window| window.weight > 0.0)?;
                Some([found.values[0], found.values[1], found.values[2]])
            }
        }
    }
}

impl<'a> OfLens<'a, ()> {
    /// What a step finds in a row.
    fn row<T: Send, S: Copy + Sync + Send>(&self, row: usize, step: S) -> Vec<T>
    where
        OfLens<'a, S>: Kernel<Output = Vec<T>>,
    {
        let Self { views, windows, lenses, .. } = *self;
        let of_lens = |u: usize| simd::run(OfLens { step, views, windows, lenses, lens: [row, u] });
        (0..lenses).into_par_iter().flat_map_iter(of_lens).collect()
    }
}

impl Kernel for OfLens<'_, ToCells<'_>> {
    type Output = Vec<Cells>;

    #[inline(always)]
    fn run(self) -> Vec<Cells> {
        let (ToCells(field), [v, u]) = (self.step, self.lens);
        vec![Cells::new(field, v, u)]
    }
}

impl Kernel for OfLens<'_, ToNodes<'_>> {
    type Output = Vec<Node>;

    #[inline(always)]
    fn run(self) -> Vec<Node> {
        let (ToNodes(field, cells), [v, u]) = (self.step, self.lens);
        let mut out = Vec::with_capacity(self.views.count());
        for node in 0..self.views.count() {
            let [t, s] = self.views.view(node);
            let disparity = field.line(v, t).1[u * field.grid.shape[3] + s][1];
            let windows = nodes::gather(&field.grid, cells, [v, u, t, s], disparity, self.windows, 0..self.windows);
            let own = &cells.row(v)[u];
            out.push(Node { disparity, is_sparse: own.is_sparse(), windows, trend: own.trend_at([t, s]) });
        }
        out
    }
}

impl Kernel for OfLens<'_, ToEvidence<'_>> {
    type Output = Vec<(Planes, Evidence)>;

    #[inline(always)]
    fn run(self) -> Vec<(Planes, Evidence)> {
        let (ToEvidence(_, _, nodes), [v, u]) = (self.step, self.lens);
        let count = self.views.count();
        let mut out = Vec::with_capacity(count);
        for node in 0..count {
            let planes = estimate::planes(nodes, [v, u], (node, count), self.lenses, self.windows);
            let own = &nodes.row(v)[u * count + node];
            let mut evidence = Evidence::NONE;
            for witness in [self.witness(node, false), self.witness(node, true)].into_iter().flatten() {
                estimate::add_evidence(&mut evidence, own, &planes, &witness, self.windows);
            }
            out.push((planes, evidence));
        }
        out
    }
}

impl OfLens<'_, ToEvidence<'_>> {
    /// The pixel at the view of a node, or one between it and others; `None` if that takes its light from elsewhere.
    #[inline(always)]
    fn witness(&self, node: usize, is_between: bool) -> Option<Witness> {
        let (ToEvidence(field, cells, _), [v, u]) = (self.step, self.lens);
        let Grid { shape, movement, .. } = field.grid;
        let at = self.views.view(node);
        let mut view = at;
        if is_between {
            // In another direction at each microlens, the same whichever lens rows there are.
            let half = self.views.farthest().map(|views| views.div_ceil(2));
            for axis in 0..2 {
                let towards_end = (u >> axis).is_multiple_of(2);
                view[axis] = if towards_end { at[axis] + half[axis] } else { at[axis].saturating_sub(half[axis]) };
                view[axis] = view[axis].min(shape[axis + 2] - 1);
            }
        }
        let [t, s] = view;
        let (colors, guides) = field.line(v, t);
        let place = u * shape[3] + s;
        let [_, disparity, samples, _] = guides[place];
        let offset = [0, 1].map(|axis| movement[axis] * disparity * (view[axis] as f32 - at[axis] as f32));
        if !is_within(offset[0].abs().max(offset[1].abs()), 0.5) {
            return None;
        }
        let cells = &cells.row(v)[u];
        let mut seen = None;
        if is_between {
            let cell = view.map(|view| view / cells.size);
            let sums = cells.sums(&(cell[0]..cell[0] + 1), &(cell[1]..cell[1] + 1));
            if sums.weight > 0.0 {
                let [r, g, b, variance] = sums.means();
                seen = Some([luminance([r, g, b]), variance]);
            }
        } else if samples > 0.0 {
            // The variance of a sample is that of those around.
            let around = cells.sums_around(view);
            seen = Some([luminance(colors[place]), around.variance / around.weight / samples]);
        }
        let is_still = cells.is_still(self.views.farthest_movement(&field.grid));
        Some(Witness { seen, is_between, is_still, offset })
    }
}

impl Kernel for OfLens<'_, ToColumns<'_>> {
    type Output = Vec<Evidence>;

    #[inline(always)]
    fn run(self) -> Vec<Evidence> {
        let (ToColumns(evidence), [v, u]) = (self.step, self.lens);
        let count = self.views.count();
        let mut out = vec![Evidence::NONE; count];
        for row in evidence.near(v, LENSES) {
            for (sum, (_, own)) in out.iter_mut().zip(&evidence.row(row)[u * count..][..count]) {
                sum.merge(own);
            }
        }
        out
    }
}

impl Kernel for OfLens<'_, ToChoices<'_>> {
    type Output = Vec<Option<Choice>>;

    #[inline(always)]
    fn run(self) -> Vec<Option<Choice>> {
        let (ToChoices(columns, levels), [_, u]) = (self.step, self.lens);
        let count = self.views.count();
        let observations = estimate::observations(self.windows);
        let mut out = Vec::with_capacity(count);
        for node in 0..count {
            let mut near = Evidence::NONE;
            for column in u.saturating_sub(LENSES)..(u + LENSES + 1).min(self.lenses) {
                self.views.around(node).for_each(|other| near.merge(&columns[column * count + other]));
            }
            out.push(near.choose(levels, &observations));
        }
        out
    }
}

impl Kernel for OfLens<'_, ToFinished<'_>> {
    type Output = Vec<Finished>;

    #[inline(always)]
    fn run(self) -> Vec<Finished> {
        let (ToFinished(nodes, evidence, choices), [v, u]) = (self.step, self.lens);
        let count = self.views.count();
        let mut out = Vec::with_capacity(count);
        for node in 0..count {
            let (mut mean, mut sum) = (Choice::default(), 0.0);
            for row in choices.near(v, SMOOTHED) {
                for column in u.saturating_sub(SMOOTHED)..(u + SMOOTHED + 1).min(self.lenses) {
                    if let Some(choice) = choices.row(row)[column * count + node] {
                        mean.level += choice.level;
                        mean.error += choice.error;
                        sum += 1.0;
                    }
                }
            }
            if sum > 0.0 {
                (mean.level, mean.error) = (mean.level / sum, mean.error / sum);
            }
            let place = u * count + node;
            out.push(estimate::finish(&nodes.row(v)[place], &evidence.row(v)[place].0, mean, self.windows));
        }
        estimate::fill(&mut out);
        out
    }
}
