//! Color of a raw image while it is rendered: bands of microlenses, in rounds if there is a target for the error after the
//! reconstruction, and the reconstruction itself.

use std::ops::Range;

use holo_core::plenoptic::{Microlens, PlenopticCamera};
use ndarray::{Array2, Array3, Array5, ArrayViewMut5, s};
use rayon::prelude::*;

use super::super::Renderer;
use super::super::checkpoint::TileKind;
use super::super::plan::needs_guides;
use super::super::plan::path_tile_pixels;
use super::super::request::{Denoise, Request};
use super::super::rounds;
use super::super::work::{TileOutput, Work};
use super::{RawRequest, scatter, zeros};
use crate::camera::plenoptic::{Order, PlenopticRays, RawPacket, RawPixels};
use crate::camera::tile::{Tile, Tiling};
use crate::error::Error;
use crate::film::error_distribution::ErrorDistribution;
use crate::film::guides;
use crate::film::inverse_depth;
use crate::film::reconstruct::lattice::{
    Lattice, LatticeReconstruction, Source, estimate_single_variances, fill_rims, share,
};
use crate::integrator::path::{PathTile, Round, Scratch};
use crate::integrator::{Integrator, RayCounts};
use crate::simd::{self, LANES};

/// The lines of microlenses that are rendered together, counted from line 0 of the array.
const BAND_LINES: i32 = 16;

/// A band is divided into at least this many tiles, unless they have fewer than [`FEWEST_PIXELS`].
const BAND_TILES: usize = 32;

/// The approximate number of pixels below which bands are not divided further.
const FEWEST_PIXELS: usize = 1024;

/// The channel of the guides that has no disparity: the weight of the samples that have color.
const WEIGHT: usize = 1;

/// The color of a request.
pub(super) struct RawColor<'a> {
    /// The request, whose rows have the [margin](with_margin).
    request: RawRequest<'a>,
    /// The requested rows.
    rows: Range<usize>,
    integrator: Integrator,
    bands: Vec<Band>,
    rounds: Vec<Round>,
    /// Which pixels see the same, if color is reconstructed or its error estimated.
    lattice: Option<Lattice>,
    /// The white image of these rows, if color is reconstructed.
    white: Option<Array2<f32>>,
}

/// The arrays that bands add their light to.
pub(super) struct Sums {
    color: Array3<f32>,
    guides: Option<Array3<f32>>,
    inverse_depths: Option<Array3<f32>>,
}

/// The requested rows of a finished image.
pub(super) struct Finished {
    pub color: Array3<f32>,
    pub error: Option<Array3<f32>>,
    pub error_distribution: Option<ErrorDistribution>,
    /// The statistics of the inverse depth, if they are rendered.
    pub inverse_depths: Option<Array3<f32>>,
}

/// Bands of lines, and how many packets each has.
struct Band {
    lines: Range<i32>,
    packets: usize,
}

/// The values of the packets of a band.
struct Values {
    color: Array5<f32>,
    guides: Option<Array5<f32>>,
    inverse_depths: Option<Array5<f32>>,
}

/// A round of samples.
struct RawRound {
    number: usize,
    round: Round,
    /// The error of the pixels before the round, and the one that is wanted.
    error: Option<Array3<f32>>,
    target: f32,
}

/// The memory of a tile of color.
struct RawTile<'a> {
    color: ArrayViewMut5<'a, f32>,
    guides: Option<ArrayViewMut5<'a, f32>>,
    inverse_depths: Option<ArrayViewMut5<'a, f32>>,
    /// The estimated error before the round, which is not a part of the result.
    error: Option<ArrayViewMut5<'a, f32>>,
}

impl TileOutput for RawTile<'_> {
    fn values(&self) -> Vec<f32> {
        let (guides, inverse_depths) = (self.guides.iter().flatten(), self.inverse_depths.iter().flatten());
        self.color.iter().chain(guides).chain(inverse_depths).copied().collect()
    }

    fn count(&self) -> usize {
        let len = |field: &Option<ArrayViewMut5<f32>>| field.as_ref().map_or(0, ArrayViewMut5::len);
        self.color.len() + len(&self.guides) + len(&self.inverse_depths)
    }

    fn fill(&mut self, values: &[f32]) {
        let (color, mut rest) = values.split_at(self.color.len());
        self.color.fill(color);
        for own in [&mut self.guides, &mut self.inverse_depths].into_iter().flatten() {
            let (values, after) = rest.split_at(own.len());
            own.fill(values);
            rest = after;
        }
    }
}

impl Values {
    /// Zeros for what `image` has.
    fn new(packets: usize, image: &Sums) -> Self {
        let zeros = |channels: usize| Array5::zeros((1, packets, 1, LANES, channels));
        Self {
            color: zeros(3),
            guides: image.guides.as_ref().map(|_| zeros(guides::CHANNELS)),
            inverse_depths: image.inverse_depths.as_ref().map(|_| zeros(inverse_depth::CHANNELS)),
        }
    }

