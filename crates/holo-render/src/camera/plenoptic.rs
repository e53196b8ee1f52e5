//! The rays of a plenoptic camera: packets of neighboring pixels behind one microlens.
//!
//! A sample is a point of a pixel and a point of the microlens through which light reaches it. Points of a microlens are
//! distributed evenly over its lit part ([`holo_core::plenoptic::LitRegion`]), so no ray is traced that the apertures
//! block. (Where that part is no disc, lune or rectangle, and before further stops, blocked ones are masked.) All rays through one point of a microlens meet in one point of the plane in focus, as those of a
//! [rig](super::rig) do. The position in the view's pixel is the point of the microlens, with the random numbers that a
//! rig uses for it; the point of the pixel has its own.
//!
//! Source: [`holo_core::plenoptic::PlenopticCamera`], in f64.

mod spots;

use holo_core::plenoptic::{LitRegion, Microlens, MicrolensIndex, PlenopticCamera, PlenopticRay, RayCoefficients};

use self::spots::{Spots, WholeLens};
use super::CameraRays;
use crate::accel::{Cells, ExactRays, RayHits};
use crate::sampling::{PixelIds, Points, Purpose, Sampler, hash, morton};
use crate::simd::{LANES, Lanes};

/// The number of the center of a micro-image along either axis of its pixels; a power of two.
const CENTER: u32 = 32_768;

/// Micro-images with pixels farther from their centers are sorted without a bit for every place.
const WIDEST: u32 = 1024;

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
    rays: RayCoefficients,
    /// The square of the distance from the center of the micro-image within which all of the microlens is lit, m^2; -1 if
    /// it never is.
    whole_squared: f64,
    /// The row and column of the pixel with the center of the micro-image, from which the random numbers of pixels count.
    corner: [f64; 2],
    /// What the random numbers of its pixels depend on.
    id: u32,
}

/// The pixels of a microlens in the order of a Morton curve.
#[derive(Default)]
pub(crate) struct Order {
    pixels: Vec<[u32; 2]>,
    /// A bit for every place on the curve, and the pixel there.
    is_taken: Vec<u64>,
    at_place: Vec<[u32; 2]>,
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
    /// Where rays start: at the main lens or its first surface, if that is in front of the entrance pupil.
    near: f32,
    /// Disparity = scale * (1 / depth - inverse focus), px between the views of neighboring pixels.
    disparity_scale_m_px: f64,
    whole: WholeLens,
    is_distorted: bool,
    has_stops: bool,
}

impl RawLens {
    pub fn new(camera: &PlenopticCamera, lens: Microlens) -> Self {
        let [x, y] = camera.position_px(lens.image_center_m).map(f64::floor);
        let MicrolensIndex { row, column } = lens.index;
        let is_gap = lens.lens_type == camera.array().type_count();
        let id = hash((row as u32) << 16 ^ hash(column as u32));
        let whole_m = camera.lit_whole_radius_m(&lens);
        Self {
            rays: lens.ray_coefficients(),
            whole_squared: if whole_m >= 0.0 { whole_m * whole_m } else { -1.0 },
            lens,
            corner: [y, x],
            id: if is_gap { hash(!id) } else { id },
        }
    }

    /// The place of a pixel from the center of the micro-image, as numbers above 0.
    fn view(&self, pixel: [u32; 2]) -> [u32; 2] {
        [0, 1].map(|k| (f64::from(pixel[k]) - self.corner[k] + f64::from(CENTER)) as u32)
    }
}

