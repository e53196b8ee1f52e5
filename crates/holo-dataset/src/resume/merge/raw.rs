//! Shards of the raw image of a plenoptic camera: some rows of its pixels.

use holo_core::{GridSize, LightField, LightFieldShape};
use holo_io::CameraFile;
use holo_render::{Layer, Layers, RawStatistics, Rendered};
use ndarray::{Array2, Array3, Axis};

use super::{COLOR, Parts, Put, grid};
use crate::Error;
use crate::output::raw::{CAMERA_TOML, lit_white_image};
use crate::output::{Traced, TracedCamera, Wanted};
use crate::settings::{RawLayer, RenderSettings, from_manifest};

/// The files of the statistics.
const STATISTICS: [RawLayer; 3] = [RawLayer::InverseDepthMean, RawLayer::InverseDepthDeviation, RawLayer::Coverage];

const ERROR: &str = "error.pfm";

fn file(layer: &str) -> String {
    format!("raw_{layer}.pfm")
}

/// Writes the layers and the statistics of a shard.
pub(super) fn write(rendered: &Rendered, put: &mut Put) -> Result<(), Error> {
    if let Some(error) = &rendered.error {
        put(ERROR.into(), grid(error)?)?;
    }
    for (layer, image) in rendered.central.iter() {
        put(file(layer.name()), image.view())?;
    }
    if let Some(RawStatistics { inverse_depth_mean, inverse_depth_deviation, coverage }) = &rendered.statistics {
        for (layer, image) in STATISTICS.iter().zip([inverse_depth_mean, inverse_depth_deviation, coverage]) {
            put(file(layer.name()), image.view().insert_axis(Axis(2)))?;
        }
    }
    Ok(())
}

/// Whether the shards are of the raw image of a plenoptic camera.
pub(super) fn is_raw(parts: &Parts) -> bool {
    parts.has(CAMERA_TOML)
}

/// The raw image of all shards.
pub(super) fn traced(parts: &Parts) -> Result<(Traced, RenderSettings), Error> {
    let file_of_camera = CameraFile::read_in(parts.folder(), CAMERA_TOML)?;
    let manifest = parts.manifest.clone();
    let settings = from_manifest(&manifest, file_of_camera.clone().into())?;
    let size = file_of_camera.camera.sensor().size;
    let shape = LightFieldShape::new(GridSize::new(1, 1), size)?;
    let color = parts.has(COLOR).then(|| parts.gather(COLOR, size, 1, 3)).transpose()?;
    let error = parts.has(ERROR).then(|| parts.gather(ERROR, size, 1, 1)).transpose()?;
    let mut central: Layers<Array3<f32>> = Layers::default();
    for layer in Layer::ALL {
        let name = file(layer.name());
        if parts.has(&name) {
            central.extend([(layer, parts.gather(&name, size, 1, layer.channels())?)]);
        }
    }
    let has_statistics = parts.has(&file(RawLayer::Coverage.name()));
    let rendered = Rendered {
        color: color.map(|color| LightField::from_elemental_grid(color, shape)).transpose()?,
        error: error.map(|error| LightField::from_elemental_grid(error, shape)).transpose()?,
        error_distribution: parts.error_distribution(),
        central,
        all: None,
        statistics: has_statistics.then(|| statistics(parts, size)).transpose()?,
        integrator: parts.integrator(),
        why: parts.why(),
        rays: parts.rays(),
        samples: parts.samples(),
    };
    let white = lit_white_image(&file_of_camera)?;
    let camera = TracedCamera::Plenoptic { file: Box::new(file_of_camera), white };
    Ok((Traced { rendered, wanted: Wanted::new(&settings)?, manifest, camera }, settings))
}

fn statistics(parts: &Parts, size: GridSize) -> Result<RawStatistics, Error> {
    let image = |layer: RawLayer| -> Result<Array2<f32>, Error> {
        Ok(parts.gather(&file(layer.name()), size, 1, 1)?.index_axis_move(Axis(2), 0))
    };
    let [mean, deviation, coverage] = STATISTICS.map(image);
    Ok(RawStatistics { inverse_depth_mean: mean?, inverse_depth_deviation: deviation?, coverage: coverage? })
}
