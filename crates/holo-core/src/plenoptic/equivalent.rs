//! The rig of pinhole cameras that an unfocused plenoptic camera is equivalent to.

use super::{LensAperture, PlenopticCamera};
use crate::{Error, Rig};
use crate::{GridSize, LightFieldShape};

/// The views of an unfocused camera as those of a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EquivalentViews {
    /// The distance between the viewpoints of neighboring pixels of a micro-image, in meters (b).
    pub baseline_m: f64,
    /// The slope between neighboring microlenses of a square grid, in meters per meter of depth (q).
    pub slope_per_lens: f64,
    /// 1 / focus distance, in 1/m; 0 for infinity.
    pub inverse_focus_per_m: f64,
    /// What the disparity of images is larger by than that of pinholes, at every depth, in pixels per view: within a
    /// microlens, points nearer to the pixel give it more light (the cos^4 law).
    pub cos4_disparity_px: f64,
}

impl PlenopticCamera {
    /// Returns what the views of this camera have in common with those of a rig; one view per pixel.
    ///
    /// # Accuracy
    ///
    /// With square microlenses that image the pupil onto the sensor the views are those of the rig, up to the area of
    /// the pixels. With others the viewpoint moves by m alpha (Q - C) over a microlens around this mean, and round
    /// microlenses leave gaps between the samples.
    ///
    /// # Source
    ///
    /// b = p m D_X / d, q = P g, F: the ray of [`PlenopticCamera::ray`] in the form of [`Rig::ray`]. cos^4:
    /// a^2 p / (d^2 P) for round microlenses of radius a, 4/3 of it for square ones.
    #[must_use]
    pub fn equivalent_views(&self) -> EquivalentViews {
        let (pixel, gap, pitch) = (self.sensor().pixel_m, self.array().gap_m, self.array().pitch_m);
        let half = self.array().aperture.half_width_m();
        // 4 var(Q): a^2 for a disc, 4/3 a^2 for a square, 10/9 a^2 for a hexagon.
        let four_variances = half
            * half
            * match self.array().aperture {
                LensAperture::Round { .. } => 1.0,
                LensAperture::Square { .. } => 4.0 / 3.0,
                LensAperture::Hexagon { .. } => 10.0 / 9.0,
            };
        EquivalentViews {
            baseline_m: pixel * self.pupils.magnification * self.exit_pupil_m() / gap,
            slope_per_lens: pitch * self.pupils.slope_per_m,
            inverse_focus_per_m: self.inverse_focus_per_m(),
            cos4_disparity_px: four_variances * pixel / (gap * gap * pitch),
        }
    }

    /// Returns the rig whose view `(t, s)` sees what pixels `step_px` apart around the centers of the micro-images see,
    /// with `lenses` places `spacing_m` apart on the array, centered on the axis.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if the camera focuses behind itself or its exit pupil lies behind the focal point: a rig has
    /// a focus distance above 0 and views in order.
    pub fn equivalent_rig(
        &self,
        views: GridSize,
        lenses: GridSize,
        spacing_m: f64,
        step_px: f64,
    ) -> Result<Rig, Error> {
        let equivalent = self.equivalent_views();
        let focus_distance_m = match equivalent.inverse_focus_per_m {
            0.0 => f64::INFINITY,
            inverse => 1.0 / inverse,
        };
        // f and the sensor in one unit: a place on the array over the distance 1/g.
        Rig::builder(LightFieldShape::new(views, lenses)?)
            .focal_length_m(1.0 / self.pupils.slope_per_m)
            .sensor_size_m(lenses.larger() as f64 * spacing_m)
            .baseline_m(equivalent.baseline_m * step_px)
            .focus_distance_m(focus_distance_m)
            .build()
    }
}
