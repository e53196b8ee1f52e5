//! Image sensors: from light to codes, by the model of EMVA 1288.
//!
//! A renderer gives linear RGB. A sensor counts electrons behind a color filter, adds its own, and rounds:
//!
//! ```text
//! camera RGB  = diag(1 / white balance) color_matrix^-1 RGB        the filter of the pixel picks one
//! mean        = e1 value (1 + PRNU n1) + dark current t (1 + hot)  electrons; e1: those of value 1
//! electrons   = min(Poisson(mean), full well)
//! code        = round(K (electrons + read noise n2 + DSNU n3 + row noise n4 + column noise n5) + black)
//! ```
//!
//! and clamps the code to 0 .. 2^bits - 1. n1, n3, n5 and the hot pixels are those of one camera: the same in every
//! picture of it ([`Exposure::camera_seed`]). Photons, n2 and n4 are those of one frame. n1 to n5 are normal numbers of mean 0
//! and variance 1.
//!
//! Source: EMVA Standard 1288, release 4.0 (2021), linear model.
//!
//! # Accuracy
//!
//! Every random number is a function of seed, frame and place, and of operations that IEEE 754 defines: all machines and any
//! number of threads give the same codes. Mean and variance of the photons are those of Poisson's distribution to 1e-3
//! (below 256 electrons to rounding).

mod demosaic;
mod expose;
mod presets;
mod random;

pub(crate) use demosaic::weighted as weighted_demosaic;
pub use demosaic::{Demosaic, demosaic};
pub use presets::{SensorPreset, sensor_presets};
pub(crate) use random::{Purpose, Stream};

use crate::Error;
use crate::base::error::{not_negative, positive};

/// Which light the pixels of a sensor count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ColorFilter {
    /// A Bayer mosaic of 2 x 2 pixels, by its first row and then its second.
    #[cfg_attr(feature = "serde", serde(rename = "RGGB"))]
    Rggb,
    /// As above.
    #[cfg_attr(feature = "serde", serde(rename = "GRBG"))]
    Grbg,
    /// As above.
    #[cfg_attr(feature = "serde", serde(rename = "GBRG"))]
    Gbrg,
    /// As above.
    #[cfg_attr(feature = "serde", serde(rename = "BGGR"))]
    Bggr,
    /// No filter: luminance.
    #[cfg_attr(feature = "serde", serde(rename = "mono"))]
    Mono,
    /// Three colors in every pixel, each with noise of its own.
    #[cfg_attr(feature = "serde", serde(rename = "rgb"))]
    Rgb,
}

impl ColorFilter {
    /// All filters.
    pub const ALL: [Self; 6] = [Self::Rggb, Self::Grbg, Self::Gbrg, Self::Bggr, Self::Mono, Self::Rgb];

    /// Returns the name: `RGGB`, `GRBG`, `GBRG`, `BGGR`, `mono`, `rgb`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Rggb => "RGGB",
            Self::Grbg => "GRBG",
            Self::Gbrg => "GBRG",
            Self::Bggr => "BGGR",
            Self::Mono => "mono",
            Self::Rgb => "rgb",
        }
    }

    /// Returns the colors of a mosaic, 0 red, 1 green, 2 blue: first row, second row. `None` for what is no mosaic.
    #[must_use]
    pub const fn mosaic(self) -> Option<[[usize; 2]; 2]> {
        match self {
            Self::Rggb => Some([[0, 1], [1, 2]]),
            Self::Grbg => Some([[1, 0], [2, 1]]),
            Self::Gbrg => Some([[1, 2], [0, 1]]),
            Self::Bggr => Some([[2, 1], [1, 0]]),
            Self::Mono | Self::Rgb => None,
        }
    }

    /// Returns the number of values a pixel has: 3 for [`Rgb`](Self::Rgb), else 1.
    #[must_use]
    pub const fn channels(self) -> usize {
        if matches!(self, Self::Rgb) { 3 } else { 1 }
    }
}

/// An image sensor with its noise.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SensorModel {
    /// The color filter array.
    pub filter: ColorFilter,
    /// Bits of a code, 1 to 16.
    pub bits: u8,
    /// The code of no light.
    pub black: f64,
    /// The most electrons that a pixel holds.
    pub full_well_e: f64,
    /// The standard deviation of reading a pixel, electrons.
    pub read_noise_e: f64,
    /// Electrons a second without light.
    pub dark_current_e_s: f64,
    /// Photo response non-uniformity: the relative standard deviation of the pixels' response.
    pub prnu: f64,
    /// Dark signal non-uniformity: the standard deviation of the pixels' offset, electrons.
    pub dsnu_e: f64,
    /// The share of hot pixels, whose dark current is larger by 10^(2 + n), n normally distributed.
    pub hot_share: f64,
    /// The standard deviation of the offset of a row in a frame, electrons.
    pub row_noise_e: f64,
    /// The standard deviation of the offset of a column, electrons.
    pub column_noise_e: f64,
    /// Codes an electron, at [`base_iso`](Self::base_iso).
    pub dn_per_e: f64,
    /// The film speed with that gain.
    pub base_iso: f64,
    /// The share of the photons that become electrons, at 525 nm.
    pub quantum_efficiency: f64,
    /// Linear sRGB from the balanced camera RGB; its rows sum to 1, so gray stays gray.
    pub color_matrix: [[f64; 3]; 3],
    /// The factors that make white of a camera's red, green and blue.
    pub white_balance: [f64; 3],
}

