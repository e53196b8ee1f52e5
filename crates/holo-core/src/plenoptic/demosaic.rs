//! Demosaicing a raw image within its micro-images.

use ndarray::{Array2, Array3, ArrayView2, Axis, Zip};

use super::{MicrolensIndex, PlenopticCamera};
use crate::base::parallel::*;
use crate::sensor::{ColorFilter, weighted_demosaic};
use crate::{Error, GridSize, base::memory};

/// The light, relative to that of an unvignetted pixel, below which the white image divides nothing.
const LEAST_LIGHT: f32 = 0.02;

/// The weight of pixels of other microlenses: where a color has none behind the same one, they are all there is.
const OTHERS: f32 = 1e-6;

impl PlenopticCamera {
    /// Returns the colors of every pixel of a mosaic, axes (row, column, channel). A missing color is the mean of those of
    /// the neighboring pixels behind the same microlens, each divided by its light in the white image and weighted with it,
    /// times the light of the pixel itself: pixels of other microlenses see another part of the scene, and dark ones
    /// nothing.
    ///
    /// # Source
    ///
    /// Bilinear interpolation, guided by the white image as in David, Le Pendu and Guillemot (2017).
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if mosaic or white image have not the size of the sensor; [`Error::OutOfMemory`].
    pub fn demosaic(
        &self,
        mosaic: ArrayView2<f32>,
        white: ArrayView2<f32>,
        filter: ColorFilter,
    ) -> Result<Array3<f32>, Error> {
        let GridSize { rows, columns } = self.sensor().size;
        for (what, (found_rows, found_columns)) in [("mosaic", mosaic.dim()), ("white image", white.dim())] {
            if (found_rows, found_columns) != (rows, columns) {
                let found = vec![found_rows, found_columns];
                return Err(Error::Shape { what, expected: vec![rows, columns], found });
            }
        }
        let owners = self.owners()?;
        let weight = |from: [usize; 2], to: [usize; 2]| {
            let light = if white[to] >= LEAST_LIGHT { white[to] } else { 0.0 };
            if owners[from] == owners[to] { light } else { OTHERS * light }
        };
        let mut image = weighted_demosaic((rows, columns), filter, weight, |at| mosaic[at] / white[at])?;
        Zip::indexed(&mut image).for_each(|(row, column, channel), value| {
            let is_own = filter.mosaic().is_none_or(|colors| colors[row % 2][column % 2] == channel);
            *value = if is_own { mosaic[[row, column]] } else { *value * white[[row, column]] };
        });
        Ok(image)
    }

    /// The microlens of every pixel, as a number that neighbors do not share.
    fn owners(&self) -> Result<Array2<u32>, Error> {
        let GridSize { rows, columns } = self.sensor().size;
        let values = memory::filled("the microlenses of the pixels", rows * columns, 0u32)?;
        let mut owners =
            Array2::from_shape_vec((rows, columns), values).map_err(|_| Error::TooLarge { what: "sensor" })?;
        let lines: Vec<_> = owners.axis_iter_mut(Axis(0)).enumerate().collect();
        lines.into_par_iter().for_each(|(row, mut line)| {
            for (column, owner) in line.iter_mut().enumerate() {
                let MicrolensIndex { row, column } = self.owner(self.place_m([column as f64 + 0.5, row as f64 + 0.5]));
                *owner = (row as u32) << 16 ^ (column as u32 & 0xffff);
            }
        });
        Ok(owners)
    }
}
