//! Where points of the scene appear on the sensor: chief pixels, virtual depth and blur.

use super::glass_lens::GlassLens;
use super::main_lens::Pupils;
use super::{Microlens, MicrolensIndex, PlenopticCamera};

/// The arrangement of a plenoptic camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlenopticMode {
    /// Plenoptic 1.0: the microlenses are focused at infinity or at the exit pupil; the main lens images onto the array.
    Unfocused,
    /// Plenoptic 2.0 with an image in front of the array, whose microlenses form real images of it (Keplerian).
    Keplerian,
    /// Plenoptic 2.0 with a virtual image behind the sensor (Galilean).
    Galilean,
}

/// A point of the scene, seen through a microlens.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MicroImagePoint {
    /// Where the ray through the center of the microlens meets the sensor, (x, y) in pixels.
    pub position_px: [f64; 2],
    /// The movement on the sensor per movement on the microlens; negative if the image lies beyond the sensor. The blur
    /// of the point has this times the radius of the microlens as its radius.
    pub kappa: f64,
    /// The radius of the blur, signed like `kappa`, in pixels: half of the width for square microlenses.
    pub blur_radius_px: f64,
}

impl PlenopticCamera {
    /// Returns the arrangement of a type of microlens: by its focal length beside the gap, within 2 %, and the focal
    /// length that images the exit pupil onto the sensor.
    ///
    /// # Panics
    ///
    /// If there is no such type.
    #[must_use]
    pub fn mode(&self, lens_type: usize) -> PlenopticMode {
        let (gap, focal) = (self.array().gap_m, self.microlens_focal_lengths_m()[lens_type]);
        let pupil = 1.0 / (1.0 / gap + 1.0 / self.exit_pupil_m());
        let tolerance = 0.02 * gap;
        if focal > gap + tolerance {
            PlenopticMode::Galilean
        } else if focal < pupil.min(gap) - tolerance {
            PlenopticMode::Keplerian
        } else {
            PlenopticMode::Unfocused
        }
    }

    /// Returns the virtual depth of a depth: the distance of its image behind the microlens array, in gaps; negative in
    /// front of the array, infinite for an image at infinity.
    ///
    /// # Units
    ///
    /// The depth in meters from the entrance pupil, above 0; may be infinite.
    ///
    /// # Source
    ///
    /// v = (b_I - D) / d with 1/b_I = 1/f - 1/(Z + o_E); the sign is that of libpleno (Galilean above 0).
    #[must_use]
    pub fn virtual_depth(&self, depth_m: f64) -> f64 {
        let vergence = 1.0 / self.main_lens().focal_length_m - 1.0 / (depth_m + self.entrance_pupil_offset_m());
        (1.0 - self.mla_distance_m() * vergence) / (self.array().gap_m * vergence)
    }

    /// Returns the signed ratio of the blur of a depth to the microlens, for a type of microlens; see
    /// [`MicroImagePoint::kappa`]. Infinite for a depth that is imaged onto the array.
    ///
    /// # Panics
    ///
    /// If there is no such type.
    #[must_use]
    pub fn kappa(&self, depth_m: f64, lens_type: usize) -> f64 {
        let vergence = 1.0 / self.main_lens().focal_length_m - 1.0 / (depth_m + self.entrance_pupil_offset_m());
        let (gap, focal) = (self.array().gap_m, self.microlens_focal_lengths_m()[lens_type]);
        1.0 + gap * vergence / (self.mla_distance_m() * vergence - 1.0) - gap / focal
    }

    /// Returns the signed radius of the blur of a depth behind a type of microlens, in pixels.
    ///
    /// # Panics
    ///
    /// If there is no such type.
    ///
    /// # Source
    ///
    /// kappa a / p; the blur radius of Labussière et al. (2020).
    #[must_use]
    pub fn blur_radius_px(&self, depth_m: f64, lens_type: usize) -> f64 {
        self.kappa(depth_m, lens_type) * self.array().aperture.half_width_m() / self.sensor().pixel_m
    }

