//! Color: its light fields while they are rendered, and their reconstruction across views.

use std::ops::Range;

use holo_core::{BaselineRatio, Disparity, GridSize, Layout, LightField, LightFieldOwned, LightFieldShape, Rig};
use ndarray::{Array3, ArrayViewMut5, s};

use super::checkpoint::TileKind;
use super::plan::{Plan, Region, needs_guides};
use super::request::{Denoise, RigRequest};
use super::rounds;
use super::work::{TileOutput, Work};
use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::film::error_distribution::ErrorDistribution;
use crate::film::guides;
use crate::film::reconstruct::Reconstruction;
use crate::integrator::path::{PathTile, Scratch};
use crate::integrator::{Context, RayCounts};
use crate::simd::{self, LANES};

/// The disparity along which views are reconstructed: that of [`BaselineRatio`].
pub(super) fn disparity(rig: &Rig) -> Disparity {
    if rig.baseline_ratio() == BaselineRatio::VERTICAL_ONLY { rig.disparity_y() } else { rig.disparity_x() }
}

/// The light fields of a render: color, and the guides of the reconstruction.
pub(super) struct ColorFields {
    color: LightFieldOwned<f32>,
    guides: Option<LightFieldOwned<f32>>,
}

/// A light field of zeros in the memory layout of the elemental image array.
pub(super) fn zeros(split: LightFieldShape, channels: usize) -> Result<LightFieldOwned<f32>, Error> {
    Ok(LightField::filled(split, channels, Layout::ElementalGrid, 0.0)?)
}

/// Color with its estimated error.
#[derive(Default)]
pub(super) struct Finished {
    pub color: Option<LightFieldOwned<f32>>,
    pub error: Option<LightFieldOwned<f32>>,
    pub error_distribution: Option<ErrorDistribution>,
}

/// The memory of a tile in them.
struct ColorTile<'a> {
    color: ArrayViewMut5<'a, f32>,
    guides: Option<ArrayViewMut5<'a, f32>>,
    /// The estimated error before the round, which is not a part of the result.
    error: Option<ArrayViewMut5<'a, f32>>,
}

impl TileOutput for ColorTile<'_> {
    fn values(&self) -> Vec<f32> {
        self.color.iter().chain(self.guides.iter().flatten()).copied().collect()
    }

    fn count(&self) -> usize {
        self.color.len() + self.guides.as_ref().map_or(0, ArrayViewMut5::len)
    }

    fn fill(&mut self, values: &[f32]) {
        let (color, guides) = values.split_at(self.color.len());
        self.color.fill(color);
        if let Some(own) = &mut self.guides {
            own.fill(guides);
        }
    }
}

impl ColorFields {
    /// Zeros for the pixels of `region`.
    pub fn new(request: &RigRequest, region: &Region) -> Result<Self, Error> {
        let shape = region.shape()?;
        let guides = if needs_guides(request) { Some(zeros(shape, guides::CHANNELS)?) } else { None };
        Ok(Self { color: zeros(shape, 3)?, guides })
    }

    /// Renders all tiles, in rounds if there is a target for the error after the reconstruction.
    pub fn trace(
        &mut self,
        request: &RigRequest,
        context: &Context,
        tiling: &Tiling,
        work: &Work,
    ) -> Result<RayCounts, Error> {
        let rounds = rounds::rounds(request);
        let target = rounds::target(request).unwrap_or(0.0);
        let mut rays = RayCounts::default();
        for (k, round) in rounds.iter().enumerate() {
            let mut error = match k {
                0 => None,
                _ => Some(self.estimate(request, work)?),
            };
            let largest = error.as_ref().map(|error| error.samples().fold(0.0, |high: f32, &error| high.max(error)));
            if largest.is_some_and(|largest| largest <= target) {
                work.leave_out((rounds.len() - k) * tiling.tiles().len());
                break;
            }
            let trace = |tile: &Tile, out: &mut ColorTile, scratch: &mut Scratch| {
                let mut wanted = Vec::new();
                if let Some(error) = &out.error {
                    let exceeds = |packet: &[[f32; LANES]; 1]| packet[0].iter().any(|&error| error > target);
                    wanted = tile.read(error).iter().map(exceeds).collect();
                    if !wanted.contains(&true) {
                        return RayCounts::default();
                    }
                }
                let (color, guides) = (out.color.view_mut(), out.guides.as_mut().map(|guides| guides.view_mut()));
                let (inverse_depths, wanted) = (None, wanted.as_slice());
                simd::run(PathTile { context, tile, color, guides, inverse_depths, round, wanted, scratch })
            };
            let first = k * tiling.tiles().len();
            rays = rays + work.run(TileKind::Color, first, tiling, self.tiles(tiling, error.as_mut()), trace)?;
        }
        Ok(rays)
    }

