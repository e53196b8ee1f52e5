//! The raw image of a plenoptic camera.
//!
//! [Color](color) is rendered microlens by microlens, in bands of lines of the array. A pixel sums the light of every
//! microlens that reaches it, in the order of the lines and along them, so the result does not depend on threads or on
//! which rows are rendered. Ground truth is that of the chief ray of every pixel.

mod color;

use std::collections::BTreeMap;
use std::ops::{Deref, Range};

use holo_core::plenoptic::{MicrolensIndex, PlenopticCamera};
use holo_core::{GridSize, Layout, LightField, LightFieldShape};
use ndarray::{Array2, Array3, Array5};
use rayon::prelude::*;

use self::color::{Finished, RawColor};
use super::Renderer;
use super::checkpoint::{Checkpoint, TileKind};
use super::plan::needs_guides;
use super::request::{Denoise, RawStatistics, Rendered, Request};
use super::rounds;
use super::work::Work;
use crate::camera::RaySource;
use crate::camera::plenoptic::{PlenopticRays, RawLens, RawPacket, RawPixels};
use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::film::guides::Movement;
use crate::film::layers::Layers;
use crate::geometry::MAX_COORDINATE_M;
use crate::integrator::aov::{AovTile, TileAovs};
use crate::integrator::depth::DepthTile;
use crate::integrator::progress::{Progress, Stop};
use crate::integrator::{Context, Integrator, Policy, RayCounts};
use crate::sampling::{self, Sampler};
use crate::simd::{self, LANES};

/// The rows of pixels whose ground truth is rendered together; a multiple of the height of a packet.
const TRUTH_ROWS: usize = 64;

/// The side of the block of pixels of a packet of ground truth.
const BLOCK: usize = 4;

/// A request of a plenoptic camera.
#[derive(Clone, Copy)]
pub(super) struct RawRequest<'a> {
    pub camera: &'a PlenopticCamera,
    pub request: &'a Request,
}

impl Deref for RawRequest<'_> {
    type Target = Request;

    fn deref(&self) -> &Request {
        self.request
    }
}

/// Validates a request of a plenoptic camera.
pub(super) fn check(request: &Request, camera: &PlenopticCamera) -> Result<(), Error> {
    request.check_needs_color()?;
    let size = camera.sensor().size;
    if size.count() > u32::MAX as usize {
        return Err(Error::BadSetting("a sensor of 2^32 or more pixels; choose fewer".into()));
    }
    for corner in [[0.0, 0.0], [size.columns as f64, size.rows as f64]] {
        let place = camera.place_m(corner);
        let lens = camera.owner(place);
        let Some(ray) = camera.ray(place, camera.lens_center_m(lens), lens) else { continue };
        if !ray.origin_m.iter().chain(&ray.direction).all(|x| x.abs() < MAX_COORDINATE_M) {
            return Err(Error::BadSetting(format!(
                "the camera is too large: a ray starts at {:?} m and runs along {:?}",
                ray.origin_m, ray.direction
            )));
        }
    }
    Ok(())
}

impl RawStatistics {
    /// From the values of [`crate::film::inverse_depth`].
    fn new(sums: &Array3<f32>) -> Self {
        let (rows, columns, _) = sums.dim();
        let image = |value: fn([f32; 4]) -> f32| {
            Array2::from_shape_fn((rows, columns), |(row, column)| {
                let values = [0, 1, 2, 3].map(|k| sums[[row, column, k]]);
                if values[0] > 0.0 { value(values) } else { 0.0 }
            })
        };
        Self {
            inverse_depth_mean: image(|values| values[2]),
            inverse_depth_deviation: image(|values| (values[3] / values[0]).sqrt()),
            coverage: image(|values| values[1] / values[0]),
        }
    }
}

