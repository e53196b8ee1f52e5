//! The folders of the HCI benchmark, as learned methods read them: EPINET, LFattNet, SubFocal, OACC-Net, DistgDisp, LF2Disp.
//!
//! `OUT/<group>/<scene>/` has `input_Cam000.png` on, `gt_disp_lowres.pfm`, `gt_depth_lowres.pfm`, `parameters.cfg`, and
//! `valid_mask.png`, 255 where the central view hits something.

use holo_core::GridSize;
use holo_io::{ColorEncoding, Compression, HciImage, HciTruth, ParametersCfg};
use ndarray::Array3;

use super::source::LoadedField;
use super::{ExportJob, ExportTarget, LoadedNote, Writer};
use crate::Error;
use crate::output::OutputFolder;

const SIDE: usize = 9;

/// Readers have scene indices up to 15.
const SCENES: usize = 16;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "hci",
    help: "EPINET, LFattNet, SubFocal, OACC-Net, DistgDisp, LF2Disp: folders of the HCI benchmark",
    usage: "Readers take the folder that contains the group, `training` unless another was given, as their dataset.",
    writer: Writer::Fields { write, check },
};

fn write(folder: &mut OutputFolder, loaded: &LoadedField, job: &ExportJob) -> Result<(), Error> {
    let advice = "render it with `preset hci`";
    let views = loaded.field.shape().views();
    if views != GridSize::new(SIDE, SIDE) {
        let what = format!("the readers take {SIDE} x {SIDE} views, and it has {} x {}", views.columns, views.rows);
        return Err(loaded.lacks(&what, advice));
    }
    let (Some(disparity), Some(depth), Some(rig)) = (&loaded.disparity_px, &loaded.depth_m, &loaded.rig) else {
        return Err(loaded.lacks("the readers need disparity, depth and camera", advice));
    };
    let scene = job.scene_folder("training", &loaded.name);
    let inner = folder.subfolder(&scene)?;
    let mut parameters = ParametersCfg::from_rig(rig);
    parameters.scene.clone_from(&loaded.name);
    let finite = disparity.iter().filter(|value| value.is_finite()).map(|value| f64::from(*value));
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    (parameters.disp_min, parameters.disp_max) = ((low <= high).then_some(low), (low <= high).then_some(high));
    let image = HciImage {
        views: Some(loaded.field.as_light_field_ref().into()),
        parameters: &parameters,
        disparity_px: HciTruth::Central(disparity.view()),
        depth_m: HciTruth::Central(depth.view()),
        high_resolution: None,
    };
    image.file_names().iter().for_each(|file| drop(folder.file(&format!("{scene}/{file}"))));
    for (file, written) in image.write_in(&inner, Compression::Fast)? {
        folder.add(format!("{scene}/{file}"), written);
    }
    let hits = loaded.hits.clone().unwrap_or_else(|| depth.mapv(f32::is_finite));
    let (rows, columns) = hits.dim();
    let mask = Array3::from_shape_fn((rows, columns, 3), |(v, u, _)| if hits[[v, u]] { 255_u8 } else { 0 });
    let name = format!("{scene}/valid_mask.png");
    let written = holo_io::write_png(folder.file(&name), mask.view(), ColorEncoding::Linear, Compression::Fast)?;
    folder.add(name, written);
    Ok(())
}

fn check(sizes: &[LoadedNote]) -> Option<String> {
    if sizes.iter().any(|size| *size != GridSize::new(512, 512)) {
        return Some("EPINET and its relatives take views of 512 x 512 px alone; render with `preset hci`".into());
    }
    let count = sizes.len();
    (count < SCENES).then(|| format!("OACC-Net and DistgDisp need {SCENES} scenes, and these are {count}"))
}
