//! What a sequence needs of the job of one image: of rendered views, and of the raw image of a plenoptic camera.

use std::path::Path;

use holo_core::ViewIndex;
use holo_io::Manifest;
use holo_render::{Denoise, GroundTruth, LayerSet, Progress, Views};
use serde_json::Value;

use crate::Error;
use crate::diagnostics::Diagnostics;
use crate::files::{exposure_ev, validate};
use crate::job::{RenderJob, request};
use crate::layers::Wanted;
use crate::output_folder::Rollback;
use crate::raw::{RawJob, RawReport};
use crate::report::{RenderReport, Seconds};
use crate::spec::{Exposure, Focus, RenderSpec, Shard};

/// The job of one image, of which a [`SequenceJob`](crate::SequenceJob) has one for every frame.
pub trait ImageJob: Clone {
    /// What a finished image reports.
    type Report: ImageReport;

    /// Returns the specification.
    fn spec(&self) -> &RenderSpec;

    /// Returns the specification, to change it.
    fn spec_mut(&mut self) -> &mut RenderSpec;

    /// Replaces what is chosen automatically by the choices for this image: focus, baseline and exposure. Returns the ray
    /// tracing backend and its version.
    ///
    /// # Errors
    /// As [`run`](Self::run), except for files.
    fn choose(&mut self, progress: &dyn Progress, diagnostics: &dyn Diagnostics) -> Result<String, Error>;

    /// Returns what identifies the job in a manifest.
    ///
    /// # Errors
    /// [`Error::Io`] if the scene or the environment map cannot be read.
    fn identity(&self, backend: &str) -> Result<Manifest, Error>;

    /// Checks that a folder holds no other image, and no other part of it.
    ///
    /// # Errors
    /// [`Error::BadRequest`] if it does.
    fn check_replaceable(&self, out: &Path, shard: Option<Shard>) -> Result<(), Error>;

    /// Renders the image, or one part of it, into the folder `out`.
    ///
    /// # Errors
    /// As [`RenderJob::run`] and [`RawJob::run`].
    fn run(
        &self,
        out: &Path,
        shard: Option<Shard>,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<Self::Report, Error>;
}

/// What a finished image reports.
pub trait ImageReport {
    /// Returns the wall-clock times.
    fn seconds(&self) -> &Seconds;

    /// Returns the rays of all kinds a second of rendering, in millions.
    fn mrays_per_second(&self) -> f64;

    /// Returns the report as a JSON object.
    fn to_json(&self) -> Value;
}

impl ImageJob for RenderJob {
    type Report = RenderReport;

    fn spec(&self) -> &RenderSpec {
        &self.spec
    }

    fn spec_mut(&mut self) -> &mut RenderSpec {
        &mut self.spec
    }

    /// Exposure is that of the central view.
    fn choose(&mut self, progress: &dyn Progress, diagnostics: &dyn Diagnostics) -> Result<String, Error> {
        validate(&self.spec)?;
        let prepared = self.prepare(diagnostics)?;
        let rig = &mut self.spec.rig;
        if rig.disparity_px.take().is_some() {
            rig.baseline_m = Some(prepared.rig.baseline_x_m());
        }
        rig.focus = Focus::Meters(prepared.rig.focus_distance_m());
        if self.spec.exposure == Exposure::Automatic {
            let (row, column) = prepared.rig.shape().central_view();
            let request = request(&self.spec, &Wanted::new(&self.spec), &prepared)
                .denoise(Denoise::Off)
                .estimate_error(false)
                .ground_truth(GroundTruth::Central)
                .layers(LayerSet::EMPTY)
                .views(Views::List(vec![ViewIndex::new(row, column)]));
            let central = prepared.renderer.render(&request, progress)?;
            if let Some(ev) = prepared.renderer.install(|| exposure_ev(&self.spec, &central)) {
                self.spec.exposure = Exposure::Ev(ev);
            }
        }
        Ok(prepared.renderer.engine_name().to_owned())
    }

    fn identity(&self, backend: &str) -> Result<Manifest, Error> {
        Self::identity(self, backend)
    }

    fn check_replaceable(&self, out: &Path, shard: Option<Shard>) -> Result<(), Error> {
        Self::check_replaceable(self, out, shard)
    }

    fn run(
        &self,
        out: &Path,
        shard: Option<Shard>,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<RenderReport, Error> {
        Self::run(self, out, shard, progress, diagnostics, rollback)
    }
}

impl ImageJob for RawJob {
    type Report = RawReport;

    fn spec(&self) -> &RenderSpec {
        &self.spec
    }

    fn spec_mut(&mut self) -> &mut RenderSpec {
        &mut self.spec
    }

    /// The camera has its own focus. Exposure is that of the whole raw image, where integers are written.
    fn choose(&mut self, progress: &dyn Progress, diagnostics: &dyn Diagnostics) -> Result<String, Error> {
        let (engine, exposure) = self.automatic_exposure(progress, diagnostics)?;
        self.spec.exposure = exposure;
        Ok(engine)
    }

    fn identity(&self, backend: &str) -> Result<Manifest, Error> {
        Self::identity(self, backend)
    }

    fn check_replaceable(&self, out: &Path, shard: Option<Shard>) -> Result<(), Error> {
        Self::check_replaceable(self, out, shard)
    }

    fn run(
        &self,
        out: &Path,
        shard: Option<Shard>,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<RawReport, Error> {
        Self::run(self, out, shard, progress, diagnostics, rollback)
    }
}

impl ImageReport for RenderReport {
    fn seconds(&self) -> &Seconds {
        &self.seconds
    }

    fn mrays_per_second(&self) -> f64 {
        Self::mrays_per_second(self)
    }

    fn to_json(&self) -> Value {
        Self::to_json(self)
    }
}

impl ImageReport for RawReport {
    fn seconds(&self) -> &Seconds {
        &self.seconds
    }

    fn mrays_per_second(&self) -> f64 {
        Self::mrays_per_second(self)
    }

    fn to_json(&self) -> Value {
        Self::to_json(self)
    }
}