impl Renderer {
    /// Renders the raw image of a plenoptic camera in the current thread pool.
    pub(super) fn render_raw(
        &self,
        request: &RawRequest,
        progress: &dyn Progress,
        checkpoint: Option<&dyn Checkpoint>,
    ) -> Result<Rendered, Error> {
        let (integrator, why) = self.integrator(&request.transport);
        let stop = Stop::new(progress);
        let wider = color::with_margin(request);
        let with_margin = RawRequest { camera: request.camera, request: &wider };
        let has_color = integrator != Integrator::Depth;
        let color = has_color.then(|| RawColor::new(with_margin, request.row_range(), integrator)).transpose()?;
        let truth = if request.layers.is_empty() { Vec::new() } else { truth_rows(request) };
        let truth_tiles = |truth: &[Range<usize>]| {
            truth.iter().map(|rows| Tiling::new(truth_counts(request, rows)).tiles().len()).sum::<usize>()
        };
        let (color_tiles, steps) = color.as_ref().map_or((0, 0), |color| (color.tiles(), color.steps()));
        let kinds = [(TileKind::Color, color_tiles), (TileKind::AllLayers, truth_tiles(&truth))].into_iter();
        let work = Work::new(progress, &stop, checkpoint, kinds, steps);
        let traced = color.as_ref().map(|color| color.trace(self, &work)).transpose()?;
        let (sums, mut rays) = traced.map_or((None, RayCounts::default()), |(sums, rays)| (Some(sums), rays));
        // Every sample has one camera ray.
        let samples = rays.primary;
        let mut layers: Layers<Array3<f32>> = request
            .layers
            .iter()
            .map(|layer| Ok((layer, zeros(request, layer.channels())?)))
            .collect::<Result<_, Error>>()?;
        for (number, rows) in truth.iter().enumerate() {
            let first = truth_tiles(&truth[..number]);
            rays = rays + self.trace_truth(request, (rows.clone(), first), &work, &mut layers)?;
        }
        let finished = color.zip(sums).map(|(color, sums)| color.finish(sums, &work)).transpose()?;
        if stop.requested() {
            return Err(Error::Cancelled);
        }
        let shape = shape(request)?;
        let field = |image: Array3<f32>| LightField::from_elemental_grid(image, shape);
        let mut out = Rendered {
            color: None,
            error: None,
            error_distribution: None,
            central: layers,
            all: None,
            statistics: None,
            integrator,
            why,
            rays,
            samples,
        };
        if let Some(Finished { color, error, error_distribution, inverse_depths }) = finished {
            out.color = Some(field(color)?);
            (out.error, out.error_distribution) = (error.map(field).transpose()?, error_distribution);
            out.statistics = inverse_depths.filter(|_| request.statistics).map(|sums| RawStatistics::new(&sums));
        }
        Ok(out)
    }

    /// Renders the layers of some rows, whose tiles are numbered from `first_tile`.
    fn trace_truth(
        &self,
        request: &RawRequest,
        (rows, first_tile): (Range<usize>, usize),
        work: &Work,
        layers: &mut Layers<Array3<f32>>,
    ) -> Result<RayCounts, Error> {
        let tiling = Tiling::new(truth_counts(request, &rows));
        let pixels = truth_pixels(request.camera, rows);
        let count = pixels.packets.len();
        let mut fields: Layers<Array5<f32>> =
            request.layers.iter().map(|layer| (layer, Array5::zeros((1, count, 1, LANES, layer.channels())))).collect();
        let rays = PlenopticRays::new(request.camera, pixels);
        let context = self.raw_context(request, Integrator::Depth, rays, work);
        let mut outputs: Vec<AovTile> = Vec::new();
        for (layer, field) in fields.iter_mut() {
            let cut = tiling.cut(field.view_mut());
            outputs.resize_with(cut.len(), AovTile::default);
            outputs.iter_mut().zip(cut).for_each(|(tile, output)| tile.extend([(layer, output)]));
        }
        let trace = |tile: &Tile, out: &mut AovTile, aov: &mut TileAovs| {
            let out = out.iter_mut().map(|(layer, output)| (layer, output.view_mut())).collect();
            simd::run(DepthTile { context: &context, tile, out, aov })
        };
        let rays = work.run(TileKind::AllLayers, first_tile, &tiling, outputs, trace)?;
        let first = request.row_range().start;
        let packets = context.camera.raw_packets();
        for ((_, image), (layer, field)) in layers.iter_mut().zip(fields.iter()) {
            debug_assert_eq!(field.dim().4, layer.channels());
            scatter(packets, field, first, image, |pixel, value| pixel.copy_from_slice(value));
        }
        Ok(rays)
    }

    fn raw_context<'a>(
        &'a self,
        request: &RawRequest,
        integrator: Integrator,
        rays: PlenopticRays,
        work: &Work<'a>,
    ) -> Context<'a> {
        let transport = &request.transport;
        let has_guides = needs_guides(request);
        // The windows of the reconstruction hold so many samples that the bias of the filter would be what is left.
        let filters = self.filters_textures(transport) && request.denoise == Denoise::Off;
        let sampler = Sampler {
            seed: transport.seed,
            samples: transport.samples.of_traced(),
            sampling: transport.sampling,
            centered: transport.samples == 1.into(),
            cells: filters.then(|| sampling::cells(transport.samples.of_traced())),
        };
        Context {
            scene: self.scene_data(transport, integrator),
            camera: RaySource::Plenoptic(Box::new(rays)),
            sampler,
            policy: Policy {
                target_error: transport.target_error.filter(|_| rounds::target(request).is_none()),
                ..self.policy(transport, integrator)
            },
            guides: has_guides.then_some(Movement::Statistics),
            moved: self.moved.as_ref(),
            inverse_depths: (request.statistics || has_guides) && integrator != Integrator::Depth,
            stop: work.stop(),
        }
    }
}

