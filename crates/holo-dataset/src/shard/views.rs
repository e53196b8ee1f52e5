//! Shards of a light field: some of its lens rows.

use holo_core::{LightField, LightFieldOwned, LightFieldShape};
use holo_io::{ParametersCfg, dataset};
use holo_render::{Layer, Layers, Rendered};
use ndarray::{Array3, ArrayView3, Axis};

use super::{COLOR, Label, PART, Parts, spec};
use crate::Error;
use crate::files::{Finished, Traced};
use crate::layers::{Wanted, write_pfm};
use crate::output_folder::OutputFolder;
use crate::spec::{RenderSpec, Shard};
use crate::statistics::Statistics;

const ERROR: &str = "error.pfm";

const VISIBILITY: &str = "visibility.pfm";

fn central_file(layer: Layer) -> String {
    format!("central_{}.pfm", layer.name())
}

fn all_file(layer: Layer) -> String {
    format!("all_{}.pfm", layer.name())
}

/// Writes a shard.
pub(crate) fn write(traced: Traced, shard: Shard, mut folder: OutputFolder) -> Result<Finished, Error> {
    let Traced { rendered, mut manifest, parameters, visibility, .. } = traced;
    folder.unseal()?;
    let mut put = |name: String, image: ArrayView3<f32>| -> Result<(), Error> {
        let path = folder.file(&name);
        folder.add(name, write_pfm(path, image)?);
        Ok(())
    };
    if let Some(color) = &rendered.color {
        put(COLOR.into(), grid(color)?.view())?;
    }
    if let Some(error) = &rendered.error {
        put(ERROR.into(), grid(error)?.view())?;
    }
    if let Some(visibility) = &visibility {
        put(VISIBILITY.into(), visibility.view().insert_axis(Axis(2)))?;
    }
    for (layer, image) in rendered.central.iter() {
        put(central_file(layer), image.view())?;
    }
    for (layer, field) in rendered.all.iter().flat_map(Layers::iter) {
        put(all_file(layer), grid(field)?.view())?;
    }
    folder.add(dataset::PARAMETERS_CFG, parameters.write(folder.file(dataset::PARAMETERS_CFG))?);
    let label =
        Label::new(shard, rendered.rays, rendered.samples, &rendered.why).with_errors(rendered.error_distribution);
    manifest.settings.insert(PART.into(), label.setting());
    Ok(Finished { disparity_px: None, statistics: Statistics::default(), files: folder.seal(manifest)? })
}

/// The elemental image array, which has the memory order of the render.
fn grid(field: &LightFieldOwned<f32>) -> Result<ArrayView3<'_, f32>, Error> {
    field.as_elemental_grid().ok_or_else(|| {
        Error::Failed("the light field does not have the memory order of an elemental image array".into())
    })
}

/// The light field of all shards.
pub(super) fn traced(parts: &Parts<'_>) -> Result<(Traced, RenderSpec), Error> {
    let manifest = parts.manifest.clone();
    let spec = spec(&manifest)?;
    let parameters = ParametersCfg::read(parts.folder().join(dataset::PARAMETERS_CFG))?;
    let broken = |what: String| Error::Failed(format!("{}: {what}", parts.folder().display()));
    let rig = manifest.rig.ok_or_else(|| broken("the manifest has no rig".into()))?;
    let shape = *rig.shape();
    let wanted = Wanted::new(&spec);
    let gather = |name: &str, shape: LightFieldShape, channels: usize| -> Result<LightFieldOwned<f32>, Error> {
        let grid = parts.gather(name, shape.raw_size(), shape.views().rows, channels)?;
        Ok(LightField::from_elemental_grid(grid, shape)?)
    };

    let color = parts.has(COLOR).then(|| gather(COLOR, shape, 3)).transpose()?;
    let error = parts.has(ERROR).then(|| gather(ERROR, shape, 1)).transpose()?;
    let visibility = parts.has(VISIBILITY).then(|| parts.gather(VISIBILITY, shape.lenses(), 1, 1)).transpose()?;
    let visibility = visibility.map(|visibility| visibility.index_axis_move(Axis(2), 0));
    let mut central: Layers<Array3<f32>> = Layers::default();
    let mut all: Layers<LightFieldOwned<f32>> = Layers::default();
    for layer in Layer::ALL {
        let name = central_file(layer);
        if parts.has(&name) {
            central.extend([(layer, parts.gather(&name, shape.lenses(), 1, layer.channels())?)]);
        }
        let name = all_file(layer);
        if parts.has(&name) {
            all.extend([(layer, gather(&name, shape, layer.channels())?)]);
        }
    }
    let all = (!all.set().is_empty()).then_some(all);
    let (integrator, why, rays, samples) = (parts.integrator(), parts.why(), parts.rays(), parts.samples());
    let error_distribution = parts.error_distribution();
    let rendered = Rendered { color, error, error_distribution, central, all, integrator, why, rays, samples };
    let (highres_depth_m, motion, warnings) = (None, Vec::new(), Vec::new());
    let traced = Traced { rendered, wanted, rig, manifest, parameters, highres_depth_m, visibility, motion, warnings };
    Ok((traced, spec))
}
