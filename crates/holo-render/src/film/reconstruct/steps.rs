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
    /// The sums of a row and its neighbors above and below.
    columns: Vec<Evidence>,
    choices: Rows<Option<Choice>>,
    pub finished: Rows<Finished>,
}

/// Where nodes are, how many windows they have, and how many microlenses a row has.
#[derive(Clone, Copy)]
struct All<'a> {
    views: &'a NodeViews,
    windows: usize,
    lenses: usize,
}

/// A step of what is behind one microlens.
struct OfLens<'a, S, T> {
    step: S,
    all: All<'a>,
    lens: [usize; 2],
    /// What it finds.
    out: &'a mut [T],
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
            columns: Vec::new(),
            choices: Rows::starting_at(starting(1)),
            finished: Rows::starting_at(starting(0)),
        }
    }

    /// Finds what the pixels of row `v` need, and forgets what only those before it did.
    pub fn advance(&mut self, field: &Field, v: usize, filters: bool) {
        let [lens_rows, lenses, ..] = field.grid.shape;
        let Self { views, windows, cells, nodes, evidence, columns, choices, finished, .. } = self;
        let (windows, count) = (*windows, views.count());
        let end = |step: usize| (v + AHEAD[step] + 1).min(lens_rows);
        let levels = if filters { choice::levels(windows) } else { 1 };
        let all = All { views, windows, lenses };
        cells.extend_to(end(4), |row, out| all.row(row, 1, ToCells(field), out));
        nodes.extend_to(end(3), |row, out| all.row(row, count, ToNodes(field, cells), out));
        evidence.extend_to(end(2), |row, out| all.row(row, count, ToEvidence(field, cells, nodes), out));
        choices.extend_to(end(1), |row, out| {
            all.row(row, count, ToColumns(evidence), columns);
            all.row(row, count, ToChoices(columns, levels), out);
        });
        finished.extend_to(end(0), |row, out| all.row(row, count, ToFinished(nodes, evidence, choices), out));
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

impl All<'_> {
    /// Puts what a step finds in a row, so many values for each microlens, in place of what is in `out`.
    fn row<T: Clone + Default + Send, S: Copy + Sync>(&self, row: usize, per_lens: usize, step: S, out: &mut Vec<T>)
    where
        for<'a> OfLens<'a, S, T>: Kernel<Output = ()>,
    {
        out.resize(self.lenses * per_lens, T::default());
        let lenses = out.par_chunks_mut(per_lens).enumerate();
        lenses.for_each(|(u, out)| simd::run(OfLens { step, all: *self, lens: [row, u], out }));
    }
}

impl Kernel for OfLens<'_, ToCells<'_>, Cells> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (ToCells(field), [v, u]) = (self.step, self.lens);
        self.out[0].find(field, v, u);
    }
}

impl Kernel for OfLens<'_, ToNodes<'_>, Node> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (ToNodes(field, cells), [v, u]) = (self.step, self.lens);
        let All { views, windows: count, .. } = self.all;
        for (node, out) in self.out.iter_mut().enumerate() {
            let [t, s] = views.view(node);
            let disparity = field.line(v, t).1[u * field.grid.shape[3] + s][1];
            let windows = nodes::gather(&field.grid, cells, [v, u, t, s], disparity, count, 0..count);
            let own = &cells.row(v)[u];
            *out = Node { disparity, is_sparse: own.is_sparse(), windows, trend: own.trend_at([t, s]) };
        }
    }
}

impl Kernel for OfLens<'_, ToEvidence<'_>, (Planes, Evidence)> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (ToEvidence(_, _, nodes), [v, u]) = (self.step, self.lens);
        let All { windows, lenses, .. } = self.all;
        let count = self.out.len();
        for node in 0..count {
            let planes = estimate::planes(nodes, [v, u], (node, count), lenses, windows);
            let own = &nodes.row(v)[u * count + node];
            let mut evidence = Evidence::NONE;
            for witness in [self.witness(node, false), self.witness(node, true)].into_iter().flatten() {
                estimate::add_evidence(&mut evidence, own, &planes, &witness, windows);
            }
            self.out[node] = (planes, evidence);
        }
    }
}

impl OfLens<'_, ToEvidence<'_>, (Planes, Evidence)> {
    /// The pixel at the view of a node, or one between it and others; `None` if that takes its light from elsewhere.
    #[inline(always)]
    fn witness(&self, node: usize, is_between: bool) -> Option<Witness> {
        let (ToEvidence(field, cells, _), [v, u]) = (self.step, self.lens);
        let Grid { shape, movement, .. } = field.grid;
        let views = self.all.views;
        let at = views.view(node);
        let mut view = at;
        if is_between {
            // In another direction at each microlens, the same whichever lens rows there are.
            let half = views.farthest().map(|views| views.div_ceil(2));
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
        let is_still = cells.is_still(views.farthest_movement(&field.grid));
        Some(Witness { seen, is_between, is_still, offset })
    }
}

impl Kernel for OfLens<'_, ToColumns<'_>, Evidence> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (ToColumns(evidence), [v, u]) = (self.step, self.lens);
        let count = self.out.len();
        self.out.fill(Evidence::NONE);
        for row in evidence.near(v, LENSES) {
            for (sum, (_, own)) in self.out.iter_mut().zip(&evidence.row(row)[u * count..][..count]) {
                sum.merge(own, choice::levels(self.all.windows));
            }
        }
    }
}

impl Kernel for OfLens<'_, ToChoices<'_>, Option<Choice>> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (ToChoices(columns, levels), [_, u]) = (self.step, self.lens);
        let All { views, windows, lenses } = self.all;
        let count = self.out.len();
        let (all, observations) = (choice::levels(windows), estimate::observations(windows));
        for (node, out) in self.out.iter_mut().enumerate() {
            let mut near = Evidence::NONE;
            for column in u.saturating_sub(LENSES)..(u + LENSES + 1).min(lenses) {
                for other in views.around(node) {
                    near.merge(&columns[column * count + other], all);
                }
            }
            *out = near.choose(levels, &observations);
        }
    }
}

impl Kernel for OfLens<'_, ToFinished<'_>, Finished> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (ToFinished(nodes, evidence, choices), [v, u]) = (self.step, self.lens);
        let All { windows, lenses, .. } = self.all;
        let count = self.out.len();
        for node in 0..count {
            let (mut mean, mut sum) = (Choice::default(), 0.0);
            for row in choices.near(v, SMOOTHED) {
                for column in u.saturating_sub(SMOOTHED)..(u + SMOOTHED + 1).min(lenses) {
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
            self.out[node] = estimate::finish(&nodes.row(v)[place], &evidence.row(v)[place].0, mean, windows);
        }
        estimate::fill(self.out);
    }
}
