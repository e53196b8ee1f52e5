//! What the rays of a plenoptic camera stand for, where textures are filtered: parts of pixels and of microlenses.

use std::sync::OnceLock;

use holo_core::plenoptic::{LitRegion, MicrolensIndex, PlenopticCamera};

use super::{Lenses, PlenopticRays, RawPacket, RayPoints};
use crate::accel::{ExactRays, SpotDifferentials};
use crate::sampling::Points;
use crate::simd::{LANES, Lanes};

/// A microlens that is lit whole, as most are in unfocused cameras: its cells are the same for all places.
pub(super) struct WholeLens {
    pub region: LitRegion,
    pub area_m2: f64,
    /// The number of cells along each axis, and the cells row by row.
    parts: OnceLock<(u32, Vec<Option<LensPart>>)>,
}

impl WholeLens {
    pub fn new(camera: &PlenopticCamera) -> Self {
        // Behind glass, light for one far from the axis may be cut off.
        let index = match camera.has_glass() {
            true => camera.owner([0.0; 2]),
            false => MicrolensIndex { row: 0, column: 0 },
        };
        let lens = camera.microlens(index);
        let region = camera.relative_lit_region(&lens, [0.0; 2]);
        Self { area_m2: region.sampled_area_m2(), region, parts: OnceLock::new() }
    }

    /// The part of the cell that begins in this column and row of `count` x `count`.
    #[inline(always)]
    fn part(&self, [column, row]: [f64; 2], count: u32) -> Option<LensPart> {
        let all = || {
            let corner = |k: u32| [k % count, k / count].map(|k| f64::from(k) / f64::from(count));
            (count, (0..count * count).map(|k| LensPart::new(&self.region, corner(k), count)).collect())
        };
        let (known, parts) = self.parts.get_or_init(all);
        if *known == count {
            parts[(row as u32 * count + column as u32) as usize]
        } else {
            LensPart::new(&self.region, [column / f64::from(count), row / f64::from(count)], count)
        }
    }
}

/// A cell of a microlens.
#[derive(Clone, Copy)]
struct LensPart {
    /// The mean of its points, m from the center of the microlens.
    mean: [f64; 2],
    /// The variances of its points along x and y, and their covariance, m^2.
    variances: [f64; 3],
}

/// The places of two points that have the mean and the variance of an interval from 0 to 1.
const TWO_POINTS: [f64; 2] = [0.211_324_865_405_187_1, 0.788_675_134_594_812_9];

impl LensPart {
    /// The part of a lit region that belongs to a cell of the unit square with this corner; `None` if it is not lit whole.
    #[inline(always)]
    fn new(region: &LitRegion, corner: [f64; 2], count: u32) -> Option<Self> {
        let mut points = [[0.0; 2]; 4];
        let mut mean = [0.0; 2];
        for k in 0..4 {
            let x = corner[0] + TWO_POINTS[k % 2] / f64::from(count);
            let y = corner[1] + TWO_POINTS[k / 2] / f64::from(count);
            points[k] = region.point([x, y])?;
            for axis in 0..2 {
                mean[axis] += points[k][axis] / 4.0;
            }
        }
        let mut variances = [0.0; 3];
        for point in points {
            let (x, y) = (point[0] - mean[0], point[1] - mean[1]);
            variances[0] += x * x / 4.0;
            variances[1] += y * y / 4.0;
            variances[2] += x * y / 4.0;
        }
        Some(Self { mean, variances })
    }
}

/// The number of the cell of a place between 0 and 1, of `count`.
#[inline(always)]
fn cell(place: f64, count: u32) -> f64 {
    (place * f64::from(count)).floor().min(f64::from(count) - 1.0)
}

/// The samples of sixteen pixels.
pub(super) struct Spots<'a> {
    pub lenses: &'a Lenses,
    /// The centers of the pixels from those of their micro-images, m.
    pub middle: &'a [[f64; LANES]; 2],
    pub points: &'a RayPoints,
    /// The places within the pixels and within the microlenses, from 0 to 1.
    pub units: &'a [Points; 2],
    pub valid: &'a Lanes<i32>,
}