/// Hands the values of packets to the pixels of an image that begins at row `first`; pixels of other rows are left to
/// others.
fn scatter(
    packets: &[RawPacket],
    field: &Array5<f32>,
    first: usize,
    image: &mut Array3<f32>,
    put: impl Fn(&mut [f32], &[f32]),
) {
    let (columns, channels) = (image.dim().1, field.dim().4);
    let (pixels, values) = (image.as_slice_mut().unwrap_or_default(), field.as_slice().unwrap_or_default());
    for (packet, values) in packets.iter().zip(values.chunks_exact(channels * LANES)) {
        for lane in 0..packet.count as usize {
            let Some(row) = (packet.pixel[0][lane] as usize).checked_sub(first) else { continue };
            let place = row * columns + packet.pixel[1][lane] as usize;
            if let Some(pixel) = pixels.get_mut(channels * place..channels * (place + 1)) {
                put(pixel, &values[channels * lane..channels * (lane + 1)]);
            }
        }
    }
}

/// Zeros for the requested rows.
fn zeros(request: &RawRequest, channels: usize) -> Result<Array3<f32>, Error> {
    let field = LightField::filled(shape(request)?, channels, Layout::ElementalGrid, 0.0)?;
    Ok(field.into_elemental_grid().or_else(|field| field.to_elemental_grid())?)
}

/// The requested rows as a light field of one view.
fn shape(request: &RawRequest) -> Result<LightFieldShape, Error> {
    let size = GridSize::new(request.row_range().len(), request.camera.sensor().size.columns);
    Ok(LightFieldShape::new(GridSize::new(1, 1), size)?)
}

/// Rows whose ground truth is rendered together.
fn truth_rows(request: &RawRequest) -> Vec<Range<usize>> {
    let Range { start, end } = request.row_range();
    // The boundaries of packets are the same for any rows.
    let first = start / TRUTH_ROWS * TRUTH_ROWS;
    (first..end).step_by(TRUTH_ROWS).map(|row| row..(row + TRUTH_ROWS).min(request.camera.sensor().size.rows)).collect()
}

/// Packets one after another, as the lenses of a row: of several rows a tile would have one packet.
fn counts(packets: usize) -> [usize; 4] {
    [1, packets, 1, LANES]
}

fn truth_counts(request: &RawRequest, rows: &Range<usize>) -> [usize; 4] {
    let blocks = rows.len().div_ceil(BLOCK) * request.camera.sensor().size.columns.div_ceil(BLOCK);
    counts(blocks)
}

/// The pixels of some rows in blocks, each with the microlens that owns it.
fn truth_pixels(camera: &PlenopticCamera, rows: Range<usize>) -> RawPixels {
    let columns = camera.sensor().size.columns;
    let of_blocks = |first_row: usize| {
        let mut pixels = RawPixels::default();
        let mut known: BTreeMap<MicrolensIndex, u32> = BTreeMap::new();
        for first_column in (0..columns).step_by(BLOCK) {
            // Lanes beyond the edges repeat its pixels: they are rendered again, to the same values.
            let mut packet = RawPacket { count: LANES as u32, pixel: [[0; LANES]; 2], lens: [0; LANES] };
            for k in 0..LANES {
                let row = (first_row + k / BLOCK).min(rows.end - 1);
                let column = (first_column + k % BLOCK).min(columns - 1);
                let owner = camera.owner(camera.place_m([column as f64 + 0.5, row as f64 + 0.5]));
                [packet.pixel[0][k], packet.pixel[1][k]] = [row as u32, column as u32];
                packet.lens[k] = *known.entry(owner).or_insert_with(|| {
                    pixels.lenses.push(RawLens::new(camera, camera.microlens(owner)));
                    pixels.lenses.len() as u32 - 1
                });
            }
            pixels.packets.push(packet);
        }
        pixels
    };
    let blocks: Vec<usize> = rows.clone().step_by(BLOCK).collect();
    RawPixels::joined(&blocks.into_par_iter().map(of_blocks).collect::<Vec<_>>())
}
