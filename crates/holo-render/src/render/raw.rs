//! The raw image of a plenoptic camera.
//!
//! Color is rendered microlens by microlens, in bands of lines of the array. A pixel sums the light of every microlens
//! that reaches it, in the order of the lines and along them, so the result does not depend on threads or on which rows
//! are rendered. Ground truth is that of the chief ray of every pixel.

use std::collections::BTreeMap;
use std::ops::Range;

use holo_core::plenoptic::{Microlens, MicrolensIndex, PlenopticCamera};
use holo_core::{GridSize, Layout, LightField, LightFieldShape};
use ndarray::{Array2, Array3, Array5, ArrayViewMut5};
use rayon::prelude::*;

use super::Renderer;
use super::checkpoint::TileKind;
use super::plan::path_tile_pixels;
use super::request::{DEPTH_AND_DISPARITY, check_ids};
use super::transport::{Reuse, TextureFilter, Transport, transport_setters};
use super::work::{TileOutput, Work};
use crate::camera::RaySource;
use crate::camera::plenoptic::{PlenopticRays, RawLens, RawPacket, RawPixels};
use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::film::inverse_depth;
use crate::film::layers::{LayerSet, Layers};
use crate::geometry::MAX_COORDINATE_M;
use crate::integrator::aov::{AovTile, TileAovs};
use crate::integrator::depth::DepthTile;
use crate::integrator::path::{PathTile, Round, Scratch};
use crate::integrator::{Context, Integrator, RayCounts};
use crate::progress::{Progress, Stop};
use crate::sampling::{Sampler, Sampling};
use crate::setters::setters;
use crate::simd::{self, LANES};

/// The lines of microlenses that are rendered together, counted from line 0 of the array.
const BAND_LINES: i32 = 16;

/// The rows of pixels whose ground truth is rendered together; a multiple of the height of a packet.
const TRUTH_ROWS: usize = 64;

/// The side of the block of pixels of a packet of ground truth.
const BLOCK: usize = 4;

/// A request for the raw image of a plenoptic camera.
///
/// The fields have the defaults of [`RawRequest::new`]; they are validated by [`Renderer::render_raw`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RawRequest {
    /// The camera. The pose of the renderer is that of its entrance pupil.
    pub camera: PlenopticCamera,
    /// Light transport: the integrator and its samples. Textures are not filtered and light is not shared between pixels:
    /// [`Transport::texture_filter`] and [`Transport::reuse`] have no effect.
    pub transport: Transport,
    /// The layers (AOVs) beside color: of the first hit of the chief ray of every pixel, from its center through the
    /// center of the nearest microlens. `Disparity` is that of views of neighboring pixels (Eq. 3 of the equivalent rig)
    /// and has a meaning for unfocused cameras only.
    pub layers: LayerSet,
    /// Whether [`RawRendered::statistics`] are computed.
    pub statistics: bool,
    /// The rows of the raw image to render; `None` renders all. They have the same values as in the whole image.
    pub rows: Option<Range<usize>>,
}

impl RawRequest {
    /// A request with the defaults of the command line, one sample per pixel and microlens, and a black environment.
    #[must_use]
    pub fn new(camera: PlenopticCamera) -> Self {
        Self { camera, transport: Transport::default(), layers: DEPTH_AND_DISPARITY, statistics: false, rows: None }
    }

    setters! {
        camera: PlenopticCamera,
        transport: Transport,
        layers: LayerSet,
        statistics: bool,
        rows: Option<Range<usize>>,
    }

    transport_setters!();

    fn row_range(&self) -> Range<usize> {
        self.rows.clone().unwrap_or(0..self.camera.sensor().size.rows)
    }

