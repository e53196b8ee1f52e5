//! Light fields from single views.

use ndarray::ArrayView3;

use super::{Layout, LightField, LightFieldOwned, ViewOrder};
use crate::{Error, GridSize, LightFieldShape};

impl<T: Copy> LightFieldOwned<T> {
    /// Copies a list of views into a light field with the memory order of `layout`.
    ///
    /// # Shape
    ///
    /// T*S images `(row, column, channel)` of equal shape, any strides.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if a count is zero; [`Error::Shape`] if an image has another shape than the first, or if
    /// there are more or fewer images than views; [`Error::TooLarge`] and [`Error::OutOfMemory`] as
    /// [`LightField::filled`].
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, Layout, LightField, ViewOrder};
    /// use ndarray::Array3;
    ///
    /// // Four images from a gantry that goes right, down, left.
    /// let images: Vec<_> = (0..4).map(|number| Array3::from_elem((5, 7, 3), number as u8)).collect();
    /// let (views, order) = (GridSize::new(2, 2), ViewOrder::Serpentine);
    /// let borrowed = images.iter().map(|image| image.view());
    /// let light_field = LightField::from_views(views, order, Layout::ViewpointGrid, borrowed)?;
    /// assert_eq!(light_field.view(1, 1)?, images[2]);
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

    fn image(number: usize) -> Array3<usize> {
        Array3::from_shape_fn((3, 4, 2), |(row, column, channel)| ((number * 3 + row) * 4 + column) * 2 + channel)
    }

    #[test]
    fn composed_light_fields_have_the_given_views_in_both_layouts_and_orders() {
        let views = GridSize::new(3, 2);
        let images: Vec<_> = (0..6).map(image).collect();
        for layout in [Layout::ElementalGrid, Layout::ViewpointGrid] {
            for order in ViewOrder::ALL {
                let borrowed = images.iter().map(|image| image.view());
                let light_field = LightField::from_views(views, order, layout, borrowed).unwrap();
                for (index, image) in images.iter().enumerate() {
                    let (t, s) = order.view(index, views).unwrap();
                    assert_eq!(light_field.view(t, s).unwrap(), image, "{layout:?} {order:?} {index}");
                }
                // The requested layout in memory: no copy is needed for the grid.
                assert_eq!(light_field.as_viewpoint_grid().is_some(), layout == Layout::ViewpointGrid);
            }
        }
    }

    #[test]
    fn wrong_lists_are_errors() {
        let images: Vec<_> = (0..5).map(image).collect();
        let compose = |rows, columns, count: usize| {
            let borrowed = images[..count].iter().map(|image| image.view());
            LightField::from_views(GridSize::new(rows, columns), ViewOrder::RowMajor, Layout::ViewpointGrid, borrowed)
        };
        assert!(compose(2, 2, 4).is_ok());
        for count in [0, 3, 5] {
            let error = compose(2, 2, count).unwrap_err();
            assert_eq!(error, Error::Shape { what: "list of views", expected: vec![4], found: vec![count] });
        }
        assert_eq!(compose(0, 2, 4).unwrap_err(), Error::ZeroCount { what: "view rows" });
        let borrowed = [images[0].view(), images[1].slice_axis(Axis(0), (..2).into())];
        let found = LightField::from_views(GridSize::new(1, 2), ViewOrder::RowMajor, Layout::ViewpointGrid, borrowed);
        assert!(matches!(found, Err(Error::Shape { what: "view", .. })));
    }
}
