//! One microlens of a camera: its rays, and through which part of it light reaches a place on the sensor.

use super::glass_lens::GlassLens;
use super::lune::Opening;
use super::main_lens::Pupils;
use super::{LensAperture, LitRegion, MicrolensFocus, MicrolensIndex, PlenopticCamera, PupilShape};

/// A ray into the scene, in the frame of the entrance pupil.
///
/// As for [`RigRay`](crate::RigRay) the direction along z is -1: the point at depth Z is `(origin + Z * direction, -Z)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlenopticRay {
    /// Where it crosses the entrance pupil's plane z = 0, x and y in meters.
    pub origin_m: [f64; 2],
    /// The displacement per meter of depth, in meters.
    pub direction: [f64; 2],
}

/// A microlens of a camera, or the clear gap around it, with the numbers that its rays need.
///
/// Places on the sensor are given from the center of the micro-image, points of the microlens from its own center, all in
/// meters in upright coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Microlens {
    /// Its row and column.
    pub index: MicrolensIndex,
    /// Its type; for a gap the number of types.
    pub lens_type: usize,
    /// Its center, in meters from the axis.
    pub center_m: [f64; 2],
    /// The center of its micro-image: the projection of its center from the exit pupil.
    pub image_center_m: [f64; 2],
    /// The distance to the sensor, in meters.
    pub gap_m: f64,
    /// The displacement over the exit pupil per displacement on the microlens.
    pub alpha: f64,
    pub(super) pupils: Pupils,
    pub(super) pupil: LitPupil,
}

/// A disc in the plane of the exit pupil that holds all light for a microlens, in meters from the axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LitPupil {
    pub center_m: [f64; 2],
    /// 0 for a microlens that no light reaches.
    pub radius_m: f64,
    /// The radius around the axis within which all is light, for a round pupil; below 0 if there is none.
    pub inner_m: f64,
}

/// How the rays of a microlens depend on the points that they pass, without distortion and near the axis of a lens of glass, along x and y alike: a point X from
/// the center of the micro-image and a point Q from the center of the microlens, both in meters.
///
/// origin = `origin_per_sensor` X - `origin_per_lens` Q, direction = `slope_per_m` (C + Q) - `inverse_focus_per_m` origin
/// for the [center](Microlens::center_m) C.
///
/// # Source
///
/// See [`PlenopticCamera::ray`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayCoefficients {
    /// The displacement of the origin per displacement on the sensor (m D_X / d).
    pub origin_per_sensor: f64,
    /// The displacement of the origin against a displacement on the microlens (m alpha).
    pub origin_per_lens: f64,
    /// The slope of the chief ray per meter on the array (g), in 1/m.
    pub slope_per_m: f64,
    /// 1 / depth of the plane in focus (1 / F), in 1/m.
    pub inverse_focus_per_m: f64,
}

impl Microlens {
    /// Returns the distance from the array to the exit pupil that it sees, in meters: where its chief ray crosses the axis.
    #[inline]
    #[must_use]
    pub const fn exit_pupil_m(&self) -> f64 {
        self.pupils.exit_m
    }

    /// Returns how its rays depend on the points that they pass.
    #[inline]
    #[must_use]
    pub fn ray_coefficients(&self) -> RayCoefficients {
        let Pupils { magnification, exit_m, inverse_focus_per_m, slope_per_m, .. } = self.pupils;
        RayCoefficients {
            origin_per_sensor: magnification * exit_m / self.gap_m,
            origin_per_lens: magnification * self.alpha,
            slope_per_m,
            inverse_focus_per_m,
        }
    }
}

impl PlenopticCamera {
    /// Returns a microlens.
    #[must_use]
    pub fn microlens(&self, index: MicrolensIndex) -> Microlens {
        self.opening(index, self.array().type_of(index))
    }

    /// Returns what light passes of the cell of a microlens: the microlens, and the gap around it if that is clear.
    pub fn openings(&self, index: MicrolensIndex) -> impl Iterator<Item = Microlens> {
        let gap = self.array().has_clear_gaps.then(|| self.opening(index, self.array().type_count()));
        std::iter::once(self.microlens(index)).chain(gap)
    }

    fn opening(&self, index: MicrolensIndex, lens_type: usize) -> Microlens {
        let center_m = self.lens_center_m(index);
        let raised_m = self.array().raised_m(self.relative_to_array_m(center_m));
        let gap_m = self.array().gap_m + raised_m;
        let (pupils, alpha) = match raised_m {
            0.0 => (self.pupils, self.alpha(lens_type)),
            _ => {
                let pupils = self.pupils.moved(raised_m);
                (pupils, self.alpha_for(lens_type, gap_m, pupils.exit_m))
            }
        };
        let radius_m = self.exit_pupil_radius_m();
        let pupil = LitPupil { center_m: [0.0; 2], radius_m, inner_m: radius_m };
        let image_center_m = center_m.map(|x| x * (1.0 + gap_m / pupils.exit_m));
        let lens = Microlens { index, lens_type, center_m, image_center_m, gap_m, alpha, pupils, pupil };
        match &self.glass {
            None => lens,
            Some(glass) => self.behind_glass(glass, lens),
        }
    }

