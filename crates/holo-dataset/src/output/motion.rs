//! Motion until the next frame: optical flow as `.flo`, scene flow as PFM.

use holo_core::Rig;
use holo_io::dataset::layer_of_view;
use holo_render::Motion;

use super::folder::OutputFolder;
use super::layers::{FLOWS, file_part, write_pfm};
use super::wanted::Wanted;
use crate::Error;

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
                kind.write(folder, layer_of_view(&name, k, count, ending), motion)?;
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
