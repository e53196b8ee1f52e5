//! Reconstruction of the raw image of a plenoptic camera: which pixels see the same point of the scene.
//!
//! A pixel sees a point through its microlens. Let D be the way from that microlens to another one, in pitches, and a the
//! way from the center of the one's micro-image to the pixel less that of the other, in pixels: the viewpoint. The
//! other pixel sees the same point if disparity * a + D = 0, with the disparity of [`Lattice::disparity_px`]. This is the
//! movement from view to view of a [rig](super), for microlenses at any places and viewpoints that are no whole numbers
//! apart; it holds for focused cameras too, whose disparities are larger. So a pixel [gathers](gather::gather) along the
//! same windows as a pixel of a rig does, and [`choice`](super::choice) takes the largest one that no smaller one
//! contradicts, per microlens and block of viewpoints.
//!
//! **Light.** Windows average radiance: the light of a pixel divided by the mean weight of its samples, which is its
//! share of the white image. The mean is multiplied by the pixel's share in closed form
//! ([`PlenopticCamera::white_image`]), because at the rim of a micro-image the samples' own share is the larger part of the
//! noise. At the rim of a micro-image a pixel without lit samples takes light and disparity from its neighbors. Vignetting therefore
//! neither spreads nor vanishes.
//!
//! **Focus.** What a pixel sees of a plane is a spot: the width of the pixel and the width of the blurred microlens. The
//! distances at which windows end are multiples of the spot. Microlenses of another type take part if their spot there
//! has about the same width.
//!
//! # Bias
//! That of views of a rig. Pixels that several microlenses light count for the nearest one, with the mean depth of all of
//! their light. The white image is itself an approximation: shares are mixed with those of the samples, as the
//! [variances](share) of both demand, so that its error vanishes as the samples grow.
//!
//! # Determinism
//! A pixel depends on the samples of at most [`Lattice::margin_rows`] rows above and below it.

mod blocks;
mod gather;
mod run;

use std::ops::Range;

use holo_core::plenoptic::{MicrolensGrid, MicrolensIndex, PlenopticCamera};
use rayon::prelude::*;

pub(crate) use run::LatticeReconstruction;

use self::blocks::Blocks;
use super::cells::{MAX_VARIANCE, Sums};
use super::{REACH, SMOOTHED};
use crate::film::guides::luminance;

/// The owner of pixels that have none in the table.
const NO_LENS: u32 = u32::MAX;

/// The spots of microlenses of two types are comparable if one is at most this many times as wide as the other.
const MAX_SPOT_RATIO: f32 = 1.25;

/// Microlenses on each side over which evidence is averaged.
const LENSES: usize = 2;

/// Neighboring microlenses in any direction on which a pixel depends.
const HALO: usize = SMOOTHED + LENSES + REACH;

/// Pixels whose samples have less light, relative to an unvignetted one, are no samples of others.
const MIN_WEIGHT: f32 = 0.01;

/// The largest error of a pixel of the white image that is usual, as [`PlenopticCamera::white_image`] states it.
const WHITE_ERROR: f32 = 0.01;

/// The distance of the rows of a hexagonal grid, in pitches.
const HEX_ROW: f64 = 0.866_025_403_784_438_6;

/// The samples of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Source {
    /// The mean radiance.
    pub color: [f32; 3],
    /// The variance of the luminance of that.
    pub variance: f32,
    /// The mean disparity of what the samples hit.
    pub disparity: f32,
    /// The mean weight of the samples: 1 for an unvignetted pixel on the axis.
    pub weight: f32,
    /// The share of the white image that the pixel has in the result.
    pub share: f32,
    /// The number of samples; without any only disparity and weight are known.
    pub samples: f32,
}

/// The share of a pixel from that of the white image and from the mean weight of its samples. A sample is lit or not,
/// so that the variance of the mean is about share (1 - share) / samples; each part counts as the other's variance.
pub(crate) fn share(white: f32, weight: f32, samples: f32) -> f32 {
    let variance = (white * (1.0 - white)).max(0.0) / samples.max(1.0);
    let own = WHITE_ERROR * WHITE_ERROR / (WHITE_ERROR * WHITE_ERROR + variance);
    white + (weight - white) * own
}

