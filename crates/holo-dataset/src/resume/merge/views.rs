//! Shards of a light field: some of its lens rows.

use holo_core::{LightField, LightFieldOwned, LightFieldShape};
use holo_io::{ParametersCfg, dataset};
use holo_render::{Layer, Layers, Rendered};
use ndarray::{Array3, Axis};

use super::{COLOR, Parts, Put, grid};
use crate::Error;
use crate::output::{Traced, TracedCamera, TracedViews, Wanted};
use crate::settings::{Camera, RenderSettings, from_manifest};

const ERROR: &str = "error.pfm";

const VISIBILITY: &str = "visibility.pfm";

fn central_file(layer: Layer) -> String {
    format!("central_{}.pfm", layer.name())
}

fn all_file(layer: Layer) -> String {
    format!("all_{}.pfm", layer.name())
}

/// Writes the layers of a shard.
pub(super) fn write(rendered: &Rendered, views: &TracedViews, put: &mut Put) -> Result<(), Error> {
    if let Some(error) = &rendered.error {
        put(ERROR.into(), grid(error)?)?;
    }
    if let Some(visibility) = &views.visibility {
        put(VISIBILITY.into(), visibility.view().insert_axis(Axis(2)))?;
    }
    for (layer, image) in rendered.central.iter() {
        put(central_file(layer), image.view())?;
    }
    for (layer, field) in rendered.all.iter().flat_map(Layers::iter) {
        put(all_file(layer), grid(field)?)?;
    }
    Ok(())
}

/// The light field of all shards.
pub(super) fn traced(parts: &Parts) -> Result<(Traced, RenderSettings), Error> {
    let manifest = parts.manifest.clone();
    let settings = from_manifest(&manifest, Camera::default())?;
    let parameters = ParametersCfg::read_in(parts.folder(), dataset::PARAMETERS_CFG)?;
    let broken = |what: String| Error::Failed(format!("{}: {what}", parts.folder().path().display()));
    let rig = manifest.rig.ok_or_else(|| broken("the manifest has no rig".into()))?;
    let shape = *rig.shape();
    let wanted = Wanted::new(&settings)?;
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
    let statistics = None;
    let rendered =
        Rendered { color, error, error_distribution, central, all, statistics, integrator, why, rays, samples };
    let views = TracedViews { rig, parameters, highres_depth_m: None, visibility, motion: Vec::new() };
    Ok((Traced { rendered, wanted, manifest, camera: TracedCamera::Rig(Box::new(views)) }, settings))
}
