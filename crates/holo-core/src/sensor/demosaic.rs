//! From a mosaic to three colors in every pixel.

use ndarray::{Array3, ArrayView2, Axis};

use super::ColorFilter;
use crate::base::parallel::*;
use crate::{Error, base::memory};

/// How the missing colors of a pixel are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Demosaic {
    /// The mean of the nearest pixels of a color.
    Bilinear,
    /// The same, corrected by the curvature of the pixel's own color (Malvar, He and Cutler, 2004).
    #[default]
    Malvar,
    /// Along edges: of two directions that with the more homogeneous colors (Hirakawa and Parks, 2005).
    Homogeneity,
}

impl Demosaic {
    /// All methods.
    pub const ALL: [Self; 3] = [Self::Bilinear, Self::Malvar, Self::Homogeneity];

    /// Returns the name on the command line: `bilinear`, `malvar`, `ahd`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bilinear => "bilinear",
            Self::Malvar => "malvar",
            Self::Homogeneity => "ahd",
        }
    }
}

/// Returns the colors of every pixel of a mosaic, axes (row, column, channel), in the units of the mosaic. What has no
/// mosaic is gray.
///
/// The methods know nothing of microlenses: they mix neighboring micro-images.
/// [`PlenopticCamera::demosaic`](crate::plenoptic::PlenopticCamera::demosaic) does not.
///
/// # Source
///
/// The crate `demosaic`; bilinear is ours, as that of the crate also averages the pixel's own color with its neighbors.
///
/// # Errors
///
/// [`Error::Shape`] for an image of fewer than 2 x 2 pixels, or one with gaps in memory; [`Error::OutOfMemory`];
/// [`Error::MissingFeature`] without the feature `demosaic` for methods other than bilinear.
pub fn demosaic(mosaic: ArrayView2<f32>, filter: ColorFilter, method: Demosaic) -> Result<Array3<f32>, Error> {
    let (rows, columns) = mosaic.dim();
    let wrong =
        || Error::Shape { what: "mosaic", expected: vec![rows.max(2), columns.max(2)], found: vec![rows, columns] };
    if rows.min(columns) < 2 {
        return Err(wrong());
    }
    if method == Demosaic::Bilinear || filter.mosaic().is_none() {
        return weighted((rows, columns), filter, |_, _| 1.0, |[row, column]| mosaic[[row, column]]);
    }
    let mut image = blank(rows, columns)?;
    let (Some(input), Some(output)) = (mosaic.as_slice(), image.as_slice_mut()) else { return Err(wrong()) };
    if !along_edges(input, [rows, columns], filter, method, output)? {
        return Err(wrong());
    }
    Ok(image)
}

/// The methods of the crate `demosaic`. Returns whether the sizes fit.
#[cfg(feature = "demosaic")]
fn along_edges(
    input: &[f32],
    [rows, columns]: [usize; 2],
    filter: ColorFilter,
    method: Demosaic,
    output: &mut [f32],
) -> Result<bool, Error> {
    let pattern = match filter {
        ColorFilter::Grbg => demosaic::CfaPattern::bayer_grbg(),
        ColorFilter::Gbrg => demosaic::CfaPattern::bayer_gbrg(),
        ColorFilter::Bggr => demosaic::CfaPattern::bayer_bggr(),
        _ => demosaic::CfaPattern::bayer_rggb(),
    };
    let algorithm = match method {
        Demosaic::Homogeneity => demosaic::Algorithm::Ahd,
        _ => demosaic::Algorithm::Mhc,
    };
    Ok(demosaic::demosaic_interleaved(input, columns, rows, &pattern, algorithm, output).is_ok())
}

#[cfg(not(feature = "demosaic"))]
fn along_edges(_: &[f32], _: [usize; 2], _: ColorFilter, _: Demosaic, _: &mut [f32]) -> Result<bool, Error> {
    Err(Error::MissingFeature { what: "demosaicing other than bilinear", feature: "demosaic" })
}

