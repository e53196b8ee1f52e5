//! What an eye sees of a display: rays traced through the lenses to the panel.

use ndarray::{Array3, ArrayRef3};

use super::{Display, PixelStripes, SheetGrid};
use crate::base::error::positive;
use crate::base::memory::filled;
use crate::base::parallel::*;
use crate::light_field::layout::checked_product;
use crate::{Error, GridSize};

impl Display {
    /// Returns the image of the display for an eye at a place, in meters: `[x, y, z]` from the middle of the lenses, z
    /// towards the viewer.
    ///
    /// A pixel of the image is a rectangle of the sheet of lenses, so the image has no perspective of the display itself: it
    /// is what a camera at the place of the eye records of the display's window. Every pixel is the mean of
    /// `rays * rays` evenly spaced rays. A ray is refracted by the lens that it meets and ends at a pixel of the panel; of a
    /// pixel with stripes it meets one, which counts three times, so white is white.
    ///
    /// # Shape
    ///
    /// The panel image is `(row, column, c)` as from [`Display::panel_image`]; the result has `size`, see
    /// [`Display::resolution`].
    ///
    /// # Accuracy
    ///
    /// Lenses are thin and without aberrations, the eye is a point. With stripes, average over several lenses: a lens shows
    /// an eye one color.
    ///
    /// # Errors
    ///
    /// [`Error::Shape`] if the image has not the size of the panel, or not three channels on stripes; [`Error::BadNumber`]
    /// if the eye is not before the display; [`Error::ZeroCount`] without pixels or rays; [`Error::OutOfMemory`] if the
    /// allocation fails.
    pub fn seen_from(
        &self,
        panel_image: &ArrayRef3<f32>,
        eye_m: [f64; 3],
        size: GridSize,
        rays: usize,
    ) -> Result<Array3<f32>, Error> {
        let (panel, dim) = (self.panel.size, panel_image.dim());
        let channels = if self.panel.stripes == PixelStripes::None { dim.2 } else { 3 };
        if dim != (panel.rows, panel.columns, channels) {
            let expected = vec![panel.rows, panel.columns, channels];
            return Err(Error::Shape { what: "image of the panel", expected, found: panel_image.shape().to_vec() });
        }
        positive("distance of the eye in meters", eye_m[2])?;
        for value in eye_m {
            if !value.is_finite() {
                return Err(Error::BadNumber { what: "place of the eye in meters", value, need: "finite" });
            }
        }
        for (what, count) in [("image rows", size.rows), ("image columns", size.columns), ("rays", rays)] {
            if count == 0 {
                return Err(Error::ZeroCount { what });
            }
        }
        let too_large = Error::TooLarge { what: "image of the eye" };
        let length = checked_product(&[size.rows, size.columns, channels]).ok_or(too_large)?;
        let mut image = filled("the image of the eye", length, 0.0_f32)?;
        let [width, height] = self.size_m();
        image.par_chunks_mut(size.columns * channels).enumerate().for_each_init(
            || vec![0.0_f64; channels],
            |sums, (row, line)| {
                for (column, pixel) in line.chunks_exact_mut(channels).enumerate() {
                    sums.fill(0.0);
                    for ray in 0..rays * rays {
                        let [down, right] = [ray / rays, ray % rays].map(|index| (index as f64 + 0.5) / rays as f64);
                        let x = ((column as f64 + right) / size.columns as f64 - 0.5) * width;
                        let y = (0.5 - (row as f64 + down) / size.rows as f64) * height;
                        self.add(panel_image, self.traced([x, y], eye_m), sums);
                    }
                    for (value, sum) in pixel.iter_mut().zip(sums.iter()) {
                        *value = (sum / (rays * rays) as f64) as f32;
                    }
                }
            },
        );
        Ok(Array3::from_shape_vec((size.rows, size.columns, channels), image).expect("the length is the product"))
    }

    /// Returns where the ray of an eye through a place of the sheet meets the panel, m.
    fn traced(&self, place: [f64; 2], eye_m: [f64; 3]) -> [f64; 2] {
        let sheet = &self.lenses;
        let middle = sheet.middle_near(place);
        let off_axis = [place[0] - middle[0], place[1] - middle[1]];
        // A thin lens bends a ray by its distance from the axis over the focal length.
        let bend = match sheet.grid {
            SheetGrid::Square | SheetGrid::HexRows => off_axis.map(|offset| offset / sheet.focal_length_m),
            SheetGrid::Lenticular { slant_rad } => {
                let normal = [slant_rad.cos(), slant_rad.sin()];
                let distance = off_axis[0] * normal[0] + off_axis[1] * normal[1];
                normal.map(|part| part * distance / sheet.focal_length_m)
            }
        };
        std::array::from_fn(|axis| {
            let slope = (place[axis] - eye_m[axis]) / eye_m[2] - bend[axis];
            place[axis] + slope * sheet.gap_m
        })
    }

    /// Adds the light of the panel at a place.
    fn add(&self, panel_image: &ArrayRef3<f32>, place: [f64; 2], sums: &mut [f64]) {
        let (size, pitch_m) = (self.panel.size, self.panel.pitch_m);
        let column = place[0] / pitch_m + size.columns as f64 / 2.0;
        let row = size.rows as f64 / 2.0 - place[1] / pitch_m;
        if !((0.0..size.columns as f64).contains(&column) && (0.0..size.rows as f64).contains(&row)) {
            return;
        }
        let (row, pixel) = (row as usize, column as usize);
        if self.panel.stripes == PixelStripes::None {
            for (channel, sum) in sums.iter_mut().enumerate() {
                *sum += f64::from(panel_image[[row, pixel, channel]]);
            }
        } else {
            let channel = self.panel.stripes.channel((((column - pixel as f64) * 3.0) as usize).min(2));
            sums[channel] += 3.0 * f64::from(panel_image[[row, pixel, channel]]);
        }
    }
}
