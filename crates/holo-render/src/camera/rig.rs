//! The rays of the rig in packets: 4 x 4 neighbouring views under one lens.
//!
//! All rays of one elemental image pass through one point of the focus plane, so a packet of neighbouring views under
//! one lens is a narrow, coherent bundle. Rigs with few views fill the packet with neighbouring lenses instead.

use holo_core::{Projection, Rig};

use crate::accel::{LANES, Lanes, RayHits};
use crate::tile::Tiling;

/// How the 16 lanes of a packet are spread over lens rows, lens columns, view rows and view columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PacketShape {
    /// Lanes along (v, u, t, s); their product is 16.
    pub size: [usize; 4],
    /// Every lane's offsets along (v, u, t, s) from the packet's first pixel.
    pub offsets: [[u32; LANES]; 4],
}

impl PacketShape {
    /// The shape for counts of lens rows and columns, view rows and columns: as square as the counts allow, views first,
    /// then lenses; lanes that remain have no pixel.
    pub fn fitting(counts: [usize; 4]) -> Self {
        let mut size = [1; 4];
        while size.iter().product::<usize>() < LANES {
            let shortest = |[a, b]: [usize; 2]| {
                let grows = |k: usize| 2 * size[k] <= counts[k];
                let order = if size[b] <= size[a] { [b, a] } else { [a, b] };
                order.into_iter().find(|&k| grows(k))
            };
            let axis = shortest([2, 3]).or_else(|| shortest([0, 1])).unwrap_or(3);
            size[axis] *= 2;
        }
        let mut offsets = [[0; LANES]; 4];
        for lane in 0..LANES {
            let mut rest = lane;
            for axis in (0..4).rev() {
                offsets[axis][lane] = (rest % size[axis]) as u32;
                rest /= size[axis];
            }
        }
        Self { size, offsets }
    }
}

/// The lanes of a packet along one axis of the light field: which index each has, and what the rig makes of it.
pub(crate) struct AxisLanes {
    /// Indices along the axis. Lanes beyond its end repeat the last one.
    pub index: [u32; LANES],
    /// -1 for lanes within the axis, else 0.
    pub valid: [i32; LANES],
    /// Lenses: slope through the pixel's centre. Views: position, m.
    value: [f64; LANES],
    /// Views: what the position takes from the slope, position / focus distance.
    shift: [f64; LANES],
}

/// Which pixels of the light field a packet holds: one entry of the tables for each of the axes (v, u, t, s).
#[derive(Clone, Copy)]
pub(crate) struct Pixels<'a> {
    pub axes: [&'a AxisLanes; 4],
    pub valid: Lanes<i32>,
}

/// The rig's numbers, tabulated packet by packet along every axis.
pub(crate) struct RigTables {
    axes: [Vec<AxisLanes>; 4],
    slope_step: f64,
    /// Perspective: 0 and 1. Orthographic: the focus distance and 0.
    slope_to_origin: f64,
    slope_to_direction: f64,
}

/// Sixteen exact rays: camera coordinates, start in the plane z = 0, direction z = -1.
pub(crate) struct ExactRays {
    pub origin_x: [f64; LANES],
    pub origin_y: [f64; LANES],
    pub direction_x: [f64; LANES],
    pub direction_y: [f64; LANES],
}

impl RigTables {
    /// The tables for the packets of `tiling`.
    pub fn new(rig: &Rig, tiling: &Tiling) -> Self {
        let inverse_focus = rig.inverse_focus_per_m();
        let axis = |axis: usize, value: &dyn Fn(usize) -> f64, inverse_focus: f64| -> Vec<AxisLanes> {
            let lanes = |(index, valid): ([u32; LANES], [i32; LANES])| {
                let value = index.map(|k| value(k as usize));
                AxisLanes { index, valid, value, shift: value.map(|x| x * inverse_focus) }
            };
            tiling.blocks(axis).map(lanes).collect()
        };
        let orthographic = rig.parameters().projection == Projection::Orthographic;
        Self {
            axes: [
                axis(0, &|v| rig.slope_y(v as f64 + 0.5), 0.0),
                axis(1, &|u| rig.slope_x(u as f64 + 0.5), 0.0),
                axis(2, &|t| rig.view_y_m(t), inverse_focus),
                axis(3, &|s| rig.view_x_m(s), inverse_focus),
            ],
            slope_step: rig.slope_x(1.0) - rig.slope_x(0.0),
            slope_to_origin: if orthographic { rig.parameters().focus_distance_m } else { 0.0 },
            slope_to_direction: if orthographic { 0.0 } else { 1.0 },
        }
    }

