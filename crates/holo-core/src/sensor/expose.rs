//! Exposing a sensor to an image.

use ndarray::{Array3, ArrayView3, Axis};

use super::random::{Purpose, Stream, exp};
use super::{ColorFilter, Exposure, SensorModel};
use crate::base::parallel::*;
use crate::{Error, base::memory};

/// The share of the lit values that automatic exposure keeps below [`TARGET`] of saturation.
const SHARE: f64 = 0.99;

/// The part of saturation that automatic exposure aims at.
const TARGET: f64 = 0.8;

/// Linear luminance of sRGB (IEC 61966-2-1).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// What the pixels of a sensor see of linear RGB.
struct Seen {
    /// The factors of red, green and blue, for the colors 0 to 2 of the sensor.
    weights: [[f64; 3]; 3],
    filter: ColorFilter,
}

impl Seen {
    fn new(sensor: &SensorModel) -> Result<Self, Error> {
        let weights = match sensor.filter {
            ColorFilter::Mono => [LUMINANCE; 3],
            _ => sensor.camera_from_rgb()?,
        };
        Ok(Self { weights, filter: sensor.filter })
    }

    /// The value of a channel of a pixel. Gray images have the same in all colors.
    #[inline]
    fn value(&self, image: &ArrayView3<f32>, [row, column, channel]: [usize; 3]) -> f64 {
        let color = match self.filter.mosaic() {
            Some(mosaic) => mosaic[row % 2][column % 2],
            None => channel,
        };
        let weights = &self.weights[color];
        let last = image.dim().2 - 1;
        let value: f64 = (0..3).map(|k| weights[k] * f64::from(image[[row, column, k.min(last)]])).sum();
        // Colors that no camera can see, and what is no number, give no electrons.
        if value > 0.0 { value } else { 0.0 }
    }
}

/// The numbers that a pixel's code is made of.
struct Pixel<'a> {
    sensor: &'a SensorModel,
    gain: f64,
    /// Electrons of the dark current, without those of hot pixels.
    dark_e: f64,
    fixed: [Stream; 5],
    /// Photons, reading and rows of every frame.
    frames: Vec<[Stream; 3]>,
    electrons_at_one: f64,
}

impl<'a> Pixel<'a> {
    fn new(sensor: &'a SensorModel, exposure: &Exposure, frames: u64) -> Self {
        let of_camera = |purpose| Stream::new(exposure.camera_seed, 0, purpose);
        let of_frame = |k: u64| {
            let stream = |purpose| Stream::new(exposure.seed, exposure.frame.wrapping_add(k), purpose);
            [stream(Purpose::Photons), stream(Purpose::Read), stream(Purpose::Row)]
        };
        Self {
            sensor,
            gain: sensor.gain(exposure.iso),
            dark_e: sensor.dark_current_e_s * exposure.time_s,
            fixed: [Purpose::Response, Purpose::Offset, Purpose::Column, Purpose::Hot, Purpose::HotRate].map(of_camera),
            frames: (0..frames).map(of_frame).collect(),
            electrons_at_one: exposure.electrons_at_one,
        }
    }

    /// Standard deviation times a normal number, which is not computed for 0.
    #[inline]
    fn noise(deviation: f64, stream: Stream, place: u64) -> f64 {
        if deviation > 0.0 { deviation * stream.normal(place) } else { 0.0 }
    }

    /// The expected electrons, and the fixed offset.
    #[inline]
    fn fixed(&self, value: f64, place: u64, column: u64) -> [f64; 2] {
        let sensor = self.sensor;
        let [response, offset, columns, hot, hot_rate] = self.fixed;
        let light = self.electrons_at_one * value * (1.0 + Self::noise(sensor.prnu, response, place)).max(0.0);
        let mut dark = self.dark_e;
        if sensor.hot_share > 0.0 && hot.uniform(place) < sensor.hot_share {
            dark *= 1.0 + exp(std::f64::consts::LN_10 * (2.0 + hot_rate.normal(place)));
        }
        let offset = Self::noise(sensor.dsnu_e, offset, place) + Self::noise(sensor.column_noise_e, columns, column);
        [light + dark, offset]
    }

    /// The code of a pixel in a frame.
    #[inline]
    fn code(&self, [mean, offset]: [f64; 2], frame: &[Stream; 3], place: u64, row: f64) -> f64 {
        let electrons = frame[0].poisson(place, mean).min(self.sensor.full_well_e);
        let read = Self::noise(self.sensor.read_noise_e, frame[1], place);
        self.quantized(electrons + read + offset + row)
    }

    #[inline]
    fn quantized(&self, electrons: f64) -> f64 {
        (self.gain * electrons + self.sensor.black).round().clamp(0.0, f64::from(self.sensor.white()))
    }
}

impl SensorModel {
    /// Returns the electrons at value 1 that an automatic exposure gives: 99 % of the lit values of the mosaic stay below
    /// 80 % of [saturation](Self::saturation_e). An image without light gives those of value 1 at 80 %.
    ///
    /// # Errors
    ///
    /// As [`expose`](Self::expose), for the image and the sensor.
    pub fn automatic_electrons(&self, image: ArrayView3<f32>, iso: f64) -> Result<f64, Error> {
        self.validate()?;
        check(&image)?;
        let seen = Seen::new(self)?;
        let (rows, columns, _) = image.dim();
        let channels = self.filter.channels();
        let mut values = memory::filled("the values of an exposure", rows * columns * channels, 0.0f32)?;
        values.par_chunks_mut(columns * channels).enumerate().for_each(|(row, values)| {
            for (k, out) in values.iter_mut().enumerate() {
                *out = seen.value(&image, [row, k / channels, k % channels]) as f32;
            }
        });
        values.retain(|&value| value > 0.0 && value.is_finite());
        let target = TARGET * self.saturation_e(iso);
        if values.is_empty() {
            return Ok(target);
        }
        let at = ((values.len() as f64 * SHARE) as usize).min(values.len() - 1);
        let (_, &mut value, _) = values.select_nth_unstable_by(at, f32::total_cmp);
        Ok(target / f64::from(value))
    }