    /// Returns where a point of the scene appears through a microlens; `None` if it is not in front of the camera, if
    /// the main lens images it onto the array, so that it lights a whole micro-image, or if it is far outside of the light of a lens
    /// of glass.
    ///
    /// The result may lie outside of the micro-image and of the sensor; whether the pupil lets the light through is not
    /// checked.
    ///
    /// # Units
    ///
    /// Meters in the frame of the entrance pupil, the camera looking along -Z.
    ///
    /// # Source
    ///
    /// The [ray](Self::ray) of the center solved for its place on the sensor; the same as X_c = C + (I - C) / v, with the
    /// image I of the main lens and its virtual depth v, where there is no distortion.
    #[must_use]
    pub fn project(&self, point_m: [f64; 3], lens: MicrolensIndex) -> Option<MicroImagePoint> {
        let depth_m = -point_m[2];
        if !(depth_m > 0.0 && point_m.iter().all(|x| x.is_finite())) {
            return None;
        }
        let lens = self.microlens(lens);
        let Pupils { magnification, exit_m, inverse_focus_per_m, slope_per_m, .. } = lens.pupils;
        // How far the ray moves at the depth of the point per movement in the pupil.
        let rest = 1.0 - depth_m * inverse_focus_per_m;
        if rest == 0.0 {
            return None;
        }
        let center = self.undistorted_m(lens.center_m);
        let per_pupil = lens.gap_m / (magnification * exit_m);
        let place = [0, 1].map(|k| {
            let origin = (point_m[k] - depth_m * slope_per_m * center[k]) / rest;
            lens.image_center_m[k] + per_pupil * origin
        });
        let place = match &self.glass {
            None => place,
            Some(glass) => self.through_glass(glass, &lens, point_m, place)?,
        };
        let kappa = per_pupil * (magnification * lens.alpha - depth_m * slope_per_m / rest);
        let blur_radius_px = kappa * self.array().aperture.half_width_m() / self.sensor().pixel_m;
        Some(MicroImagePoint { position_px: self.position_px(place), kappa, blur_radius_px })
    }

    /// The place on the sensor whose ray through the center of a microlens meets a point of the scene through a lens of glass, by
    /// Newton's method from a place near it.
    fn through_glass(
        &self,
        glass: &GlassLens,
        lens: &Microlens,
        point_m: [f64; 3],
        place_m: [f64; 2],
    ) -> Option<[f64; 2]> {
        let miss = |on_sensor: [f64; 2]| {
            let (ray, _) = self.glass_ray(glass, lens, on_sensor, [0.0; 2]);
            [0, 1].map(|k| ray.origin_m[k] - point_m[2] * ray.direction[k] - point_m[k])
        };
        let reach_m = self.exit_pupil_radius_m() * lens.gap_m / lens.exit_pupil_m();
        let start = [0, 1].map(|k| place_m[k] - lens.image_center_m[k]);
        let mut on_sensor = start.map(|x| x * (reach_m / start[0].hypot(start[1])).min(1.0));
        let step_m = 1e-4 * lens.gap_m;
        for _ in 0..30 {
            let [x, y] = miss(on_sensor);
            let [right, up] =
                [[step_m, 0.0], [0.0, step_m]].map(|by| miss([on_sensor[0] + by[0], on_sensor[1] + by[1]]));
            let [[xx, yx], [xy, yy]] =
                [[right[0] - x, right[1] - y], [up[0] - x, up[1] - y]].map(|by| by.map(|x| x / step_m));
            let determinant = xx * yy - xy * yx;
            let by = [(yy * x - xy * y) / determinant, (xx * y - yx * x) / determinant];
            let length_m = by[0].hypot(by[1]);
            if !length_m.is_finite() {
                return None;
            }
            // Steps stay within the light, beyond which glass sends rays anywhere.
            let part = (0.5 * reach_m / length_m).min(1.0);
            on_sensor = [0, 1].map(|k| on_sensor[k] - part * by[k]);
            // The differences leave a few digits of the last step.
            if length_m <= 1e-13 {
                return Some([0, 1].map(|k| lens.image_center_m[k] + on_sensor[k]));
            }
        }
        None
    }