impl Order {
    /// Puts the pixels in the order of a Morton curve around the center of their micro-image: a bit for each place, of
    /// which there are few.
    fn sort(&mut self, lens: &RawLens) {
        let Self { pixels, is_taken, at_place } = self;
        let far = pixels.iter().flat_map(|&pixel| lens.view(pixel)).map(|x| x.abs_diff(CENTER)).max().unwrap_or(0);
        // Places from the center, moved above 0 by a power of two, have the order of those moved by the center's number.
        let half = (far + 1).next_power_of_two();
        if half > WIDEST {
            return pixels.sort_unstable_by_key(|&pixel| morton(lens.view(pixel)));
        }
        let places = 4 * (half as usize).pow(2);
        is_taken.clear();
        is_taken.resize(places.div_ceil(64), 0);
        at_place.resize(places.max(at_place.len()), [0; 2]);
        for &pixel in &*pixels {
            let place = morton(lens.view(pixel).map(|x| x + half - CENTER)) as usize;
            is_taken[place / 64] |= 1 << (place % 64);
            at_place[place] = pixel;
        }
        pixels.clear();
        for (word, &taken) in is_taken.iter().enumerate() {
            let mut left = taken;
            while left != 0 {
                pixels.push(at_place[64 * word + left.trailing_zeros() as usize]);
                left &= left - 1;
            }
        }
    }
}

