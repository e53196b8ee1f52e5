//! Sequences: the frames of an animated scene, each in a folder of its own.
//!
//! What is chosen automatically is chosen once, for the first frame, so that nothing flickers: the focus distance, the
//! baseline of a range of disparities, and the exposure, which is that of the central view. It depends on no other frame,
//! so that every part of a sequence has the same.

use std::path::{Path, PathBuf};

use holo_core::ViewIndex;
use holo_io::Manifest;
use holo_io::dataset::{MANIFEST_JSON, SEQUENCE_HDF5, SequenceFolder};
use holo_render::{Denoise, GroundTruth, LayerSet, Progress, Request, Views};

use crate::Error;
use crate::diagnostics::Diagnostics;
use crate::files::{exposure_ev, validate};
use crate::identity::difference;
use crate::job::RenderJob;
use crate::outcome::{JobOutcome, done};
use crate::output_folder::Rollback;
use crate::spec::{Exposure, Focus, Frames, Output, Shard};

/// The frames of an animated scene. Its job has [`SceneSpec::frames`](crate::SceneSpec::frames).
#[derive(Clone, Debug)]
pub struct SequenceJob {
    render: RenderJob,
    frames: Frames,
    backend: String,
}

impl SequenceJob {
    /// Returns the folder of a frame below that of its sequence: `frame_0012`.
    #[must_use]
    pub fn folder(frame: u32) -> PathBuf {
        SequenceFolder::frame_name(frame).into()
    }

    /// Makes the choices of the first frame: loads the scene, and renders its central view if exposure is automatic.
    ///
    /// # Errors
    /// As [`RenderJob::render`]; [`Error::BadRequest`] if the job has no frames.
    pub fn new(mut render: RenderJob, progress: &dyn Progress, diagnostics: &dyn Diagnostics) -> Result<Self, Error> {
        let Some(frames) = render.spec.scene.frames else {
            return Err(Error::BadRequest("a sequence needs frames; give --frame A-B".into()));
        };
        validate(&render.spec)?;
        render.spec.scene.frames = Some(Frames::one(frames.first));
        let prepared = render.prepare(diagnostics)?;
        let rig = &mut render.spec.rig;
        if rig.disparity_px.take().is_some() {
            rig.baseline_m = Some(prepared.rig.baseline_x_m());
        }
        rig.focus = Focus::Meters(prepared.rig.focus_distance_m());
        if render.spec.exposure == Exposure::Automatic {
            let (row, column) = prepared.rig.shape().central_view();
            let request = Request::new(prepared.rig)
                .transport(render.transport())
                .denoise(Denoise::Off)
                .ground_truth(GroundTruth::Central)
                .layers(LayerSet::EMPTY)
                .views(Views::List(vec![ViewIndex::new(row, column)]));
            let central = prepared.renderer.render(&request, progress)?;
            if let Some(ev) = prepared.renderer.install(|| exposure_ev(&render.spec, &central)) {
                render.spec.exposure = Exposure::Ev(ev);
            }
        }
        Ok(Self { render, frames, backend: prepared.renderer.engine_name().to_owned() })
    }

    /// Returns the numbers of the frames: all of them, or every N-th of a shard.
    pub fn frames(&self, shard: Option<Shard>) -> impl Iterator<Item = u32> {
        let Frames { first, last } = self.frames;
        let Shard { part, of } = shard.unwrap_or(Shard { part: 1, of: 1 });
        (first..=last).skip(part - 1).step_by(of)
    }

    /// Returns the job of one frame.
    #[must_use]
    pub fn frame(&self, frame: u32) -> RenderJob {
        let mut render = self.render.clone();
        render.spec.scene.frames = Some(Frames::one(frame));
        render
    }

    /// Renders a frame into its folder below `root`, unless the folder is up to date.
    ///
    /// # Errors
    /// As [`RenderJob::run`].
    pub fn run_frame(
        &self,
        frame: u32,
        root: &Path,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<JobOutcome, Error> {
        let (render, out) = (self.frame(frame), root.join(Self::folder(frame)));
        let why = match done(&out, &render.identity(&self.backend)?) {
            Ok(manifest) => return Ok(JobOutcome::Kept(Box::new(manifest))),
            Err(why) => why,
        };
        // It is of all frames, and this one may get another shape.
        match std::fs::remove_file(root.join(SEQUENCE_HDF5)) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(Error::Failed(format!("cannot remove {}: {error}", root.join(SEQUENCE_HDF5).display())));
            }
            _ => {}
        }
        Ok(JobOutcome::Made(Box::new(render.run(&out, None, progress, diagnostics, rollback)?), why))
    }
    /// Writes `sequence_5d.h5`, the light fields of all frames as one array, below `root`, if HDF5 files are wanted and all
    /// frames are there; of several parts the one that ends last. Returns whether it is there.
    ///
    /// # Errors
    /// Those of [`holo_io::write_hdf5_sequence`].
    pub fn finish(&self, root: &Path) -> Result<bool, Error> {
        if !self.render.spec.outputs.contains(&Output::H5) {
            return Ok(false);
        }
        for frame in self.frames(None) {
            let manifest = root.join(Self::folder(frame)).join(MANIFEST_JSON);
            let Ok(manifest) = Manifest::read(manifest) else { return Ok(false) };
            if difference(&manifest, &self.frame(frame).identity(&self.backend)?).is_some() {
                return Ok(false);
            }
        }
        self.write_hdf5(root)
    }

    #[cfg(feature = "hdf5")]
    fn write_hdf5(&self, root: &Path) -> Result<bool, Error> {
        let frames: Vec<u32> = self.frames(None).collect();
        holo_io::write_hdf5_sequence(&SequenceFolder::open(root)?, &frames)?;
        Ok(true)
    }

    #[cfg(not(feature = "hdf5"))]
    fn write_hdf5(&self, _: &Path) -> Result<bool, Error> {
        Err(crate::images::without_hdf5())
    }
}