    fn tiles<'a>(&'a mut self, tiling: &Tiling, error: Option<&'a mut Array5<f32>>) -> Vec<RawTile<'a>> {
        let colors = tiling.cut(self.color.view_mut());
        let fields = [self.guides.as_mut(), self.inverse_depths.as_mut(), error];
        let [mut guides, mut inverse_depths, mut errors] =
            fields.map(|field| field.map(|field| tiling.cut(field.view_mut())).into_iter().flatten());
        let tile = |color| RawTile {
            color,
            guides: guides.next(),
            inverse_depths: inverse_depths.next(),
            error: errors.next(),
        };
        colors.into_iter().map(tile).collect()
    }

    /// Notes the weight of those pixels that have samples of color.
    fn note_weights(&mut self) {
        if let (Some(guides), Some(statistics)) = (&mut self.guides, &self.inverse_depths) {
            let pixels = guides.as_slice_mut().unwrap_or_default().chunks_exact_mut(guides::CHANNELS);
            let statistics = statistics.as_slice().unwrap_or_default().chunks_exact(inverse_depth::CHANNELS);
            for (guides, statistics) in pixels.zip(statistics) {
                guides[WEIGHT] = if guides[guides::SAMPLES] > 0.0 { statistics[0] } else { 0.0 };
            }
        }
    }

    /// Adds the light of the packets to an image that begins at row `first`.
    fn add_to(&self, image: &mut Sums, packets: &[RawPacket], first: usize) {
        let add = |sum: &mut [f32], added: &[f32]| {
            sum.iter_mut().zip(added).for_each(|(sum, value)| *sum += value);
        };
        scatter(packets, &self.color, first, &mut image.color, add);
        if let (Some(all), Some(own)) = (&mut image.guides, &self.guides) {
            scatter(packets, own, first, all, |sum, added| {
                sum[0] += added[0];
                sum[WEIGHT] += added[WEIGHT];
                // Each of the microlenses that light a pixel has its samples.
                sum[guides::SAMPLES] = sum[guides::SAMPLES].max(added[guides::SAMPLES]);
            });
        }
        if let (Some(all), Some(own)) = (&mut image.inverse_depths, &self.inverse_depths) {
            scatter(packets, own, first, all, |sum, added| {
                if let (Ok(a), Ok(b)) = (<[f32; inverse_depth::CHANNELS]>::try_from(&*sum), added.try_into()) {
                    sum.copy_from_slice(&inverse_depth::merged(a, b));
                }
            });
        }
    }
}

/// The same request for all pixels on which the requested ones depend.
pub(super) fn with_margin(request: &RawRequest) -> Request {
    let mut wider = request.request.clone();
    if needs_guides(request) {
        // In a round, the samples of a pixel depend on the error estimated before it.
        let margin = Lattice::margin_rows(request.camera) * rounds::rounds(request).len();
        let (rows, count) = (request.row_range(), request.camera.sensor().size.rows);
        wider.rows = Some(rows.start.saturating_sub(margin)..(rows.end + margin).min(count));
    }
    wider
}

impl<'a> RawColor<'a> {
    /// The color of the requested `rows` of a `request` with their margin.
    pub fn new(request: RawRequest<'a>, rows: Range<usize>, integrator: Integrator) -> Result<Self, Error> {
        let lattice = needs_guides(&request).then(|| Lattice::new(request.camera, request.row_range()));
        let reconstructs = request.denoise == Denoise::Views;
        let white = reconstructs.then(|| request.camera.white_rows(request.row_range())).transpose()?;
        Ok(Self { bands: bands(&request), rounds: rounds::rounds(&request), request, rows, integrator, lattice, white })
    }

    /// The number of tiles of all rounds.
    pub fn tiles(&self) -> usize {
        self.tiles_before(self.bands.len()) * self.rounds.len()
    }

    /// The number of steps after the tiles.
    pub fn steps(&self) -> usize {
        self.lattice.as_ref().map_or(0, |lattice| LatticeReconstruction::steps(lattice, &self.rows))
    }

    /// The number of tiles of the first bands.
    fn tiles_before(&self, bands: usize) -> usize {
        self.bands[..bands].iter().map(|band| self.tiling(band.packets).tiles().len()).sum()
    }

    /// A band has so many tiles that the threads of most machines have work.
    fn tiling(&self, packets: usize) -> Tiling {
        let share = (packets * LANES / BAND_TILES).max(FEWEST_PIXELS);
        let pixels = path_tile_pixels(&self.request.transport, self.integrator).min(share);
        Tiling::with_tiles_of(super::counts(packets), pixels)
    }

