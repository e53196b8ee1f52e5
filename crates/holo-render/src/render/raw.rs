//! The raw image of a plenoptic camera.
//!
//! Color is rendered microlens by microlens, in bands of lines of the array. A pixel sums the light of every microlens
//! that reaches it, in the order of the lines and along them, so the result does not depend on threads or on which rows
//! are rendered. Ground truth is that of the chief ray of every pixel.

use std::collections::BTreeMap;
use std::ops::{Deref, Range};

use holo_core::plenoptic::{Microlens, MicrolensIndex, PlenopticCamera};
use holo_core::{GridSize, Layout, LightField, LightFieldShape};
use ndarray::{Array2, Array3, Array5, ArrayViewMut5};
use rayon::prelude::*;

use super::Renderer;
use super::checkpoint::{Checkpoint, TileKind};
use super::plan::path_tile_pixels;
use super::request::{Denoise, RawStatistics, Rendered, Request};
use super::transport::TextureFilter;
use super::work::{TileOutput, Work};
use crate::camera::RaySource;
use crate::camera::plenoptic::{PlenopticRays, RawLens, RawPacket, RawPixels};
use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::film::inverse_depth;
use crate::film::layers::Layers;
use crate::geometry::MAX_COORDINATE_M;
use crate::integrator::aov::{AovTile, TileAovs};
use crate::integrator::depth::DepthTile;
use crate::integrator::path::{PathTile, Round, Scratch};
use crate::integrator::{Context, Integrator, RayCounts};
use crate::progress::{Progress, Stop};
use crate::sampling::{self, Sampler};
use crate::simd::{self, LANES};

/// The lines of microlenses that are rendered together, counted from line 0 of the array.
const BAND_LINES: i32 = 16;

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
    if request.denoise != Denoise::Off || request.estimate_error {
        return Err(Error::BadSetting(
            "the raw image of a plenoptic camera has no views to reduce its noise or estimate its error with".into(),
        ));
    }
    let size = camera.sensor().size;
    if size.count() > u32::MAX as usize {
        return Err(Error::BadSetting("a sensor of 2^32 or more pixels; choose fewer".into()));
    }
    for corner in [[0.0, 0.0], [size.columns as f64, size.rows as f64]] {
        let place = camera.place_m(corner);
        let lens = camera.owner(place);
        let ray = camera.ray(place, camera.lens_center_m(lens), lens);
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
    /// From the values of [`inverse_depth`].
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

/// The arrays that bands add their light to.
struct Sums {
    color: Array3<f32>,
    inverse_depths: Option<Array3<f32>>,
}

/// The memory of a tile of color.
struct RawTile<'a> {
    color: ArrayViewMut5<'a, f32>,
    inverse_depths: Option<ArrayViewMut5<'a, f32>>,
}

impl TileOutput for RawTile<'_> {
    fn values(&self) -> Vec<f32> {
        self.color.iter().chain(self.inverse_depths.iter().flatten()).copied().collect()
    }

    fn count(&self) -> usize {
        self.color.len() + self.inverse_depths.as_ref().map_or(0, ArrayViewMut5::len)
    }

    fn fill(&mut self, values: &[f32]) {
        let (color, rest) = values.split_at(self.color.len());
        self.color.fill(color);
        if let Some(own) = &mut self.inverse_depths {
            own.fill(rest);
        }
    }
}

