//! The synthetic aperture: a weight for every view.

use ndarray::{Array2, ArrayView2};

use crate::error::positive;
use crate::light_field::checked_length;
use crate::memory::filled;
use crate::{Error, GridSize, LightFieldShape};

/// A synthetic aperture: a weight for every view of a light field.
///
/// # Units
///
/// Sizes and positions are in views: the distance between adjacent views is 1. A position is a row and a column, which
/// may be fractional. The middle of the grid is `((T-1)/2, (S-1)/2)`.
///
/// # Examples
///
/// ```
/// use holo_core::GridSize;
/// use holo_core::refocus::Aperture;
///
/// // A disc three views wide around the middle of 5 x 5 views: the middle and its four neighbors.
/// let disc = Aperture::disc(GridSize::new(5, 5), (2.0, 2.0), 2.0)?;
/// assert_eq!(disc.weights().sum(), 5.0);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Aperture {
    weights: Array2<f32>,
}

impl Aperture {
    /// Returns the aperture of all views with equal weights.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if there are no views; [`Error::TooLarge`] and [`Error::OutOfMemory`] if there are too
    /// many.
    pub fn all(views: GridSize) -> Result<Self, Error> {
        Self::from_function(views, |_, _| 1.0)
    }

    /// Returns a round aperture: the views within half the diameter of `center`, with equal weights.
    ///
    /// # Errors
    ///
    /// As [`Aperture::all`]; [`Error::BadNumber`] if the diameter is not finite and above 0, or if no view lies within
    /// it.
    pub fn disc(views: GridSize, center: (f64, f64), diameter_views: f64) -> Result<Self, Error> {
        let radius = positive("diameter of the aperture in views", diameter_views)? / 2.0;
        Self::cut_out(views, center, diameter_views, |down, right| down.hypot(right) <= radius + EDGE)
    }

    /// Returns a square aperture: the views within half the side of `center` along both axes, with equal weights.
    ///
    /// # Errors
    ///
    /// As [`Aperture::disc`].
    pub fn square(views: GridSize, center: (f64, f64), side_views: f64) -> Result<Self, Error> {
        let half = positive("side of the aperture in views", side_views)? / 2.0;
        Self::cut_out(views, center, side_views, |down, right| down.abs().max(right.abs()) <= half + EDGE)
    }

    /// Returns an aperture of Gaussian weights around `center`.
    ///
    /// # Units
    ///
    /// The standard deviation in views.
    ///
    /// # Errors
    ///
    /// As [`Aperture::disc`].
    pub fn gaussian(views: GridSize, center: (f64, f64), deviation_views: f64) -> Result<Self, Error> {
        let deviation = positive("deviation of the aperture in views", deviation_views)?;
        let aperture = Self::from_function(views, |t, s| {
            let (down, right) = (t as f64 - center.0, s as f64 - center.1);
            (-0.5 * ((down / deviation).powi(2) + (right / deviation).powi(2))).exp() as f32
        })?;
        aperture.not_empty(deviation_views)
    }

    /// Returns the aperture of the given weights, one for each view `(t, s)`.
    ///
    /// # Errors
    ///
    /// [`Error::ZeroCount`] if there are no views; [`Error::BadNumber`] if a weight is negative, infinite or NaN, or if
    /// their sum is not finite and above 0.
    pub fn from_weights(weights: Array2<f32>) -> Result<Self, Error> {
        LightFieldShape::new(GridSize::new(weights.nrows(), weights.ncols()), GridSize::new(1, 1))?;
        for &weight in &weights {
            if !(weight.is_finite() && weight >= 0.0) {
                let what = "weight of a view in the aperture";
                return Err(Error::BadNumber { what, value: f64::from(weight), need: "finite and not negative" });
            }
        }
        positive("sum of the weights of the aperture", f64::from(weights.sum()))?;
        Ok(Self { weights })
    }