impl RawPixels {
    /// Adds the pixels that light reaches through a microlens, as packets in the order of a Morton curve: blocks of 4 x 4
    /// pixels, aligned with the micro-image, follow each other.
    pub fn push_lens(&mut self, camera: &PlenopticCamera, lens: Microlens, scratch: &mut Order) {
        let raw_lens = RawLens::new(camera, lens);
        scratch.pixels.clear();
        for (row, columns) in camera.lit_pixels(&lens, 0..camera.sensor().size.rows) {
            scratch.pixels.extend(columns.map(|column| [row as u32, column as u32]));
        }
        scratch.sort(&raw_lens);
        let index = self.lenses.len() as u32;
        self.lenses.push(raw_lens);
        for pixels in scratch.pixels.chunks(LANES) {
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

/// The microlenses of sixteen pixels.
struct Lenses {
    center: [[f64; LANES]; 2],
    image_center: [[f64; LANES]; 2],
    gap: [f64; LANES],
    origin_per_sensor: [f64; LANES],
    origin_per_lens: [f64; LANES],
    slope: [f64; LANES],
    inverse_focus: [f64; LANES],
    whole_squared: [f64; LANES],
    alpha: [f64; LANES],
    exit: [f64; LANES],
}

impl Lenses {
    const NONE: Self = Self {
        center: [[0.0; LANES]; 2],
        image_center: [[0.0; LANES]; 2],
        gap: [1.0; LANES],
        origin_per_sensor: [0.0; LANES],
        origin_per_lens: [0.0; LANES],
        slope: [0.0; LANES],
        inverse_focus: [0.0; LANES],
        whole_squared: [0.0; LANES],
        alpha: [0.0; LANES],
        exit: [1.0; LANES],
    };

    #[inline(always)]
    fn set(&mut self, lane: usize, lens: &RawLens) {
        for axis in 0..2 {
            self.center[axis][lane] = lens.lens.center_m[axis];
            self.image_center[axis][lane] = lens.lens.image_center_m[axis];
        }
        self.gap[lane] = lens.lens.gap_m;
        self.origin_per_sensor[lane] = lens.rays.origin_per_sensor;
        self.origin_per_lens[lane] = lens.rays.origin_per_lens;
        self.slope[lane] = lens.rays.slope_per_m;
        self.inverse_focus[lane] = lens.rays.inverse_focus_per_m;
        self.whole_squared[lane] = lens.whole_squared;
        self.alpha[lane] = lens.lens.alpha;
        self.exit[lane] = lens.lens.exit_pupil_m();
    }

    /// cos^4 of the light from a point of the microlens to a place on the sensor, as
    /// [`PlenopticCamera::relative_cos4`].
    #[inline(always)]
    fn cos4(&self, points: &RayPoints, lane: usize) -> f64 {
        let away = |axis: usize| {
            points.on_lens[axis][lane]
                - points.on_sensor[axis][lane]
                - (self.image_center[axis][lane] - self.center[axis][lane])
        };
        let [x, y] = [away(0), away(1)];
        let squared = 1.0 + (x * x + y * y) / (self.gap[lane] * self.gap[lane]);
        1.0 / (squared * squared)
    }
}

/// The points that sixteen rays pass.
struct RayPoints {
    /// On the sensor, from the centers of the micro-images, m.
    on_sensor: [[f64; LANES]; 2],
    /// On the microlenses, from their centers, m.
    on_lens: [[f64; LANES]; 2],
    /// The area that a point of a microlens stands for, m^2.
    area: [f64; LANES],
    /// Whether the microlens is known to be lit whole.
    is_whole: [bool; LANES],
}

impl RayPoints {
    const NONE: Self =
        Self { on_sensor: [[0.0; LANES]; 2], on_lens: [[0.0; LANES]; 2], area: [0.0; LANES], is_whole: [false; LANES] };
}

impl PlenopticRays {
    pub fn new(camera: &PlenopticCamera, pixels: RawPixels) -> Self {
        let views = camera.equivalent_views();
        Self {
            pixels,
            scale: 1.0 / (camera.array().aperture.area_m2() * camera.central_cos4()),
            near: (camera.front_depth_m() as f32).max(f32::MIN_POSITIVE),
            disparity_scale_m_px: views.baseline_m / views.slope_per_lens,
            whole: WholeLens::new(camera),
            is_distorted: !camera.main_lens().distortion.is_none(),
            has_stops: !camera.main_lens().stops.is_empty(),
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

    /// The microlenses of the pixels.
    #[inline(always)]
    fn lenses(&self, pixels: &RawPacket) -> Lenses {
        let mut out = Lenses::NONE;
        let first = pixels.lens[0];
        if pixels.lens.iter().all(|&lens| lens == first) {
            let lens = &self.pixels.lenses[first as usize];
            for lane in 0..LANES {
                out.set(lane, lens);
            }
        } else {
            for lane in 0..LANES {
                out.set(lane, &self.pixels.lenses[pixels.lens[lane] as usize]);
            }
        }
        out
    }

    /// The centers of the pixels from those of their micro-images, m.
    #[inline(always)]
    fn on_sensor(&self, pixels: &RawPacket, lenses: &Lenses) -> [[f64; LANES]; 2] {
        let mut out = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let [row, column] = [f64::from(pixels.pixel[0][lane]), f64::from(pixels.pixel[1][lane])];
            let place = self.camera.place_m([column + 0.5, row + 0.5]);
            out[0][lane] = place[0] - lenses.image_center[0][lane];
            out[1][lane] = place[1] - lenses.image_center[1][lane];
        }
        out
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
        let mut units: [Points; 2] = [[[0.5; LANES]; 2]; 2];
        if !sampler.centered {
            let runs = sampler.runs(ids);
            let on_pixel = sampler.points(&runs.sequence, &runs.first.map(|first| first + sample), Purpose::SENSOR);
            units = [on_pixel, sampler.pixel_positions(ids, sample)];
        }
        let lenses = self.lenses(pixels);
        let middle = self.on_sensor(pixels, &lenses);
        let width = self.width_m();
        let mut points = RayPoints { on_sensor: middle, ..RayPoints::NONE };
        for lane in 0..LANES {
            points.on_sensor[0][lane] += (f64::from(units[0][0][lane]) - 0.5) * width;
            points.on_sensor[1][lane] -= (f64::from(units[0][1][lane]) - 0.5) * width;
        }
        let mut valid = pixels.valid();
        self.find_points(pixels, &lenses, &units[1], &mut points, &mut valid);
        let mut exact = self.passing_rays(&lenses, &points, &mut valid);
        let mut weight = [0.0; LANES];
        for lane in 0..LANES {
            let light = points.area[lane] * lenses.cos4(&points, lane) * self.scale;
            let is_lit = valid.0[lane] != 0;
            weight[lane] = if is_lit { light as f32 } else { 0.0 };
            for x in [&mut exact.origin_x, &mut exact.origin_y, &mut exact.direction_x, &mut exact.direction_y] {
                x[lane] = if is_lit { x[lane] } else { 0.0 };
            }
        }
        let spots = Spots { lenses: &lenses, middle: &middle, points: &points, units: &units, valid: &valid };
        let cells = sampler.cells.map(|count| Cells::Spots(self.spots(pixels, &exact, &spots, count)));
        self.write(&exact, packet);
        CameraRays { exact, weight, valid, cells }
    }

    /// Finds the points of the microlenses for places on the sensor and points of the unit square; lanes without light are
    /// not valid.
    #[inline(always)]
    fn find_points(
        &self,
        pixels: &RawPacket,
        lenses: &Lenses,
        units: &Points,
        points: &mut RayPoints,
        valid: &mut Lanes<i32>,
    ) {
        for lane in 0..LANES {
            let [x, y] = [points.on_sensor[0][lane], points.on_sensor[1][lane]];
            points.is_whole[lane] = x * x + y * y <= lenses.whole_squared[lane];
        }
        for lane in 0..LANES {
            let unit = [f64::from(units[0][lane]), f64::from(units[1][lane])];
            let (point, area) = match points.is_whole[lane] {
                true => (self.whole.region.point(unit), self.whole.area_m2),
                false => self.point_of_part(pixels, points, lane, unit),
            };
            [points.on_lens[0][lane], points.on_lens[1][lane]] = point.unwrap_or_default();
            points.area[lane] = area;
            valid.0[lane] &= -i32::from(point.is_some());
        }
    }

    /// The point of a microlens that may not be lit whole, and the area that it stands for.
    #[inline(never)]
    fn point_of_part(
        &self,
        pixels: &RawPacket,
        points: &mut RayPoints,
        lane: usize,
        unit: [f64; 2],
    ) -> (Option<[f64; 2]>, f64) {
        let region = self.region(pixels, points, lane);
        // Those of other shapes are.
        points.is_whole[lane] = region == self.whole.region;
        (region.point(unit), region.sampled_area_m2())
    }

    /// The lit part of a microlens.
    fn region(&self, pixels: &RawPacket, points: &RayPoints, lane: usize) -> LitRegion {
        let lens = &self.pixels.lenses[pixels.lens[lane] as usize].lens;
        self.camera.relative_lit_region(lens, [points.on_sensor[0][lane], points.on_sensor[1][lane]])
    }

    /// The rays through points of the sensor and of the microlenses.
    #[inline(always)]
    fn rays(&self, lenses: &Lenses, points: &RayPoints) -> ExactRays {
        let mut on_array = [[0.0; LANES]; 2];
        for axis in 0..2 {
            for lane in 0..LANES {
                on_array[axis][lane] = lenses.center[axis][lane] + points.on_lens[axis][lane];
            }
        }
        if self.is_distorted {
            self.undistort(&mut on_array);
        }
        let mut exact = NO_RAYS;
        for lane in 0..LANES {
            let origin = |axis: usize| {
                lenses.origin_per_sensor[lane] * points.on_sensor[axis][lane]
                    - lenses.origin_per_lens[lane] * points.on_lens[axis][lane]
            };
            let [x, y] = [origin(0), origin(1)];
            let (slope, inverse_focus) = (lenses.slope[lane], lenses.inverse_focus[lane]);
            exact.origin_x[lane] = x;
            exact.origin_y[lane] = y;
            exact.direction_x[lane] = slope * on_array[0][lane] - x * inverse_focus;
            exact.direction_y[lane] = slope * on_array[1][lane] - y * inverse_focus;
        }
        exact
    }

    /// The rays through points of the sensor and of the microlenses; those that further stops or a lens of glass block are not
    /// valid.
    #[inline(always)]
    fn passing_rays(&self, lenses: &Lenses, points: &RayPoints, valid: &mut Lanes<i32>) -> ExactRays {
        if !self.camera.has_glass() {
            let exact = self.rays(lenses, points);
            self.block(&exact, valid);
            return exact;
        }
        let (mut place, mut slope) = ([[0.0; LANES]; 2], [[0.0; LANES]; 2]);
        let gap = self.camera.array().gap_m;
        for axis in 0..2 {
            for lane in 0..LANES {
                let in_pupil = lenses.exit[lane] / lenses.gap[lane] * points.on_sensor[axis][lane]
                    - lenses.alpha[lane] * points.on_lens[axis][lane];
                let point = lenses.center[axis][lane] + points.on_lens[axis][lane];
                slope[axis][lane] = -(point + in_pupil) / lenses.exit[lane];
                // On the plane of an array that is not tilted.
                place[axis][lane] = point - (lenses.gap[lane] - gap) * slope[axis][lane];
            }
        }
        let Some(rays) = self.camera.traced_rays(place, slope) else { return NO_RAYS };
        for lane in 0..LANES {
            valid.0[lane] &= -i32::from(rays.clearance[lane] >= 0.0);
        }
        let ([origin_x, origin_y], [direction_x, direction_y]) = (rays.origin_m, rays.direction);
        ExactRays { origin_x, origin_y, direction_x, direction_y }
    }

    #[inline(never)]
    fn undistort(&self, on_array: &mut [[f64; LANES]; 2]) {
        let distortion = self.camera.main_lens().distortion;
        for lane in 0..LANES {
            [on_array[0][lane], on_array[1][lane]] = distortion.undistorted([on_array[0][lane], on_array[1][lane]]);
        }
    }

    /// Marks rays that further stops block as not valid.
    #[inline(always)]
    fn block(&self, exact: &ExactRays, valid: &mut Lanes<i32>) {
        if self.has_stops {
            for lane in 0..LANES {
                let origin_m = [exact.origin_x[lane], exact.origin_y[lane]];
                let direction = [exact.direction_x[lane], exact.direction_y[lane]];
                valid.0[lane] &= -i32::from(self.camera.passes_stops(&PlenopticRay { origin_m, direction }));
            }
        }
    }

    /// The width of the light-sensitive square of a pixel, m.
    #[inline(always)]
    fn width_m(&self) -> f64 {
        self.camera.sensor().fill * self.camera.sensor().pixel_m
    }

    /// The chief rays: from the centers of the pixels through the centers of their microlenses. Those that a lens of glass stops
    /// start infinitely far away, and hit nothing.
    #[inline(always)]
    pub fn chief(&self, pixels: &RawPacket, packet: &mut RayHits) -> ExactRays {
        let lenses = self.lenses(pixels);
        let points = RayPoints { on_sensor: self.on_sensor(pixels, &lenses), ..RayPoints::NONE };
        if !self.camera.has_glass() {
            let exact = self.rays(&lenses, &points);
            self.write(&exact, packet);
            return exact;
        }
        let mut passes = Lanes([-1; LANES]);
        let mut exact = self.passing_rays(&lenses, &points, &mut passes);
        let mut near = [self.near; LANES];
        for lane in 0..LANES {
            if passes.0[lane] == 0 {
                near[lane] = f32::INFINITY;
                for x in [&mut exact.origin_x, &mut exact.origin_y, &mut exact.direction_x, &mut exact.direction_y] {
                    x[lane] = 0.0;
                }
            }
        }
        self.write(&exact, packet);
        packet.rays.near = near;
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

#[cfg(test)]
mod tests {
    use holo_core::GridSize;
    use holo_core::plenoptic::{ImageSensor, MainLens, MicrolensArray, MicrolensGrid};

    use super::*;

    /// The order of the bits is that of a sort, near the center and far from it.
    #[test]
    fn pixels_follow_the_curve() {
        let array = MicrolensArray::new(MicrolensGrid::Square, 1e-4, 4e-4);
        let sensor = ImageSensor::new(GridSize::new(90, 120), 5e-6);
        let camera = PlenopticCamera::new(sensor, array, MainLens::new(0.05, 4.0, 2.0)).unwrap();
        let lens = RawLens::new(&camera, camera.microlens(MicrolensIndex { row: 0, column: 0 }));
        for far in [1, 7, 60, 2 * WIDEST] {
            let pixels: Vec<[u32; 2]> = (0..400).map(|k| [hash(k) % far, hash(k + 400) % far]).collect();
            let mut expected = pixels.clone();
            expected.sort_by_key(|&pixel| morton(lens.view(pixel)));
            expected.dedup();
            let mut order = Order { pixels, ..Order::default() };
            order.sort(&lens);
            order.pixels.dedup();
            assert_eq!(order.pixels, expected, "{far}");
        }
    }
}