    /// The same microlens behind a lens of glass, with the pupil that it has at this distance from the axis.
    fn behind_glass(&self, glass: &GlassLens, mut lens: Microlens) -> Microlens {
        let raised_m = lens.gap_m - self.array().gap_m;
        let field = glass.field_of_raised(lens.center_m, raised_m);
        let exit_m = field.exit_m - raised_m;
        let away_m = lens.center_m[0].hypot(lens.center_m[1]);
        let along = if away_m > 0.0 { lens.center_m.map(|x| x / away_m) } else { [0.0; 2] };
        lens.pupils.exit_m = exit_m;
        lens.alpha = self.alpha_for(lens.lens_type, lens.gap_m, exit_m);
        lens.image_center_m = lens.center_m.map(|x| x * (1.0 + lens.gap_m / exit_m));
        let center_m = along.map(|x| x * field.center_m);
        lens.pupil = LitPupil { center_m, radius_m: field.radius_m, inner_m: field.inner_m };
        lens
    }

    /// Alpha of a type of microlens, or of gaps, at a distance from sensor and exit pupil.
    pub(super) fn alpha_for(&self, lens_type: usize, gap_m: f64, exit_m: f64) -> f64 {
        let vergence = match &self.array().focus {
            _ if lens_type == self.array().type_count() => 0.0,
            // Exactly 0.
            MicrolensFocus::Pupil if self.glass.is_none() => return 0.0,
            MicrolensFocus::Pupil | MicrolensFocus::Lengths(_) => 1.0 / self.microlens_focal_lengths_m()[lens_type],
        };
        1.0 + exit_m * (1.0 / gap_m - vergence)
    }

    /// Returns the ray from a place on the sensor through a point of a microlens, both in meters in upright coordinates. A
    /// ray of a thin lens may miss the pupil, see [`passes`](Self::passes); `None` is one that a lens of glass stops.
    ///
    /// Without distortion and glass, all rays through one point of a microlens meet in one point of the plane in focus.
    ///
    /// # Source
    ///
    /// Thin lenses one after the other, collected: with C' the [center of the micro-image](Self::micro_image_center_m),
    /// origin = m (D_X / d) (X - C') - m alpha (Q - C), direction = g Q - origin / F, g = (1 + o_E / F) / D, where Q is
    /// [undistorted](super::Distortion::undistorted) first. Through glass by the law of refraction, surface by surface.
    ///
    /// # Accuracy
    ///
    /// Rounding of f64.
    #[must_use]
    pub fn ray(&self, place_m: [f64; 2], lens_point_m: [f64; 2], lens: MicrolensIndex) -> Option<PlenopticRay> {
        let lens = self.microlens(lens);
        let on_sensor = [0, 1].map(|k| place_m[k] - lens.image_center_m[k]);
        let on_lens = [0, 1].map(|k| lens_point_m[k] - lens.center_m[k]);
        self.relative_ray(&lens, on_sensor, on_lens)
    }

    /// Returns the same ray by the points relative to the centers: that on the sensor to the center of the micro-image
    /// (X - C'), that on the microlens to its center (Q - C).
    #[inline]
    #[must_use]
    pub fn relative_ray(&self, lens: &Microlens, on_sensor_m: [f64; 2], on_lens_m: [f64; 2]) -> Option<PlenopticRay> {
        if let Some(glass) = &self.glass {
            let (ray, passes) = self.glass_ray(glass, lens, on_sensor_m, on_lens_m);
            return passes.then_some(ray);
        }
        let RayCoefficients { origin_per_sensor, origin_per_lens, slope_per_m, inverse_focus_per_m } =
            lens.ray_coefficients();
        let origin_m = [0, 1].map(|k| origin_per_sensor * on_sensor_m[k] - origin_per_lens * on_lens_m[k]);
        let point = [0, 1].map(|k| lens.center_m[k] + on_lens_m[k]);
        let point = self.main_lens().distortion.undistorted(point);
        let direction = [0, 1].map(|k| slope_per_m * point[k] - origin_m[k] * inverse_focus_per_m);
        Some(PlenopticRay { origin_m, direction })
    }

    /// Returns whether a ray of a thin lens passes the pupil and the further stops.
    #[must_use]
    pub fn passes(&self, ray: &PlenopticRay) -> bool {
        self.main_lens().aperture.contains(ray.origin_m, self.pupils.entrance_radius_m) && self.passes_stops(ray)
    }

