//! Checks of a request before it is rendered.

use holo_core::ViewIndex;

use super::request::{Camera, Denoise, Request, RigRequest, Views};
use super::transport::Reuse;
use super::{raw, spectral};
use crate::error::Error;
use crate::film::layers::{Layer, LayerSet};
use crate::geometry::MAX_COORDINATE_M;
use crate::integrator::Integrator;

/// The largest [`Request::filter_width_px`].
const MAX_FILTER_WIDTH_PX: f64 = 64.0;

/// The largest id that f32 represents exactly together with all smaller ones: 2^24.
pub(super) const MAX_EXACT_ID: usize = 1 << 24;

impl Request {
    /// Whether the samples of color are compared with each other, and for what.
    fn needs_samples(&self) -> (bool, &'static str) {
        let what = if self.estimate_error { "the estimate of the error" } else { "denoising" };
        (self.denoise == Denoise::Views || self.estimate_error, what)
    }

    /// Validates that there is color if its samples are needed.
    pub(super) fn check_needs_color(&self) -> Result<(), Error> {
        let (needs_samples, what) = self.needs_samples();
        if needs_samples && self.transport.integrator == Integrator::Depth {
            return Err(Error::BadSetting(format!(
                "{what} needs color, which the integrator 'depth' does not render; choose another one, or leave it out"
            )));
        }
        Ok(())
    }

    /// Validates that less than one sample per pixel is shared between pixels.
    fn check_fraction(&self) -> Result<(), Error> {
        let samples = self.transport.samples;
        if samples.is_fraction() && self.denoise != Denoise::Views {
            return Err(Error::BadSetting(format!(
                "{samples} samples per pixel leave pixels without any; give 1 or more, or share those of neighboring views \
                 (`denoise views`)"
            )));
        }
        Ok(())
    }

    /// Validates the request for a [moved](super::Renderer::moved) renderer.
    pub(super) fn check_moved(&self, integrator: Integrator) -> Result<(), Error> {
        let is_plain =
            self.layers.is_empty() && self.denoise == Denoise::Off && !self.estimate_error && !self.statistics;
        if is_plain && integrator != Integrator::Depth && self.transport.reuse == Reuse::Off {
            return Ok(());
        }
        Err(Error::BadSetting("a renderer that was moved renders plain color alone; prepare one at the pose".into()))
    }

    /// Validates the request for a scene with this many instances and materials.
    pub(super) fn check(&self, counts: [usize; 2]) -> Result<(), Error> {
        self.transport.check()?;
        self.check_fraction()?;
        if self.transport.spectral {
            spectral::check(self)?;
        }
        check_ids(self.layers, counts)?;
        let (rows, count) = (self.row_range(), self.camera.row_count());
        if rows.is_empty() || rows.end > count {
            return Err(Error::BadSetting(format!("rows {rows:?} are not a range of the {count} rows")));
        }
        match &self.camera {
            Camera::Rig(rig) => RigRequest { rig, request: self }.check(),
            Camera::Plenoptic(camera) => raw::check(self, camera),
        }
    }
}

impl RigRequest<'_> {
    fn check(&self) -> Result<(), Error> {
        if !(self.filter_width_px > 0.0 && self.filter_width_px <= MAX_FILTER_WIDTH_PX) {
            return Err(Error::BadSetting(format!(
                "a pixel averages over {} px; choose a width above 0, at most {MAX_FILTER_WIDTH_PX}",
                self.filter_width_px
            )));
        }
        let split = self.rig.shape();
        if split.lenses().count() > u32::MAX as usize || split.views().count() > u32::MAX as usize {
            return Err(Error::BadSetting("2^32 or more lenses or views; choose fewer".into()));
        }
        // Rays are linear in all indices, so the largest coordinates occur at the corners.
        let (lenses, views) = (split.lenses(), split.views());
        for (v, u) in [(0, 0), (lenses.rows - 1, lenses.columns - 1)] {
            for (t, s) in [(0, 0), (views.rows - 1, views.columns - 1)] {
                let ray = self.rig.ray(v, u, t, s, 0.5, 0.5);
                if !ray.origin_m.iter().chain(&ray.direction).all(|x| x.abs() < MAX_COORDINATE_M) {
                    return Err(Error::BadSetting(format!(
                        "the rig is too large: a ray starts at {:?} m and runs along {:?}; \
                         choose a smaller baseline or sensor",
                        ray.origin_m, ray.direction
                    )));
                }
            }
        }
        self.check_needs_color()?;
        let (needs_samples, what) = self.needs_samples();
        if needs_samples && self.views != Views::All {
            return Err(Error::BadSetting(format!("{what} needs all views; render them all, or without it")));
        }
        if let Views::List(list) = &self.views {
            let outside = list.iter().find(|view| view.row >= views.rows || view.column >= views.columns);
            if let Some(ViewIndex { row, column }) = outside {
                return Err(Error::BadSetting(format!(
                    "view row {row}, column {column} is outside the {} rows and {} columns of views",
                    views.rows, views.columns
                )));
            }
            if list.is_empty() {
                return Err(Error::BadSetting("the list of views is empty; name one or more".into()));
            }
        }
        Ok(())
    }
}

/// Validates the ids of layers for a scene with this many instances and materials.
pub(super) fn check_ids(layers: LayerSet, [instances, materials]: [usize; 2]) -> Result<(), Error> {
    for (layer, what, count) in [(Layer::ObjectId, "instances", instances), (Layer::MaterialId, "materials", materials)]
    {
        if layers.contains(layer) && count > MAX_EXACT_ID {
            return Err(Error::BadSetting(format!(
                "the layer '{layer}' has exact ids of at most {MAX_EXACT_ID} {what}, but the scene has \
                 {count}: omit the layer"
            )));
        }
    }
    Ok(())
}
