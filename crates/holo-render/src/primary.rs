//! The rays of the rig in packets: 4 x 4 neighbouring views under one lens.
//!
//! All rays of one elemental image pass through one point of the focus plane, so a packet of neighbouring views under
//! one lens is a narrow, coherent bundle. Rigs with few views fill the packet with neighbouring lenses instead.

use holo_core::{Projection, Rig};

use crate::accel::{LANES, Lanes, RayHits};

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
    /// Indices along (v, u, t, s).
    pub place: [[u32; LANES]; 4],
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
        let [v, u, t, s] = &pixels.place;
        let mut x = [0.0; LANES];
        let mut y = [0.0; LANES];
        for lane in 0..LANES {
            x[lane] = self.view_x[s[lane] as usize];
            y[lane] = self.view_y[t[lane] as usize];
        }
        let mut rays = ExactRays {
            origin_x: [0.0; LANES],
            origin_y: [0.0; LANES],
            direction_x: [0.0; LANES],
            direction_y: [0.0; LANES],
        };
        for lane in 0..LANES {
            let slope_x = self.slope_left + (f64::from(u[lane]) + f64::from(jitter[0][lane])) * self.slope_step;
            let slope_y = self.slope_top - (f64::from(v[lane]) + f64::from(jitter[1][lane])) * self.slope_step;
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
            let tables = RigTables::new(&rig);
            let pixels = Pixels {
                place: [99, 9, 5, 6].map(|n| std::array::from_fn(|k| if n == 99 { 6 } else { (k % n) as u32 })),
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
