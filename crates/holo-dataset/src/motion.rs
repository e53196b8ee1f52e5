//! Motion until the next frame: optical flow as `.flo`, scene flow as PFM.

use holo_core::{Rig, ViewIndex};
use holo_render::{Frame, Framed, GroundTruth, Motion, Progress};
use holo_scene::Scene;

use crate::Error;
use crate::layers::{FLOWS, Wanted, file_part, view_file, write_pfm};
use crate::output_folder::OutputFolder;
use crate::prepare::{Prepared, load_frame};
use crate::source::SceneSource;
use crate::spec::{Frames, RenderSpec};

/// Computes the motion of the central view, or with ground truth of all views of each, in the order of their rows.
pub(crate) fn trace(
    (source, spec): (&SceneSource, &RenderSpec),
    prepared: &Prepared,
    progress: &dyn Progress,
) -> Result<Vec<Motion>, Error> {
    let frame = spec.scene.frames.map_or(0, |frames| frames.first);
    let mut later = spec.scene.clone();
    later.frames = Some(Frames::one(frame.saturating_add(1)));
    let (scene, framed) = load_frame((source, &later), &spec.rig, *prepared.rig.shape())?;
    let rig = rig_of(spec, &prepared.rig, &framed)?;
    let this = Frame { scene: &prepared.loaded.scene, pose: prepared.framed.pose, rig: &prepared.rig };
    let next = Frame { scene: &scene, pose: framed.pose, rig: &rig };
    check_camera(&prepared.loaded.scene, &scene)?;
    let views = prepared.rig.shape().views();
    let (t, s) = prepared.rig.shape().central_view();
    let wanted: Vec<ViewIndex> = match spec.ground_truth {
        GroundTruth::Central => vec![ViewIndex::new(t, s)],
        GroundTruth::All => (0..views.count()).map(|k| ViewIndex::new(k / views.columns, k % views.columns)).collect(),
    };
    Ok(prepared.renderer.motion([&this, &next], &wanted, spec.cull, progress)?)
}

/// The rig of the next frame with the same focus distance, for cameras that zoom. A baseline that followed from disparities
/// stays; one of an f-number changes with the focal length.
fn rig_of(spec: &RenderSpec, rig: &Rig, framed: &Framed) -> Result<Rig, Error> {
    match spec.rig.disparity_px {
        Some(_) => Ok(rig.to_builder().intrinsics(framed.intrinsics).build()?),
        None => Ok(framed.rig(rig.focus_distance_m())?),
    }
}

/// Without a camera in the file, that of the whole scene may be another one in every frame, as if it moved.
fn check_camera(this: &Scene, next: &Scene) -> Result<(), Error> {
    if this.cameras.is_empty() || next.cameras.is_empty() {
        return Err(Error::BadRequest(
            "optical and scene flow need a camera in the scene file: the automatic one follows what moves".into(),
        ));
    }
    Ok(())
}

/// Writes the motion of the central view, and of all views into folders if there is more than one.
pub(crate) fn write(folder: &mut OutputFolder, wanted: &Wanted, rig: &Rig, motion: &[Motion]) -> Result<(), Error> {
    let count = rig.shape().views().count();
    let (t, s) = rig.shape().central_view();
    let central = if motion.len() == 1 { 0 } else { t * rig.shape().views().columns + s };
    for kind in [Kind::Optical, Kind::Scene].into_iter().filter(|kind| wanted.flow[*kind as usize]) {
        let (name, ending) = (file_part(FLOWS[kind as usize]), kind.ending());
        if let Some(motion) = motion.get(central) {
            kind.write(folder, format!("scene_{name}.{ending}"), motion)?;
        }
        if motion.len() > 1 {
            folder.subfolder(&name)?;
            for (k, motion) in motion.iter().enumerate() {
                kind.write(folder, view_file(&name, k, count, ending), motion)?;
            }
        }
    }
    Ok(())
}

/// The kinds of flow, in the order of [`FLOWS`].
#[derive(Clone, Copy)]
enum Kind {
    Optical,
    Scene,
}

impl Kind {
    fn ending(self) -> &'static str {
        match self {
            Self::Optical => "flo",
            Self::Scene => "pfm",
        }
    }

    fn write(self, folder: &mut OutputFolder, file: String, motion: &Motion) -> Result<(), Error> {
        let path = folder.file(&file);
        let written = match self {
            Self::Optical => holo_io::write_flo(path, motion.optical_flow.view())?,
            Self::Scene => write_pfm(path, motion.scene_flow.view())?,
        };
        folder.add(file, written);
        Ok(())
    }
}