    /// Returns the place on the array at which the chief ray of a place would arrive if the main lens were free of distortion.
    ///
    /// # Units
    ///
    /// Meters from the axis, in upright coordinates.
    #[must_use]
    pub fn undistorted_m(&self, place_m: [f64; 2]) -> [f64; 2] {
        match &self.glass {
            None => self.main_lens().distortion.undistorted(place_m),
            Some(glass) => glass.chief(place_m).direction.map(|x| x[0] / self.pupils.slope_per_m),
        }
    }

    /// Returns the microlenses through which a point of the scene appears within its micro-image, at most `radius_px` from
    /// its center, and the micro-image's center on the sensor: those whose chief ray from the point passes through a
    /// disc in the pupil. None for a point that [`project`](Self::project) has no image of.
    ///
    /// # Units
    ///
    /// Meters in the frame of the entrance pupil, as for [`project`](Self::project).
    #[must_use]
    pub fn lenses_seeing(&self, point_m: [f64; 3], radius_px: f64) -> Vec<MicrolensIndex> {
        let size = self.sensor().size;
        let corners = [[0.0, size.rows as f64], [size.columns as f64, 0.0]].map(|corner| self.place_m(corner));
        let [mut low, mut high] = corners.map(|corner| corner.map(|x| x / self.micro_image_scale()));
        let corners_m = [low, high, [low[0], high[1]], [high[0], low[1]]];
        // X_c - C' = (P - Z g C) / (1 - Z/F) in the pupil: for undistorted microlenses on a plane their centers lie in a disc, and
        // behind a lens of glass nearly so. On a tilted array every microlens has the disc of its height, which lies between those of
        // the lowest and the highest one.
        let raised_m = corners_m.map(|corner| self.array().raised_m(self.relative_to_array_m(corner)).abs());
        let raised_m = raised_m.into_iter().fold(0.0, f64::max);
        let astray_m = self.farthest_distorted_m(&corners_m);
        let windows = [-raised_m, 0.0, raised_m].map(|raised_m| {
            let Pupils { magnification, exit_m, inverse_focus_per_m, slope_per_m, .. } = self.pupils.moved(raised_m);
            let per_center = -point_m[2] * slope_per_m;
            let gap_m = self.array().gap_m + raised_m;
            let in_pupil_m = radius_px * self.sensor().pixel_m * magnification.abs() * exit_m / gap_m;
            let radius_m = in_pupil_m * (1.0 + point_m[2] * inverse_focus_per_m).abs() / per_center.abs();
            let radius_m =
                self.glass.as_ref().map_or(radius_m, |glass| 1.5 * radius_m + glass.astray_m(point_m[2], slope_per_m));
            [0, 1].map(|k| [-1.0, 1.0].map(|side| point_m[k] / per_center + side * (radius_m + astray_m)))
        });
        for k in 0..2 {
            low[k] = low[k].max(windows.iter().map(|window| window[k][0]).fold(f64::INFINITY, f64::min));
            high[k] = high[k].min(windows.iter().map(|window| window[k][1]).fold(f64::NEG_INFINITY, f64::max));
        }
        let near = |lens: &MicrolensIndex| {
            let found = self.project(point_m, *lens).map(|found| found.position_px);
            let middle = self.micro_image_center_px(*lens);
            found.is_some_and(|[x, y]| (x - middle[0]).hypot(y - middle[1]) <= radius_px)
        };
        self.lenses_within(low, high).filter(near).collect()
    }

    /// By how much distortion moves a place on the array at most, with a margin: along the ways to its corners.
    fn farthest_distorted_m(&self, corners_m: &[[f64; 2]]) -> f64 {
        const STEPS: u32 = 16;
        const MARGIN: f64 = 1.5;
        let distortion = &self.main_lens().distortion;
        if distortion.is_none() {
            return 0.0;
        }
        let places = corners_m
            .iter()
            .flat_map(|corner| (1..=STEPS).map(|k| corner.map(|x| x * f64::from(k) / f64::from(STEPS))));
        let away = |place: [f64; 2]| {
            let found = distortion.undistorted(place);
            (found[0] - place[0]).hypot(found[1] - place[1])
        };
        MARGIN * places.map(away).fold(0.0, f64::max)
    }
}