    /// Validates the request for a scene with this many instances and materials.
    fn check(&self, counts: [usize; 2]) -> Result<(), Error> {
        self.transport.check()?;
        check_ids(self.layers, counts)?;
        let size = self.camera.sensor().size;
        if size.count() > u32::MAX as usize {
            return Err(Error::BadSetting("a sensor of 2^32 or more pixels; choose fewer".into()));
        }
        let rows = self.row_range();
        if rows.is_empty() || rows.end > size.rows {
            return Err(Error::BadSetting(format!("rows {rows:?} are not a range of the {} rows", size.rows)));
        }
        for corner in [[0.0, 0.0], [size.columns as f64, size.rows as f64]] {
            let place = self.camera.place_m(corner);
            let lens = self.camera.owner(place);
            let ray = self.camera.ray(place, self.camera.lens_center_m(lens), lens);
            if !ray.origin_m.iter().chain(&ray.direction).all(|x| x.abs() < MAX_COORDINATE_M) {
                return Err(Error::BadSetting(format!(
                    "the camera is too large: a ray starts at {:?} m and runs along {:?}",
                    ray.origin_m, ray.direction
                )));
            }
        }
        Ok(())
    }
}

/// The raw image of a plenoptic camera. All arrays have the rows of [`RawRequest::rows`].
#[derive(Debug)]
pub struct RawRendered {
    /// Linear RGB, axes (row, column, channel): radiance times [white
    /// image](holo_core::plenoptic::PlenopticCamera::white_image). `None` for the integrator `Depth`.
    pub color: Option<Array3<f32>>,
    /// The layers, axes (row, column, channel). Units: [`layers`](crate::layers).
    pub layers: Layers<Array3<f32>>,
    /// Statistics of the inverse depth, if they were requested and there is color.
    pub statistics: Option<RawStatistics>,
    /// The integrator that was used.
    pub integrator: Integrator,
    /// The reason for the choice of the integrator.
    pub why: String,
    /// The number of rays, including those for ground truth.
    pub rays: RayCounts,
}

/// What the pixels of a raw image see, over the samples of their color with their weights; axes (row, column). 0 where no
/// light reaches a pixel.
#[derive(Debug)]
pub struct RawStatistics {
    /// The mean of 1 / depth, 1/m; rays that miss the scene count as 0.
    pub inverse_depth_mean: Array2<f32>,
    /// The standard deviation of 1 / depth, 1/m.
    pub inverse_depth_deviation: Array2<f32>,
    /// The share of the light whose rays hit the scene.
    pub coverage: Array2<f32>,
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
    /// Renders the raw image of a plenoptic camera. The result depends only on the scene, the pose and `request`, not on
    /// the number of threads or their timing.
    ///
    /// A sample is a ray from a point of a pixel through a point of a microlens that both apertures let pass. Pixels
    /// between the micro-images, which no light reaches, are black and cost nothing.
    ///
    /// # Errors
    /// [`Error::BadSetting`] for settings that are out of range or do not fit the scene, [`Error::Core`] if the image does
    /// not fit into memory, [`Error::Cancelled`] if `progress` cancels.
    pub fn render_raw(&self, request: &RawRequest, progress: &dyn Progress) -> Result<RawRendered, Error> {
        request.check(self.counts)?;
        self.pool.install(|| self.render_raw_here(request, progress))
    }

