//! The rays of a camera, and through which part of a microlens light reaches a place on the sensor.

use super::glass_lens::GlassLens;
use super::lune::Opening;
use super::main_lens::Pupils;
use super::microlens::LitPupil;
use super::{
    LensAperture, LitRegion, Microlens, MicrolensFocus, MicrolensIndex, PlenopticCamera, PlenopticRay, PupilShape,
    RayCoefficients, TracedRays,
};
use crate::Error;

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

/// Cameras with a lens of glass.
impl PlenopticCamera {
    /// Returns the camera for light of another wavelength, which the glass of its lens refracts otherwise. A camera without a
    /// prescription stays as it is. Everything that is defined near the axis stays that of the d line, 587.6 nm.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] for a wavelength outside of 350 to 1100 nm.
    pub fn at_wavelength(&self, wavelength_nm: f64) -> Result<Self, Error> {
        if !(350.0..=1100.0).contains(&wavelength_nm) {
            return Err(Error::BadNumber {
                what: "wavelength in nanometers",
                value: wavelength_nm,
                need: "350 to 1100",
            });
        }
        let mut camera = self.clone();
        camera.set_glass(wavelength_nm);
        Ok(camera)
    }

    /// Returns whether the main lens is one of glass, whose rays are traced.
    #[inline]
    #[must_use]
    pub const fn has_glass(&self) -> bool {
        self.glass.is_some()
    }

    /// Returns rays as [`relative_ray`](Self::relative_ray) does, for a lens of glass and points of several microlenses: by places on
    /// the plane of an array that is not tilted, and slopes per meter between microlens and main lens, in upright coordinates. `None`
    /// without a prescription.
    #[inline(always)]
    #[must_use]
    pub fn traced_rays<const N: usize>(&self, place_m: [[f64; N]; 2], slope: [[f64; N]; 2]) -> Option<TracedRays<N>> {
        self.glass.as_ref().map(|glass| glass.trace(place_m, slope))
    }

    /// The light from a place on the sensor through a point of a microlens, by points relative to the centers: where it crosses the
    /// plane of an array that is not tilted, and its slope per meter between microlens and main lens.
    #[inline]
    #[must_use]
    pub(super) fn to_glass(&self, lens: &Microlens, on_sensor_m: [f64; 2], on_lens_m: [f64; 2]) -> [[f64; 2]; 2] {
        let (exit_m, raised_m) = (lens.pupils.exit_m, lens.gap_m - self.array().gap_m);
        let point = [0, 1].map(|k| lens.center_m[k] + on_lens_m[k]);
        let slope = [0, 1].map(|k| {
            let in_pupil = exit_m / lens.gap_m * on_sensor_m[k] - lens.alpha * on_lens_m[k];
            -(point[k] + in_pupil) / exit_m
        });
        [[0, 1].map(|k| point[k] - raised_m * slope[k]), slope]
    }

    /// The ray through a lens of glass, and whether it passes.
    pub(super) fn glass_ray(
        &self,
        glass: &GlassLens,
        lens: &Microlens,
        on_sensor_m: [f64; 2],
        on_lens_m: [f64; 2],
    ) -> (PlenopticRay, bool) {
        let [place, slope] = self.to_glass(lens, on_sensor_m, on_lens_m).map(|pair| pair.map(|x| [x]));
        let TracedRays { origin_m, direction, clearance } = glass.trace(place, slope);
        let ray = PlenopticRay { origin_m: origin_m.map(|x| x[0]), direction: direction.map(|x| x[0]) };
        (ray, clearance[0] >= 0.0)
    }
}
