//! The synthetic aperture: a weight for every view.

use std::str::FromStr;

use ndarray::{Array2, ArrayView2};

use crate::base::error::positive;
use crate::base::memory::filled;
use crate::light_field::checked_length;
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
        positive("diameter of the aperture in views", diameter_views)?;
        Self::sized(views, center, diameter_views, ApertureShape::Disc)
    }

    /// Returns a square aperture: the views within half the side of `center` along both axes, with equal weights.
    ///
    /// # Errors
    ///
    /// As [`Aperture::disc`].
    pub fn square(views: GridSize, center: (f64, f64), side_views: f64) -> Result<Self, Error> {
        positive("side of the aperture in views", side_views)?;
        Self::sized(views, center, side_views, ApertureShape::Square)
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
        positive("deviation of the aperture in views", deviation_views)?;
        Self::sized(views, center, deviation_views, ApertureShape::Gaussian)
    }

    /// Returns the aperture of a shape around `center`.
    ///
    /// # Errors
    ///
    /// As [`Aperture::disc`].
    pub fn shaped(views: GridSize, center: (f64, f64), shape: ApertureShape) -> Result<Self, Error> {
        match shape {
            ApertureShape::All => Self::all(views),
            ApertureShape::Disc(diameter) => Self::disc(views, center, diameter),
            ApertureShape::Square(side) => Self::square(views, center, side),
            ApertureShape::Gaussian(deviation) => Self::gaussian(views, center, deviation),
        }
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

    /// The aperture of a shape of a size; one without views, such as one whose center is NaN, is refused.
    fn sized(
        views: GridSize,
        center: (f64, f64),
        size_views: f64,
        shape: impl Fn(f64) -> ApertureShape,
    ) -> Result<Self, Error> {
        let shape = shape(size_views);
        let weight = |t: usize, s: usize| shape.weight([t as f64 - center.0, s as f64 - center.1]);
        let aperture = Self::from_function(views, weight)?;
        if aperture.weights.iter().any(|&weight| weight > 0.0) {
            return Ok(aperture);
        }
        let what = "size of the aperture in views";
        Err(Error::BadNumber { what, value: size_views, need: "large enough to reach a view from its center" })
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
}

/// The shape of a synthetic aperture, and its size: in views of a grid, in meters of cameras anywhere.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ApertureShape {
    /// All views or cameras, with equal weights.
    #[default]
    All,
    /// A disc of this diameter.
    Disc(f64),
    /// A square of this side.
    Square(f64),
    /// Gaussian weights of this standard deviation.
    Gaussian(f64),
}

impl ApertureShape {
    /// The weight at a distance from the center, along both axes.
    #[must_use]
    pub fn weight(self, [down, right]: [f64; 2]) -> f32 {
        let inside = |is_inside: bool| f32::from(u8::from(is_inside));
        match self {
            Self::All => 1.0,
            Self::Disc(diameter) => inside(down.hypot(right) <= diameter / 2.0 + EDGE),
            Self::Square(side) => inside(down.abs().max(right.abs()) <= side / 2.0 + EDGE),
            Self::Gaussian(deviation) => {
                (-0.5 * ((down / deviation).powi(2) + (right / deviation).powi(2))).exp() as f32
            }
        }
    }
}

impl FromStr for ApertureShape {
    type Err = String;

    /// Reads `all`, `disc:D`, `square:D` or `gaussian:D`, D finite and above 0.
    fn from_str(text: &str) -> Result<Self, String> {
        let size = |text: &str| text.parse().ok().filter(|x: &f64| x.is_finite() && *x > 0.0);
        match text.split_once(':').and_then(|(shape, text)| Some((shape, size(text)?))) {
            Some(("disc", diameter)) => Ok(Self::Disc(diameter)),
            Some(("square", side)) => Ok(Self::Square(side)),
            Some(("gaussian", deviation)) => Ok(Self::Gaussian(deviation)),
            _ if text == "all" => Ok(Self::All),
            _ => Err("write all, disc:D, square:D or gaussian:D, such as disc:9, D above 0".into()),
        }
    }
}

/// The tolerance of the edge, in views or meters, for rounded sizes.
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
    fn shapes_are_written_as_words() {
        assert_eq!("all".parse(), Ok(ApertureShape::All));
        assert_eq!("disc:4.5".parse(), Ok(ApertureShape::Disc(4.5)));
        assert_eq!("square:3".parse(), Ok(ApertureShape::Square(3.0)));
        assert_eq!("gaussian:1e-2".parse(), Ok(ApertureShape::Gaussian(0.01)));
        for text in ["", "disc", "disc:", "disc:0", "disc:-1", "disc:inf", "disc:nan", "round:3", "all:3"] {
            assert!(text.parse::<ApertureShape>().is_err(), "{text}");
        }
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
