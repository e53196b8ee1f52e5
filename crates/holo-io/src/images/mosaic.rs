//! What belongs to the codes of an image sensor: a JSON file beside the image, by which the codes become light again.

use std::path::{Path, PathBuf};

use holo_core::sensor::{Exposure, SensorModel};
use ndarray::{Array3, ArrayView3};
use serde::{Deserialize, Serialize};

use crate::files::folder::{Destination, read_beside};
use crate::{Error, FileDigest, write_file};

/// The largest such file, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// The endings of the files of one development: the codes themselves, and those without noise.
const WITHOUT_NOISE: &str = "_clean";

/// The sensor and the exposure of an image of codes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MosaicInfo {
    /// The name of the sensor or camera.
    pub name: String,
    /// The numbers of the sensor that are not published; empty if there are none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub guesses: String,
    /// The sensor.
    pub sensor: SensorModel,
    /// The exposure.
    pub exposure: Exposure,
    /// The frames of which the codes are the mean.
    pub frames: u64,
    /// The SHA-256 of the file that was exposed, as hexadecimal digits; empty if it was none.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub input_sha256: String,
    /// The version of `holo`.
    pub holo: String,
}

impl MosaicInfo {
    /// One frame of a sensor, of no file.
    #[must_use]
    pub fn new(name: &str, guesses: &str, sensor: SensorModel, exposure: Exposure) -> Self {
        let (name, guesses, holo) = (name.to_owned(), guesses.to_owned(), env!("CARGO_PKG_VERSION").to_owned());
        Self { name, guesses, sensor, exposure, frames: 1, input_sha256: String::new(), holo }
    }

    /// Returns the path of the file that belongs to an image: its name with the extension `.json`; that of the image with
    /// noise, for one without.
    #[must_use]
    pub fn path_of(image: &Path) -> PathBuf {
        let stem = image.file_stem().unwrap_or_default().to_string_lossy();
        let stem = stem.strip_suffix(WITHOUT_NOISE).unwrap_or(&stem);
        image.with_file_name(format!("{stem}.json"))
    }

    /// Reads the file that belongs to an image.
    ///
    /// # Errors
    /// [`Error::Io`] if there is none; [`Error::Broken`] if it is damaged, or its sensor is impossible.
    pub fn read_for(image: impl AsRef<Path>) -> Result<Self, Error> {
        let path = Self::path_of(image.as_ref());
        let bytes = read_beside(&path, MAX_BYTES)?;
        let broken = |what: String| Error::Broken { path: path.clone(), format: "mosaic", what };
        let info: Self = serde_json::from_slice(&bytes).map_err(|why| broken(why.to_string()))?;
        info.sensor.validate().map_err(|why| broken(why.to_string()))?;
        Ok(info)
    }

    /// Writes the file at `path`.
    ///
    /// # Errors
    /// [`Error::Io`] if it cannot be written.
    pub fn write(&self, path: impl Destination) -> Result<FileDigest, Error> {
        let text = serde_json::to_string_pretty(self)
            .map_err(|why| Error::bad_input(path.path(), format!("a number that JSON does not have: {why}")))?;
        write_file(path, (text + "\n").as_bytes())
    }

    /// Returns the light of codes: value 1 is what the exposure's electrons stand for, in the colors of the camera.
    #[must_use]
    pub fn linear(&self, codes: ArrayView3<u16>) -> Array3<f32> {
        codes.mapv(|code| self.sensor.linear(f64::from(code), &self.exposure) as f32)
    }
}
