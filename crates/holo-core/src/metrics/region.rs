//! The evaluated region of a map, and the numbers of its pixels.

use ndarray::{ArrayRef2, ArrayView2};

use crate::{Error, Real};

/// The border that the benchmark excludes on every side, in pixels.
pub const DEFAULT_BORDER_PX: usize = 15;

/// The evaluated pixels of a map: those inside a border and, if there is one, inside a mask.
///
/// # Examples
///
/// ```
/// use holo_core::metrics::Region;
///
/// assert_eq!(Region::default().border_px, 15);
/// assert_eq!(Region::with_border(0).border_px, 0);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Region<'a> {
    /// The excluded border on every side, in pixels.
    pub border_px: usize,
    /// `true` for evaluated pixels; of the shape of the map.
    pub mask: Option<ArrayView2<'a, bool>>,
}

impl Default for Region<'_> {
    fn default() -> Self {
        Self::with_border(DEFAULT_BORDER_PX)
    }
}

impl<'a> Region<'a> {
    /// Returns the region of all pixels at least `border_px` from every edge.
    #[must_use]
    pub const fn with_border(border_px: usize) -> Self {
        Self { border_px, mask: None }
    }

    /// Returns the part of this region where `mask` is true.
    #[must_use]
    pub const fn masked(self, mask: ArrayView2<'a, bool>) -> Self {
        Self { border_px: self.border_px, mask: Some(mask) }
    }

    /// The pixels of the region, row by row.
    pub(super) fn pixels(&self, shape: [usize; 2]) -> Result<impl Iterator<Item = [usize; 2]>, Error> {
        let mask = self.mask;
        if let Some(mask) = mask
            && mask.shape() != shape
        {
            return Err(Error::Shape { what: "mask", expected: shape.to_vec(), found: mask.shape().to_vec() });
        }
        let border = self.border_px;
        let inside = move |count: usize| border..count.saturating_sub(border);
        let columns = inside(shape[1]);
        Ok(inside(shape[0])
            .flat_map(move |row| columns.clone().map(move |column| [row, column]))
            .filter(move |&pixel| mask.is_none_or(|mask| mask[pixel])))
    }
}

/// The numbers of compared and of excluded pixels of a score.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct PixelCounts {
    /// Pixels of the region: inside the border and the mask.
    pub region: usize,
    /// Pixels of the region whose ground truth is NaN or infinite: excluded from every score.
    pub truth_not_finite: usize,
    /// Pixels of the region with a finite ground truth whose estimate is NaN or infinite: bad pixels, excluded from
    /// means and percentiles.
    pub estimate_not_finite: usize,
    /// Pixels of the region in which both are finite.
    pub compared: usize,
}

/// Checks that an estimate has the shape of the ground truth, and returns that shape.
pub(super) fn same_shape<A, B>(estimate: &ArrayRef2<A>, truth: &ArrayRef2<B>) -> Result<[usize; 2], Error> {
    if estimate.dim() == truth.dim() {
        Ok(truth.dim().into())
    } else {
        let (expected, found) = (truth.shape().to_vec(), estimate.shape().to_vec());
        Err(Error::Shape { what: "estimated map", expected, found })
    }
}

/// The errors, estimate - truth, of all pixels in which both are finite, row by row, and the counts of all pixels.
///
/// The subtraction is done in `f64`, which is exact for two `f32` of similar size.
pub(super) fn errors<A: Real, B: Real>(
    estimate: &ArrayRef2<A>,
    truth: &ArrayRef2<B>,
    region: &Region<'_>,
    what: &'static str,
) -> Result<(Vec<f64>, PixelCounts), Error> {
    let shape = same_shape(estimate, truth)?;
    let (mut errors, mut counts) = (Vec::new(), PixelCounts::default());
    for pixel in region.pixels(shape)? {
        counts.region += 1;
        let (estimate, truth) = (estimate[pixel].to_f64(), truth[pixel].to_f64());
        if !truth.is_finite() {
            counts.truth_not_finite += 1;
        } else if !estimate.is_finite() {
            counts.estimate_not_finite += 1;
        } else {
            errors.push(estimate - truth);
        }
    }
    counts.compared = errors.len();
    if counts.region == counts.truth_not_finite {
        return Err(Error::NothingToMeasure { what, shape, border_px: region.border_px });
    }
    Ok((errors, counts))
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::{Array2, array};

    #[test]
    fn border_and_mask_exclude_pixels() {
        let region = Region::with_border(1);
        let pixels: Vec<_> = region.pixels([3, 4]).unwrap().collect();
        assert_eq!(pixels, [[1, 1], [1, 2]]);
        let mut mask = Array2::from_elem((3, 4), false);
        (mask[[0, 0]], mask[[1, 2]]) = (true, true);
        let pixels: Vec<_> = region.masked(mask.view()).pixels([3, 4]).unwrap().collect();
        assert_eq!(pixels, [[1, 2]]);
        // A border wider than the map excludes all pixels without an underflow.
        assert_eq!(Region::default().pixels([3, 40]).unwrap().count(), 0);
        assert_eq!(Region::with_border(usize::MAX).pixels([3, 4]).unwrap().count(), 0);
    }

    #[test]
    fn wrong_shapes_and_empty_regions_are_errors() {
        let map = Array2::<f32>::zeros((4, 5));
        let mask = Array2::from_elem((5, 4), true);
        let found = errors(&map, &map, &Region::with_border(0).masked(mask.view()), "x").unwrap_err();
        assert_eq!(found, Error::Shape { what: "mask", expected: vec![4, 5], found: vec![5, 4] });
        let other = Array2::<f64>::zeros((4, 4));
        assert!(matches!(errors(&other, &map, &Region::with_border(0), "x"), Err(Error::Shape { .. })));
        assert!(matches!(errors(&map, &map, &Region::default(), "x"), Err(Error::NothingToMeasure { .. })));
    }

    #[test]
    fn missing_estimates_and_missing_truth_are_counted_separately() {
        let truth = array![[f64::NAN, 1.0, 1.0, f64::INFINITY, 1.0]];
        let estimate = array![[f32::NAN, f32::NAN, f32::NEG_INFINITY, 1.0, 1.5]];
        let (errors, counts) = errors(&estimate, &truth, &Region::with_border(0), "x").unwrap();
        assert_eq!(errors, [0.5]);
        // A pixel without both counts as one without ground truth.
        assert_eq!(counts, PixelCounts { region: 5, truth_not_finite: 2, estimate_not_finite: 2, compared: 1 });
    }
}
