//! The rows of one stage of a reconstruction: found once, kept as long as later stages need them.

use std::collections::VecDeque;
use std::ops::Range;

/// Consecutive rows of microlenses with a value for each microlens.
pub(super) struct Rows<T> {
    first: usize,
    rows: VecDeque<Vec<T>>,
}

impl<T> Rows<T> {
    /// No rows yet; the first one that is added is row `first`.
    pub fn starting_at(first: usize) -> Self {
        Self { first, rows: VecDeque::new() }
    }

    /// The microlenses of a row that is there.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &[T] {
        &self.rows[row - self.first]
    }

    /// Adds the rows up to `end`.
    pub fn extend_to(&mut self, end: usize, mut find: impl FnMut(usize) -> Vec<T>) {
        for row in self.first + self.rows.len()..end {
            self.rows.push_back(find(row));
        }
    }

    /// Forgets the rows before `start`.
    pub fn forget_before(&mut self, start: usize) {
        while self.first < start && self.rows.pop_front().is_some() {
            self.first += 1;
        }
    }

    /// Those of some rows that are there.
    pub fn near(&self, row: usize, distance: usize) -> Range<usize> {
        row.saturating_sub(distance).max(self.first)..(row + distance + 1).min(self.first + self.rows.len())
    }
}
