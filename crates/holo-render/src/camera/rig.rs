//! The rays of the rig: packets of neighboring views under one microlens, 4 x 4 or a block that leaves fewer lanes empty.
//!
//! All rays of one elemental image pass through one point of the focus plane, so a packet of neighboring views under
//! one microlens is a narrow, coherent bundle. For rigs with few views a packet contains neighboring microlenses
//! instead.
//!
//! Source: the rig of [`holo_core::Rig`], tabulated along each axis in f64.

use holo_core::{Disparity, Projection, Rig};

use super::tile::{Selection, Tiling};
use crate::accel::{ExactRays, RayDifferentials, RayHits};
use crate::sampling::{PixelIds, rank};
use crate::simd::{LANES, Lanes};

/// The lanes of a packet along one axis of the light field: their indices and the tabulated values of the rig.
pub(crate) struct AxisLanes {
    /// Indices along the axis. Lanes beyond the end repeat the last index.
    pub index: [u32; LANES],
    /// -1 for lanes within the axis, else 0.
    pub valid: [i32; LANES],
    /// Lens axes: slope through the center of the pixel. View axes: position, m.
    value: [f64; LANES],
    /// View axes: the shift of the slope, position / focus distance.
    shift: [f64; LANES],
}

/// The pixels of a packet: one entry of the tables for each of the axes (v, u, t, s).
#[derive(Clone, Copy)]
pub(crate) struct RigPixels<'a> {
    axes: [&'a AxisLanes; 4],
    valid: Lanes<i32>,
}

impl RigPixels<'_> {
    #[inline(always)]
    pub fn valid(&self) -> Lanes<i32> {
        self.valid
    }
}

/// The rays of a rig, tabulated per packet along every axis.
pub(crate) struct RigRays {
    axes: [Vec<AxisLanes>; 4],
    /// Whether the views are a list; the tables of both view axes then have an entry per list position.
    is_list: bool,
    disparity: Disparity,
    /// Lens columns of the whole light field, which determine the ids of lenses.
    lens_columns: u32,
    /// The pixels of a packet along (v, u, t, s).
    packet: [u32; 4],
    slope_step: f64,
    /// The same for the part that a pixel averages over.
    filter_step: f64,
    /// For perspective 0 and 1; for orthographic projection the focus distance and 0.
    slope_to_origin: f64,
    slope_to_direction: f64,
}

impl RigRays {
    /// The tables for the packets of `tiling`, which divides the pixels of `selection`.
    pub fn new(rig: &Rig, tiling: &Tiling, selection: &Selection) -> Self {
        let inverse_focus = rig.inverse_focus_per_m();
        let axis = |axis: usize, value: &dyn Fn(usize) -> f64, inverse_focus: f64| -> Vec<AxisLanes> {
            let lanes = |(place, valid): ([usize; LANES], [i32; LANES])| {
                let index = place.map(|k| selection.index(axis, k));
                let value = index.map(|k| value(k as usize));
                AxisLanes { index, valid, value, shift: value.map(|x| x * inverse_focus) }
            };
            let along = if axis == 2 && selection.is_list() { 3 } else { axis };
            tiling.axis_lanes(along).map(lanes).collect()
        };
        let split = rig.shape();
        let orthographic = rig.projection() == Projection::Orthographic;
        let slope_step = rig.slope_x(1.0) - rig.slope_x(0.0);
        Self {
            axes: [
                axis(0, &|v| rig.slope_y(v as f64 + 0.5), 0.0),
                axis(1, &|u| rig.slope_x(u as f64 + 0.5), 0.0),
                axis(2, &|t| rig.view_y_m(t), inverse_focus),
                axis(3, &|s| rig.view_x_m(s), inverse_focus),
            ],
            is_list: selection.is_list(),
            disparity: rig.disparity(),
            lens_columns: split.lenses().columns as u32,
            packet: tiling.packet_size().map(|size| size as u32),
            slope_step,
            filter_step: slope_step,
            slope_to_origin: if orthographic { rig.focus_distance_m() } else { 0.0 },
            slope_to_direction: if orthographic { 0.0 } else { 1.0 },
        }
    }

    /// The same rig whose pixels average over squares of this width, px.
    pub fn with_filter_width(self, px: f64) -> Self {
        Self { filter_step: self.slope_step * px, ..self }
    }

