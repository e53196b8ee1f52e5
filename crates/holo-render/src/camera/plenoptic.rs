//! The rays of a plenoptic camera: packets of neighboring pixels behind one microlens.
//!
//! A sample is a point of a pixel and a point of the microlens through which light reaches it. Points of a microlens are
//! distributed evenly over its lit part ([`holo_core::plenoptic::LitRegion`]), so no ray is traced that the apertures
//! block. (Where that part is no disc, lune or rectangle, and before further stops, blocked ones are masked.) All rays through one point of a microlens meet in one point of the plane in focus, as those of a
//! [rig](super::rig) do. The position in the view's pixel is the point of the microlens, with the random numbers that a
//! rig uses for it; the point of the pixel has its own.
//!
//! Source: [`holo_core::plenoptic::PlenopticCamera`], in f64.

use std::sync::OnceLock;

use holo_core::plenoptic::{LitRegion, Microlens, MicrolensIndex, PlenopticCamera};

use super::CameraRays;
use crate::accel::{Cells, ExactRays, RayHits, SpotDifferentials};
use crate::sampling::{PixelIds, Points, Purpose, Sampler, hash, morton};
use crate::simd::{LANES, Lanes};

/// Sixteen pixels, each with a microlens.
#[derive(Clone, Copy)]
pub(crate) struct RawPacket {
    /// The number of lanes with a pixel; lanes after them repeat the last.
    pub count: u32,
    /// The rows and columns of the pixels.
    pub pixel: [[u32; LANES]; 2],
    /// The microlenses, in the list of [`PlenopticRays`].
    pub lens: [u32; LANES],
}

/// A microlens and the random numbers of its pixels.
#[derive(Clone, Copy)]
pub(crate) struct RawLens {
    lens: Microlens,
    /// The row and column of the pixel with the center of the micro-image, from which the random numbers of pixels count.
    corner: [f64; 2],
    /// What the random numbers of its pixels depend on.
    id: u32,
}

/// The pixels of some packets and their microlenses.
#[derive(Default)]
pub(crate) struct RawPixels {
    pub packets: Vec<RawPacket>,
    pub lenses: Vec<RawLens>,
}

/// The rays of a plenoptic camera through the pixels of some packets.
pub(crate) struct PlenopticRays {
    camera: PlenopticCamera,
    pixels: RawPixels,
    /// 1 / (the light of an unvignetted pixel on the axis * area of a microlens).
    scale: f64,
    /// Where rays start: at the main lens, if that is in front of the entrance pupil.
    near: f32,
    /// Disparity = scale * (1 / depth - inverse focus), px between the views of neighboring pixels.
    disparity_scale_m_px: f64,
    whole: WholeLens,
}

/// A microlens that is lit whole, as most are in unfocused cameras: its cells are the same for all places.
struct WholeLens {
    region: LitRegion,
    /// The number of cells along each axis, and the cells row by row.
    parts: OnceLock<(u32, Vec<Option<LensPart>>)>,
}

impl WholeLens {
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

impl RawLens {
    pub fn new(camera: &PlenopticCamera, lens: Microlens) -> Self {
        let [x, y] = camera.position_px(lens.image_center_m).map(f64::floor);
        let MicrolensIndex { row, column } = lens.index;
        let is_gap = lens.lens_type == camera.array().type_count();
        let id = hash((row as u32) << 16 ^ hash(column as u32));
        Self { lens, corner: [y, x], id: if is_gap { hash(!id) } else { id } }
    }

    /// The place of a pixel from the center of the micro-image, as numbers above 0.
    fn view(&self, pixel: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|k| (f64::from(pixel[k]) - self.corner[k] + 32_768.0) as u32)
    }
}

impl RawPixels {
    /// Adds the pixels that light reaches through a microlens, as packets in the order of a Morton curve: blocks of 4 x 4
    /// pixels, aligned with the micro-image, follow each other.
    pub fn push_lens(&mut self, camera: &PlenopticCamera, lens: Microlens, scratch: &mut Vec<[u32; 2]>) {
        let raw_lens = RawLens::new(camera, lens);
        scratch.clear();
        for (row, columns) in camera.lit_pixels(&lens, 0..camera.sensor().size.rows) {
            scratch.extend(columns.map(|column| [row as u32, column as u32]));
        }
        scratch.sort_by_cached_key(|&pixel| morton(raw_lens.view(pixel)));
        let index = self.lenses.len() as u32;
        self.lenses.push(raw_lens);
        for pixels in scratch.chunks(LANES) {
            let at = |k: usize| pixels[k.min(pixels.len() - 1)];
            let pixel = [0, 1].map(|axis| std::array::from_fn(|k| at(k)[axis]));
            self.packets.push(RawPacket { count: pixels.len() as u32, pixel, lens: [index; LANES] });
        }
    }

