//! A light field out of single views, in the order in which a camera took them.

use ndarray::ArrayView3;

use super::{Layout, LightField, LightFieldOwned};
use crate::{Error, GridSize, LightFieldShape};

/// The order in which a list holds the views of a light field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ViewOrder {
    /// Row by row, every row from left to right: the numbering `t*S + s` of the HCI benchmark.
    #[default]
    RowMajor,
    /// Row by row, the first row from left to right, the next from right to left, and so on: how a gantry moves that does not
    /// travel back empty ("lawnmower", "snake").
    Serpentine,
}

impl ViewOrder {
    /// Returns the row and column `(t, s)` of the view at place `index` of the list.
    ///
    /// Any index has a view; those from `views.count()` on lie below the grid.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if the grid has no columns.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, ViewOrder};
    ///
    /// let views = GridSize::new(2, 3);
    /// assert_eq!(ViewOrder::RowMajor.view(3, views)?, (1, 0));
    /// assert_eq!(ViewOrder::Serpentine.view(3, views)?, (1, 2));
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn view(self, index: usize, views: GridSize) -> Result<(usize, usize), Error> {
        if views.columns == 0 {
            return Err(Error::ZeroCount { what: "view columns" });
        }
        let (row, column) = (index / views.columns, index % views.columns);
        let backwards = self == Self::Serpentine && row % 2 == 1;
        Ok((row, if backwards { views.columns - 1 - column } else { column }))
    }
}

impl<T: Copy> LightFieldOwned<T> {
    /// Copies a list of views into a light field, in memory as `layout` says.
    ///
    /// # Shape
    ///
    /// T*S images `(row, column, channel)` of equal shape, any strides.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if a count is zero; [`Error::Shape`] if an image has another shape than the first, or if there are more or fewer
    /// images than views; [`Error::TooLarge`] and [`Error::OutOfMemory`] as [`LightField::filled`].
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, Layout, LightField, ViewOrder};
    /// use ndarray::Array3;
    ///
    /// // Four pictures from a gantry that goes right, down, left.
    /// let pictures: Vec<_> = (0..4).map(|number| Array3::from_elem((5, 7, 3), number as u8)).collect();
    /// let images = pictures.iter().map(|picture| picture.view());
    /// let (views, order) = (GridSize::new(2, 2), ViewOrder::Serpentine);
    /// let light_field = LightField::from_views(views, order, Layout::ViewpointGrid, images)?;
    /// assert_eq!(light_field.view(1, 1)?, pictures[2]);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    pub fn from_views<'a>(
        views: GridSize,
        order: ViewOrder,
        layout: Layout,
        images: impl IntoIterator<Item = ArrayView3<'a, T>>,
    ) -> Result<Self, Error>
    where
        T: 'a,
    {
        let mut images = images.into_iter();
        let miscounted = |found: usize| {
            Err(Error::Shape { what: "list of views", expected: vec![views.count()], found: vec![found] })
        };
        let Some(first) = images.next() else { return miscounted(0) };
        let (rows, columns, channels) = first.dim();
        let shape = LightFieldShape::new(views, GridSize::new(rows, columns))?;
        let Some(&sample) = first.first() else { return Err(Error::ZeroCount { what: "channels" }) };
        let mut light_field = LightField::filled(shape, channels, layout, sample)?;
        let mut count = 0;
        for image in std::iter::once(first).chain(images) {
            if count == views.count() {
                return miscounted(count + 1);
            }
            if image.dim() != (rows, columns, channels) {
                let (expected, found) = (vec![rows, columns, channels], image.shape().to_vec());
                return Err(Error::Shape { what: "view", expected, found });
            }
            let (t, s) = order.view(count, views)?;
            light_field.view_mut(t, s)?.assign(&image);
            count += 1;
        }
        if count == views.count() { Ok(light_field) } else { miscounted(count) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array3, Axis};

    fn picture(number: usize) -> Array3<usize> {
        Array3::from_shape_fn((3, 4, 2), |(row, column, channel)| ((number * 3 + row) * 4 + column) * 2 + channel)
    }

    #[test]
    fn serpentine_turns_every_other_row() {
        let order: Vec<_> =
            (0..9).map(|index| ViewOrder::Serpentine.view(index, GridSize::new(3, 3)).unwrap()).collect();
        assert_eq!(order, [(0, 0), (0, 1), (0, 2), (1, 2), (1, 1), (1, 0), (2, 0), (2, 1), (2, 2)]);
        assert!(ViewOrder::RowMajor.view(0, GridSize::new(3, 0)).is_err());
    }

    #[test]
    fn composing_undoes_taking_apart_in_both_layouts_and_orders() {
        let views = GridSize::new(3, 2);
        let pictures: Vec<_> = (0..6).map(picture).collect();
        for layout in [Layout::ElementalGrid, Layout::ViewpointGrid] {
            for order in [ViewOrder::RowMajor, ViewOrder::Serpentine] {
                let images = pictures.iter().map(|picture| picture.view());
                let light_field = LightField::from_views(views, order, layout, images).unwrap();
                for (index, picture) in pictures.iter().enumerate() {
                    let (t, s) = order.view(index, views).unwrap();
                    assert_eq!(light_field.view(t, s).unwrap(), picture, "{layout:?} {order:?} {index}");
                }
                // In memory as asked: the grid comes out without a copy.
                assert_eq!(light_field.as_viewpoint_grid().is_some(), layout == Layout::ViewpointGrid);
            }
        }
    }

    #[test]
    fn wrong_lists_are_errors() {
        let pictures: Vec<_> = (0..5).map(picture).collect();
        let compose = |rows, columns, count: usize| {
            let images = pictures[..count].iter().map(|picture| picture.view());
            LightField::from_views(GridSize::new(rows, columns), ViewOrder::RowMajor, Layout::ViewpointGrid, images)
        };
        assert!(compose(2, 2, 4).is_ok());
        for count in [0, 3, 5] {
            let error = compose(2, 2, count).unwrap_err();
            assert_eq!(error, Error::Shape { what: "list of views", expected: vec![4], found: vec![count] });
        }
        assert_eq!(compose(0, 2, 4).unwrap_err(), Error::ZeroCount { what: "view rows" });
        let images = [pictures[0].view(), pictures[1].slice_axis(Axis(0), (..2).into())];
        let found = LightField::from_views(GridSize::new(1, 2), ViewOrder::RowMajor, Layout::ViewpointGrid, images);
        assert!(matches!(found, Err(Error::Shape { what: "view", .. })));
    }
}
