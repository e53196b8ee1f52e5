//! The rows of one stage of a reconstruction: found once, kept as long as later stages need them.

use std::collections::VecDeque;
use std::ops::Range;

/// Consecutive rows of microlenses with as many values for each microlens.
pub(super) struct Rows<T> {
    first: usize,
    rows: VecDeque<Vec<T>>,
    /// Forgotten rows, whose memory is used again.
    spare: Vec<Vec<T>>,
}

impl<T> Rows<T> {
    /// No rows yet; the first one that is added is row `first`.
    pub fn starting_at(first: usize) -> Self {
        Self { first, rows: VecDeque::new(), spare: Vec::new() }
    }

    /// The microlenses of a row that is there.
    #[inline(always)]
    pub fn row(&self, row: usize) -> &[T] {
        &self.rows[row - self.first]
    }

    /// Adds the rows up to `end`; `find` writes their values over old ones, or over none.
    pub fn extend_to(&mut self, end: usize, mut find: impl FnMut(usize, &mut Vec<T>)) {
        for row in self.first + self.rows.len()..end {
            let mut values = self.spare.pop().unwrap_or_default();
            find(row, &mut values);
            self.rows.push_back(values);
        }
    }

    /// Forgets the rows before `start`.
    pub fn forget_before(&mut self, start: usize) {
        while self.first < start
            && let Some(values) = self.rows.pop_front()
        {
            self.spare.push(values);
            self.first += 1;
        }
    }

    /// Those of some rows that are there.
    pub fn near(&self, row: usize, distance: usize) -> Range<usize> {
        row.saturating_sub(distance).max(self.first)..(row + distance + 1).min(self.first + self.rows.len())
    }
}