    /// The pixels of the packet at this position along (v, u, t, s).
    #[inline(always)]
    pub fn pixels(&self, packet: [usize; 4]) -> RigPixels<'_> {
        let [v, u, t, s] = packet;
        let t = if self.is_list { s } else { t };
        let axes = [&self.axes[0][v], &self.axes[1][u], &self.axes[2][t], &self.axes[3][s]];
        let mut valid = Lanes([0; LANES]);
        for lane in 0..LANES {
            valid.0[lane] = axes[0].valid[lane] & axes[1].valid[lane] & axes[2].valid[lane] & axes[3].valid[lane];
        }
        RigPixels { axes, valid }
    }

    /// The ids of the pixels in the whole light field.
    #[inline(always)]
    pub fn pixel_ids(&self, pixels: &RigPixels) -> PixelIds {
        let [v, u, t, s] = pixels.axes;
        let mut lens = [0; LANES];
        for lane in 0..LANES {
            lens[lane] = v.index[lane] * self.lens_columns + u.index[lane];
        }
        let [along_v, along_u, along_t, along_s] = self.packet;
        let is_behind_one = along_v * along_u == 1 && !self.is_list;
        let packet = is_behind_one.then(|| [t.index[0] / along_t, s.index[0] / along_s]);
        PixelIds { lens, view: [t.index, s.index], packet }
    }

    /// The rank of the packet with these pixels.
    #[inline(always)]
    pub fn rank(&self, seed: u64, pixels: &PixelIds) -> u32 {
        let (lens, [t, s]) = (pixels.lens[0], [pixels.view[0][0], pixels.view[1][0]]);
        if let Some(packet) = pixels.packet {
            return rank(seed, lens, packet);
        }
        let [along_v, along_u, ..] = self.packet;
        let [v, u] = [lens / self.lens_columns / along_v, lens % self.lens_columns / along_u];
        rank(seed, t << 16 | s, [v, u])
    }

    #[inline(always)]
    pub fn disparity(&self) -> &Disparity {
        &self.disparity
    }

    /// The cells of the squares that pixels average over, around positions `within` them, or around their centers, if a
    /// square has `count` x `count`.
    #[inline(always)]
    pub fn cells(&self, within: Option<&[[f32; LANES]; 2]>, count: u32) -> RayDifferentials {
        let count = count as f32;
        let step = self.filter_step as f32 / count;
        let [origin_step, direction_step] = [self.slope_to_origin, self.slope_to_direction].map(|x| x as f32 * step);
        let center = [[0.5; LANES]; 2];
        let mut to_center = *within.unwrap_or(&center);
        for position in to_center.as_flattened_mut() {
            let in_cells = *position * count;
            *position = in_cells.floor() + 0.5 - in_cells;
        }
        RayDifferentials { origin_step, direction_step, to_center }
    }

    /// The rays through the pixels, exact and as f32 in `packet`: through the centers, or through the positions
    /// `within` the squares that they average over (x and y from the upper left corner, 0 to 1).
    #[inline(always)]
    pub fn fill(&self, pixels: &RigPixels, within: Option<&[[f32; LANES]; 2]>, packet: &mut RayHits) -> ExactRays {
        let [v, u, t, s] = pixels.axes;
        let mut slope_x = u.value;
        let mut slope_y = v.value;
        if let Some([x, y]) = within {
            for lane in 0..LANES {
                slope_x[lane] += (f64::from(x[lane]) - 0.5) * self.filter_step;
                slope_y[lane] -= (f64::from(y[lane]) - 0.5) * self.filter_step;
            }
        }
        let mut rays = ExactRays {
            origin_x: [0.0; LANES],
            origin_y: [0.0; LANES],
            direction_x: [0.0; LANES],
            direction_y: [0.0; LANES],
        };
        for lane in 0..LANES {
            rays.origin_x[lane] = s.value[lane] + slope_x[lane] * self.slope_to_origin;
            rays.origin_y[lane] = t.value[lane] + slope_y[lane] * self.slope_to_origin;
            rays.direction_x[lane] = slope_x[lane] * self.slope_to_direction - s.shift[lane];
            rays.direction_y[lane] = slope_y[lane] * self.slope_to_direction - t.shift[lane];
        }
        rays.write(packet);
        rays
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::{GridSize, LightFieldShape};

    /// The tabulated rays equal those of the rig, up to the rounding of a few f64 operations.
    #[test]
    fn tables_and_rig_give_the_same_rays() {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let split = LightFieldShape::new(GridSize::new(5, 6), GridSize::new(7, 9)).unwrap();
            let rig = Rig::builder(split)
                .focal_length_m(0.05)
                .sensor_size_m(0.036)
                .baseline_x_m(0.01)
                .baseline_y_m(0.02)
                .focus_distance_m(3.0)
                .projection(projection)
                .build()
                .unwrap();
            let selection = Selection::whole(&split);
            let tiling = Tiling::new(selection.counts());
            let tables = RigRays::new(&rig, &tiling, &selection);
            let wider = RigRays::new(&rig, &tiling, &selection).with_filter_width(3.0);
            let mut packet = RayHits::EMPTY;
            // Two packets of 5 x 3 views, whose last lane has no pixel.
            for position in [[6, 8, 0, 0], [3, 4, 0, 1]] {
                let pixels = tables.pixels(position);
                let rays = tables.fill(&pixels, Some(&[[0.25; LANES], [0.75; LANES]]), &mut packet);
                let centers = tables.fill(&pixels, None, &mut packet);
                let wide = wider.fill(&pixels, Some(&[[0.25; LANES], [0.75; LANES]]), &mut packet);
                for k in 0..LANES {
                    let [v, u, t, s] = pixels.axes.map(|axis| axis.index[k] as usize);
                    let ray = rig.ray(v, u, t, s, 0.25, 0.75);
                    let center = rig.ray(v, u, t, s, 0.5, 0.5);
                    // A square of three pixels: a quarter of it before the center is three quarters of a pixel.
                    let outer = rig.ray(v, u, t, s, -0.25, 1.25);
                    for (a, b) in [
                        (wide.origin_x[k], outer.origin_m[0]),
                        (wide.direction_x[k], outer.direction[0]),
                        (wide.direction_y[k], outer.direction[1]),
                        (rays.origin_x[k], ray.origin_m[0]),
                        (rays.origin_y[k], ray.origin_m[1]),
                        (rays.direction_x[k], ray.direction[0]),
                        (rays.direction_y[k], ray.direction[1]),
                        (centers.direction_x[k], center.direction[0]),
                        (centers.direction_y[k], center.direction[1]),
                    ] {
                        assert!((a - b).abs() < 1e-15, "{projection:?} lane {k}: {a} {b}");
                    }
                }
            }
        }
    }
}