/// Gives pixels at the rims of micro-images whose samples have no light the mean of their neighbors behind the same
/// microlens. Pixels without such neighbors keep the share of their samples.
pub(crate) fn fill_rims(lattice: &Lattice, sources: &mut [Source]) {
    let filled = |place: usize| -> Option<(usize, Source)> {
        let source = &sources[place];
        if source.is_lit() || source.share <= 0.0 || lattice.owners[place] == NO_LENS {
            return None;
        }
        let (row, column) = (place / lattice.columns, place % lattice.columns);
        let around = |k: usize, count: usize| k.saturating_sub(1)..(k + 2).min(count);
        let near = around(row, lattice.rows.len())
            .flat_map(|row| around(column, lattice.columns).map(move |column| row * lattice.columns + column))
            .filter(|&other| lattice.owners[other] == lattice.owners[place] && sources[other].is_lit());
        let (mut sum, mut count, mut samples) = (Source::default(), 0.0, 0.0);
        for other in near {
            let Source { color, disparity, .. } = sources[other];
            if sources[other].has_samples() {
                sum.color = std::array::from_fn(|c| sum.color[c] + color[c]);
                samples += 1.0;
            }
            sum.disparity += disparity;
            count += 1.0;
        }
        if count == 0.0 {
            return Some((place, Source { share: source.weight, ..*source }));
        }
        let color = sum.color.map(|value| if samples > 0.0 { value / samples } else { 0.0 });
        Some((place, Source { color, disparity: sum.disparity / count, samples: 0.0, ..*source }))
    };
    let filled: Vec<(usize, Source)> = (0..sources.len()).into_par_iter().filter_map(filled).collect();
    for (place, source) in filled {
        sources[place] = source;
    }
}

impl Source {
    /// Whether the pixel has so much light that what it shows is known.
    #[inline]
    fn is_lit(&self) -> bool {
        self.weight > MIN_WEIGHT
    }

    /// Whether the pixel is a sample of others.
    #[inline]
    fn has_samples(&self) -> bool {
        self.samples > 0.0 && self.is_lit()
    }

    /// Its samples.
    #[inline]
    fn sums(&self) -> Sums {
        Sums {
            color: self.color.map(|value| value * self.samples),
            variance: self.variance.min(MAX_VARIANCE) * self.samples * self.samples,
            weight: self.samples,
            views: [0.0; 2],
            tint: [self.samples; 3],
        }
    }
}

/// Gives pixels with a single sample, which have no halves, a variance: from the difference to a neighbor behind the same
/// microlens. Those without one have that of the square of the luminance.
pub(crate) fn estimate_single_variances(lattice: &Lattice, sources: &mut [Source]) {
    let variance = |place: usize| {
        let source = &sources[place];
        if source.samples != 1.0 {
            return source.variance;
        }
        let own = luminance(source.color);
        let column = place % lattice.columns;
        let is_partner = |other: usize| lattice.owners[other] == lattice.owners[place] && sources[other].has_samples();
        let left = column.checked_sub(1).map(|_| place - 1);
        let right = Some(place + 1).filter(|_| column + 1 < lattice.columns);
        let ends = if column.is_multiple_of(2) { [right, left] } else { [left, right] };
        ends.into_iter().flatten().find(|&other| is_partner(other)).map_or(own * own, |other| {
            let partner = &sources[other];
            (own - luminance(partner.color)).powi(2) * partner.samples / (partner.samples + 1.0)
        })
    };
    let variances: Vec<f32> = (0..sources.len()).into_par_iter().map(variance).collect();
    for (source, variance) in sources.iter_mut().zip(variances) {
        source.variance = variance;
    }
}

/// A microlens of the table.
struct LatticeLens {
    /// The center of its micro-image, x and y, px from the upper left corner of the sensor.
    center: [f64; 2],
    /// Its center on the array, to the right and down, in pitches.
    place: [f64; 2],
    lens_type: usize,
    /// The rows and columns of the pixels that it owns; empty for a microlens beside the part.
    rows: Range<usize>,
    columns: Range<usize>,
}

/// How wide the spot of a pixel is behind a type of microlens.
#[derive(Clone, Copy)]
struct Spot {
    /// The width of a microlens, in pitches.
    width: f32,
    /// By how much of it the spot becomes narrower per disparity.
    narrowing: f32,
}