    /// Black.
    fn sums(&self) -> Result<Sums, Error> {
        let has_guides = self.lattice.is_some();
        let zeros = |wanted: bool, channels: usize| wanted.then(|| zeros(&self.request, channels)).transpose();
        Ok(Sums {
            color: super::zeros(&self.request, 3)?,
            guides: zeros(has_guides, guides::CHANNELS)?,
            inverse_depths: zeros(has_guides || self.request.statistics, inverse_depth::CHANNELS)?,
        })
    }

    /// Renders all bands, in rounds if there is a target for the error after the reconstruction.
    pub fn trace(&self, renderer: &Renderer, work: &Work) -> Result<(Sums, RayCounts), Error> {
        let target = rounds::target(&self.request).unwrap_or(0.0);
        let mut rays = RayCounts::default();
        let mut image = self.sums()?;
        // Later rounds add to the values of a band.
        let mut kept: Vec<Option<Values>> = self.bands.iter().map(|_| None).collect();
        for (number, round) in self.rounds.iter().enumerate() {
            let mut round = RawRound { number, round: round.clone(), error: None, target };
            if number > 0 {
                let error = self.estimate(&image, work)?;
                let largest = error.iter().fold(0.0, |high: f32, &error| high.max(error));
                if largest <= target {
                    work.leave_out((self.rounds.len() - number) * self.tiles_before(self.bands.len()));
                    break;
                }
                round.error = Some(error);
                image = self.sums()?;
            }
            rays = rays + self.trace_round(renderer, &round, work, &mut kept, &mut image)?;
        }
        Ok((image, rays))
    }

    fn trace_round(
        &self,
        renderer: &Renderer,
        round: &RawRound,
        work: &Work,
        kept: &mut [Option<Values>],
        image: &mut Sums,
    ) -> Result<RayCounts, Error> {
        let mut rays = RayCounts::default();
        let mut pixels = self.bands.first().map(|band| band_pixels(&self.request, band));
        for (number, kept) in kept.iter_mut().enumerate() {
            let before = kept.take();
            // The pixels of the next band are found while this one is traced.
            let (traced, following) = rayon::join(
                || pixels.map(|pixels| self.trace_band(renderer, round, (number, pixels, before), work, image)),
                || self.bands.get(number + 1).map(|band| band_pixels(&self.request, band)),
            );
            if let Some((values, added)) = traced.transpose()? {
                rays = rays + added;
                *kept = Some(values).filter(|_| self.rounds.len() > 1);
            }
            pixels = following;
        }
        Ok(rays)
    }

    /// Renders a round of the band of this number, which has the values `before` it, and adds its light to `image`.
    fn trace_band(
        &self,
        renderer: &Renderer,
        round: &RawRound,
        (number, pixels, before): (usize, RawPixels, Option<Values>),
        work: &Work,
        image: &mut Sums,
    ) -> Result<(Values, RayCounts), Error> {
        let request = &self.request;
        let tiling = self.tiling(pixels.packets.len());
        let first_tile = round.number * self.tiles_before(self.bands.len()) + self.tiles_before(number);
        let mut values = before.unwrap_or_else(|| Values::new(pixels.packets.len(), image));
        let mut error = round.error.as_ref().map(|error| self.of_packets(error, &pixels.packets));
        let rays = PlenopticRays::new(request.camera, pixels);
        let context = renderer.raw_context(request, self.integrator, rays, work);
        let trace = |tile: &Tile, out: &mut RawTile, scratch: &mut Scratch| {
            let mut wanted = Vec::new();
            if let Some(error) = &out.error {
                let exceeds = |packet: &[[f32; LANES]; 1]| packet[0].iter().any(|&error| error > round.target);
                wanted = tile.read(error).iter().map(exceeds).collect();
                if !wanted.contains(&true) {
                    return RayCounts::default();
                }
            }
            let (color, guides) = (out.color.view_mut(), out.guides.as_mut().map(|guides| guides.view_mut()));
            let inverse_depths = out.inverse_depths.as_mut().map(|sums| sums.view_mut());
            let (context, round, wanted) = (&context, &round.round, wanted.as_slice());
            simd::run(PathTile { context, tile, color, guides, inverse_depths, round, wanted, scratch })
        };
        let outputs = values.tiles(&tiling, error.as_mut());
        let rays = work.run(TileKind::Color, first_tile, &tiling, outputs, trace)?;
        values.note_weights();
        values.add_to(image, context.camera.raw_packets(), request.row_range().start);
        Ok((values, rays))
    }