/// Bands of lines, and how many packets each has.
struct Band {
    lines: Range<i32>,
    packets: usize,
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
        let has_color = integrator != Integrator::Depth;
        let bands = if has_color { bands(request) } else { Vec::new() };
        let tile_pixels = path_tile_pixels(&request.transport, integrator);
        let color_tiles = |bands: &[Band]| {
            bands.iter().map(|band| color_tiling(band.packets, tile_pixels).tiles().len()).sum::<usize>()
        };
        let truth = if request.layers.is_empty() { Vec::new() } else { truth_rows(request) };
        let truth_tiles = |truth: &[Range<usize>]| {
            truth.iter().map(|rows| Tiling::new(truth_counts(request, rows)).tiles().len()).sum::<usize>()
        };
        let kinds = [(TileKind::Color, color_tiles(&bands)), (TileKind::AllLayers, truth_tiles(&truth))].into_iter();
        let work = Work::new(progress, &stop, checkpoint, kinds, 0);
        let mut rays = RayCounts::default();
        let mut sums = None;
        if has_color {
            let inverse_depths = request.statistics.then(|| zeros(request, inverse_depth::CHANNELS)).transpose()?;
            let mut image = Sums { color: zeros(request, 3)?, inverse_depths };
            let mut pixels = bands.first().map(|band| band_pixels(request, band));
            for number in 0..bands.len() {
                let first = color_tiles(&bands[..number]);
                // The pixels of the next band are found while this one is traced.
                let (traced, following) = rayon::join(
                    || pixels.map(|pixels| self.trace_band(request, integrator, (pixels, first), &work, &mut image)),
                    || bands.get(number + 1).map(|band| band_pixels(request, band)),
                );
                rays = rays + traced.transpose()?.unwrap_or_default();
                pixels = following;
            }
            sums = Some(image);
        }
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
        if stop.requested() {
            return Err(Error::Cancelled);
        }
        let (color, inverse_depths) = sums.map_or((None, None), |sums| (Some(sums.color), sums.inverse_depths));
        let shape = shape(request)?;
        Ok(Rendered {
            color: color.map(|color| LightField::from_elemental_grid(color, shape)).transpose()?,
            error: None,
            error_distribution: None,
            central: layers,
            all: None,
            statistics: inverse_depths.map(|sums| RawStatistics::new(&sums)),
            integrator,
            why,
            rays,
            samples,
        })
    }

    /// Renders the light of a band of microlenses, whose tiles are numbered from `first_tile`, and adds it to `image`.
    fn trace_band(
        &self,
        request: &RawRequest,
        integrator: Integrator,
        (pixels, first_tile): (RawPixels, usize),
        work: &Work,
        image: &mut Sums,
    ) -> Result<RayCounts, Error> {
        let tiling = color_tiling(pixels.packets.len(), path_tile_pixels(&request.transport, integrator));
        let count = pixels.packets.len();
        let zeros = |channels| Array5::zeros((count, 1, 1, LANES, channels));
        let mut color = zeros(3);
        let mut inverse_depths = image.inverse_depths.is_some().then(|| zeros(inverse_depth::CHANNELS));
        let rays = PlenopticRays::new(request.camera, pixels);
        let context = self.raw_context(request, integrator, rays, work);
        let round = Round { samples: 0..request.transport.samples, wanted: Vec::new() };
        let trace = |tile: &Tile, out: &mut RawTile, scratch: &mut Scratch| {
            let color = out.color.view_mut();
            let inverse_depths = out.inverse_depths.as_mut().map(|sums| sums.view_mut());
            simd::run(PathTile { context: &context, tile, color, guides: None, inverse_depths, round: &round, scratch })
        };
        let mut depths = inverse_depths.as_mut().map(|sums| tiling.cut(sums.view_mut())).into_iter().flatten();
        let outputs = tiling.cut(color.view_mut()).into_iter();
        let outputs = outputs.map(|color| RawTile { color, inverse_depths: depths.next() }).collect();
        let rays = work.run(TileKind::Color, first_tile, &tiling, outputs, trace)?;
        drop(depths);
        let first = request.row_range().start;
        let packets = context.camera.raw_packets();
        scatter(packets, &color, first, &mut image.color, |sum, added| {
            sum.iter_mut().zip(added).for_each(|(sum, value)| *sum += value);
        });
        if let (Some(all), Some(own)) = (&mut image.inverse_depths, &inverse_depths) {
            scatter(packets, own, first, all, |sum, added| {
                if let (Ok(a), Ok(b)) = (<[f32; inverse_depth::CHANNELS]>::try_from(&*sum), added.try_into()) {
                    sum.copy_from_slice(&inverse_depth::merged(a, b));
                }
            });
        }
        Ok(rays)
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
            request.layers.iter().map(|layer| (layer, Array5::zeros((count, 1, 1, LANES, layer.channels())))).collect();
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
        // The windows of the reconstruction hold so many samples that the bias of the filter would be what is left.
        let filters = transport.texture_filter == TextureFilter::Footprint && request.denoise == Denoise::Off;
        let sampler = Sampler {
            seed: transport.seed,
            samples: transport.samples,
            sampling: transport.sampling,
            centered: transport.samples == 1,
            cells: filters.then(|| sampling::cells(transport.samples)),
        };
        Context {
            scene: self.scene_data(transport, integrator),
            camera: RaySource::Plenoptic(Box::new(rays)),
            sampler,
            policy: self.policy(transport, integrator),
            guides: None,
            inverse_depths: request.statistics && integrator != Integrator::Depth,
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

/// The microlenses of a line and the clear gaps around them.
fn openings_on_line(camera: &PlenopticCamera, line: i32) -> impl Iterator<Item = Microlens> {
    camera.lenses_on_line(line, 0..camera.sensor().size.rows).flat_map(|lens| camera.openings(lens))
}

/// The pixels of a band in the order of its microlenses.
fn band_pixels(request: &RawRequest, band: &Band) -> RawPixels {
    let camera = request.camera;
    let of_line = |line: i32| {
        let (mut scratch, mut pixels) = (Vec::new(), RawPixels::default());
        for lens in openings_on_line(camera, line) {
            pixels.push_lens(camera, lens, &mut scratch);
        }
        pixels
    };
    RawPixels::joined(&band.lines.clone().into_par_iter().map(of_line).collect::<Vec<_>>())
}

/// The bands that light the requested rows. Their boundaries are the same for any rows.
fn bands(request: &RawRequest) -> Vec<Band> {
    let camera = request.camera;
    let size = camera.sensor().size;
    let (all, wanted) = (camera.lens_lines(0..size.rows), camera.lens_lines(request.row_range()));
    let (first, last) = (wanted.start().div_euclid(BAND_LINES), wanted.end().div_euclid(BAND_LINES));
    let band = |number: i32| {
        let lines = (number * BAND_LINES).max(*all.start())..((number + 1) * BAND_LINES).min(all.end() + 1);
        let count = |lens: Microlens| -> usize {
            let pixels: usize = camera.lit_pixels(&lens, 0..size.rows).map(|(_, columns)| columns.len()).sum();
            pixels.div_ceil(LANES)
        };
        let packets =
            lines.clone().into_par_iter().map(|line| openings_on_line(camera, line).map(count).sum::<usize>()).sum();
        Band { lines, packets }
    };
    (first..=last).map(band).filter(|band| band.packets > 0).collect()
}

fn color_tiling(packets: usize, tile_pixels: usize) -> Tiling {
    Tiling::with_tiles_of([packets, 1, 1, LANES], tile_pixels)
}

/// Rows whose ground truth is rendered together.
fn truth_rows(request: &RawRequest) -> Vec<Range<usize>> {
    let Range { start, end } = request.row_range();
    // The boundaries of packets are the same for any rows.
    let first = start / TRUTH_ROWS * TRUTH_ROWS;
    (first..end).step_by(TRUTH_ROWS).map(|row| row..(row + TRUTH_ROWS).min(request.camera.sensor().size.rows)).collect()
}

fn truth_counts(request: &RawRequest, rows: &Range<usize>) -> [usize; 4] {
    let blocks = rows.len().div_ceil(BLOCK) * request.camera.sensor().size.columns.div_ceil(BLOCK);
    [blocks, 1, 1, LANES]
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