    /// Returns the weights, one for each view `(t, s)`.
    #[must_use]
    pub fn weights(&self) -> ArrayView2<'_, f32> {
        self.weights.view()
    }

    /// Returns the number of views, those of weight 0 included.
    #[must_use]
    pub fn views(&self) -> GridSize {
        GridSize::new(self.weights.nrows(), self.weights.ncols())
    }

    fn cut_out(
        views: GridSize,
        center: (f64, f64),
        size_views: f64,
        inside: impl Fn(f64, f64) -> bool,
    ) -> Result<Self, Error> {
        let weight = |t: usize, s: usize| f32::from(u8::from(inside(t as f64 - center.0, s as f64 - center.1)));
        Self::from_function(views, weight)?.not_empty(size_views)
    }

    fn from_function(views: GridSize, weight: impl Fn(usize, usize) -> f32) -> Result<Self, Error> {
        let shape = LightFieldShape::new(views, GridSize::new(1, 1))?;
        let memory = filled("the weights of an aperture", checked_length::<f32>(&shape, 1)?, 0.0)?;
        let mut weights =
            Array2::from_shape_vec((views.rows, views.columns), memory).expect("the length is the product");
        for ((t, s), value) in weights.indexed_iter_mut() {
            *value = weight(t, s);
        }
        Ok(Self { weights })
    }

    /// Rejects an aperture without views, such as one whose center is NaN.
    fn not_empty(self, size_views: f64) -> Result<Self, Error> {
        if self.weights.iter().any(|&weight| weight > 0.0) {
            return Ok(self);
        }
        let what = "size of the aperture in views";
        Err(Error::BadNumber { what, value: size_views, need: "large enough to reach a view from its center" })
    }
}

/// The tolerance of the edge, in views, for rounded sizes.
const EDGE: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn apertures_contain_the_views_within_them() {
        let views = GridSize::new(3, 4);
        assert_eq!(Aperture::all(views).unwrap().weights().sum(), 12.0);
        // Around the middle of an even count: half a view away are two columns, and with a side of 2 no row but the
        // middle one.
        let square = Aperture::square(views, (1.0, 1.5), 1.0).unwrap();
        assert_eq!(square.weights(), array![[0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0]]);
        // Around the corner view, one view away: not the diagonal one.
        let disc = Aperture::disc(views, (0.0, 3.0), 2.0).unwrap();
        assert_eq!(disc.weights(), array![[0.0, 0.0, 1.0, 1.0], [0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0]]);
        let square = Aperture::square(views, (0.0, 3.0), 2.0).unwrap();
        assert_eq!(square.weights().sum(), 4.0);
        let gaussian = Aperture::gaussian(views, (1.0, 1.0), 1.0).unwrap();
        assert_eq!(gaussian.weights()[[1, 1]], 1.0);
        assert!((f64::from(gaussian.weights()[[0, 2]]) - (-1.0_f64).exp()).abs() < 1e-7);
    }

    #[test]
    fn apertures_without_views_are_errors() {
        let views = GridSize::new(3, 4);
        assert!(matches!(Aperture::disc(views, (0.5, 0.5), 0.9), Err(Error::BadNumber { .. })));
        assert!(matches!(Aperture::square(views, (9.0, 9.0), 2.0), Err(Error::BadNumber { .. })));
        assert!(Aperture::gaussian(views, (f64::NAN, 0.0), 1.0).is_err());
        for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Aperture::disc(views, (1.0, 1.0), size).is_err(), "{size}");
            assert!(Aperture::gaussian(views, (1.0, 1.0), size).is_err(), "{size}");
        }
        assert!(matches!(Aperture::all(GridSize::new(0, 4)), Err(Error::ZeroCount { .. })));
        for weights in [array![[0.0, 0.0]], array![[1.0, -1.0]], array![[1.0, f32::NAN]], array![[f32::MAX, f32::MAX]]]
        {
            assert!(Aperture::from_weights(weights).is_err());
        }
    }
}
