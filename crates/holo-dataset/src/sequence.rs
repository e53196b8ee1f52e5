//! Sequences: the frames of an animated scene, each in a folder of its own.
//!
//! What is chosen automatically is chosen once, for the first frame, so that nothing flickers: the focus distance, the
//! baseline of a range of disparities, and the exposure. It depends on no other frame, so that every part of a sequence has
//! the same.

use std::path::{Path, PathBuf};

use holo_io::Manifest;
use holo_io::dataset::{MANIFEST_JSON, SEQUENCE_HDF5, SequenceFolder};
use holo_render::Progress;

use crate::Error;
use crate::diagnostics::Diagnostics;
use crate::identity::difference;
use crate::image_job::ImageJob;
use crate::job::RenderJob;
use crate::outcome::{JobOutcome, done};
use crate::output_folder::Rollback;
use crate::spec::{Frames, Output, Shard};

/// The frames of an animated scene: of views, or of the raw image of a plenoptic camera. Its job has
/// [`SceneSpec::frames`](crate::SceneSpec::frames).
#[derive(Clone, Debug)]
pub struct SequenceJob<J = RenderJob> {
    image: J,
    frames: Frames,
    backend: String,
}

impl SequenceJob {
    /// Returns the folder of a frame below that of its sequence: `frame_0012`.
    #[must_use]
    pub fn folder(frame: u32) -> PathBuf {
        SequenceFolder::frame_name(frame).into()
    }
}

impl<J: ImageJob> SequenceJob<J> {
    /// Makes the choices of the first frame: loads the scene, and if exposure is automatic renders the central view, or the
    /// raw image.
    ///
    /// # Errors
    /// As [`ImageJob::choose`]; [`Error::BadRequest`] if the job has no frames.
    pub fn new(mut image: J, progress: &dyn Progress, diagnostics: &dyn Diagnostics) -> Result<Self, Error> {
        let Some(frames) = image.spec().scene.frames else {
            return Err(Error::BadRequest("a sequence needs frames; give --frame A-B".into()));
        };
        image.spec_mut().scene.frames = Some(Frames::one(frames.first));
        let backend = image.choose(progress, diagnostics)?;
        Ok(Self { image, frames, backend })
    }

    /// Checks that the folders of the frames below `root` hold no other images, before anything is loaded.
    ///
    /// # Errors
    /// As [`ImageJob::check_replaceable`].
    pub fn check_replaceable(image: &J, root: &Path) -> Result<(), Error> {
        let Some(frames) = image.spec().scene.frames else { return Ok(()) };
        let mut image = image.clone();
        for frame in frames.first..=frames.last {
            image.spec_mut().scene.frames = Some(Frames::one(frame));
            image.check_replaceable(&root.join(SequenceFolder::frame_name(frame)), None)?;
        }
        Ok(())
    }

    /// Returns the numbers of the frames: all of them, or every N-th of a shard.
    pub fn frames(&self, shard: Option<Shard>) -> impl Iterator<Item = u32> + use<J> {
        let Frames { first, last } = self.frames;
        let Shard { part, of } = shard.unwrap_or(Shard { part: 1, of: 1 });
        (first..=last).skip(part.saturating_sub(1)).step_by(of.max(1))
    }

    /// Returns the job of one frame.
    #[must_use]
    pub fn frame(&self, frame: u32) -> J {
        let mut image = self.image.clone();
        image.spec_mut().scene.frames = Some(Frames::one(frame));
        image
    }

    /// Renders a frame into its folder below `root`, unless the folder is up to date.
    ///
    /// # Errors
    /// As [`ImageJob::run`].
    pub fn run_frame(
        &self,
        frame: u32,
        root: &Path,
        progress: &dyn Progress,
        diagnostics: &dyn Diagnostics,
        rollback: &Rollback,
    ) -> Result<JobOutcome<J::Report>, Error> {
        let (image, out) = (self.frame(frame), root.join(SequenceFolder::frame_name(frame)));
        let why = match done(&out, &image.identity(&self.backend)?) {
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
        Ok(JobOutcome::Made(Box::new(image.run(&out, None, progress, diagnostics, rollback)?), why))
    }

    /// Writes `sequence_5d.h5`, the light fields of all frames as one array, below `root`, if HDF5 files are wanted and all
    /// frames are there; of several parts the one that ends last. Returns whether it is there.
    ///
    /// # Errors
    /// Those of `holo_io::write_hdf5_sequence`.
    pub fn finish(&self, root: &Path) -> Result<bool, Error> {
        if !self.image.spec().outputs.contains(&Output::H5) {
            return Ok(false);
        }
        for frame in self.frames(None) {
            let manifest = root.join(SequenceFolder::frame_name(frame)).join(MANIFEST_JSON);
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