/// How many electrons a value of 1 is worth.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum ElectronsAtOne {
    /// As many as [`SensorModel::automatic_electrons`] gives.
    #[default]
    Automatic,
    /// A number.
    Given(f64),
    /// By what the scene and the optics are: [`photometric_electrons`](crate::plenoptic::PlenopticCamera::photometric_electrons).
    Photometric {
        /// The luminance of radiance 1, cd/m^2.
        luminance_cd_m2: f64,
        /// Exposure time, s.
        exposure_s: f64,
        /// The share of photons that become electrons; `None`: that of the sensor.
        quantum_efficiency: Option<f64>,
    },
}

/// One exposure of a sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Exposure {
    /// The electrons of a pixel of value 1 without color filter.
    pub electrons_at_one: f64,
    /// Exposure time, s: for the dark current.
    pub time_s: f64,
    /// Film speed: the gain is that of the base speed times its ratio to that.
    pub iso: f64,
    /// What the fixed pattern of the camera depends on.
    pub camera_seed: u64,
    /// What the noise of its frames depends on.
    pub seed: u64,
    /// The number of the frame.
    pub frame: u64,
}

impl SensorModel {
    /// A sensor without noise whose codes are proportional to light: `bits` for a full well of `full_well_e` electrons.
    #[must_use]
    pub fn ideal(filter: ColorFilter, bits: u8, full_well_e: f64) -> Self {
        Self {
            filter,
            bits,
            black: 0.0,
            full_well_e,
            read_noise_e: 0.0,
            dark_current_e_s: 0.0,
            prnu: 0.0,
            dsnu_e: 0.0,
            hot_share: 0.0,
            row_noise_e: 0.0,
            column_noise_e: 0.0,
            dn_per_e: ((1u32 << bits.min(16)) - 1) as f64 / full_well_e,
            base_iso: 100.0,
            quantum_efficiency: 1.0,
            color_matrix: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            white_balance: [1.0; 3],
        }
    }

    /// Returns the largest code.
    #[must_use]
    pub fn white(&self) -> u16 {
        ((1u32 << self.bits.min(16)) - 1) as u16
    }

    /// Returns the codes an electron at a film speed.
    #[must_use]
    pub fn gain(&self, iso: f64) -> f64 {
        self.dn_per_e * iso / self.base_iso
    }

    /// Returns the electrons at which a pixel saturates: the full well, or what reaches the largest code.
    #[must_use]
    pub fn saturation_e(&self, iso: f64) -> f64 {
        self.full_well_e.min((f64::from(self.white()) - self.black) / self.gain(iso))
    }

    /// Returns camera RGB from linear sRGB: white balance and color matrix undone.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the color matrix has no inverse.
    pub fn camera_from_rgb(&self) -> Result<[[f64; 3]; 3], Error> {
        let m = &self.color_matrix;
        let minor = |row: usize, column: usize| {
            let [a, b] = [(row + 1) % 3, (row + 2) % 3];
            let [c, d] = [(column + 1) % 3, (column + 2) % 3];
            m[a][c] * m[b][d] - m[a][d] * m[b][c]
        };
        let determinant = (0..3).map(|k| m[0][k] * minor(0, k)).sum::<f64>();
        if determinant.is_nan() || determinant.abs() <= 1e-9 {
            let what = "determinant of the color matrix";
            return Err(Error::BadNumber { what, value: determinant, need: "other than 0" });
        }
        let inverse = |row: usize, column: usize| minor(column, row) / determinant / self.white_balance[row];
        Ok([0, 1, 2].map(|row| [0, 1, 2].map(|column| inverse(row, column))))
    }

    /// Checks that every number is possible.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] names the first that is not.
    pub fn validate(&self) -> Result<(), Error> {
        let in_range = |what, value: f64, most: f64, need| match value >= 0.0 && value <= most {
            true => Ok(()),
            false => Err(Error::BadNumber { what, value, need }),
        };
        if !(1..=16).contains(&self.bits) {
            let what = "number of bits of a code";
            return Err(Error::BadNumber { what, value: self.bits.into(), need: "1 to 16" });
        }
        in_range("black level", self.black, f64::from(self.white()) - 1.0, "from 0 to below the largest code")?;
        positive("full well in electrons", self.full_well_e)?;
        not_negative("read noise in electrons", self.read_noise_e)?;
        not_negative("dark current in electrons a second", self.dark_current_e_s)?;
        in_range("photo response non-uniformity", self.prnu, 1.0, "from 0 to 1")?;
        not_negative("dark signal non-uniformity in electrons", self.dsnu_e)?;
        in_range("share of hot pixels", self.hot_share, 1.0, "from 0 to 1")?;
        not_negative("row noise in electrons", self.row_noise_e)?;
        not_negative("column noise in electrons", self.column_noise_e)?;
        positive("gain in codes an electron", self.dn_per_e)?;
        positive("base film speed", self.base_iso)?;
        positive("quantum efficiency", self.quantum_efficiency)?;
        for factor in self.white_balance {
            positive("white balance", factor)?;
        }
        if let Some(&value) = self.color_matrix.iter().flatten().find(|value| !value.is_finite()) {
            return Err(Error::BadNumber { what: "color matrix", value, need: "finite" });
        }
        self.camera_from_rgb().map(|_| ())
    }
}

impl Exposure {
    /// An exposure of 10 ms at a film speed, frame 0 of seed 0 of camera 0.
    #[must_use]
    pub fn new(electrons_at_one: f64, iso: f64) -> Self {
        Self { electrons_at_one, time_s: 0.01, iso, camera_seed: 0, seed: 0, frame: 0 }
    }

    fn validate(&self) -> Result<(), Error> {
        positive("number of electrons at value 1", self.electrons_at_one)?;
        not_negative("exposure time in seconds", self.time_s)?;
        positive("film speed", self.iso).map(|_| ())
    }
}
