//! Rotations by 180 degrees, the only operations of this crate that rotate an image.

use ndarray::{Axis, RawData};

use super::LightField;

impl<S: RawData> LightField<S> {
    /// Rotates every elemental image by 180 degrees about its center, by strides alone: no sample moves.
    ///
    /// Integral *displays* need this: the microlens in front of an elemental image rotates it, so without this rotation
    /// the displayed depth is inverted (pseudoscopic). Two rotations are the identity. Use
    /// `light_field.as_light_field_ref().rotate_elemental_images()` to keep the original.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{GridSize, LightField, LightFieldShape};
    /// use ndarray::array;
    ///
    /// // One row of two lenses with three views each.
    /// let shape = LightFieldShape::new(GridSize::new(1, 3), GridSize::new(1, 2))?;
    /// let raw = array![[[1], [2], [3], [4], [5], [6]]];
    /// let light_field = LightField::from_elemental_grid(raw, shape)?;
    /// let display = light_field.as_light_field_ref().rotate_elemental_images().to_elemental_grid()?;
    /// assert_eq!(display, array![[[3], [2], [1], [6], [5], [4]]]);
    /// let sensor = light_field.rotate_raw().to_elemental_grid()?;
    /// assert_eq!(sensor, array![[[6], [5], [4], [3], [2], [1]]]);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    #[must_use]
    pub fn rotate_elemental_images(mut self) -> Self {
        for axis in [2, 3] {
            self.samples.invert_axis(Axis(axis));
        }
        self
    }

    /// Rotates the whole raw image by 180 degrees, by strides alone: no sample moves.
    ///
    /// A sensor behind a main lens records the raw image rotated as a whole. This also rotates every elemental image
    /// and every view, and is the same in either layout.
    #[must_use]
    pub fn rotate_raw(mut self) -> Self {
        for axis in [0, 1, 2, 3] {
            self.samples.invert_axis(Axis(axis));
        }
        self
    }
}
