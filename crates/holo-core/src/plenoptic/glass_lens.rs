//! The main lens of glass of a camera: its rays, and which of them pass.

use super::main_lens::Pupils;
use super::prescription::{Field, FieldTable, TracedLens};
use super::{LensRays, Prescription};

/// The wavelength that cameras are traced at if none is chosen, in nanometers: the d line.
pub(super) const WAVELENGTH_NM: f64 = 587.5618;

/// A lens of glass in front of an array.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct GlassLens {
    lens: TracedLens,
    table: FieldTable,
    /// How far chief rays arrive from where they would without distortion, and how far from the axis they cross the entrance
    /// pupil, at most, m.
    astray_m: [f64; 2],
}

impl GlassLens {
    /// `farthest_m`: the greatest distance from the axis of a microlens that lights the sensor.
    pub fn new(prescription: &Prescription, wavelength_nm: f64, pupils: &Pupils, farthest_m: f64) -> Self {
        let lens = TracedLens::new(prescription, wavelength_nm);
        let behind_m = pupils.lens_m + prescription.paraxial().rear_principal_m;
        let table = FieldTable::new(&lens, behind_m, (pupils.exit_m, pupils.exit_radius_m()), farthest_m);
        let mut glass = Self { lens, table, astray_m: [0.0; 2] };
        for k in 1..=32 {
            let away_m = farthest_m * f64::from(k) / 32.0;
            let TracedRays { origin_m, direction, .. } = glass.chief([away_m, 0.0]);
            let found = [direction[0][0] / pupils.slope_per_m - away_m, origin_m[0][0]];
            for (most, x) in glass.astray_m.iter_mut().zip(found) {
                *most = if x.is_finite() { most.max(1.1 * x.abs()) } else { *most };
            }
        }
        glass
    }

    /// How far from that without distortion and with a pupil in one place a microlens lies that sees a point at a depth, at most, by
    /// the slope of chief rays per meter on the array; m.
    pub fn astray_m(&self, depth_m: f64, slope_per_m: f64) -> f64 {
        self.astray_m[0] + self.astray_m[1] / (depth_m * slope_per_m).abs()
    }

    /// By how much the chief ray of a place on the array misses the middle of the stop, m.
    #[cfg(test)]
    pub fn stop_miss_m(&self, place_m: [f64; 2]) -> f64 {
        let (away_m, exit_m) = (place_m[0].hypot(place_m[1]), self.field(place_m).exit_m);
        self.lens.at_stop_m(LensRays::new([[-away_m], [0.0]], -self.table.array_m(), [[away_m / exit_m], [0.0]]))
    }

    /// The chief ray of a place on the array, whether it passes or not.
    pub fn chief(&self, place_m: [f64; 2]) -> TracedRays<1> {
        let exit_m = self.field(place_m).exit_m;
        self.trace(place_m.map(|x| [x]), place_m.map(|x| [-x / exit_m]))
    }

    /// The light of a microlens by the place of its center on the array, in meters from the axis, that lies nearer to the main lens
    /// than the array by this much; its plane is as far from the array.
    pub fn field_of_raised(&self, center_m: [f64; 2], raised_m: f64) -> Field {
        let mut field = self.field(center_m);
        if raised_m != 0.0 {
            // Where its chief ray crosses the array, which is so near that three rounds are enough.
            for _ in 0..3 {
                field = self.field(center_m.map(|x| x * field.exit_m / (field.exit_m - raised_m)));
            }
        }
        field
    }

    /// The same of a microlens in the plane of the array.
    pub fn field(&self, center_m: [f64; 2]) -> Field {
        self.table.field(center_m[0] * center_m[0] + center_m[1] * center_m[1])
    }

    pub fn table(&self) -> &FieldTable {
        &self.table
    }

    /// Where the first surface lies, as a depth from the entrance pupil, m.
    pub fn front_depth_m(&self) -> f64 {
        self.lens.front_depth_m()
    }

    /// Traces rays from places on the array to the scene by their slopes per meter between microlens and main lens, both in upright
    /// coordinates. Returns the places in the entrance pupil, the displacements per meter of depth, and a number below 0 for rays
    /// that the lens stops.
    #[inline(always)]
    pub fn trace<const N: usize>(&self, place_m: [[f64; N]; 2], slope: [[f64; N]; 2]) -> TracedRays<N> {
        let upside_down = |x: [[f64; N]; 2]| x.map(|x| x.map(|x| -x));
        let mut rays = LensRays::new(upside_down(place_m), -self.table.array_m(), upside_down(slope));
        let [origin_m, direction] = self.lens.trace(&mut rays);
        TracedRays { origin_m, direction, clearance: rays.clearance }
    }
}

/// Rays into the scene, as [`PlenopticRay`](super::PlenopticRay).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracedRays<const N: usize> {
    /// Where they cross the entrance pupil's plane z = 0, x and y in meters.
    pub origin_m: [[f64; N]; 2],
    /// The displacement per meter of depth, in meters.
    pub direction: [[f64; N]; 2],
    /// Below 0 for rays that the lens stops.
    pub clearance: [f64; N],
}
