//! What a lens of glass does otherwise than a thin lens, over the field.

use super::glass_lens::{GlassLens, TracedRays};
use super::prescription::{TracedLens, chief_direction};
use super::{Paraxial, PlenopticCamera};

/// The F and the C line, nm.
const BLUE_NM: f64 = 486.1327;
const RED_NM: f64 = 656.2725;

/// Rays of a spot along each axis of the pupil.
const SPOT: usize = 32;

/// The part of the exit pupil's radius that the rays of a narrow pencil lie apart.
const PENCIL: f64 = 1e-4;

/// What the main lens does at a distance from the axis.
///
/// # Units
///
/// Meters on the microlens array.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aberrations {
    /// The distance from the axis.
    pub field_m: f64,
    /// How much farther from the axis light arrives than without distortion, as a part of that distance; below 0 for a barrel.
    pub distortion: f64,
    /// The solid angle of the light, but for its cosines, beside that on the axis: what vignetting leaves.
    pub pupil_share: f64,
    /// The root of the mean squared distance of rays from their mean: of a point in the plane in focus.
    pub spot_m: f64,
    /// How far behind the array lines towards the axis are sharp (sagittal focus)...
    pub sagittal_m: f64,
    /// ... and lines across them (tangential focus), towards the sensor.
    pub tangential_m: f64,
    /// How much farther from the axis light of 486.1 nm arrives than light of 656.3 nm.
    pub lateral_color_m: f64,
}

impl PlenopticCamera {
    /// Returns what the lens of glass does at a distance from the axis; `None` without a prescription, and where no light passes.
    ///
    /// # Accuracy
    ///
    /// Rays are traced from the array to the plane in focus, and what they miss there is scaled by the magnification near the
    /// axis. The foci are those of narrow pencils around the chief ray.
    #[must_use]
    pub fn aberrations(&self, field_m: f64) -> Option<Aberrations> {
        let glass = self.glass.as_ref()?;
        let lens = self.main_lens().prescription.as_ref()?;
        let comes_from = |nm: f64| {
            let (array_m, exit_m) = (glass.table().array_m(), self.exit_pupil_m());
            chief_direction(&TracedLens::new(lens, nm), array_m, field_m, exit_m) / self.pupils.slope_per_m
        };
        // What the chief ray of a color comes from farther, its light arrives nearer.
        let lateral_color_m = if field_m > 0.0 { comes_from(RED_NM) - comes_from(BLUE_NM) } else { 0.0 };
        let share = glass.table().solid_angle(field_m * field_m) / glass.table().solid_angle(0.0);
        if share <= 0.0 {
            return None;
        }
        let [sagittal_m, tangential_m] = self.foci_m(glass, field_m);
        let undistorted_m = self.undistorted_m([field_m, 0.0])[0];
        Some(Aberrations {
            field_m,
            distortion: if field_m > 0.0 { field_m / undistorted_m - 1.0 } else { 0.0 },
            pupil_share: share,
            spot_m: self.spot_m(glass, field_m),
            sagittal_m,
            tangential_m,
            lateral_color_m,
        })
    }

    /// Returns how far behind the array light of a wavelength is sharp on the axis, if that of the d line is sharp on the array, in
    /// meters; `None` without a prescription.
    #[must_use]
    pub fn chromatic_shift_m(&self, wavelength_nm: f64) -> Option<f64> {
        let lens = self.main_lens().prescription.as_ref()?;
        let other = Paraxial::at(lens.surfaces(), wavelength_nm).ok()?;
        let depth_from_first = |paraxial: &Paraxial, image_m: f64| {
            // The image behind the last surface, from the rear principal plane, and the object from the front one.
            let from_rear = image_m - paraxial.rear_principal_m;
            1.0 / (1.0 / paraxial.focal_length_m - 1.0 / from_rear) - paraxial.front_principal_m
        };
        let behind_m = self.mla_distance_m() + lens.paraxial().rear_principal_m;
        let object_m = depth_from_first(lens.paraxial(), behind_m);
        let from_front = object_m + other.front_principal_m;
        let image_m = 1.0 / (1.0 / other.focal_length_m - 1.0 / from_front) + other.rear_principal_m;
        Some(image_m - behind_m)
    }

    /// A ray to a place on the array through a point of the exit pupil of its field.
    fn pupil_ray(glass: &GlassLens, field_m: f64, exit_m: f64, in_pupil_m: [f64; 2]) -> TracedRays<1> {
        glass.trace([[field_m], [0.0]], [[-(field_m + in_pupil_m[0]) / exit_m], [-in_pupil_m[1] / exit_m]])
    }

    fn spot_m(&self, glass: &GlassLens, field_m: f64) -> f64 {
        let field = glass.table().field(field_m * field_m);
        let inverse_focus = self.inverse_focus_per_m();
        let mut sums = [0.0; 5];
        for k in 0..SPOT * SPOT {
            let unit = [k % SPOT, k / SPOT].map(|k| (2 * k + 1) as f64 / SPOT as f64 - 1.0);
            let in_pupil = [field.center_m + unit[0] * field.radius_m, unit[1] * field.radius_m];
            let rays = Self::pupil_ray(glass, field_m, field.exit_m, in_pupil);
            if rays.clearance[0] < 0.0 {
                continue;
            }
            // The displacement per meter of depth in the plane in focus.
            let [x, y] = [0, 1].map(|axis| rays.direction[axis][0] + inverse_focus * rays.origin_m[axis][0]);
            for (sum, value) in sums.iter_mut().zip([1.0, x, y, x * x, y * y]) {
                *sum += value;
            }
        }
        let [count, x, y, xx, yy] = sums;
        let variance = (xx - x * x / count + yy - y * y / count) / count;
        variance.max(0.0).sqrt() / self.pupils.slope_per_m.abs()
    }

    /// The sagittal and the tangential focus: of pencils beside the plane of axis and place, and within it.
    fn foci_m(&self, glass: &GlassLens, field_m: f64) -> [f64; 2] {
        let field = glass.table().field(field_m * field_m);
        let step = PENCIL * self.exit_pupil_radius_m();
        [1, 0].map(|axis| {
            let moved = |by: f64| if axis == 0 { [by, 0.0] } else { [0.0, by] };
            let [low, high] = [-step, step].map(|by| Self::pupil_ray(glass, field_m, field.exit_m, moved(by)));
            let origin = high.origin_m[axis][0] - low.origin_m[axis][0];
            let direction = high.direction[axis][0] - low.direction[axis][0];
            // The place sees sharply at 1 / depth = -direction / origin. What is nearer than that plane is imaged behind the array,
            // by d(1 / depth) / g^2.
            (self.inverse_focus_per_m() + direction / origin) / (self.pupils.slope_per_m * self.pupils.slope_per_m)
        })
    }
}
