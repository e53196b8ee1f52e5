//! The rays of a plenoptic camera: packets of neighboring pixels behind one microlens.
//!
//! A sample is a point of a pixel and a point of the microlens through which light reaches it. Points of a microlens are
//! distributed evenly over its lit part ([`holo_core::plenoptic::LitRegion`]), so no ray is traced that the apertures
//! block. All rays through one point of a microlens meet in one point of the plane in focus, as those of a
//! [rig](super::rig) do. The position in the view's pixel is the point of the microlens, with the random numbers that a
//! rig uses for it; the point of the pixel has its own.
//!
//! Source: [`holo_core::plenoptic::PlenopticCamera`], in f64.

use holo_core::plenoptic::{MicrolensIndex, PlenopticCamera};

use super::CameraRays;
use crate::accel::{ExactRays, RayHits};
use crate::sampling::{PixelIds, Points, Purpose, Sampler, hash};
use crate::simd::{LANES, Lanes};

/// Sixteen pixels, each with a microlens.
#[derive(Clone, Copy)]
pub(crate) struct RawPacket {
    /// -1 for lanes with a pixel, else 0.
    pub valid: Lanes<i32>,
    pub ids: PixelIds,
    /// The index of each pixel in the raw image, row by row.
    pub pixel: [u32; LANES],
    /// The centers of the microlenses, m from the axis.
    center: [[f64; LANES]; 2],
    /// The centers of the pixels from the centers of the micro-images, m.
    on_sensor: [[f64; LANES]; 2],
    lens_type: [u8; LANES],
}

/// The rays of a plenoptic camera through the pixels of some packets.
pub(crate) struct PlenopticRays {
    camera: PlenopticCamera,
    packets: Vec<RawPacket>,
    /// 1 / (the light of an unvignetted pixel on the axis * area of a microlens).
    scale: f64,
    /// Where rays start: at the main lens, if that is in front of the entrance pupil.
    near: f32,
    /// Disparity = scale * (1 / depth - inverse focus), px between the views of neighboring pixels.
    disparity_scale_m_px: f64,
}

/// The pixels that light reaches through a microlens, as packets in the order of a Morton curve.
pub(crate) fn packets_of_lens(
    camera: &PlenopticCamera,
    lens: MicrolensIndex,
    scratch: &mut Vec<[u32; 2]>,
    packets: &mut Vec<RawPacket>,
) {
    let size = camera.sensor().size;
    scratch.clear();
    for (row, columns) in camera.lit_pixels(lens, 0..size.rows) {
        scratch.extend(columns.map(|column| [row as u32, column as u32]));
    }
    // Blocks of 4 x 4 pixels follow each other, aligned with the micro-image.
    let [x, y] = camera.micro_image_center_px(lens).map(f64::floor);
    let place =
        |&[row, column]: &[u32; 2]| [f64::from(row) - y, f64::from(column) - x].map(|k| (k as i64 + 32_768) as u32);
    scratch.sort_by_cached_key(|pixel| crate::sampling::morton(place(pixel)));
    for pixels in scratch.chunks(LANES) {
        let lane = |k: usize| (pixels[k.min(pixels.len() - 1)], lens);
        packets.push(RawPacket::new(camera, std::array::from_fn(lane), pixels.len()));
    }
}

impl RawPacket {
    /// Packet of the first `count` of these pixels, each with its microlens.
    pub fn new(camera: &PlenopticCamera, pixels: [([u32; 2], MicrolensIndex); LANES], count: usize) -> Self {
        let mut packet = Self {
            valid: Lanes(std::array::from_fn(|lane| -i32::from(lane < count))),
            ids: PixelIds { lens: [0; LANES], view: [[0; LANES]; 2] },
            pixel: [0; LANES],
            center: [[0.0; LANES]; 2],
            on_sensor: [[0.0; LANES]; 2],
            lens_type: [0; LANES],
        };
        let columns = camera.sensor().size.columns as u32;
        // Lanes of one microlens are common.
        let mut last = None;
        for (lane, ([row, column], lens)) in pixels.into_iter().enumerate() {
            let (center, image, corner) = match last {
                Some((same, found)) if same == lens => found,
                _ => {
                    let corner = camera.micro_image_center_px(lens).map(f64::floor);
                    (camera.lens_center_m(lens), camera.micro_image_center_m(lens), corner)
                }
            };
            last = Some((lens, (center, image, corner)));
            let place = camera.place_m([f64::from(column) + 0.5, f64::from(row) + 0.5]);
            for axis in 0..2 {
                packet.center[axis][lane] = center[axis];
                packet.on_sensor[axis][lane] = place[axis] - image[axis];
            }
            packet.ids.lens[lane] = hash((lens.row as u32) << 16 ^ hash(lens.column as u32));
            packet.ids.view[0][lane] = ((f64::from(row) - corner[1]) as i64 + 32_768) as u32;
            packet.ids.view[1][lane] = ((f64::from(column) - corner[0]) as i64 + 32_768) as u32;
            packet.pixel[lane] = row * columns + column;
            packet.lens_type[lane] = camera.array().type_of(lens) as u8;
        }
        packet
    }
}