/// The pixels of some rows of a sensor and the microlenses that own them.
pub(crate) struct Lattice {
    /// The rows of the sensor.
    rows: Range<usize>,
    columns: usize,
    /// The microlens of every pixel: a number in `lenses`.
    owners: Vec<u32>,
    /// Rows and columns of the table of microlenses.
    grid: [usize; 2],
    lenses: Vec<LatticeLens>,
    /// The side of the square of pixels around the center of a micro-image that holds all pixels of a microlens.
    views: usize,
    spots: Vec<Spot>,
    /// Rows or columns of the table that a way of one pitch along an axis crosses at most.
    lines_per_pitch: f64,
    /// Disparity = scale * (1 / depth - inverse focus).
    disparity_scale_m_px: f64,
    inverse_focus_per_m: f64,
}

impl Lattice {
    /// The lattice of the pixels in these rows of the sensor of `camera`.
    pub fn new(camera: &PlenopticCamera, rows: Range<usize>) -> Self {
        let (array, sensor) = (camera.array(), camera.sensor());
        let columns = sensor.size.columns;
        let owner = |row: usize, column: usize| camera.owner(camera.place_m([column as f64 + 0.5, row as f64 + 0.5]));
        let (first, grid) = table(&rows, columns, owner);
        let number = |lens: MicrolensIndex| {
            let [row, column] = [lens.row.checked_sub(first.row), lens.column.checked_sub(first.column)];
            let inside = |k: Option<i32>, count: usize| k.and_then(|k| usize::try_from(k).ok()).filter(|&k| k < count);
            let (row, column) = (inside(row, grid[0])?, inside(column, grid[1])?);
            u32::try_from(row * grid[1] + column).ok()
        };
        let of_row = |row: usize| (0..columns).map(move |column| number(owner(row, column)).unwrap_or(NO_LENS));
        let owners: Vec<u32> = rows.clone().into_par_iter().flat_map_iter(of_row).collect();
        let lens = |k: usize| {
            let (row, column) = (k / grid[1], k % grid[1]);
            let index = MicrolensIndex { row: first.row + row as i32, column: first.column + column as i32 };
            let lens = camera.microlens(index);
            let [x, y] = camera.undistorted_m(lens.center_m).map(|x| x / array.pitch_m);
            LatticeLens {
                center: camera.position_px(lens.image_center_m),
                place: [x, -y],
                lens_type: lens.lens_type,
                rows: 0..0,
                columns: 0..0,
            }
        };
        let mut lenses: Vec<LatticeLens> = (0..grid[0] * grid[1]).map(lens).collect();
        for (k, owner) in owners.iter().enumerate() {
            if let Some(lens) = lenses.get_mut(*owner as usize) {
                widen(&mut lens.rows, rows.start + k / columns);
                widen(&mut lens.columns, k % columns);
            }
        }
        let spot = |lens_type: usize| {
            let per_pitch = array.pitch_m * array.gap_m / (sensor.pixel_m * camera.exit_pupil_m());
            Spot {
                width: (2.0 * array.aperture.half_width_m() / array.pitch_m) as f32,
                narrowing: (camera.alpha(lens_type) * per_pitch) as f32,
            }
        };
        let (sin, cos) = array.rotation_rad.sin_cos();
        let line = if array.grid == MicrolensGrid::Square { 1.0 } else { HEX_ROW };
        let equivalent = camera.equivalent_views();
        Self {
            rows,
            columns,
            owners,
            grid,
            lenses,
            views: views(camera),
            spots: (0..array.type_count()).map(spot).collect(),
            lines_per_pitch: (sin.abs() + cos.abs()) / (line * array.scale_y.min(1.0)),
            disparity_scale_m_px: equivalent.baseline_m / equivalent.slope_per_lens,
            inverse_focus_per_m: equivalent.inverse_focus_per_m,
        }
    }

    /// The rows above and below a pixel on which it may depend: those of its neighbors in every step of the
    /// reconstruction, each up to the edge of its micro-image, for grids at any angle.
    pub fn margin_rows(camera: &PlenopticCamera) -> usize {
        let (array, pixel_m) = (camera.array(), camera.sensor().pixel_m);
        // One pitch for the microlens that owns the pixel, one for the edges of its neighbors' micro-images.
        let pitches = (HALO as f64 * std::f64::consts::SQRT_2 + 2.0) * array.scale_y.max(1.0);
        // The number of samples is that of packets, whose pixels lie anywhere in a micro-image.
        let openings = 0..array.type_count() + usize::from(array.has_clear_gaps);
        let dark_px = openings.map(|k| camera.micro_image_radii_m(k)[2] / pixel_m).fold(0.0, f64::max);
        (pitches * camera.micro_image_pitch_px() + 2.0 * dark_px).ceil() as usize + 1
    }

