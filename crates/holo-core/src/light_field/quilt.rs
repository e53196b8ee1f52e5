//! Quilts: views side by side in one image, in the order of multi-view displays.

use ndarray::{Array3, Axis, Data, Slice};

use super::{LightField, checked_length};
use crate::base::memory::filled;
use crate::{Error, GridSize, LightFieldShape};

/// Returns `count` evenly spaced views `(t, s)` of a row, the first and the last of the row included; for a count of 1,
/// the middle view.
///
/// # Errors
///
/// [`Error::OutOfRange`] if there is no such row; [`Error::BadRange`] if the row has fewer views or `count` is 0.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, evenly_spaced_views};
///
/// assert_eq!(evenly_spaced_views(GridSize::new(3, 9), 1, 3)?, [(1, 0), (1, 4), (1, 8)]);
/// # Ok::<(), holo_core::Error>(())
/// ```
pub fn evenly_spaced_views(views: GridSize, row: usize, count: usize) -> Result<Vec<(usize, usize)>, Error> {
    if row >= views.rows {
        return Err(Error::OutOfRange { what: "view row", index: row, count: views.rows, first: 0 });
    }
    match count {
        1 => Ok(vec![(row, views.columns / 2)]),
        2.. if count <= views.columns => {
            let last = count - 1;
            // Rounded to the nearest view.
            Ok((0..count).map(|index| (row, (2 * index * (views.columns - 1) + last) / (2 * last))).collect())
        }
        _ => Err(Error::BadRange { what: "views of a row", start: 0, end: count, count: views.columns }),
    }
}

impl<S: Data> LightField<S>
where
    S::Elem: Copy,
{
    /// Returns a list of views as one image in the order of multi-view displays: the first at the bottom left, then to
    /// the right, then row by row **upward**.
    ///
    /// This is the quilt of Looking Glass displays, whose first view is the leftmost camera. Every view is upright. The
    /// views of one row of cameras, from left to right, are `ViewPath::Sweep { row }.views(..)`.
    ///
    /// # Shape
    ///
    /// `tiles.rows * V` rows and `tiles.columns * U` columns, for `tiles.count()` views.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the length of the list is not the number of tiles; [`Error::OutOfRange`] if there is no such
    /// view; [`Error::ZeroCount`] without tiles; [`Error::TooLarge`] and [`Error::OutOfMemory`] if the image is too
    /// large.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightField, LightFieldShape, ViewPath};
    /// use ndarray::array;
    ///
    /// // Four views of one pixel each, in a row.
    /// let shape = LightFieldShape::new(GridSize::new(1, 4), GridSize::new(1, 1))?;
    /// let light_field = LightField::from_elemental_grid(array![[['a'], ['b'], ['c'], ['d']]], shape)?;
    /// let views = ViewPath::Sweep { row: 0 }.views(shape.views())?;
    /// let quilt = light_field.to_quilt(GridSize::new(2, 2), &views)?;
    /// assert_eq!(quilt, array![[['c'], ['d']], [['a'], ['b']]]);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn to_quilt(&self, tiles: GridSize, views: &[(usize, usize)]) -> Result<Array3<S::Elem>, Error> {
        if views.len() != tiles.count() {
            let (expected, found) = (vec![tiles.count()], vec![views.len()]);
            return Err(Error::Shape { what: "list of views of the quilt", expected, found });
        }
        let (lenses, channels) = (self.shape().lenses(), self.channels());
        // A quilt has the size of a viewpoint grid of `tiles` views.
        let shape = LightFieldShape::new(tiles, lenses)?;
        let memory = filled("a quilt", checked_length::<S::Elem>(&shape, channels)?, self.samples[[0, 0, 0, 0, 0]])?;
        let size = shape.raw_size();
        let mut quilt =
            Array3::from_shape_vec((size.rows, size.columns, channels), memory).expect("the length is the product");
        for (index, &(t, s)) in views.iter().enumerate() {
            let (row, column) = (tiles.rows - 1 - index / tiles.columns, index % tiles.columns);
            let (top, left) = (row * lenses.rows, column * lenses.columns);
            let mut tile = quilt.slice_axis_mut(Axis(0), Slice::from(top..top + lenses.rows));
            tile.slice_axis_inplace(Axis(1), Slice::from(left..left + lenses.columns));
            tile.assign(&self.view(t, s)?);
        }
        Ok(quilt)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Layout, ViewPath};

    fn numbered() -> LightField<ndarray::OwnedRepr<u32>> {
        let shape = LightFieldShape::new(GridSize::new(2, 6), GridSize::new(3, 4)).unwrap();
        let mut light_field = LightField::filled(shape, 2, Layout::ElementalGrid, 0).unwrap();
        for ((v, u, t, s, c), sample) in light_field.samples_mut().indexed_iter_mut() {
            *sample = (t * 10_000 + s * 1000 + v * 100 + u * 10 + c) as u32;
        }
        light_field
    }

    #[test]
    fn views_are_spread_from_end_to_end() {
        let columns = |count, all| -> Vec<usize> {
            let views = evenly_spaced_views(GridSize::new(2, all), 1, count).unwrap();
            views.into_iter().map(|(row, column)| column + 1000 * (row - 1)).collect()
        };
        assert_eq!(columns(5, 5), [0, 1, 2, 3, 4]);
        assert_eq!(columns(2, 9), [0, 8]);
        assert_eq!(columns(1, 9), [4]);
        let many = columns(48, 100);
        assert!(many.windows(2).all(|pair| (2..=3).contains(&(pair[1] - pair[0]))), "{many:?}");
        let views = GridSize::new(2, 5);
        assert!(matches!(evenly_spaced_views(views, 2, 5), Err(Error::OutOfRange { .. })));
        assert!(
            [0, 6].iter().all(|&count| matches!(evenly_spaced_views(views, 0, count), Err(Error::BadRange { .. })))
        );
    }

    #[test]
    fn first_view_is_bottom_left_and_upright() {
        let light_field = numbered();
        let views = ViewPath::Sweep { row: 1 }.views(light_field.shape().views()).unwrap();
        // Two columns and three rows of tiles of 4 x 3 pixels.
        let quilt = light_field.to_quilt(GridSize::new(3, 2), &views).unwrap();
        assert_eq!(quilt.dim(), (9, 8, 2));
        // Bottom row: views 0 and 1; middle: 2 and 3; top: 4 and 5. The pixel (0, 0) of each is its top left.
        assert_eq!((quilt[[6, 0, 0]], quilt[[6, 4, 0]]), (10_000, 11_000));
        assert_eq!((quilt[[3, 0, 0]], quilt[[3, 4, 0]]), (12_000, 13_000));
        assert_eq!((quilt[[0, 0, 0]], quilt[[0, 4, 0]]), (14_000, 15_000));
        assert_eq!(quilt[[8, 7, 1]], 11_000 + 200 + 30 + 1);
    }

    #[test]
    fn wrong_lists_are_errors() {
        let light_field = numbered();
        let tiles = GridSize::new(1, 2);
        assert!(matches!(light_field.to_quilt(tiles, &[(0, 0)]), Err(Error::Shape { .. })));
        assert!(matches!(light_field.to_quilt(tiles, &[(0, 0), (2, 0)]), Err(Error::OutOfRange { .. })));
        assert!(matches!(light_field.to_quilt(GridSize::new(0, 2), &[]), Err(Error::ZeroCount { .. })));
    }
}