    fn render_raw_here(&self, request: &RawRequest, progress: &dyn Progress) -> Result<RawRendered, Error> {
        let (integrator, why) = self.integrator(&request.transport);
        let stop = Stop::new(progress);
        let has_color = integrator != Integrator::Depth;
        let bands = if has_color { bands(request) } else { Vec::new() };
        let tile_pixels = path_tile_pixels(&request.transport, integrator);
        let color_tiles = bands.iter().map(|band| color_tiling(band.packets, tile_pixels).tiles().len()).sum();
        let truth = if request.layers.is_empty() { Vec::new() } else { truth_rows(request) };
        let truth_tiles = truth.iter().map(|rows| Tiling::new(truth_counts(request, rows)).tiles().len()).sum();
        let kinds = [(TileKind::Color, color_tiles), (TileKind::AllLayers, truth_tiles)].into_iter();
        let work = Work::new(progress, &stop, None, kinds, 0);
        let mut rays = RayCounts::default();
        let mut sums = None;
        if has_color {
            let inverse_depths = request.statistics.then(|| zeros(request, inverse_depth::CHANNELS)).transpose()?;
            let mut image = Sums { color: zeros(request, 3)?, inverse_depths };
            let mut pixels = bands.first().map(|band| band_pixels(request, band));
            for next in (1..=bands.len()).map(|number| bands.get(number)) {
                // The pixels of the next band are found while this one is traced.
                let (traced, following) = rayon::join(
                    || pixels.map(|pixels| self.trace_band(request, integrator, pixels, &work, &mut image)),
                    || next.map(|band| band_pixels(request, band)),
                );
                rays = rays + traced.transpose()?.unwrap_or_default();
                pixels = following;
            }
            sums = Some(image);
        }
        let mut layers: Layers<Array3<f32>> = request
            .layers
            .iter()
            .map(|layer| Ok((layer, zeros(request, layer.channels())?)))
            .collect::<Result<_, Error>>()?;
        for rows in truth {
            rays = rays + self.trace_truth(request, rows, &work, &mut layers)?;
        }
        if stop.requested() {
            return Err(Error::Cancelled);
        }
        let (color, inverse_depths) = sums.map_or((None, None), |sums| (Some(sums.color), sums.inverse_depths));
        let statistics = inverse_depths.map(|sums| RawStatistics::new(&sums));
        Ok(RawRendered { color, layers, statistics, integrator, why, rays })
    }

    /// Renders the light of a band of microlenses and adds it to `image`.
    fn trace_band(
        &self,
        request: &RawRequest,
        integrator: Integrator,
        pixels: RawPixels,
        work: &Work,
        image: &mut Sums,
    ) -> Result<RayCounts, Error> {
        let tiling = color_tiling(pixels.packets.len(), path_tile_pixels(&request.transport, integrator));
        let count = pixels.packets.len();
        let zeros = |channels| Array5::zeros((count, 1, 1, LANES, channels));
        let mut color = zeros(3);
        let mut inverse_depths = image.inverse_depths.is_some().then(|| zeros(inverse_depth::CHANNELS));
        let rays = PlenopticRays::new(&request.camera, pixels);
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
        let rays = work.run(TileKind::Color, 0, &tiling, outputs, trace)?;
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

    /// Renders the layers of some rows.
    fn trace_truth(
        &self,
        request: &RawRequest,
        rows: Range<usize>,
        work: &Work,
        layers: &mut Layers<Array3<f32>>,
    ) -> Result<RayCounts, Error> {
        let tiling = Tiling::new(truth_counts(request, &rows));
        let pixels = truth_pixels(&request.camera, rows);
        let count = pixels.packets.len();
        let mut fields: Layers<Array5<f32>> =
            request.layers.iter().map(|layer| (layer, Array5::zeros((count, 1, 1, LANES, layer.channels())))).collect();
        let rays = PlenopticRays::new(&request.camera, pixels);
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
        let rays = work.run(TileKind::AllLayers, 0, &tiling, outputs, trace)?;
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
        let sampler = Sampler {
            seed: transport.seed,
            samples: transport.samples,
            sampling: transport.sampling,
            centered: transport.samples == 1,
            cells: None,
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
    let size = GridSize::new(request.row_range().len(), request.camera.sensor().size.columns);
    let shape = LightFieldShape::new(GridSize::new(1, 1), size)?;
    let field = LightField::filled(shape, channels, Layout::ElementalGrid, 0.0)?;
    Ok(field.into_elemental_grid().or_else(|field| field.to_elemental_grid())?)
}

/// The microlenses of a line and the clear gaps around them.
fn openings_on_line(camera: &PlenopticCamera, line: i32) -> impl Iterator<Item = Microlens> {
    camera.lenses_on_line(line, 0..camera.sensor().size.rows).flat_map(|lens| camera.openings(lens))
}

/// The pixels of a band in the order of its microlenses.
fn band_pixels(request: &RawRequest, band: &Band) -> RawPixels {
    let camera = &request.camera;
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
    let camera = &request.camera;
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
