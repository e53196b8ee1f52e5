//! Shards of the raw image of a plenoptic camera: some rows of its pixels.

use holo_core::GridSize;
use holo_io::{CameraFile, ManifestValue};
use holo_render::{Layer, Layers, RawRendered, RawStatistics};
use ndarray::{Array2, Array3, ArrayView3, Axis};

use super::{COLOR, Label, PART, Parts, spec};
use crate::Error;
use crate::exports::Tool;
use crate::layers::write_pfm;
use crate::output_folder::OutputFolder;
use crate::raw_files::{CAMERA_TOML, RawTraced, TOOLS, lit_white_image};
use crate::spec::{RawLayer, Shard};

/// The files of the statistics.
const STATISTICS: [RawLayer; 3] = [RawLayer::InverseDepthMean, RawLayer::InverseDepthDeviation, RawLayer::Coverage];

fn file(layer: &str) -> String {
    format!("raw_{layer}.pfm")
}

/// Writes a shard.
pub(crate) fn write(traced: RawTraced, shard: Shard, mut folder: OutputFolder) -> Result<Vec<String>, Error> {
    let RawTraced { rendered, camera, mut manifest, .. } = traced;
    let mut put = |name: String, image: ArrayView3<f32>| -> Result<(), Error> {
        let path = folder.file(&name);
        folder.add(name, write_pfm(path, image)?);
        Ok(())
    };
    if let Some(color) = &rendered.color {
        put(COLOR.into(), color.view())?;
    }
    for (layer, image) in rendered.layers.iter() {
        put(file(layer.name()), image.view())?;
    }
    if let Some(RawStatistics { inverse_depth_mean, inverse_depth_deviation, coverage }) = &rendered.statistics {
        for (layer, image) in STATISTICS.iter().zip([inverse_depth_mean, inverse_depth_deviation, coverage]) {
            put(file(layer.name()), image.view().insert_axis(Axis(2)))?;
        }
    }
    folder.add(CAMERA_TOML, holo_io::write_file(folder.file(CAMERA_TOML), camera.to_toml().as_bytes())?);
    let label = Label::new(shard, rendered.rays, 0, &rendered.why);
    manifest.settings.insert(PART.into(), label.setting());
    folder.seal(manifest)
}

/// Whether the shards are of the raw image of a plenoptic camera.
pub(super) fn is_raw(parts: &Parts<'_>) -> bool {
    parts.has(CAMERA_TOML)
}

/// The raw image of all shards.
pub(super) fn traced(parts: &Parts<'_>) -> Result<RawTraced, Error> {
    let camera = CameraFile::read(parts.folder().join(CAMERA_TOML))?;
    let manifest = parts.manifest.clone();
    let size = camera.camera.sensor().size;
    let color = parts.has(COLOR).then(|| parts.gather(COLOR, size, 1, 3)).transpose()?;
    let mut layers: Layers<Array3<f32>> = Layers::default();
    for layer in Layer::ALL {
        let name = file(layer.name());
        if parts.has(&name) {
            layers.extend([(layer, parts.gather(&name, size, 1, layer.channels())?)]);
        }
    }
    let has_statistics = parts.has(&file(RawLayer::Coverage.name()));
    let statistics = has_statistics.then(|| statistics(parts, size)).transpose()?;
    let (integrator, why, rays) = (parts.integrator(), parts.why(), parts.rays());
    let rendered = RawRendered { color, layers, statistics, integrator, why, rays };
    let white = lit_white_image(&camera)?;
    let tools = match manifest.settings.get(TOOLS) {
        Some(ManifestValue::List(names)) => {
            let tool = |name: &ManifestValue| Tool::ALL.into_iter().find(|tool| name.as_text() == Some(tool.name()));
            names.iter().filter_map(tool).collect()
        }
        _ => Vec::new(),
    };
    Ok(RawTraced { rendered, white, camera, spec: spec(&manifest)?, tools, manifest })
}

fn statistics(parts: &Parts<'_>, size: GridSize) -> Result<RawStatistics, Error> {
    let image = |layer: RawLayer| -> Result<Array2<f32>, Error> {
        Ok(parts.gather(&file(layer.name()), size, 1, 1)?.index_axis_move(Axis(2), 0))
    };
    let [mean, deviation, coverage] = STATISTICS.map(image);
    Ok(RawStatistics { inverse_depth_mean: mean?, inverse_depth_deviation: deviation?, coverage: coverage? })
}
