//! The rays of the rig in packets: 4 x 4 neighbouring views under one lens.
//!
//! All rays of one elemental image pass through one point of the focus plane, so a packet of neighbouring views under
//! one lens is a narrow, coherent bundle. Rigs with few views fill the packet with neighbouring lenses instead.

use holo_core::{Projection, Rig};

use crate::accel::{LANES, Lanes, RayHits};

/// How the 16 lanes of a packet are spread over lens rows, lens columns, view rows and view columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct PacketShape {
    pub v: usize,
    pub u: usize,
    pub t: usize,
    pub s: usize,
}

impl PacketShape {
    /// The shape for counts of lens rows and columns, view rows and columns: as square as the counts allow, views first,
    /// then lenses; lanes that remain have no pixel.
    pub fn fitting(counts: [usize; 4]) -> Self {
        let mut shape = [1; 4];
        while shape.iter().product::<usize>() < LANES {
            let shortest = |[a, b]: [usize; 2]| {
                let grows = |k: usize| 2 * shape[k] <= counts[k];
                let order = if shape[b] <= shape[a] { [b, a] } else { [a, b] };
                order.into_iter().find(|&k| grows(k))
            };
            let axis = shortest([2, 3]).or_else(|| shortest([0, 1])).unwrap_or(3);
            shape[axis] *= 2;
        }
        let [v, u, t, s] = shape;
        Self { v, u, t, s }
    }

    /// Lane `k`'s offsets (v, u, t, s) from the packet's first pixel.
    #[inline(always)]
    pub fn offset(&self, lane: usize) -> [usize; 4] {
        let s = lane % self.s;
        let rest = lane / self.s;
        let t = rest % self.t;
        let rest = rest / self.t;
        [rest / self.u, rest % self.u, t, s]
    }
}

/// The rig's numbers, tabulated once: positions of all views and what a projection does with them.
pub(crate) struct RigTables {
    view_x: Vec<f64>,
    view_y: Vec<f64>,
    inverse_focus: f64,
    /// Slope per pixel and slope at the left and upper edge.
    slope_step: f64,
    slope_left: f64,
    slope_top: f64,
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

/// Which pixels of the light field a packet holds.
#[derive(Clone, Copy)]
pub(crate) struct Pixels {
    pub v: [u32; LANES],
    pub u: [u32; LANES],
    pub t: [u32; LANES],
    pub s: [u32; LANES],
    pub valid: Lanes<i32>,
}

impl RigTables {
    pub fn new(rig: &Rig) -> Self {
        let split = rig.split();
        let orthographic = rig.parameters().projection == Projection::Orthographic;
        Self {
            view_x: (0..split.views().columns).map(|s| rig.view_x_m(s)).collect(),
            view_y: (0..split.views().rows).map(|t| rig.view_y_m(t)).collect(),
            inverse_focus: rig.inverse_focus_per_m(),
            slope_step: rig.slope_x(1.0) - rig.slope_x(0.0),
            slope_left: rig.slope_x(0.0),
            slope_top: rig.slope_y(0.0),
            slope_to_origin: if orthographic { rig.parameters().focus_distance_m } else { 0.0 },
            slope_to_direction: if orthographic { 0.0 } else { 1.0 },
        }
    }

    /// The rays through the points (`u + jitter`, `v + jitter`) of the pixels, exact and as f32 in `packet`.
    #[inline(always)]
    pub fn fill(&self, pixels: &Pixels, jitter: [&[f32; LANES]; 2], packet: &mut RayHits) -> ExactRays {
        let mut x = [0.0; LANES];
        let mut y = [0.0; LANES];
        for lane in 0..LANES {
            x[lane] = self.view_x[pixels.s[lane] as usize];
            y[lane] = self.view_y[pixels.t[lane] as usize];
        }
        let mut rays = ExactRays {
            origin_x: [0.0; LANES],
            origin_y: [0.0; LANES],
            direction_x: [0.0; LANES],
            direction_y: [0.0; LANES],
        };
        for lane in 0..LANES {
            let slope_x = self.slope_left + (f64::from(pixels.u[lane]) + f64::from(jitter[0][lane])) * self.slope_step;
            let slope_y = self.slope_top - (f64::from(pixels.v[lane]) + f64::from(jitter[1][lane])) * self.slope_step;
            rays.origin_x[lane] = x[lane] + slope_x * self.slope_to_origin;
            rays.origin_y[lane] = y[lane] + slope_y * self.slope_to_origin;
            rays.direction_x[lane] = slope_x * self.slope_to_direction - x[lane] * self.inverse_focus;
            rays.direction_y[lane] = slope_y * self.slope_to_direction - y[lane] * self.inverse_focus;
        }
        packet.reset();
        for lane in 0..LANES {
            packet.rays.origin[0][lane] = rays.origin_x[lane] as f32;
            packet.rays.origin[1][lane] = rays.origin_y[lane] as f32;
            packet.rays.origin[2][lane] = 0.0;
            packet.rays.direction[0][lane] = rays.direction_x[lane] as f32;
            packet.rays.direction[1][lane] = rays.direction_y[lane] as f32;
            packet.rays.direction[2][lane] = -1.0;
        }
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
            assert_eq!(shape.v * shape.u * shape.t * shape.s, LANES, "{counts:?} {shape:?}");
            let mut seen: Vec<[usize; 4]> = (0..LANES).map(|k| shape.offset(k)).collect();
            seen.sort_unstable();
            seen.dedup();
            assert_eq!(seen.len(), LANES);
        }
        assert_eq!(PacketShape::fitting([53, 79, 100, 100]), PacketShape { v: 1, u: 1, t: 4, s: 4 });
        assert_eq!(PacketShape::fitting([132, 198, 1, 1]), PacketShape { v: 4, u: 4, t: 1, s: 1 });
        assert_eq!(PacketShape::fitting([1, 1, 1, 10_000]), PacketShape { v: 1, u: 1, t: 1, s: 16 });
        assert_eq!(PacketShape::fitting([1, 1, 10_000, 1]), PacketShape { v: 1, u: 1, t: 16, s: 1 });
        assert_eq!(PacketShape::fitting([2000, 1, 1, 1]), PacketShape { v: 16, u: 1, t: 1, s: 1 });
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
            let tables = RigTables::new(&rig);
            let pixels = Pixels {
                v: [6; LANES],
                u: std::array::from_fn(|k| (k % 9) as u32),
                t: std::array::from_fn(|k| (k % 5) as u32),
                s: std::array::from_fn(|k| (k % 6) as u32),
                valid: Lanes([-1; LANES]),
            };
            let mut packet = RayHits::EMPTY;
            let rays = tables.fill(&pixels, [&[0.25; LANES], &[0.75; LANES]], &mut packet);
            for k in 0..LANES {
                let ray = rig.ray(6, k % 9, k % 5, k % 6, 0.25, 0.75);
                for (a, b) in [
                    (rays.origin_x[k], ray.origin_m[0]),
                    (rays.origin_y[k], ray.origin_m[1]),
                    (rays.direction_x[k], ray.direction[0]),
                    (rays.direction_y[k], ray.direction[1]),
                ] {
                    assert!((a - b).abs() < 1e-15, "{projection:?} lane {k}: {a} {b}");
                }
            }
        }
    }
}
