//! One render: every array of it, in turn.

use holo_core::{Layout, LightField, LightFieldOwned, LightFieldShape};
use ndarray::Array3;

use super::Renderer;
use super::plan::{Plan, Region};
use super::request::{GroundTruth, Rendered, Request, Views};
use super::work::Work;
use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::film::layers::{LayerSet, Layers};
use crate::integrator::depth::DepthTile;
use crate::integrator::path::{PathTile, Scratch};
use crate::integrator::truth::TruthTile;
use crate::integrator::{Context, Integrator, RayCounts};
use crate::progress::{Progress, Stop};
use crate::simd;

impl Renderer {
    /// Renders on this thread's pool.
    pub(super) fn render_here(&self, request: &Request, progress: &dyn Progress) -> Result<Rendered, Error> {
        let (integrator, why) = self.choose(request)?;
        let plan = Plan::new(request, integrator);
        let stop = Stop::new(progress);
        let with_color = integrator != Integrator::Depth;
        let with_layers = !request.layers.is_empty();
        let with_all = request.ground_truth == GroundTruth::All && with_layers;
        // The central view is one of all views; of a list it may be none.
        let with_central = with_layers && !(with_all && request.views == Views::All);

        // The large arrays first: a size that does not fit is refused before anything else is made for it.
        let mut color = if with_color { Some(zeros(plan.color.shape()?, 3)?) } else { None };
        let mut all = if with_all { Some(light_fields(plan.all.shape()?, request.layers)?) } else { None };
        let tile_count = |wanted: bool, region: &Region| if wanted { region.tiling.tiles().len() as u64 } else { 0 };
        let total = tile_count(with_color, &plan.color)
            + tile_count(with_all, &plan.all)
            + tile_count(with_central, &plan.central);
        let work = Work::new(progress, &stop, total);
        let mut rays = RayCounts::default();
        let mut samples = 0;

        if let Some(color) = &mut color {
            let context = self.context(request, integrator, &plan.color, &stop);
            let tiling = &plan.color.tiling;
            let trace = |tile: &Tile, color, scratch: &mut Scratch| {
                simd::run(PathTile { context: &context, tile, color, scratch })
            };
            rays = work.run(tiling, tiling.cut(color.samples_mut()), trace)?;
            // Every sample has one ray from the camera.
            samples = rays.primary;
        }
        // The ground truth has rays of its own, through the pixels' centers, however many samples color takes.
        let truth = |region: &Region, fields: &mut Layers<LightFieldOwned<f32>>| {
            let context = self.context(request, Integrator::Depth, region, &stop);
            trace_truth(&context, &region.tiling, &work, fields)
        };
        if let Some(all) = &mut all {
            rays = rays + truth(&plan.all, all)?;
        }
        let central = match &all {
            Some(all) if !with_central => {
                let (t, s) = request.rig.shape().central_view();
                let images = all.iter().map(|(layer, field)| Ok((layer, field.view(t, s)?.to_owned())));
                images.collect::<Result<_, Error>>()?
            }
            _ if with_central => {
                let mut fields = light_fields(plan.central.shape()?, request.layers)?;
                rays = rays + truth(&plan.central, &mut fields)?;
                fields.into_iter().map(|(layer, field)| Ok((layer, only_view(field)?))).collect::<Result<_, Error>>()?
            }
            _ => Layers::default(),
        };
        if stop.requested() {
            return Err(Error::Cancelled);
        }
        Ok(Rendered { color, central, all, integrator, why, rays, samples })
    }
}

/// Light fields for `layers`.
pub(super) fn light_fields(split: LightFieldShape, layers: LayerSet) -> Result<Layers<LightFieldOwned<f32>>, Error> {
    layers.iter().map(|layer| Ok((layer, zeros(split, layer.channels())?))).collect()
}

/// A light field of zeros whose memory is an elemental grid.
pub(super) fn zeros(split: LightFieldShape, channels: usize) -> Result<LightFieldOwned<f32>, Error> {
    Ok(LightField::filled(split, channels, Layout::ElementalGrid, 0.0)?)
}

/// Fills layers.
fn trace_truth(
    context: &Context,
    tiling: &Tiling,
    work: &Work,
    fields: &mut Layers<LightFieldOwned<f32>>,
) -> Result<RayCounts, Error> {
    work.run(tiling, tiles(fields, tiling), |tile, out, truth| simd::run(DepthTile { context, tile, out, truth }))
}

/// All layers cut into the same tiles.
pub(super) fn tiles<'a>(fields: &'a mut Layers<LightFieldOwned<f32>>, tiling: &Tiling) -> Vec<TruthTile<'a>> {
    let mut tiles = Vec::new();
    for (layer, field) in fields.iter_mut() {
        let parts = tiling.cut(field.samples_mut());
        tiles.resize_with(parts.len(), TruthTile::default);
        tiles.iter_mut().zip(parts).for_each(|(tile, part)| tile.extend([(layer, part)]));
    }
    tiles
}

/// The image of a light field of one view.
fn only_view(field: LightFieldOwned<f32>) -> Result<Array3<f32>, Error> {
    Ok(field.into_elemental_grid().or_else(|field| field.to_elemental_grid())?)
}