impl PlenopticRays {
    /// The parts of pixels and microlenses that the rays of a sample stand for, if both are divided into `count` x `count`
    /// cells. Cells of a microlens have the same area; the means and variances of their points are those of four points.
    #[inline(always)]
    pub(super) fn spots(&self, pixels: &RawPacket, exact: &ExactRays, spots: &Spots, count: u32) -> SpotDifferentials {
        let (lenses, points) = (spots.lenses, spots.points);
        let (width, per_cell) = (self.width_m(), 1.0 / f64::from(count));
        let mut out = SpotDifferentials {
            on_sensor: [[0.0; LANES]; 2],
            on_lens: [[0.0; LANES]; 2],
            lens_part: [[f32::NAN; LANES]; 3],
            to_center: [[[0.0; LANES]; 2]; 2],
        };
        // The rays through the middles of the parts.
        let mut middles = RayPoints { on_sensor: *spots.middle, ..RayPoints::NONE };
        for lane in 0..LANES {
            for axis in 0..2 {
                let sign = if axis == 0 { 1.0 } else { -1.0 };
                let start = cell(f64::from(spots.units[0][axis][lane]), count) * per_cell;
                middles.on_sensor[axis][lane] += sign * (start + 0.5 * per_cell - 0.5) * width;
            }
        }
        for lane in 0..LANES {
            let of_lens =
                [cell(f64::from(spots.units[1][0][lane]), count), cell(f64::from(spots.units[1][1][lane]), count)];
            let part = match (spots.valid.0[lane] != 0, points.is_whole[lane]) {
                (false, _) => None,
                (true, true) => self.whole.part(of_lens, count),
                (true, false) => self.part_of_region(pixels, points, lane, of_lens, count),
            };
            let Some(part) = part else { continue };
            for k in 0..3 {
                out.lens_part[k][lane] = (12.0 * part.variances[k]) as f32;
            }
            [middles.on_lens[0][lane], middles.on_lens[1][lane]] = part.mean;
        }
        let to = self.rays(lenses, &middles);
        for lane in 0..LANES {
            let (per_sensor, per_lens) = (lenses.origin_per_sensor[lane], lenses.origin_per_lens[lane]);
            let inverse_focus = lenses.inverse_focus[lane];
            out.on_sensor[0][lane] = (per_sensor * width * per_cell) as f32;
            out.on_sensor[1][lane] = (-per_sensor * inverse_focus * width * per_cell) as f32;
            out.on_lens[0][lane] = -per_lens as f32;
            out.on_lens[1][lane] = (lenses.slope[lane] + per_lens * inverse_focus) as f32;
            out.to_center[0][0][lane] = (to.origin_x[lane] - exact.origin_x[lane]) as f32;
            out.to_center[0][1][lane] = (to.origin_y[lane] - exact.origin_y[lane]) as f32;
            out.to_center[1][0][lane] = (to.direction_x[lane] - exact.direction_x[lane]) as f32;
            out.to_center[1][1][lane] = (to.direction_y[lane] - exact.direction_y[lane]) as f32;
        }
        if self.is_distorted {
            self.distort_lens_differentials(lenses, &middles, &to, &mut out);
        }
        out
    }

    /// The part of a microlens that may not be lit whole; `None` if the part itself is not.
    #[inline(never)]
    fn part_of_region(
        &self,
        pixels: &RawPacket,
        points: &RayPoints,
        lane: usize,
        of_lens: [f64; 2],
        count: u32,
    ) -> Option<LensPart> {
        let corner = of_lens.map(|cell| cell / f64::from(count));
        LensPart::new(&self.region(pixels, points, lane), corner, count)
    }

    /// Directions change over a microlens with the distortion around it.
    #[inline(never)]
    fn distort_lens_differentials(
        &self,
        lenses: &Lenses,
        middles: &RayPoints,
        to: &ExactRays,
        out: &mut SpotDifferentials,
    ) {
        let unit = self.camera.array().aperture.half_width_m();
        let mut beside = RayPoints { on_sensor: middles.on_sensor, on_lens: middles.on_lens, ..RayPoints::NONE };
        for lane in 0..LANES {
            beside.on_lens[0][lane] += unit;
        }
        let across = self.rays(lenses, &beside);
        for lane in 0..LANES {
            out.on_lens[1][lane] = ((across.direction_x[lane] - to.direction_x[lane]) / unit) as f32;
        }
    }
}