    /// The values of an image for the pixels of packets; 0 beside the image.
    fn of_packets(&self, image: &Array3<f32>, packets: &[RawPacket]) -> Array5<f32> {
        let first = self.request.row_range().start;
        let mut out = Array5::zeros((1, packets.len(), 1, LANES, 1));
        for (k, packet) in packets.iter().enumerate() {
            for lane in 0..packet.count as usize {
                let row = (packet.pixel[0][lane] as usize).checked_sub(first);
                let value = row.and_then(|row| image.get([row, packet.pixel[1][lane] as usize, 0]));
                out[[0, k, 0, lane, 0]] = value.copied().unwrap_or(0.0);
            }
        }
        out
    }

    /// The error that reconstructed pixels would have with the samples so far.
    fn estimate(&self, image: &Sums, work: &Work) -> Result<Array3<f32>, Error> {
        let mut error = zeros(&self.request, 1)?;
        if let Some(sources) = self.sources(image) {
            self.reconstruct(&sources, self.request.row_range(), None, Some(&mut error), || !work.is_stopped());
        }
        Ok(error)
    }

    /// The samples of the pixels; `None` if none are needed.
    fn sources(&self, image: &Sums) -> Option<Vec<Source>> {
        let lattice = self.lattice.as_ref()?;
        let (color, guides) = (image.color.as_slice()?, image.guides.as_ref()?.as_slice()?);
        let inverse_depths = image.inverse_depths.as_ref()?.as_slice()?;
        let source = |((color, guides), inverse_depth): ((&[f32], &[f32]), &[f32])| {
            let weight = inverse_depth[0];
            let scale = if guides[WEIGHT] > 0.0 { 1.0 / guides[WEIGHT] } else { 0.0 };
            Source {
                color: [color[0] * scale, color[1] * scale, color[2] * scale],
                variance: (guides[0] * scale).powi(2),
                disparity: lattice.disparity_px(f64::from(inverse_depth[2])),
                weight,
                share: weight,
                samples: guides[guides::SAMPLES],
            }
        };
        let pixels = color.par_chunks_exact(3).zip(guides.par_chunks_exact(guides::CHANNELS));
        let pixels = pixels.zip(inverse_depths.par_chunks_exact(inverse_depth::CHANNELS));
        let mut sources: Vec<Source> = pixels.map(source).collect();
        estimate_single_variances(lattice, &mut sources);
        if let Some(white) = self.white.as_ref().and_then(|white| white.as_slice()) {
            let pixels = sources.par_iter_mut().zip(white);
            pixels.for_each(|(source, &white)| source.share = share(white, source.weight, source.samples));
            fill_rims(lattice, &mut sources);
        }
        Some(sources)
    }

    /// Reconstructs `color` in some rows, if it is to be replaced, and estimates its error.
    fn reconstruct(
        &self,
        sources: &[Source],
        rows: Range<usize>,
        color: Option<&mut Array3<f32>>,
        error: Option<&mut Array3<f32>>,
        advance: impl Fn() -> bool,
    ) -> Option<ErrorDistribution> {
        let reconstruction = LatticeReconstruction {
            lattice: self.lattice.as_ref()?,
            sources,
            filters: self.request.denoise == Denoise::Views,
            rows,
            color: memory(color),
            error: memory(error),
        };
        Some(reconstruction.run(advance))
    }

    /// The requested rows: reconstructed, with their error, if that is wanted.
    pub fn finish(&self, mut image: Sums, work: &Work) -> Result<Finished, Error> {
        let mut error = self.request.estimate_error.then(|| zeros(&self.request, 1)).transpose()?;
        let mut error_distribution = None;
        if let Some(sources) = self.sources(&image) {
            image.guides = None;
            let color = (self.request.denoise == Denoise::Views).then_some(&mut image.color);
            error_distribution = self.reconstruct(&sources, self.rows.clone(), color, error.as_mut(), || work.step());
        }
        let first = self.request.row_range().start;
        let rows = self.rows.start - first..self.rows.end - first;
        let only = |field: Array3<f32>| {
            if field.dim().0 == rows.len() { field } else { field.slice(s![rows.clone(), .., ..]).to_owned() }
        };
        let inverse_depths = image.inverse_depths.map(only);
        Ok(Finished { color: only(image.color), error: error.map(only), error_distribution, inverse_depths })
    }
}

/// All values of an image in their order.
fn memory(image: Option<&mut Array3<f32>>) -> Option<&mut [f32]> {
    image?.as_slice_mut()
}

/// The microlenses of a line and the clear gaps around them.
fn openings_on_line(camera: &PlenopticCamera, line: i32) -> impl Iterator<Item = Microlens> {
    camera.lenses_on_line(line, 0..camera.sensor().size.rows).flat_map(|lens| camera.openings(lens))
}

/// The pixels of a band in the order of its microlenses.
fn band_pixels(request: &RawRequest, band: &Band) -> RawPixels {
    let camera = request.camera;
    let of_line = |line: i32| {
        let (mut scratch, mut pixels) = (Order::default(), RawPixels::default());
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