/// Returns the colors of every pixel as weighted means of `value` over the nearest pixels of each color; that of the
/// pixel itself is its value. `weight(from, to)` is the weight of the pixel `to` for `from`; a color whose pixels all have
/// the weight 0 is 0. What has no mosaic has the value in all channels.
pub(crate) fn weighted(
    (rows, columns): (usize, usize),
    filter: ColorFilter,
    weight: impl Fn([usize; 2], [usize; 2]) -> f32 + Sync,
    value: impl Fn([usize; 2]) -> f32 + Sync,
) -> Result<Array3<f32>, Error> {
    let mut image = blank(rows, columns)?;
    let lines: Vec<_> = image.axis_iter_mut(Axis(0)).enumerate().collect();
    lines.into_par_iter().for_each(|(row, mut line)| {
        for column in 0..columns {
            let at = [row, column];
            let Some(colors) = filter.mosaic() else {
                line.index_axis_mut(Axis(0), column).fill(value(at));
                continue;
            };
            // Sums of weighted values and of weights.
            let mut sums = [[0.0f32; 2]; 3];
            for r in row.saturating_sub(1)..(row + 2).min(rows) {
                for c in column.saturating_sub(1)..(column + 2).min(columns) {
                    let weight = weight(at, [r, c]);
                    if weight > 0.0 {
                        let [sum, weights] = &mut sums[colors[r % 2][c % 2]];
                        (*sum, *weights) = (*sum + weight * value([r, c]), *weights + weight);
                    }
                }
            }
            let own = colors[row % 2][column % 2];
            for (channel, [sum, weights]) in sums.into_iter().enumerate() {
                line[[column, channel]] = match weights > 0.0 {
                    _ if channel == own => value(at),
                    true => sum / weights,
                    false => 0.0,
                };
            }
        }
    });
    Ok(image)
}

fn blank(rows: usize, columns: usize) -> Result<Array3<f32>, Error> {
    let values = memory::filled("a demosaiced image", rows * columns * 3, 0.0f32)?;
    Array3::from_shape_vec((rows, columns, 3), values).map_err(|_| Error::TooLarge { what: "image" })
}

#[cfg(all(test, feature = "demosaic"))]
mod tests {
    use ndarray::Array2;

    use super::*;

    /// Every method keeps the value of a pixel in its own color; at one pixel, red in RGGB, the definitions of bilinear and
    /// of Malvar's filters. Three copies of a gray image are what a sensor without mosaic has.
    #[test]
    fn methods_are_their_definitions() {
        let mosaic = Array2::from_shape_fn((8, 10), |(r, c)| 0.3 + ((r * 7 + c * 5) % 11) as f32 / 20.0);
        for filter in ColorFilter::ALL {
            for method in Demosaic::ALL {
                let image = demosaic(mosaic.view(), filter, method).unwrap();
                for ((row, column), &value) in mosaic.indexed_iter() {
                    let channels = filter.mosaic().map_or(vec![0, 1, 2], |colors| vec![colors[row % 2][column % 2]]);
                    for channel in channels {
                        let found = image[[row, column, channel]];
                        assert!((found - value).abs() < 1e-6, "{filter:?} {method:?} {row} {column}: {found} {value}");
                    }
                }
            }
        }
        let (row, column) = (4, 4);
        let at = |r: i32, c: i32| mosaic[[(row + r) as usize, (column + c) as usize]];
        let sides = at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1);
        let corners = at(-1, -1) + at(-1, 1) + at(1, -1) + at(1, 1);
        let far = at(-2, 0) + at(2, 0) + at(0, -2) + at(0, 2);
        let green = (4.0 * at(0, 0) + 2.0 * sides - far) / 8.0;
        let blue = (6.0 * at(0, 0) + 2.0 * corners - 1.5 * far) / 8.0;
        for (method, expected) in
            [(Demosaic::Bilinear, [sides / 4.0, corners / 4.0]), (Demosaic::Malvar, [green, blue])]
        {
            let image = demosaic(mosaic.view(), ColorFilter::Rggb, method).unwrap();
            let found = [1, 2].map(|channel| image[[row as usize, column as usize, channel]]);
            assert!(
                found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-6),
                "{method:?} {found:?} {expected:?}"
            );
        }
        assert!(demosaic(Array2::zeros((1, 9)).view(), ColorFilter::Rggb, Demosaic::Malvar).is_err());
    }
}
