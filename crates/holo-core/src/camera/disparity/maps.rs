//! Eq. 3 for maps.

use ndarray::{Array, ArrayRef, Dimension};

use super::Disparity;
use crate::{Error, Real};

impl Disparity {
    /// Returns the disparity of every depth of a map, in pixels between adjacent views.
    ///
    /// # Shape
    ///
    /// Any; the result has the same.
    ///
    /// # Units
    ///
    /// Meters in, pixels out. `+infinity` stands for "no hit" and gives the disparity of infinity.
    ///
    /// # Accuracy
    ///
    /// [`Disparity::from_depth_m`] in `f64`, then rounded once to the element type.
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::{Disparity, Projection};
    /// use ndarray::array;
    ///
    /// let disparity = Disparity::new(12.0, 4.0, Projection::Perspective)?;
    /// let map = disparity.map_from_depth_m(&array![[2.0_f32, 4.0], [6.0, f32::INFINITY]]);
    /// assert_eq!(map, array![[3.0_f32, 0.0], [-1.0, -3.0]]);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    #[must_use]
    pub fn map_from_depth_m<T: Real, D: Dimension>(&self, depth_m: &ArrayRef<T, D>) -> Array<T, D> {
        depth_m.mapv(|depth| T::from_f64(self.from_depth_m(depth.to_f64())))
    }

    /// Returns the depth of every disparity of a map, in meters.
    ///
    /// # Shape
    ///
    /// Any; the result has the same.
    ///
    /// # Accuracy
    ///
    /// [`Disparity::to_depth_m`] in `f64`, then rounded once to the element type. A disparity that equals the disparity
    /// of infinity in the element type gives `+infinity`, so "no hit" is preserved in files of `f32`.
    ///
    /// # Errors
    ///
    /// [`Error::NoBaseline`] if the views coincide.
    pub fn map_to_depth_m<T: Real, D: Dimension>(&self, disparity_px: &ArrayRef<T, D>) -> Result<Array<T, D>, Error> {
        let to_depth_m = self.depth_function()?;
        Ok(disparity_px.mapv(to_depth_m))
    }

    fn depth_function<T: Real>(&self) -> Result<impl Fn(T) -> T, Error> {
        if self.scale_m_px() == 0.0 {
            return Err(Error::NoBaseline);
        }
        let disparity = *self;
        let at_infinity = T::from_f64(self.at_infinity_px());
        Ok(move |value: T| T::from_f64(disparity.depth_or_infinity(value.to_f64(), value == at_infinity)))
    }
}
