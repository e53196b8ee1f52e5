//! Focusing by a part of a lens.

use std::ops::RangeInclusive;

use super::{Medium, Paraxial, Prescription, Surface};
use crate::Error;

/// Places of the group that are tried in either direction.
const STEPS: u32 = 256;

impl Prescription {
    /// Returns the same lens with a group of its surfaces moved along the axis, so that it images a depth to where this lens images
    /// what is infinitely far: the sensor and the other surfaces stay. Of several such places the nearest is taken.
    ///
    /// `group` has the first and the last surface that move, counted from 0 from the scene; `depth_m` is counted from the entrance
    /// pupil. The space before and behind the group bounds the movement on the axis. Whether rims touch is not checked.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the group has no surface, all of them, or ends within glass, or reaches no such focus.
    ///
    /// # Source
    ///
    /// Welford, "Aberrations of optical systems" (1986), ch. 3: rays near the axis.
    pub(crate) fn focused_by(&self, group: RangeInclusive<usize>, depth_m: f64) -> Result<Self, Error> {
        let (first, last, count) = (*group.start(), *group.end(), self.surfaces.len());
        if first > last || last >= count || last - first + 1 == count {
            let (what, value) = ("number of lens surfaces that focus", (last + 1).saturating_sub(first) as f64);
            return Err(Error::BadNumber { what, value, need: "surfaces of the lens: one at least, and not all" });
        }
        let air_before = first == 0 || self.surfaces[first - 1].medium == Medium::Air;
        if !air_before || self.surfaces[last].medium != Medium::Air {
            let index = self.surfaces[if air_before { last } else { first - 1 }].medium.index(super::glass::D_LINE_NM);
            let what = "refractive index around the surfaces that focus";
            return Err(Error::BadNumber { what, value: index, need: "1: elements of glass move as a whole" });
        }
        if depth_m == f64::INFINITY {
            return Ok(self.clone());
        }
        // Towards the scene, and towards the sensor.
        let focal_m = self.paraxial.focal_length_m;
        let forward_m = if first == 0 { focal_m } else { self.surfaces[first - 1].thickness_m };
        let backward_m =
            if last + 1 == count { self.paraxial.back_focal_m.max(0.0) } else { self.surfaces[last].thickness_m };
        let miss = |by_m: f64| self.miss_m(&self.moved(first, last, by_m), last + 1 == count, by_m, depth_m);
        let mut found: Option<f64> = None;
        for room_m in [-forward_m, backward_m] {
            let place = |step: u32| room_m * f64::from(step) / f64::from(STEPS);
            for step in 0..STEPS {
                let [near, far] = [place(step), place(step + 1)];
                let (Some(before), Some(behind)) = (miss(near), miss(far)) else { continue };
                // A jump through infinity is no zero.
                let is_zero = (before <= 0.0) != (behind <= 0.0) && (before - behind).abs() < focal_m;
                if is_zero && found.is_none_or(|other| far.abs() < other.abs() || near.abs() < other.abs()) {
                    found = Some(root(&miss, [near, far]));
                    break;
                }
            }
        }
        let Some(by_m) = found else {
            let need = "a depth that these surfaces focus at within the space around them";
            return Err(Error::BadNumber { what: "focus distance in meters", value: depth_m, need });
        };
        Self::new(self.moved(first, last, by_m))
    }

    /// The surfaces with some of them moved towards the sensor.
    fn moved(&self, first: usize, last: usize, by_m: f64) -> Vec<Surface> {
        let mut surfaces = self.surfaces.clone();
        if first > 0 {
            surfaces[first - 1].thickness_m = (surfaces[first - 1].thickness_m + by_m).max(0.0);
        }
        if last + 1 < surfaces.len() {
            surfaces[last].thickness_m = (surfaces[last].thickness_m - by_m).max(0.0);
        }
        surfaces
    }

    /// How far behind the focus of this lens moved surfaces image a depth.
    fn miss_m(&self, surfaces: &[Surface], has_last: bool, by_m: f64, depth_m: f64) -> Option<f64> {
        let near_axis = Paraxial::new(surfaces).ok()?;
        let sensor_m = self.paraxial.back_focal_m - if has_last { by_m } else { 0.0 };
        let from_principal_m = depth_m + near_axis.entrance_pupil_from_principal_m();
        let image_m = 1.0 / (1.0 / near_axis.focal_length_m - 1.0 / from_principal_m);
        Some(near_axis.rear_principal_m + image_m - sensor_m).filter(|miss_m| miss_m.is_finite())
    }
}

/// The zero of a function between two places of unlike signs, by bisection.
fn root(value: &impl Fn(f64) -> Option<f64>, [mut low, mut high]: [f64; 2]) -> f64 {
    let is_low = |x: f64| value(x).is_some_and(|value| value <= 0.0);
    let low_side = is_low(low);
    for _ in 0..100 {
        let middle = low + (high - low) / 2.0;
        if is_low(middle) == low_side { low = middle } else { high = middle }
    }
    low + (high - low) / 2.0
}
