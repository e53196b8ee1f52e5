//! Eq. 5: the pixels of a grid that belong to one microlens or to one view.

use std::ops::{Range, RangeInclusive};

use crate::base::error::index_below;
use crate::{Error, LightFieldShape};

/// The pixels of one elemental image or of one view within a grid: 0-based, half-open ranges.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Block {
    /// The rows of the raw image.
    pub rows: Range<usize>,
    /// The columns of the raw image.
    pub columns: Range<usize>,
}

/// The pixels of one elemental image or of one view within a grid as in the paper and in MATLAB: 1-based, closed
/// ranges.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct OneBasedBlock {
    /// The rows of the raw image.
    pub rows: RangeInclusive<usize>,
    /// The columns of the raw image.
    pub columns: RangeInclusive<usize>,
}

impl LightFieldShape {
    /// Returns the block of the elemental image of microlens `(v, u)` in the elemental grid: T rows from `v*T`, S
    /// columns from `u*S`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such microlens.
    ///
    /// # Source
    ///
    /// Eq. 5, 0-based.
    pub fn elemental_image_block(&self, v: usize, u: usize) -> Result<Block, Error> {
        index_below("lens row", v, self.lenses().rows)?;
        index_below("lens column", u, self.lenses().columns)?;
        let (rows, columns) = (self.views().rows, self.views().columns);
        Ok(Block { rows: v * rows..(v + 1) * rows, columns: u * columns..(u + 1) * columns })
    }

    /// Returns the block of view `(t, s)` in the viewpoint grid: V rows from `t*V`, U columns from `s*U`.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if there is no such view.
    ///
    /// # Source
    ///
    /// Eq. 5, 0-based.
    pub fn view_block(&self, t: usize, s: usize) -> Result<Block, Error> {
        index_below("view row", t, self.views().rows)?;
        index_below("view column", s, self.views().columns)?;
        let (rows, columns) = (self.lenses().rows, self.lenses().columns);
        Ok(Block { rows: t * rows..(t + 1) * rows, columns: s * columns..(s + 1) * columns })
    }

    /// Returns the rows `(v-1)*T+1 ..= v*T` and columns `(u-1)*S+1 ..= u*S` of microlens `(v, u)`, with all indices
    /// from 1.
    ///
    /// The `_one_based` methods are the only 1-based ones of the crate.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if `v` or `u` is 0 or too large.
    ///
    /// # Source
    ///
    /// Eq. 5 as printed.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightFieldShape};
    ///
    /// let shape = LightFieldShape::new(GridSize::new(20, 20), GridSize::new(265, 397))?;
    /// assert_eq!(shape.elemental_image_block_one_based(1, 1)?.rows, 1..=20);
    /// assert_eq!(shape.elemental_image_block_one_based(1, 2)?.columns, 21..=40);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn elemental_image_block_one_based(&self, v: usize, u: usize) -> Result<OneBasedBlock, Error> {
        index_from_one("lens row", v, self.lenses().rows)?;
        index_from_one("lens column", u, self.lenses().columns)?;
        let (rows, columns) = (self.views().rows, self.views().columns);
        Ok(OneBasedBlock { rows: (v - 1) * rows + 1..=v * rows, columns: (u - 1) * columns + 1..=u * columns })
    }

    /// Returns the rows `(t-1)*V+1 ..= t*V` and columns `(s-1)*U+1 ..= s*U` of view `(t, s)`, with all indices
    /// from 1.
    ///
    /// # Errors
    ///
    /// [`Error::OutOfRange`] if `t` or `s` is 0 or too large.
    ///
    /// # Source
    ///
    /// Eq. 5 as printed, for the viewpoint grid.
    pub fn view_block_one_based(&self, t: usize, s: usize) -> Result<OneBasedBlock, Error> {
        index_from_one("view row", t, self.views().rows)?;
        index_from_one("view column", s, self.views().columns)?;
        let (rows, columns) = (self.lenses().rows, self.lenses().columns);
        Ok(OneBasedBlock { rows: (t - 1) * rows + 1..=t * rows, columns: (s - 1) * columns + 1..=s * columns })
    }
}

fn index_from_one(what: &'static str, index: usize, count: usize) -> Result<(), Error> {
    if (1..=count).contains(&index) { Ok(()) } else { Err(Error::OutOfRange { what, index, count, first: 1 }) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GridSize;

    /// Whether a 1-based closed range and a 0-based half-open range have the same pixels.
    fn same(paper: &RangeInclusive<usize>, ours: &Range<usize>) -> bool {
        paper.clone().map(|index| index - 1).eq(ours.clone())
    }

    #[test]
    fn the_papers_ranges_are_ours_shifted_by_one() {
        for (t, s, v, u) in [(3, 4, 5, 7), (1, 1, 1, 1), (1, 6, 2, 1), (20, 20, 3, 2)] {
            let shape = LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u)).unwrap();
            for row in 0..v {
                for column in 0..u {
                    let ours = shape.elemental_image_block(row, column).unwrap();
                    let paper = shape.elemental_image_block_one_based(row + 1, column + 1).unwrap();
                    assert!(same(&paper.rows, &ours.rows) && same(&paper.columns, &ours.columns));
                }
            }
            for row in 0..t {
                for column in 0..s {
                    let ours = shape.view_block(row, column).unwrap();
                    let paper = shape.view_block_one_based(row + 1, column + 1).unwrap();
                    assert!(same(&paper.rows, &ours.rows) && same(&paper.columns, &ours.columns));
                }
            }
        }
    }

    #[test]
    fn blocks_tile_the_raw_image() {
        let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 7)).unwrap();
        let raw = shape.raw_size();
        let mut by_lens = vec![0; raw.count()];
        let mut by_view = vec![0; raw.count()];
        let count = |owners: &mut Vec<usize>, block: Block| {
            for row in block.rows {
                for column in block.columns.clone() {
                    owners[row * raw.columns + column] += 1;
                }
            }
        };
        for v in 0..5 {
            for u in 0..7 {
                count(&mut by_lens, shape.elemental_image_block(v, u).unwrap());
            }
        }
        for t in 0..3 {
            for s in 0..4 {
                count(&mut by_view, shape.view_block(t, s).unwrap());
            }
        }
        assert!(by_lens.iter().chain(&by_view).all(|&owners| owners == 1));
    }

    #[test]
    fn indices_out_of_range_are_errors() {
        let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 7)).unwrap();
        assert_eq!(
            shape.elemental_image_block(5, 0),
            Err(Error::OutOfRange { what: "lens row", index: 5, count: 5, first: 0 })
        );
        assert_eq!(
            shape.view_block(0, 4),
            Err(Error::OutOfRange { what: "view column", index: 4, count: 4, first: 0 })
        );
        assert_eq!(
            shape.elemental_image_block_one_based(0, 1),
            Err(Error::OutOfRange { what: "lens row", index: 0, count: 5, first: 1 })
        );
        assert!(shape.elemental_image_block_one_based(5, 7).is_ok());
        assert!(shape.view_block_one_based(4, 1).is_err());
        assert!(shape.view_block_one_based(usize::MAX, usize::MAX).is_err());
    }
}