    /// Exposes the sensor to an image: linear RGB or gray, axes (row, column, channel). Returns codes, axes (row, column,
    /// channel), of one channel, or three for [`ColorFilter::Rgb`]. With several `frames` it is their mean, rounded: such
    /// of an even white is a white image, of a black image a dark frame.
    ///
    /// The code of a pixel depends on its row and column alone, and on the model: parts of an image have the codes of the
    /// whole, if they begin at even rows and columns and their place is the same.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] for a number of sensor or exposure that is out of range; [`Error::Shape`] for an image that is
    /// empty or has neither one nor three channels; [`Error::ZeroCount`] for no frames; [`Error::OutOfMemory`].
    pub fn expose(&self, image: ArrayView3<f32>, exposure: &Exposure, frames: u64) -> Result<Array3<u16>, Error> {
        if frames == 0 {
            return Err(Error::ZeroCount { what: "frames" });
        }
        exposure.validate()?;
        let pixel = Pixel::new(self, exposure, frames);
        self.coded(image, |value, [row, column, channel]| {
            let place = place(row, column, channel);
            let fixed = pixel.fixed(value, place, column as u64);
            let sum: f64 = pixel
                .frames
                .iter()
                .map(|frame| {
                    let row = Pixel::noise(self.row_noise_e, frame[2], row as u64);
                    pixel.code(fixed, frame, place, row)
                })
                .sum();
            (sum / frames as f64).round()
        })
    }

    /// Returns the codes without any noise, shot noise and fixed patterns included: the truth that noisy codes scatter
    /// about. Axes and errors as [`expose`](Self::expose).
    ///
    /// # Errors
    ///
    /// As there.
    pub fn expose_without_noise(&self, image: ArrayView3<f32>, exposure: &Exposure) -> Result<Array3<u16>, Error> {
        exposure.validate()?;
        let pixel = Pixel::new(self, exposure, 0);
        self.coded(image, |value, _| {
            let electrons = exposure.electrons_at_one * value + pixel.dark_e;
            pixel.quantized(electrons.min(self.full_well_e))
        })
    }

    fn coded(
        &self,
        image: ArrayView3<f32>,
        code: impl Fn(f64, [usize; 3]) -> f64 + Sync,
    ) -> Result<Array3<u16>, Error> {
        self.validate()?;
        check(&image)?;
        let seen = Seen::new(self)?;
        let (rows, columns, _) = image.dim();
        let channels = self.filter.channels();
        let mut codes = Array3::from_shape_vec(
            (rows, columns, channels),
            memory::filled("the codes of a sensor", rows * columns * channels, 0u16)?,
        )
        .map_err(|_| Error::TooLarge { what: "image" })?;
        let lines: Vec<_> = codes.axis_iter_mut(Axis(0)).enumerate().collect();
        lines.into_par_iter().for_each(|(row, mut line)| {
            for ((column, channel), out) in line.indexed_iter_mut() {
                let at = [row, column, channel];
                *out = code(seen.value(&image, at), at) as u16;
            }
        });
        Ok(codes)
    }

    /// Returns linear sRGB from camera colors, axes (row, column, channel): white balance and color matrix. An image of one
    /// channel, and that of a sensor without filter, is returned as it is.
    #[must_use]
    pub fn rgb_from_camera(&self, mut image: Array3<f32>) -> Array3<f32> {
        if self.filter == ColorFilter::Mono || image.dim().2 != 3 {
            return image;
        }
        let lines: Vec<_> = image.axis_iter_mut(Axis(0)).collect();
        lines.into_par_iter().for_each(|mut line| {
            for mut pixel in line.axis_iter_mut(Axis(0)) {
                let balanced = [0, 1, 2].map(|k| f64::from(pixel[k]) * self.white_balance[k]);
                for (row, value) in self.color_matrix.iter().zip(pixel.iter_mut()) {
                    *value = row.iter().zip(balanced).map(|(a, b)| a * b).sum::<f64>() as f32;
                }
            }
        });
        image
    }

    /// Returns the linear values of codes, the inverse of [`expose`](Self::expose) without noise, in camera colors: (code -
    /// black) / (gain electrons_at_one). Values below black stay negative, so that means keep their truth.
    #[must_use]
    pub fn linear(&self, code: f64, exposure: &Exposure) -> f64 {
        (code - self.black) / (self.gain(exposure.iso) * exposure.electrons_at_one)
    }
}

/// A number for every place of a sensor, whatever its size.
#[inline]
fn place(row: usize, column: usize, channel: usize) -> u64 {
    (row as u64) << 34 | (column as u64) << 2 | channel as u64
}

fn check(image: &ArrayView3<f32>) -> Result<(), Error> {
    let (rows, columns, channels) = image.dim();
    if rows == 0 || columns == 0 || !matches!(channels, 1 | 3) {
        let found = vec![rows, columns, channels];
        return Err(Error::Shape { what: "image of a sensor", expected: vec![rows.max(1), columns.max(1), 3], found });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
