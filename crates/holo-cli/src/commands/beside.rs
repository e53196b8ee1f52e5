//! What lies beside a picture: the rig it was taken with, and the truth about its central view.

use std::path::Path;

use holo_core::Rig;
use holo_io::dataset::{DatasetFolder, PARAMETERS_CFG};
use holo_io::{FileInfo, FileKind, HciFolder, HciQuantity, HciResolution, Limits, ParametersCfg};
use ndarray::Array2;

use crate::failure::Failure;

/// All of it that is there.
#[derive(Default)]
pub struct Beside {
    pub rig: Option<Rig>,
    /// Metres.
    pub depth_m: Option<Array2<f32>>,
    /// Pixels between adjacent views.
    pub disparity_px: Option<Array2<f32>>,
}

impl Beside {
    /// What a folder tells, or the files beside a picture. `is_other`: the command line says what the picture is, so that
    /// parameters beside it may be those of another.
    pub fn of(input: &Path, is_other: bool) -> Result<Self, Failure> {
        let limits = Limits::default();
        if !input.is_dir() {
            return Ok(Self { rig: rig_of_file(input, is_other), ..Self::default() });
        }
        Ok(match holo_io::open(input)? {
            FileInfo::DatasetFolder(folder) => of_dataset(&folder, &limits)?,
            FileInfo::HciFolder(folder) => of_hci(&folder, &limits)?,
            _ => Self::default(),
        })
    }
}

fn of_dataset(folder: &DatasetFolder, limits: &Limits) -> Result<Beside, Failure> {
    Ok(Beside {
        rig: Some(*folder.rig()),
        depth_m: folder.depth_m(limits)?,
        disparity_px: folder.disparity_px(limits)?,
    })
}

fn of_hci(folder: &HciFolder, limits: &Limits) -> Result<Beside, Failure> {
    let map = |quantity| folder.central_truth(quantity, HciResolution::Low, limits);
    Ok(Beside { rig: folder.rig().ok(), depth_m: map(HciQuantity::Depth)?, disparity_px: map(HciQuantity::Disparity)? })
}

/// The rig of a file: its own, or that of the `parameters.cfg` beside it.
fn rig_of_file(input: &Path, is_other: bool) -> Option<Rig> {
    match holo_io::recognise(input).ok()? {
        FileKind::Mat5 | FileKind::Mat73 => holo_io::read_mat_light_field(input, &Limits::default()).ok()?.rig,
        _ if is_other => None,
        _ => ParametersCfg::read(input.with_file_name(PARAMETERS_CFG)).ok()?.rig().ok(),
    }
}

/// The range of disparities that the parameters of a picture promise.
pub fn disparity_range(input: &Path) -> Option<(f64, f64)> {
    let path = if input.is_dir() { input.join(PARAMETERS_CFG) } else { input.with_file_name(PARAMETERS_CFG) };
    let parameters = ParametersCfg::read(path).ok()?;
    Some((parameters.disp_min?, parameters.disp_max?))
}
