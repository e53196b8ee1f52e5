//! The codes that an image sensor makes of a raw image: `scene_raw.png`, `scene_raw.dng` of a mosaic, `scene_raw.json`.

use holo_core::sensor::Exposure;
use holo_core::{ColorEncoding, LightFieldOwned};
use holo_io::{Compression, MosaicInfo};
use ndarray::Axis;

use super::folder::OutputFolder;
use crate::Error;
use crate::settings::SensorName;

const PNG: &str = "scene_raw.png";
const DNG: &str = "scene_raw.dng";
const JSON: &str = "scene_raw.json";

/// Writes the codes of the elemental images of a light field, with automatic exposure.
pub(crate) fn write(
    folder: &mut OutputFolder,
    color: &LightFieldOwned<f32>,
    name: SensorName,
    iso: Option<f64>,
    seed: u64,
) -> Result<(), Error> {
    let unknown = || Error::BadRequest(format!("there is no sensor '{}'", name.name()));
    let preset = name.preset().ok_or_else(unknown)?;
    let sensor = &preset.model;
    let copy;
    let image = match color.as_elemental_grid() {
        Some(image) => image,
        None => {
            copy = color.to_elemental_grid()?;
            copy.view()
        }
    };
    let iso = iso.unwrap_or(sensor.base_iso);
    let exposure = Exposure { seed, ..Exposure::new(sensor.automatic_electrons(image, iso)?, iso) };
    let codes = sensor.expose(image, &exposure, 1)?;
    folder.add(PNG, holo_io::write_png(folder.file(PNG), codes.view(), ColorEncoding::Linear, Compression::Best)?);
    if sensor.filter.mosaic().is_some() {
        let mosaic = codes.index_axis(Axis(2), 0);
        folder.add(DNG, holo_io::write_dng(folder.file(DNG), mosaic, sensor, name.name())?);
    }
    let info = MosaicInfo::new(name.name(), preset.guesses, *sensor, exposure);
    folder.add(JSON, info.write(folder.file(JSON))?);
    Ok(())
}
