//! `holo optics`: what a camera will see, before it is built or rendered; and the camera that sees what is wanted.

mod plot;

use holo_core::optics::{DepthRange, Optics};
use holo_dataset::{QuantityValue, adjusted_camera, camera_optics, camera_warnings, planned_rig, rig_optics};
use holo_io::Limits;

use crate::arguments::{OpticsOptions, open_camera};
use crate::console::say;
use crate::failure::Failure;
use crate::quantities;

pub fn run(options: &OpticsOptions) -> Result<(), Failure> {
    if let Some(camera) = &options.camera_file {
        return plenoptic(options, camera);
    }
    let depths = options.depths_m.map(|(near_m, far_m)| DepthRange::new(near_m, far_m)).transpose()?;
    let rig = match &options.input {
        Some(input) => holo_io::read_rig(input, &Limits::default())?.ok_or_else(|| {
            Failure::Usage(format!(
                "{}: the camera parameters are unknown; is there a parameters.cfg beside it?",
                input.display()
            ))
        })?,
        None => planned_rig(&options.rig()?, options.lens_pitch_mm, depths)?,
    };
    let optics = Optics::new(rig).map_err(|error| match &options.input {
        // That of a file is no wrong use.
        None if rig.shape().views().columns < 2 => {
            Failure::Usage("one column of views has no disparities between them; give --views with two or more".into())
        }
        None if rig.baseline_x_m() == 0.0 => {
            Failure::Usage("with --baseline-m 0 all views coincide and have no disparities; give one above 0".into())
        }
        _ => error.into(),
    })?;
    let rows = rig_optics(&optics, depths, options.circle_px, options.step_px)?;
    quantities::print(&rows, options.json)?;
    if let Some(depths) = depths {
        for warning in optics.warnings(depths, options.limit_px, options.step_px)? {
            say!("warning: {warning}");
        }
    }
    Ok(())
}

/// The optics of a plenoptic camera.
fn plenoptic(options: &OpticsOptions, name: &str) -> Result<(), Failure> {
    let camera = adjusted_camera(open_camera(name)?, &mut options.settings.given().clone())?;
    let depths = options.depths_m.map_or(Vec::new(), |(near_m, far_m)| vec![near_m, far_m]);
    let rows = camera_optics(&camera.camera, &depths)?;
    if let Some(path) = &options.plot {
        let field = rows.iter().find(|row| row.key == "field_mm").map(|row| &row.value);
        let Some(QuantityValue::List(field_mm)) = field else {
            return Err(Failure::Usage(format!(
                "--plot: the main lens of {name} is thin and has no aberrations; give a camera with main_lens.prescription"
            )));
        };
        let corner_m = field_mm.last().copied().unwrap_or_default() * 1e-3;
        holo_io::write_file(path, plot::curves(&camera.camera, corner_m).as_bytes())?;
        say!("wrote {}", path.display());
    }
    quantities::print(&rows, options.json)?;
    camera_warnings(&camera).iter().for_each(|line| say!("warning: {line}"));
    Ok(())
}
