//! Blocks of viewpoints that choose together.

use super::super::choice::Choice;

/// The approximate size of blocks, in views.
const BLOCK: usize = 8;

/// Blocks of views along the two axes.
#[derive(Clone, Copy)]
pub(super) struct Blocks {
    views: [usize; 2],
    counts: [usize; 2],
}

impl Blocks {
    pub fn new(views: [usize; 2]) -> Self {
        Self { views, counts: views.map(|count| count.div_ceil(BLOCK)) }
    }

    pub fn count(&self) -> usize {
        self.counts[0] * self.counts[1]
    }

    /// The block of a view.
    pub fn of(&self, view: [usize; 2]) -> usize {
        let [row, column] = [0, 1].map(|k| view[k] * self.counts[k] / self.views[k]);
        row * self.counts[1] + column
    }

    /// The average number of views of a block.
    pub fn size(&self) -> f64 {
        (self.views[0] * self.views[1]) as f64 / self.count() as f64
    }

    /// Interpolates linearly between the centers of the blocks along one axis: the lower block, and the weight of the
    /// upper one.
    fn between(&self, axis: usize, view: usize) -> (usize, f32) {
        let place = (view as f32 + 0.5) * self.counts[axis] as f32 / self.views[axis] as f32 - 0.5;
        let last = self.counts[axis] - 1;
        let place = place.clamp(0.0, last as f32);
        let lower = (place as usize).min(last.saturating_sub(1));
        (lower, place - lower as f32)
    }

    /// Interpolates the choices of a microlens at a view.
    pub fn interpolate(&self, choices: &[Choice], [t, s]: [usize; 2]) -> Choice {
        let ((top, down), (left, across)) = (self.between(0, t), self.between(1, s));
        let mut out = Choice::default();
        for (row, row_weight) in [(top, 1.0 - down), (top + 1, down)] {
            for (column, column_weight) in [(left, 1.0 - across), (left + 1, across)] {
                let weight = row_weight * column_weight;
                if weight > 0.0 {
                    let choice = choices[row * self.counts[1] + column];
                    out.level += choice.level * weight;
                    out.error += choice.error * weight;
                }
            }
        }
        out
    }
}