    /// The pixels of all parts, in their order.
    pub fn joined(parts: &[Self]) -> Self {
        let mut all = Self {
            packets: Vec::with_capacity(parts.iter().map(|part| part.packets.len()).sum()),
            lenses: Vec::with_capacity(parts.iter().map(|part| part.lenses.len()).sum()),
        };
        for part in parts {
            let first = all.lenses.len() as u32;
            all.lenses.extend_from_slice(&part.lenses);
            let moved = |packet: &RawPacket| RawPacket { lens: packet.lens.map(|lens| lens + first), ..*packet };
            all.packets.extend(part.packets.iter().map(moved));
        }
        all
    }
}

impl RawPacket {
    /// -1 for lanes with a pixel, else 0.
    #[inline(always)]
    pub fn valid(&self) -> Lanes<i32> {
        let mut valid = Lanes([0; LANES]);
        for lane in 0..LANES {
            valid.0[lane] = -i32::from((lane as u32) < self.count);
        }
        valid
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

impl PlenopticRays {
    pub fn new(camera: &PlenopticCamera, pixels: RawPixels) -> Self {
        let views = camera.equivalent_views();
        Self {
            pixels,
            scale: 1.0 / (camera.array().aperture.area_m2() * camera.central_cos4()),
            near: (-camera.entrance_pupil_offset_m() as f32).max(f32::MIN_POSITIVE),
            disparity_scale_m_px: views.baseline_m / views.slope_per_lens,
            whole: WholeLens {
                region: camera.relative_lit_region(&camera.microlens(MicrolensIndex { row: 0, column: 0 }), [0.0; 2]),
                parts: OnceLock::new(),
            },
            camera: camera.clone(),
        }
    }

    #[inline(always)]
    pub fn packet(&self, index: usize) -> &RawPacket {
        &self.pixels.packets[index]
    }

    /// All packets.
    pub fn packets(&self) -> &[RawPacket] {
        &self.pixels.packets
    }

    /// What the random numbers of the pixels depend on.
    #[inline(always)]
    pub fn pixel_ids(&self, pixels: &RawPacket) -> PixelIds {
        let mut ids = PixelIds { lens: [0; LANES], view: [[0; LANES]; 2], packet: None };
        for lane in 0..LANES {
            let lens = &self.pixels.lenses[pixels.lens[lane] as usize];
            ids.lens[lane] = lens.id;
            [ids.view[0][lane], ids.view[1][lane]] = lens.view([pixels.pixel[0][lane], pixels.pixel[1][lane]]);
        }
        ids
    }

    /// The center of a pixel from that of its micro-image, m.
    #[inline(always)]
    fn on_sensor(&self, pixels: &RawPacket, lane: usize, lens: &Microlens) -> [f64; 2] {
        let [row, column] = [pixels.pixel[0][lane], pixels.pixel[1][lane]].map(f64::from);
        let place = self.camera.place_m([column + 0.5, row + 0.5]);
        [place[0] - lens.image_center_m[0], place[1] - lens.image_center_m[1]]
    }

    /// Disparity between the views of neighboring pixels, px.
    #[inline(always)]
    pub fn disparity_px(&self, depth_m: f64) -> f64 {
        self.disparity_scale_m_px * (1.0 / depth_m - self.camera.inverse_focus_per_m())
    }

    /// The rays of a sample: from points of the pixels through points of the lit part of their microlenses, with the light
    /// that they stand for; rays without light are not valid.
    #[inline(always)]
    pub fn sample(
        &self,
        pixels: &RawPacket,
        ids: &PixelIds,
        sampler: &Sampler,
        sample: u32,
        packet: &mut RayHits,
    ) -> CameraRays {
        let center: Points = [[0.5; LANES]; 2];
        let (mut on_lens, mut on_pixel) = (center, center);
        if !sampler.centered {
            on_lens = sampler.pixel_positions(ids, sample);
            let runs = sampler.runs(ids);
            on_pixel = sampler.points(&runs.sequence, &runs.first.map(|first| first + sample), Purpose::SENSOR);
        }
        let width = self.width_m();
        let mut out = CameraRays { exact: NO_RAYS, weight: [0.0; LANES], valid: pixels.valid(), cells: None };
        for lane in 0..LANES {
            let lens = &self.pixels.lenses[pixels.lens[lane] as usize].lens;
            let middle = self.on_sensor(pixels, lane, lens);
            let on_sensor = [
                middle[0] + (f64::from(on_pixel[0][lane]) - 0.5) * width,
                middle[1] - (f64::from(on_pixel[1][lane]) - 0.5) * width,
            ];
            let region = self.camera.relative_lit_region(lens, on_sensor);
            let Some(point) = region.point([f64::from(on_lens[0][lane]), f64::from(on_lens[1][lane])]) else {
                out.valid.0[lane] = 0;
                continue;
            };
            let ray = self.camera.relative_ray(lens, on_sensor, point);
            if !self.camera.passes_stops(&ray) {
                out.valid.0[lane] = 0;
                continue;
            }
            let cos4 = self.camera.relative_cos4(lens, on_sensor, point);
            out.weight[lane] = (region.sampled_area_m2() * cos4 * self.scale) as f32;
            out.exact.origin_x[lane] = ray.origin_m[0];
            out.exact.origin_y[lane] = ray.origin_m[1];
            out.exact.direction_x[lane] = ray.direction[0];
            out.exact.direction_y[lane] = ray.direction[1];
        }
        if let Some(count) = sampler.cells {
            out.cells = Some(Cells::Spots(self.spots(pixels, &out, [&on_lens, &on_pixel], count)));
        }
        self.write(&out.exact, packet);
        out
    }

    /// The width of the light-sensitive square of a pixel, m.
    #[inline(always)]
    fn width_m(&self) -> f64 {
        self.camera.sensor().fill * self.camera.sensor().pixel_m
    }

    /// The parts of pixels and microlenses that the `rays` of a sample stand for, if both are divided into `count` x `count`
    /// cells. Cells of a microlens have the same area; the means and variances of their points are those of four points.
    #[inline(always)]
    fn spots(
        &self,
        pixels: &RawPacket,
        rays: &CameraRays,
        [on_lens, on_pixel]: [&Points; 2],
        count: u32,
    ) -> SpotDifferentials {
        let width = self.width_m();
        let unit = self.camera.array().aperture.half_width_m();
        let mut out = SpotDifferentials {
            on_sensor: [[0.0; LANES]; 2],
            on_lens: [[0.0; LANES]; 2],
            lens_part: [[f32::NAN; LANES]; 3],
            to_center: [[[0.0; LANES]; 2]; 2],
        };
        for lane in 0..LANES {
            if rays.valid.0[lane] == 0 {
                continue;
            }
            let lens = &self.pixels.lenses[pixels.lens[lane] as usize].lens;
            let middle = self.on_sensor(pixels, lane, lens);
            let (mut on_sensor, mut center) = ([0.0; 2], [0.0; 2]);
            let mut of_lens = [0.0; 2];
            for axis in 0..2 {
                let sign = if axis == 0 { 1.0 } else { -1.0 };
                let place = f64::from(on_pixel[axis][lane]);
                on_sensor[axis] = middle[axis] + sign * (place - 0.5) * width;
                let start = cell(place, count) / f64::from(count);
                center[axis] = middle[axis] + sign * (start + 0.5 / f64::from(count) - 0.5) * width;
                of_lens[axis] = cell(f64::from(on_lens[axis][lane]), count);
            }
            let region = self.camera.relative_lit_region(lens, on_sensor);
            let part = if region == self.whole.region {
                self.whole.part(of_lens, count)
            } else {
                LensPart::new(&region, [of_lens[0] / f64::from(count), of_lens[1] / f64::from(count)], count)
            };
            let Some(part) = part else { continue };
            let at = self.camera.relative_ray(lens, on_sensor, part.mean);
            let beside = self.camera.relative_ray(lens, [on_sensor[0] + width, on_sensor[1]], part.mean);
            let across = self.camera.relative_ray(lens, on_sensor, [part.mean[0] + unit, part.mean[1]]);
            let to = self.camera.relative_ray(lens, center, part.mean);
            let per_cell = 1.0 / f64::from(count);
            out.on_sensor[0][lane] = ((beside.origin_m[0] - at.origin_m[0]) * per_cell) as f32;
            out.on_sensor[1][lane] = ((beside.direction[0] - at.direction[0]) * per_cell) as f32;
            out.on_lens[0][lane] = ((across.origin_m[0] - at.origin_m[0]) / unit) as f32;
            out.on_lens[1][lane] = ((across.direction[0] - at.direction[0]) / unit) as f32;
            for k in 0..3 {
                out.lens_part[k][lane] = (12.0 * part.variances[k]) as f32;
            }
            out.to_center[0][0][lane] = (to.origin_m[0] - rays.exact.origin_x[lane]) as f32;
            out.to_center[0][1][lane] = (to.origin_m[1] - rays.exact.origin_y[lane]) as f32;
            out.to_center[1][0][lane] = (to.direction[0] - rays.exact.direction_x[lane]) as f32;
            out.to_center[1][1][lane] = (to.direction[1] - rays.exact.direction_y[lane]) as f32;
        }
        out
    }

    /// The chief rays: from the centers of the pixels through the centers of their microlenses.
    #[inline(always)]
    pub fn chief(&self, pixels: &RawPacket, packet: &mut RayHits) -> ExactRays {
        let mut exact = NO_RAYS;
        for lane in 0..LANES {
            let lens = &self.pixels.lenses[pixels.lens[lane] as usize].lens;
            let on_sensor = self.on_sensor(pixels, lane, lens);
            let ray = self.camera.relative_ray(lens, on_sensor, [0.0; 2]);
            exact.origin_x[lane] = ray.origin_m[0];
            exact.origin_y[lane] = ray.origin_m[1];
            exact.direction_x[lane] = ray.direction[0];
            exact.direction_y[lane] = ray.direction[1];
        }
        self.write(&exact, packet);
        exact
    }

    /// Writes the rays as f32.
    #[inline(always)]
    fn write(&self, exact: &ExactRays, packet: &mut RayHits) {
        exact.write(packet);
        packet.rays.near = [self.near; LANES];
    }
}

const NO_RAYS: ExactRays =
    ExactRays { origin_x: [0.0; LANES], origin_y: [0.0; LANES], direction_x: [0.0; LANES], direction_y: [0.0; LANES] };
