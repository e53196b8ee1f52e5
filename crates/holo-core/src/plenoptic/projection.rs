//! Where points of the scene appear on the sensor: chief pixels, virtual depth and blur.

use super::{MicrolensIndex, PlenopticCamera};

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

/// The image of the main lens of a point, by its vergence, which is finite where the image is not.
pub(super) struct MainImage {
    /// 1 / the distance of the image from the main lens, 1/m.
    pub vergence: f64,
    /// The lateral position of the image divided by that distance.
    pub slope: [f64; 2],
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

    pub(super) fn main_image(&self, point_m: [f64; 3]) -> Option<MainImage> {
        let depth_m = -point_m[2];
        let from_lens_m = depth_m + self.entrance_pupil_offset_m();
        if !(depth_m > 0.0 && from_lens_m != 0.0 && point_m.iter().all(|x| x.is_finite())) {
            return None;
        }
        let vergence = 1.0 / self.main_lens().focal_length_m - 1.0 / from_lens_m;
        Some(MainImage { vergence, slope: [point_m[0] / from_lens_m, point_m[1] / from_lens_m] })
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

    /// Returns where a point of the scene appears through a microlens; `None` if it is not in front of the camera, or if
    /// the main lens images it onto the array, so that it lights a whole micro-image.
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
    /// X_c = C + (I - C) / v, with the image I of the main lens and its virtual depth v.
    #[must_use]
    pub fn project(&self, point_m: [f64; 3], lens: MicrolensIndex) -> Option<MicroImagePoint> {
        let image = self.main_image(point_m)?;
        let rest = 1.0 - self.mla_distance_m() * image.vergence;
        if rest == 0.0 {
            return None;
        }
        let (center, gap) = (self.lens_center_m(lens), self.array().gap_m);
        let place = [0, 1].map(|k| center[k] + (image.slope[k] - center[k] * image.vergence) * gap / rest);
        let lens_type = self.array().type_of(lens);
        let kappa = 1.0 - gap * image.vergence / rest - gap / self.microlens_focal_lengths_m()[lens_type];
        let blur_radius_px = kappa * self.array().aperture.half_width_m() / self.sensor().pixel_m;
        Some(MicroImagePoint { position_px: self.position_px(place), kappa, blur_radius_px })
    }
}