    /// Returns whether a ray passes the further stops of the main lens.
    #[inline]
    #[must_use]
    pub fn passes_stops(&self, ray: &PlenopticRay) -> bool {
        self.stops.iter().all(|&[depth_m, radius_m]| {
            let [x, y] = [0, 1].map(|k| ray.origin_m[k] + depth_m * ray.direction[k]);
            x * x + y * y <= radius_m * radius_m
        })
    }

    /// Returns the cosine to the power of 4 of the angle between the axis and the light from a point of a microlens to
    /// a place on the sensor, the factor of irradiance, by points relative to the centers as for
    /// [`relative_ray`](Self::relative_ray).
    #[inline]
    #[must_use]
    pub fn relative_cos4(&self, lens: &Microlens, on_sensor_m: [f64; 2], on_lens_m: [f64; 2]) -> f64 {
        let away = [0, 1].map(|k| on_lens_m[k] - on_sensor_m[k] - (lens.image_center_m[k] - lens.center_m[k]));
        let squared = 1.0 + (away[0] * away[0] + away[1] * away[1]) / (lens.gap_m * lens.gap_m);
        1.0 / (squared * squared)
    }

    /// Returns the part of a microlens through which light of the pupil reaches a place on the sensor, whatever further
    /// stops do; for a lens of glass that of a disc around the light.
    #[must_use]
    pub fn lit_region(&self, place_m: [f64; 2], lens: MicrolensIndex) -> LitRegion {
        let lens = self.microlens(lens);
        self.relative_lit_region(&lens, [0, 1].map(|k| place_m[k] - lens.image_center_m[k]))
    }

    /// Returns the same by the place relative to the center of the micro-image, in meters.
    #[inline]
    #[must_use]
    pub fn relative_lit_region(&self, lens: &Microlens, on_sensor_m: [f64; 2]) -> LitRegion {
        // The pupil is upside down where the magnification is below 0.
        let sign = lens.pupils.magnification.signum();
        let scale = sign * lens.pupils.exit_m / lens.gap_m;
        let array = self.array();
        let opening = Opening {
            aperture: array.aperture,
            rotation_rad: array.rotation_rad,
            cell: (lens.lens_type == array.type_count()).then(|| array.cell()),
        };
        let from_center = [0, 1].map(|k| scale * on_sensor_m[k] - sign * lens.pupil.center_m[k]);
        LitRegion::new(opening, self.main_lens().aperture, lens.pupil.radius_m, from_center, sign * lens.alpha)
    }

    /// Returns the distance from the center of the micro-image within which places on the sensor get light through all of a
    /// round microlens, in meters; below 0 if there are none, or if the apertures are of other shapes.
    #[must_use]
    pub fn lit_whole_radius_m(&self, lens: &Microlens) -> f64 {
        match (self.array().aperture, self.main_lens().aperture) {
            (LensAperture::Round { radius_m }, PupilShape::Round) if lens.lens_type != self.array().type_count() => {
                (lens.pupil.inner_m - lens.alpha.abs() * radius_m) * lens.gap_m / lens.pupils.exit_m
            }
            _ => -1.0,
        }
    }

    /// Whether the light from a place on the sensor through a point of a microlens within the pupil passes further stops, or the
    /// lens of glass by the table of its edge.
    pub(super) fn lets_pass(&self, lens: &Microlens, on_sensor_m: [f64; 2], on_lens_m: [f64; 2]) -> bool {
        match &self.glass {
            Some(glass) => {
                let [place, slope] = self.to_glass(lens, on_sensor_m, on_lens_m);
                glass.table().within_m(place, slope) >= 0.0
            }
            None => self.relative_ray(lens, on_sensor_m, on_lens_m).is_some_and(|ray| self.passes_stops(&ray)),
        }
    }

    /// Returns whether no stop can block light of the pupil through a microlens.
    pub(super) fn is_clear_of_stops(&self, lens: &Microlens) -> bool {
        let Pupils { inverse_focus_per_m, slope_per_m, .. } = lens.pupils;
        let outer = self.main_lens().aperture.inner_and_outer()[1] * self.pupils.entrance_radius_m;
        let [x, y] = self.main_lens().distortion.undistorted(lens.center_m);
        // A little more than the microlens, for its distortion.
        let point = x.hypot(y) + 1.1 * self.array().pitch_m;
        self.stops.iter().all(|&[depth_m, radius_m]| {
            let farthest = outer * (1.0 - depth_m * inverse_focus_per_m).abs() + (depth_m * slope_per_m).abs() * point;
            farthest <= radius_m
        })
    }
}
