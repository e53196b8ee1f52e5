//! The two baselines of a rig, relative to each other.

use super::Rig;
use crate::Error;
use crate::base::error::not_negative;

/// How far a point moves between vertically and between horizontally adjacent views, in multiples of its disparity.
///
/// The disparity of files and of [`Rig::disparity`] is that of horizontally adjacent views, so the horizontal multiple is
/// 1 and the vertical one is the ratio of the baselines. A rig whose horizontal baseline is 0 moves points along columns
/// only; a disparity is then that of vertically adjacent views.
///
/// # Examples
///
/// ```
/// use holo_core::BaselineRatio;
///
/// let ratio = BaselineRatio::vertical_over_horizontal(0.5)?;
/// assert_eq!((ratio.vertical(), ratio.horizontal()), (0.5, 1.0));
/// assert_eq!(BaselineRatio::default(), BaselineRatio::EQUAL);
/// # Ok::<(), holo_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BaselineRatio {
    vertical: f64,
    horizontal: f64,
}

impl BaselineRatio {
    /// The ratio of equal baselines.
    pub const EQUAL: Self = Self { vertical: 1.0, horizontal: 1.0 };
    /// The ratio of a rig whose views differ vertically only.
    pub const VERTICAL_ONLY: Self = Self { vertical: 1.0, horizontal: 0.0 };

    /// Returns the ratio of the vertical to the horizontal baseline. With 0, the views differ horizontally only.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if it is NaN, infinite or negative.
    pub fn vertical_over_horizontal(ratio: f64) -> Result<Self, Error> {
        Ok(Self { vertical: not_negative("ratio of the vertical to the horizontal baseline", ratio)?, horizontal: 1.0 })
    }

    /// Returns the movement between vertically adjacent views, in multiples of the disparity.
    #[must_use]
    pub const fn vertical(self) -> f64 {
        self.vertical
    }

    /// Returns the movement between horizontally adjacent views, in multiples of the disparity: 1 or 0.
    #[must_use]
    pub const fn horizontal(self) -> f64 {
        self.horizontal
    }
}

impl Default for BaselineRatio {
    fn default() -> Self {
        Self::EQUAL
    }
}

impl Rig {
    /// Returns the ratio of the baselines.
    ///
    /// [`BaselineRatio::EQUAL`] if both are 0: nothing moves between the views of such a rig.
    #[must_use]
    pub fn baseline_ratio(&self) -> BaselineRatio {
        let (x, y) = (self.baseline_x_m(), self.baseline_y_m());
        let ratio = y / x;
        match () {
            () if x == y => BaselineRatio::EQUAL,
            () if ratio.is_finite() => BaselineRatio { vertical: ratio, horizontal: 1.0 },
            // The horizontal baseline is 0, or vanishes beside the vertical one.
            () => BaselineRatio::VERTICAL_ONLY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{GridSize, LightFieldShape};

    #[test]
    fn baselines_of_zero_are_ratios_too() {
        let shape = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(4, 4)).unwrap();
        let ratio = |x_m, y_m| {
            let rig = Rig::builder(shape).baseline_x_m(x_m).baseline_y_m(y_m).build().unwrap();
            let ratio = rig.baseline_ratio();
            (ratio.vertical(), ratio.horizontal())
        };
        assert_eq!(ratio(0.02, 0.02), (1.0, 1.0));
        assert_eq!(ratio(0.02, 0.01), (0.5, 1.0));
        assert_eq!(ratio(0.02, 0.0), (0.0, 1.0));
        assert_eq!(ratio(0.0, 0.02), (1.0, 0.0));
        assert_eq!(ratio(0.0, 0.0), (1.0, 1.0));
        assert_eq!(ratio(1e-308, 1e10), (1.0, 0.0));
        for wrong in [f64::NAN, f64::INFINITY, -0.5] {
            assert!(BaselineRatio::vertical_over_horizontal(wrong).is_err(), "{wrong}");
        }
    }
}