    /// The pixels of the packet that is `block[axis]`-th along every axis.
    #[inline(always)]
    pub fn pixels(&self, block: [usize; 4]) -> Pixels<'_> {
        let axes = [&self.axes[0][block[0]], &self.axes[1][block[1]], &self.axes[2][block[2]], &self.axes[3][block[3]]];
        let mut valid = Lanes([0; LANES]);
        for lane in 0..LANES {
            valid.0[lane] = axes[0].valid[lane] & axes[1].valid[lane] & axes[2].valid[lane] & axes[3].valid[lane];
        }
        Pixels { axes, valid }
    }

    /// The rays through the pixels, exact and as f32 in `packet`: through the centres, or through the points `within` the
    /// pixels (x and y from the upper left corner, 0 to 1).
    #[inline(always)]
    pub fn fill(&self, pixels: &Pixels, within: Option<&[[f32; LANES]; 2]>, packet: &mut RayHits) -> ExactRays {
        let [v, u, t, s] = pixels.axes;
        let mut slope_x = u.value;
        let mut slope_y = v.value;
        if let Some([x, y]) = within {
            for lane in 0..LANES {
                slope_x[lane] += (f64::from(x[lane]) - 0.5) * self.slope_step;
                slope_y[lane] -= (f64::from(y[lane]) - 0.5) * self.slope_step;
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
        packet.reset();
        for lane in 0..LANES {
            packet.rays.origin[0][lane] = rays.origin_x[lane] as f32;
            packet.rays.origin[1][lane] = rays.origin_y[lane] as f32;
            packet.rays.direction[0][lane] = rays.direction_x[lane] as f32;
            packet.rays.direction[1][lane] = rays.direction_y[lane] as f32;
        }
        packet.rays.origin[2] = [0.0; LANES];
        packet.rays.direction[2] = [-1.0; LANES];
        rays
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::{GridSize, Intrinsics, RigParameters, Split};

    #[test]
    fn every_shape_has_sixteen_lanes_and_no_needless_waste() {
        for counts in
            [[53, 79, 100, 100], [132, 198, 1, 1], [1, 1, 1, 10_000], [1, 1, 10_000, 1], [3, 3, 2, 2], [1, 1, 1, 1]]
        {
            let shape = PacketShape::fitting(counts);
            assert_eq!(shape.size.iter().product::<usize>(), LANES, "{counts:?} {shape:?}");
            let mut seen: Vec<[u32; 4]> = (0..LANES).map(|k| shape.offsets.map(|axis| axis[k])).collect();
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), LANES);
        }
        assert_eq!(PacketShape::fitting([53, 79, 100, 100]).size, [1, 1, 4, 4]);
        assert_eq!(PacketShape::fitting([132, 198, 1, 1]).size, [4, 4, 1, 1]);
        assert_eq!(PacketShape::fitting([1, 1, 1, 10_000]).size, [1, 1, 1, 16]);
        assert_eq!(PacketShape::fitting([1, 1, 10_000, 1]).size, [1, 1, 16, 1]);
        assert_eq!(PacketShape::fitting([2000, 1, 1, 1]).size, [16, 1, 1, 1]);
    }

    /// The tabulated rays are the rig's rays, to the rounding of a handful of f64 operations.
    #[test]
    fn tables_and_rig_give_the_same_rays() {
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let split = Split::new(GridSize::new(5, 6), GridSize::new(7, 9)).unwrap();
            let rig = Rig::new(RigParameters {
                split,
                intrinsics: Intrinsics { focal_length_m: 0.05, sensor_size_m: 0.036 },
                baseline_x_m: 0.01,
                baseline_y_m: 0.02,
                focus_distance_m: 3.0,
                projection,
            })
            .unwrap();
            let tiling = Tiling::new([7, 9, 5, 6]);
            let tables = RigTables::new(&rig, &tiling);
            let mut packet = RayHits::EMPTY;
            // Two packets: within the grid, and at its end where some lanes are beyond it.
            for block in [[6, 8, 0, 0], [3, 4, 1, 1]] {
                let pixels = tables.pixels(block);
                let rays = tables.fill(&pixels, Some(&[[0.25; LANES], [0.75; LANES]]), &mut packet);
                let centres = tables.fill(&pixels, None, &mut packet);
                for k in 0..LANES {
                    let [v, u, t, s] = pixels.axes.map(|axis| axis.index[k] as usize);
                    let ray = rig.ray(v, u, t, s, 0.25, 0.75);
                    let centre = rig.ray(v, u, t, s, 0.5, 0.5);
                    for (a, b) in [
                        (rays.origin_x[k], ray.origin_m[0]),
                        (rays.origin_y[k], ray.origin_m[1]),
                        (rays.direction_x[k], ray.direction[0]),
                        (rays.direction_y[k], ray.direction[1]),
                        (centres.direction_x[k], centre.direction[0]),
                        (centres.direction_y[k], centre.direction[1]),
                    ] {
                        assert!((a - b).abs() < 1e-15, "{projection:?} lane {k}: {a} {b}");
                    }
                }
            }
        }
    }
}