    /// The error that reconstructed pixels would have with the samples so far.
    fn estimate(&mut self, request: &RigRequest, work: &Work) -> Result<LightFieldOwned<f32>, Error> {
        let mut error = zeros(self.color.shape(), 1)?;
        let rows = 0..self.color.shape().lenses().rows;
        self.reconstruct(request, rows, false, Some(&mut error), || !work.is_stopped())?;
        Ok(error)
    }

    /// Reconstructs color in some lens rows if it `replaces` the samples, and estimates its error; `None` without guides.
    fn reconstruct(
        &mut self,
        request: &RigRequest,
        rows: Range<usize>,
        replaces: bool,
        error: Option<&mut LightFieldOwned<f32>>,
        advance: impl Fn() -> bool,
    ) -> Result<Option<ErrorDistribution>, Error> {
        let (views, lenses) = (self.color.shape().views(), self.color.shape().lenses());
        let ratio = request.rig.baseline_ratio();
        let Some(guides) = &mut self.guides else { return Ok(None) };
        let reconstruction = Reconstruction {
            shape: [lenses.rows, lenses.columns, views.rows, views.columns],
            color: memory(&mut self.color)?,
            guides: memory(guides)?,
            movement: [ratio.vertical() as f32, ratio.horizontal() as f32],
            filters: request.denoise == Denoise::Views,
            replaces,
            rows,
            error: error.map(memory).transpose()?,
        };
        Ok(Some(reconstruction.run(advance)))
    }

    /// Splits the light fields into tiles.
    fn tiles<'a>(&'a mut self, tiling: &Tiling, error: Option<&'a mut LightFieldOwned<f32>>) -> Vec<ColorTile<'a>> {
        let colors = tiling.cut(self.color.samples_mut());
        let guides = self.guides.as_mut().map(|guides| tiling.cut(guides.samples_mut()));
        let errors = error.map(|error| tiling.cut(error.samples_mut()));
        let [mut guides, mut errors] = [guides, errors].map(|tiles| tiles.into_iter().flatten());
        colors.into_iter().map(|color| ColorTile { color, guides: guides.next(), error: errors.next() }).collect()
    }

    /// Color and its error in the requested lens rows: reconstructed and estimated, if there are guides.
    pub fn finish(mut self, request: &RigRequest, plan: &Plan, work: &Work) -> Result<Finished, Error> {
        if self.guides.is_none() {
            return Ok(Finished { color: Some(self.color), ..Finished::default() });
        }
        let rendered = &plan.color.selection.lens_rows;
        let wanted = request.row_range();
        let rows = wanted.start - rendered.start..wanted.end - rendered.start;
        let (views, lenses) = (self.color.shape().views(), self.color.shape().lenses());
        let mut error = if request.estimate_error { Some(zeros(self.color.shape(), 1)?) } else { None };
        let filters = request.denoise == Denoise::Views;
        let error_distribution = self.reconstruct(request, rows.clone(), filters, error.as_mut(), || work.step())?;
        let shape = LightFieldShape::new(views, GridSize::new(rows.len(), lenses.columns))?;
        let only = |field: LightFieldOwned<f32>| -> Result<LightFieldOwned<f32>, Error> {
            if rows.len() == lenses.rows {
                return Ok(field);
            }
            let image = grid(field)?.slice(s![rows.start * views.rows..rows.end * views.rows, .., ..]).to_owned();
            Ok(LightField::from_elemental_grid(image, shape)?)
        };
        Ok(Finished { color: Some(only(self.color)?), error: error.map(only).transpose()?, error_distribution })
    }
}

/// The color and the guides of a request before the reconstruction, as elemental image arrays.
#[cfg(feature = "bench")]
pub(crate) fn samples(renderer: &super::Renderer, request: &super::Request) -> Result<[Array3<f32>; 2], Error> {
    let request = request.clone().denoise(Denoise::Views);
    let (integrator, _) = renderer.choose(&request)?;
    let request = request.of_rig()?;
    let plan = Plan::new(&request, integrator);
    let stop = crate::integrator::progress::Stop::new(&());
    let work = Work::new(&(), &stop, None, std::iter::empty(), 0);
    let mut fields = ColorFields::new(&request, &plan.color)?;
    let context = renderer.context(&request, integrator, &plan.color, &stop);
    renderer.install(|| fields.trace(&request, &context, &plan.color.tiling, &work))?;
    let guides = fields.guides.ok_or_else(|| Error::BadSetting("no guides".into()))?;
    Ok([grid(fields.color)?, grid(guides)?])
}

/// All values of a light field in the order of the elemental image array, which is that of its memory.
fn memory(field: &mut LightFieldOwned<f32>) -> Result<&mut [f32], Error> {
    let gaps = || Error::BadSetting("the light field has gaps in memory; report this, with the request".into());
    field.samples_mut().permuted_axes([0, 2, 1, 3, 4]).into_slice().ok_or_else(gaps)
}

/// The elemental image array; light fields of a render have its memory order.
fn grid(field: LightFieldOwned<f32>) -> Result<Array3<f32>, Error> {
    Ok(field.into_elemental_grid().or_else(|field| field.to_elemental_grid())?)
}
