//! The execution of a request of a rig.

use holo_core::{LightFieldOwned, LightFieldShape};
use ndarray::Array3;

use super::Renderer;
use super::checkpoint::{Checkpoint, TileKind};
use super::color::{ColorFields, Finished, zeros};
use super::plan::{Plan, Region, needs_guides};
use super::request::{GroundTruth, Rendered, RigRequest, Views};
use super::rounds;
use super::work::Work;
use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::film::layers::{LayerSet, Layers};
use crate::integrator::aov::{AovTile, TileAovs};
use crate::integrator::depth::DepthTile;
use crate::integrator::progress::{Progress, Stop};
use crate::integrator::{Context, Integrator, RayCounts};
use crate::simd;

impl Renderer {
    /// Renders the light field of a rig in the current thread pool.
    pub(super) fn render_rig(
        &self,
        request: &RigRequest,
        progress: &dyn Progress,
        checkpoint: Option<&dyn Checkpoint>,
    ) -> Result<Rendered, Error> {
        let (integrator, why) = self.choose(request)?;
        let plan = Plan::new(request, integrator);
        let stop = Stop::new(progress);
        let with_color = integrator != Integrator::Depth;
        let with_layers = !request.layers.is_empty();
        let with_all = request.ground_truth == GroundTruth::All && with_layers;
        // The grid of all views contains the central view; a list may not.
        let with_central = with_layers && !(with_all && request.views == Views::All);

        // The large arrays are allocated first, so that a size that does not fit into memory fails early.
        let mut color = if with_color { Some(ColorFields::new(request, &plan.color)?) } else { None };
        let mut all = if with_all { Some(light_fields(plan.all.shape()?, request.layers)?) } else { None };
        let kinds = [
            (with_color, TileKind::Color, &plan.color),
            (with_all, TileKind::AllLayers, &plan.all),
            (with_central, TileKind::CentralLayers, &plan.central),
        ];
        let steps = if with_color && needs_guides(request) { request.row_range().len() } else { 0 };
        let wanted = kinds.into_iter().filter(|(wanted, ..)| *wanted);
        let rounds = rounds::rounds(request).len();
        let counts = wanted.map(|(_, kind, region)| {
            let rounds = if kind == TileKind::Color { rounds } else { 1 };
            (kind, region.tiling.tiles().len() * rounds)
        });
        let work = Work::new(progress, &stop, checkpoint, counts, steps);
        let mut rays = RayCounts::default();
        let mut samples = 0;

        if let Some(color) = &mut color {
            let context = self.context(request, integrator, &plan.color, &stop);
            rays = color.trace(request, &context, &plan.color.tiling, &work)?;
            // Every sample has one camera ray.
            samples = rays.primary;
        }
        // Ground truth has rays of its own through the centers of the pixels, independent of the samples of color.
        let aov = |kind: TileKind, region: &Region, fields: &mut Layers<LightFieldOwned<f32>>| {
            let context = self.context(request, Integrator::Depth, region, &stop);
            trace_aovs(&context, kind, &region.tiling, &work, fields)
        };
        if let Some(all) = &mut all {
            rays = rays + aov(TileKind::AllLayers, &plan.all, all)?;
        }
        let central = match &all {
            Some(all) if !with_central => {
                let (t, s) = request.rig.shape().central_view();
                let images = all.iter().map(|(layer, field)| Ok((layer, field.view(t, s)?.to_owned())));
                images.collect::<Result<_, Error>>()?
            }
            _ if with_central => {
                let mut fields = light_fields(plan.central.shape()?, request.layers)?;
                rays = rays + aov(TileKind::CentralLayers, &plan.central, &mut fields)?;
                fields.into_iter().map(|(layer, field)| Ok((layer, only_view(field)?))).collect::<Result<_, Error>>()?
            }
            _ => Layers::default(),
        };
        let Finished { color, error, error_distribution } =
            color.map(|fields| fields.finish(request, &plan, &work)).transpose()?.unwrap_or_default();
        if stop.requested() {
            return Err(Error::Cancelled);
        }
        let statistics = None;
        Ok(Rendered { color, error, error_distribution, central, all, statistics, integrator, why, rays, samples })
    }
}

/// Light fields of zeros for `layers`.
pub(super) fn light_fields(split: LightFieldShape, layers: LayerSet) -> Result<Layers<LightFieldOwned<f32>>, Error> {
    layers.iter().map(|layer| Ok((layer, zeros(split, layer.channels())?))).collect()
}

/// Renders the layers of `fields`.
fn trace_aovs(
    context: &Context,
    kind: TileKind,
    tiling: &Tiling,
    work: &Work,
    fields: &mut Layers<LightFieldOwned<f32>>,
) -> Result<RayCounts, Error> {
    let trace = |tile: &Tile, out: &mut AovTile, aov: &mut TileAovs| {
        let out = out.iter_mut().map(|(layer, output)| (layer, output.view_mut())).collect();
        simd::run(DepthTile { context, tile, out, aov })
    };
    work.run(kind, 0, tiling, tiles(fields, tiling), trace)
}

/// Splits all layers into the same tiles.
pub(super) fn tiles<'a>(fields: &'a mut Layers<LightFieldOwned<f32>>, tiling: &Tiling) -> Vec<AovTile<'a>> {
    let mut tiles = Vec::new();
    for (layer, field) in fields.iter_mut() {
        let outputs = tiling.cut(field.samples_mut());
        tiles.resize_with(outputs.len(), AovTile::default);
        tiles.iter_mut().zip(outputs).for_each(|(tile, output)| tile.extend([(layer, output)]));
    }
    tiles
}

/// The image of a light field with one view.
fn only_view(field: LightFieldOwned<f32>) -> Result<Array3<f32>, Error> {
    Ok(field.into_elemental_grid().or_else(|field| field.to_elemental_grid())?)
}
