//! Color: its light fields while they are rendered, and their reconstruction across views.

use holo_core::{BaselineRatio, Disparity, GridSize, LightField, LightFieldOwned, LightFieldShape, Rig};
use ndarray::{Array3, ArrayViewMut5, s};

use super::checkpoint::TileKind;
use super::image::zeros;
use super::plan::{Plan, Region};
use super::request::{Denoise, Request};
use super::work::{TileOutput, Work};
use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::film::guides;
use crate::film::reconstruct::{HALO, Reconstruction};
use crate::integrator::path::{PathTile, Scratch};
use crate::integrator::{Context, RayCounts};
use crate::simd;

/// The disparity along which views are reconstructed: that of [`BaselineRatio`].
pub(super) fn disparity(rig: &Rig) -> Disparity {
    if rig.baseline_ratio() == BaselineRatio::VERTICAL_ONLY { rig.disparity_y() } else { rig.disparity_x() }
}

/// Whether a render needs the guides of its pixels.
pub(super) fn needs_guides(request: &Request) -> bool {
    request.denoise == Denoise::Views || request.estimate_error
}

/// The lens rows on each side that are rendered for the reconstruction of others.
pub(super) fn margin(request: &Request) -> usize {
    if needs_guides(request) { HALO } else { 0 }
}

/// The light fields of a render: color, and the guides of the reconstruction.
pub(super) struct ColorFields {
    color: LightFieldOwned<f32>,
    guides: Option<LightFieldOwned<f32>>,
}

/// Color and its estimated error.
type Finished = (Option<LightFieldOwned<f32>>, Option<LightFieldOwned<f32>>);

/// The memory of a tile in them.
struct ColorTile<'a> {
    color: ArrayViewMut5<'a, f32>,
    guides: Option<ArrayViewMut5<'a, f32>>,
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
    pub fn new(request: &Request, region: &Region) -> Result<Self, Error> {
        let shape = region.shape()?;
        let guides = if needs_guides(request) { Some(zeros(shape, guides::CHANNELS)?) } else { None };
        Ok(Self { color: zeros(shape, 3)?, guides })
    }

    /// Renders all tiles.
    pub fn trace(&mut self, context: &Context, tiling: &Tiling, work: &Work) -> Result<RayCounts, Error> {
        let trace = |tile: &Tile, out: &mut ColorTile, scratch: &mut Scratch| {
            let (color, guides) = (out.color.view_mut(), out.guides.as_mut().map(|guides| guides.view_mut()));
            simd::run(PathTile { context, tile, color, guides, scratch })
        };
        work.run(TileKind::Color, tiling, self.tiles(tiling), trace)
    }

    /// Splits the light fields into tiles.
    fn tiles(&mut self, tiling: &Tiling) -> Vec<ColorTile<'_>> {
        let colors = tiling.cut(self.color.samples_mut());
        let Some(guides) = &mut self.guides else {
            return colors.into_iter().map(|color| ColorTile { color, guides: None }).collect();
        };
        let guides = tiling.cut(guides.samples_mut());
        colors.into_iter().zip(guides).map(|(color, guides)| ColorTile { color, guides: Some(guides) }).collect()
    }

    /// Color and its error in the requested lens rows: reconstructed and estimated, if there are guides.
    pub fn finish(self, request: &Request, plan: &Plan, work: &Work) -> Result<Finished, Error> {
        let Some(guides) = self.guides else { return Ok((Some(self.color), None)) };
        let rendered = &plan.color.selection.lens_rows;
        let wanted = request.lens_row_range();
        let rows = wanted.start - rendered.start..wanted.end - rendered.start;
        let views = self.color.shape().views();
        let lenses = GridSize::new(rows.len(), self.color.shape().lenses().columns);
        let ratio = request.rig.baseline_ratio();
        let mut error = if request.estimate_error { Some(grid(zeros(self.color.shape(), 1)?)?) } else { None };
        let (mut color, mut guides) = (grid(self.color)?, grid(guides)?);
        let [v, u, t, s] = plan.color.selection.counts();
        let reconstruction = Reconstruction {
            shape: [v, u, t, s],
            color: values(&mut color)?,
            guides: values(&mut guides)?,
            movement: [ratio.vertical() as f32, ratio.horizontal() as f32],
            samples: request.samples,
            filters: request.denoise == Denoise::Views,
            rows: rows.clone(),
            error: error.as_mut().map(values).transpose()?,
        };
        reconstruction.run(|| work.step());
        let shape = LightFieldShape::new(views, lenses)?;
        let only = |image: Array3<f32>| -> Result<LightFieldOwned<f32>, Error> {
            let image = if rows.len() < v {
                image.slice(s![rows.start * views.rows..rows.end * views.rows, .., ..]).to_owned()
            } else {
                image
            };
            Ok(LightField::from_elemental_grid(image, shape)?)
        };
        Ok((Some(only(color)?), error.map(only).transpose()?))
    }
}

/// The color and the guides of a request before the reconstruction, as elemental image arrays.
#[cfg(feature = "bench")]
pub(crate) fn samples(renderer: &super::Renderer, request: &Request) -> Result<[Array3<f32>; 2], Error> {
    let request = request.clone().denoise(Denoise::Views);
    let (integrator, _) = renderer.choose(&request)?;
    let plan = Plan::new(&request, integrator);
    let stop = crate::progress::Stop::new(&());
    let work = Work::new(&(), &stop, None, std::iter::empty(), 0);
    let mut fields = ColorFields::new(&request, &plan.color)?;
    let context = renderer.context(&request, integrator, &plan.color, &stop);
    renderer.install(|| fields.trace(&context, &plan.color.tiling, &work))?;
    let guides = fields.guides.ok_or_else(|| Error::BadSetting("no guides".into()))?;
    Ok([grid(fields.color)?, grid(guides)?])
}

/// All values of an elemental image array, which has no gaps in memory.
fn values(image: &mut Array3<f32>) -> Result<&mut [f32], Error> {
    let gaps = || Error::BadSetting("the light field has gaps in memory; report this, with the request".into());
    image.as_slice_mut().ok_or_else(gaps)
}

/// The elemental image array; light fields of a render have its memory order.
fn grid(field: LightFieldOwned<f32>) -> Result<Array3<f32>, Error> {
    Ok(field.into_elemental_grid().or_else(|field| field.to_elemental_grid())?)
}
