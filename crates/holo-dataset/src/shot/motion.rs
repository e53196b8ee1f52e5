//! Motion until the next frame.

use holo_core::ViewIndex;
use holo_render::{Frame, GroundTruth, Motion, Progress};

use super::prepare::{Prepared, Setup, Stage};
use crate::Error;

/// Computes the motion of the central view, or with ground truth of all views of each, in the order of their rows.
pub(super) fn trace(
    setup: &Setup,
    (stage, prepared, pose): (&Stage, &Prepared, usize),
    progress: &dyn Progress,
) -> Result<Vec<Motion>, Error> {
    let Some(rig) = prepared.rig() else { return Ok(Vec::new()) };
    let settings = setup.settings;
    let frame = settings.scene.frames.map_or(0, |frames| frames.first);
    let (scene, next_pose, next_rig) = setup.next_frame(frame.saturating_add(1), rig, pose)?;
    let has_no_camera = stage.loaded.scene.cameras.is_empty() || scene.cameras.is_empty();
    if has_no_camera && settings.poses.cameras().is_none() {
        return Err(Error::BadRequest(
            "optical and scene flow need a camera in the scene file: the automatic one follows what moves".into(),
        ));
    }
    let this = Frame { scene: &stage.loaded.scene, pose: prepared.pose, rig };
    let next = Frame { scene: &scene, pose: next_pose, rig: &next_rig };
    let views = rig.shape().views();
    let (t, s) = rig.shape().central_view();
    let wanted: Vec<ViewIndex> = match settings.output.ground_truth {
        GroundTruth::Central => vec![ViewIndex::new(t, s)],
        GroundTruth::All => (0..views.count()).map(|k| ViewIndex::new(k / views.columns, k % views.columns)).collect(),
    };
    Ok(prepared.renderer.motion([&this, &next], &wanted, settings.light.cull, progress)?)
}
