//! The codes that an image sensor makes of a raw image: `scene_raw.png`, `scene_raw.dng` of a mosaic, `scene_raw.json`.

use holo_core::sensor::{Exposure, SensorModel, SensorPreset};
use holo_core::{ColorEncoding, LightFieldOwned};
use holo_io::{Compression, MosaicInfo};
use ndarray::{ArrayView3, Axis};

use super::folder::OutputFolder;
use crate::Error;
use crate::settings::{RenderSettings, SensorName};

const PNG: &str = "scene_raw.png";
const DNG: &str = "scene_raw.dng";
const JSON: &str = "scene_raw.json";

/// How the integers of an image are exposed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exposed {
    /// The exposure compensation, EV; `None` without color.
    pub ev: Option<f64>,
    /// The electrons of the radiance 1 on an image sensor; `None`: by the image itself.
    pub electrons: Option<f64>,
}

impl Exposed {
    /// The image sensor of the settings, if they have one.
    pub fn sensor(self, settings: &RenderSettings) -> Option<Exposing> {
        let sensor = settings.output.sensor_model?;
        let (iso, seed) = (settings.output.iso, settings.light.seed);
        Some(Exposing { sensor, iso, electrons: self.electrons, seed })
    }
}

/// An image sensor, and how it is exposed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exposing {
    pub sensor: SensorName,
    /// Film speed; `None`: that of the sensor.
    pub iso: Option<f64>,
    /// The electrons of the radiance 1, where all shots of a job have the same; `None`: by the image itself.
    pub electrons: Option<f64>,
    /// The seed of the noise.
    pub seed: u64,
}

/// Returns the electrons of the radiance 1 that automatic exposure gives to the elemental images of a light field.
pub(crate) fn automatic_electrons(
    color: &LightFieldOwned<f32>,
    name: SensorName,
    iso: Option<f64>,
) -> Result<f64, Error> {
    let sensor = &preset(name)?.model;
    with_elemental_grid(color, |image| Ok(sensor.automatic_electrons(image, speed(sensor, iso))?))
}

/// Writes the codes of the elemental images of a light field.
pub(crate) fn write(folder: &mut OutputFolder, color: &LightFieldOwned<f32>, exposing: Exposing) -> Result<(), Error> {
    let Exposing { sensor: name, iso, electrons, seed } = exposing;
    let preset = preset(name)?;
    let sensor = &preset.model;
    let iso = speed(sensor, iso);
    let (codes, exposure) = with_elemental_grid(color, |image| {
        let electrons = electrons.map_or_else(|| sensor.automatic_electrons(image, iso), Ok)?;
        let exposure = Exposure { seed, ..Exposure::new(electrons, iso) };
        Ok((sensor.expose(image, &exposure, 1)?, exposure))
    })?;
    folder.add(PNG, holo_io::write_png(folder.file(PNG), codes.view(), ColorEncoding::Linear, Compression::Best)?);
    if sensor.filter.mosaic().is_some() {
        let mosaic = codes.index_axis(Axis(2), 0);
        folder.add(DNG, holo_io::write_dng(folder.file(DNG), mosaic, sensor, name.name())?);
    }
    let info = MosaicInfo::new(name.name(), preset.guesses, *sensor, exposure);
    folder.add(JSON, info.write(folder.file(JSON))?);
    Ok(())
}

fn preset(name: SensorName) -> Result<&'static SensorPreset, Error> {
    name.preset().ok_or_else(|| Error::BadRequest(format!("there is no sensor '{}'", name.name())))
}

fn speed(sensor: &SensorModel, iso: Option<f64>) -> f64 {
    iso.unwrap_or(sensor.base_iso)
}

/// Does `work` with the elemental images, which are copied if the light field has another order.
fn with_elemental_grid<T>(
    color: &LightFieldOwned<f32>,
    work: impl FnOnce(ArrayView3<f32>) -> Result<T, Error>,
) -> Result<T, Error> {
    match color.as_elemental_grid() {
        Some(image) => work(image),
        None => work(color.to_elemental_grid()?.view()),
    }
}