impl PlenopticRays {
    pub fn new(camera: &PlenopticCamera, packets: Vec<RawPacket>) -> Self {
        let views = camera.equivalent_views();
        Self {
            packets,
            scale: 1.0 / (camera.array().aperture.area_m2() * camera.central_cos4()),
            near: (-camera.entrance_pupil_offset_m() as f32).max(f32::MIN_POSITIVE),
            disparity_scale_m_px: views.baseline_m / views.slope_per_lens,
            camera: camera.clone(),
        }
    }

    #[inline(always)]
    pub fn packet(&self, index: usize) -> &RawPacket {
        &self.packets[index]
    }

    /// Disparity between the views of neighboring pixels, px.
    #[inline(always)]
    pub fn disparity_px(&self, depth_m: f64) -> f64 {
        self.disparity_scale_m_px * (1.0 / depth_m - self.camera.inverse_focus_per_m())
    }

    /// The rays of a sample: from points of the pixels through points of the lit part of their microlenses, with the light
    /// that they stand for; rays without light are not valid.
    #[inline(always)]
    pub fn sample(&self, pixels: &RawPacket, sampler: &Sampler, sample: u32, packet: &mut RayHits) -> CameraRays {
        let center: Points = [[0.5; LANES]; 2];
        let (mut on_lens, mut on_pixel) = (center, center);
        if !sampler.centered {
            on_lens = sampler.pixel_positions(&pixels.ids, sample);
            let runs = sampler.runs(&pixels.ids);
            on_pixel = sampler.points(&runs.sequence, &runs.first.map(|first| first + sample), Purpose::SENSOR);
        }
        let width = self.camera.sensor().fill * self.camera.sensor().pixel_m;
        let mut out = CameraRays { exact: NO_RAYS, weight: [0.0; LANES], valid: pixels.valid, cells: None };
        for lane in 0..LANES {
            let lens_type = usize::from(pixels.lens_type[lane]);
            let on_sensor = [
                pixels.on_sensor[0][lane] + (f64::from(on_pixel[0][lane]) - 0.5) * width,
                pixels.on_sensor[1][lane] - (f64::from(on_pixel[1][lane]) - 0.5) * width,
            ];
            let region = self.camera.relative_lit_region(on_sensor, lens_type);
            let Some(point) = region.point([f64::from(on_lens[0][lane]), f64::from(on_lens[1][lane])]) else {
                out.valid.0[lane] = 0;
                continue;
            };
            let lens_center = [pixels.center[0][lane], pixels.center[1][lane]];
            let ray = self.camera.relative_ray(lens_center, lens_type, on_sensor, point);
            let cos4 = self.camera.relative_cos4(lens_center, on_sensor, point);
            out.weight[lane] = (region.sampled_area_m2() * cos4 * self.scale) as f32;
            out.exact.origin_x[lane] = ray.origin_m[0];
            out.exact.origin_y[lane] = ray.origin_m[1];
            out.exact.direction_x[lane] = ray.direction[0];
            out.exact.direction_y[lane] = ray.direction[1];
        }
        self.write(&out.exact, packet);
        out
    }

    /// The chief rays: from the centers of the pixels through the centers of their microlenses.
    #[inline(always)]
    pub fn chief(&self, pixels: &RawPacket, packet: &mut RayHits) -> ExactRays {
        let mut exact = NO_RAYS;
        for lane in 0..LANES {
            let lens_center = [pixels.center[0][lane], pixels.center[1][lane]];
            let on_sensor = [pixels.on_sensor[0][lane], pixels.on_sensor[1][lane]];
            let lens_type = usize::from(pixels.lens_type[lane]);
            let ray = self.camera.relative_ray(lens_center, lens_type, on_sensor, [0.0; 2]);
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