    /// The movement between pixels one pixel apart, in pitches of the array, of what lies at this inverse depth, 1/m.
    pub fn disparity_px(&self, inverse_depth_per_m: f64) -> f32 {
        (self.disparity_scale_m_px * (inverse_depth_per_m - self.inverse_focus_per_m)) as f32
    }

    /// The place of a pixel in arrays of the part.
    #[inline]
    fn place(&self, row: usize, column: usize) -> usize {
        (row - self.rows.start) * self.columns + column
    }

    /// The row or column of a pixel among those around the center of its micro-image.
    #[inline]
    fn view(&self, center: f64, pixel: usize) -> usize {
        let from_corner = pixel as f64 - (center - self.views as f64 / 2.0).round();
        (from_corner.max(0.0) as usize).min(self.views - 1)
    }

    /// The blocks of viewpoints that choose together.
    fn blocks(&self) -> Blocks {
        Blocks::new([self.views; 2])
    }

    /// The width of the spot behind a type of microlens, in pitches.
    #[inline]
    fn spot(&self, lens_type: usize, disparity: f32) -> f32 {
        let Spot { width, narrowing } = self.spots[lens_type];
        let of_lens = width * (1.0 - disparity * narrowing);
        (of_lens * of_lens + disparity * disparity).sqrt()
    }

    /// The numbers of the microlenses at most `lines` rows and columns of the table away.
    fn around(&self, lens: usize, lines: usize) -> impl Iterator<Item = usize> {
        let [rows, columns] = self.grid;
        let near = move |k: usize, count: usize| k.saturating_sub(lines)..(k + lines + 1).min(count);
        near(lens / columns, rows)
            .flat_map(move |row| near(lens % columns, columns).map(move |column| row * columns + column))
    }

    /// The rows of the table with microlenses that own pixels in these rows of the sensor.
    fn lens_rows(&self, rows: &Range<usize>) -> Range<usize> {
        let owns = |lens: &LatticeLens| lens.rows.start < rows.end && rows.start < lens.rows.end;
        let mut found = 0..0;
        for (row, lenses) in self.lenses.chunks(self.grid[1]).enumerate() {
            if lenses.iter().any(owns) {
                widen(&mut found, row);
            }
        }
        found
    }
}

/// The first row and column of a table of all microlenses that own pixels of some rows, and the counts of its rows and
/// columns. The extreme ones own pixels at the edge; one more on each side, as a tilted array may be a little irregular.
fn table(
    rows: &Range<usize>,
    columns: usize,
    owner: impl Fn(usize, usize) -> MicrolensIndex,
) -> (MicrolensIndex, [usize; 2]) {
    let (top, bottom) = (rows.start, rows.end - 1);
    let across = (0..columns).flat_map(|column| [(top, column), (bottom, column)]);
    let down = rows.clone().flat_map(|row| [(row, 0), (row, columns - 1)]);
    let any = owner(top, 0);
    let (mut low, mut high) = (any, any);
    for (row, column) in across.chain(down) {
        let lens = owner(row, column);
        low = MicrolensIndex { row: low.row.min(lens.row), column: low.column.min(lens.column) };
        high = MicrolensIndex { row: high.row.max(lens.row), column: high.column.max(lens.column) };
    }
    let count = |low: i32, high: i32| usize::try_from(i64::from(high) - i64::from(low) + 3).unwrap_or(1);
    let counts = [count(low.row, high.row), count(low.column, high.column)];
    (MicrolensIndex { row: low.row - 1, column: low.column - 1 }, counts)
}

/// Extends a range so that it contains `k`.
fn widen(range: &mut Range<usize>, k: usize) {
    *range = if range.start >= range.end { k..k + 1 } else { range.start.min(k)..range.end.max(k + 1) };
}

/// The side of the square of pixels around the center of a micro-image that holds the cell of any microlens.
fn views(camera: &PlenopticCamera) -> usize {
    let array = camera.array();
    let (sin, cos) = array.rotation_rad.sin_cos();
    let half = match array.grid {
        MicrolensGrid::Square => (sin.abs() + cos.abs()) / 2.0,
        // The corners of a regular hexagon.
        MicrolensGrid::HexRows | MicrolensGrid::HexColumns => 0.5 / HEX_ROW,
    };
    (2.0 * half * array.scale_y.max(1.0) * camera.micro_image_pitch_px()).ceil() as usize + 1
}

#[cfg(test)]
mod tests;
