//! The keys of `parameters.cfg`: those of the HCI tools, in their order.

use std::path::Path;

use holo_core::{GridSize, Projection};

use super::ini::{Ini, IniWriter};
use super::{CameraPose, ParametersCfg};
use crate::Error;

const INTRINSICS: &str = "intrinsics";
const EXTRINSICS: &str = "extrinsics";
const META: &str = "meta";

const POSITION_KEYS: [&str; 3] = ["center_cam_x_m", "center_cam_y_m", "center_cam_z_m"];
const ROTATION_KEYS: [&str; 3] = ["center_cam_rx_rad", "center_cam_ry_rad", "center_cam_rz_rad"];

pub(super) fn write(parameters: &ParametersCfg, path: &Path) -> Result<String, Error> {
    let mut ini = IniWriter::new(path);
    ini.section(INTRINSICS)?;
    ini.number("focal_length_mm", parameters.focal_length_mm);
    ini.integer("image_resolution_x_px", parameters.image_resolution_px.columns);
    ini.integer("image_resolution_y_px", parameters.image_resolution_px.rows);
    ini.number("sensor_size_mm", parameters.sensor_size_mm);
    optional(&mut ini, "fstop", parameters.fstop);
    rest_of_section(&mut ini, parameters, INTRINSICS)?;

    ini.section(EXTRINSICS)?;
    ini.integer("num_cams_x", parameters.num_cams.columns);
    ini.integer("num_cams_y", parameters.num_cams.rows);
    ini.number("baseline_mm", parameters.baseline_mm);
    // Infinity is 0 in the file.
    let focus_m = if parameters.focus_distance_m == f64::INFINITY { 0.0 } else { parameters.focus_distance_m };
    ini.number("focus_distance_m", focus_m);
    if let Some(pose) = &parameters.center_cam {
        POSITION_KEYS.iter().zip(pose.position_m).for_each(|(key, value)| ini.number(key, value));
        ROTATION_KEYS.iter().zip(pose.rotation_rad).for_each(|(key, value)| ini.number(key, value));
    }
    optional(&mut ini, "offset", parameters.offset);
    optional(&mut ini, "baseline_y_mm", parameters.baseline_y_mm);
    if parameters.projection == Projection::Orthographic {
        ini.text("projection", "orthographic")?;
    }
    rest_of_section(&mut ini, parameters, EXTRINSICS)?;

    ini.section(META)?;
    ini.text("scene", &parameters.scene)?;
    ini.text("category", &parameters.category)?;
    ini.text("date", &parameters.date)?;
    ini.text("version", &parameters.version)?;
    ini.text("authors", &parameters.authors)?;
    ini.text("contact", &parameters.contact)?;
    if let Some(seed) = parameters.cycles_seed {
        ini.integer("cycles_seed", seed);
    }
    optional(&mut ini, "disp_min", parameters.disp_min);
    optional(&mut ini, "disp_max", parameters.disp_max);
    optional(&mut ini, "frustum_disp_min", parameters.frustum_disp_min);
    optional(&mut ini, "frustum_disp_max", parameters.frustum_disp_max);
    optional(&mut ini, "depth_map_scale", parameters.depth_map_scale);
    rest_of_section(&mut ini, parameters, META)?;

    let mut section = None;
    for ((name, key), value) in &parameters.other {
        if [INTRINSICS, EXTRINSICS, META].contains(&name.as_str()) {
            continue;
        }
        if section != Some(name) {
            if section.is_some() {
                ini.end_section();
            }
            ini.section(name)?;
            section = Some(name);
        }
        ini.other(key, value)?;
    }
    if section.is_some() {
        ini.end_section();
    }
    Ok(ini.finish())
}

fn optional(ini: &mut IniWriter<'_>, key: &str, value: Option<f64>) {
    if let Some(value) = value {
        ini.number(key, value);
    }
}

fn rest_of_section(ini: &mut IniWriter<'_>, parameters: &ParametersCfg, section: &str) -> Result<(), Error> {
    for ((_, key), value) in parameters.other.iter().filter(|((name, _), _)| name == section) {
        ini.other(key, value)?;
    }
    ini.end_section();
    Ok(())
}

pub(super) fn read(text: &str, path: &Path) -> Result<ParametersCfg, Error> {
    let mut ini = Ini::parse(text, path)?;
    let focus_distance_m = needed(&mut ini, EXTRINSICS, "focus_distance_m")?;
    let projection = match ini.text(EXTRINSICS, "projection").as_deref() {
        None | Some("perspective") => Projection::Perspective,
        Some("orthographic") => Projection::Orthographic,
        Some(other) => {
            return Err(Error::unsupported(
                path,
                format!("[{EXTRINSICS}] projection = {other:?}; only perspective and orthographic can be read"),
            ));
        }
    };
    let mut text_of = {
        let ini = &mut ini;
        move |key: &str| ini.text(META, key).unwrap_or_default()
    };
    let (scene, category, date) = (text_of("scene"), text_of("category"), text_of("date"));
    let (version, authors, contact) = (text_of("version"), text_of("authors"), text_of("contact"));
    Ok(ParametersCfg {
        focal_length_mm: needed(&mut ini, INTRINSICS, "focal_length_mm")?,
        image_resolution_px: size(&mut ini, INTRINSICS, "image_resolution_y_px", "image_resolution_x_px")?,
        sensor_size_mm: needed(&mut ini, INTRINSICS, "sensor_size_mm")?,
        fstop: ini.number(INTRINSICS, "fstop")?,
        num_cams: size(&mut ini, EXTRINSICS, "num_cams_y", "num_cams_x")?,
        baseline_mm: needed(&mut ini, EXTRINSICS, "baseline_mm")?,
        baseline_y_mm: ini.number(EXTRINSICS, "baseline_y_mm")?,
        focus_distance_m: if focus_distance_m == 0.0 { f64::INFINITY } else { focus_distance_m },
        projection,
        center_cam: pose(&mut ini)?,
        offset: ini.number(EXTRINSICS, "offset")?,
        scene,
        category,
        date,
        version,
        authors,
        contact,
        cycles_seed: ini.integer(META, "cycles_seed")?,
        disp_min: ini.number(META, "disp_min")?,
        disp_max: ini.number(META, "disp_max")?,
        frustum_disp_min: ini.number(META, "frustum_disp_min")?,
        frustum_disp_max: ini.number(META, "frustum_disp_max")?,
        depth_map_scale: ini.number(META, "depth_map_scale")?,
        other: ini.rest(),
    })
}

fn needed(ini: &mut Ini<'_>, section: &str, key: &str) -> Result<f64, Error> {
    ini.number(section, key)?.ok_or_else(|| ini.missing(section, key))
}

fn size(ini: &mut Ini<'_>, section: &str, rows: &str, columns: &str) -> Result<GridSize, Error> {
    let mut count = |key: &str| {
        let count = ini.count(section, key)?.ok_or_else(|| ini.missing(section, key))?;
        // A count that does not fit is refused where the rig is built.
        Ok::<_, Error>(usize::try_from(count).unwrap_or(usize::MAX))
    };
    Ok(GridSize::new(count(rows)?, count(columns)?))
}

/// The pose, if all six numbers are there; an incomplete pose is ignored.
fn pose(ini: &mut Ini<'_>) -> Result<Option<CameraPose>, Error> {
    let mut pose = CameraPose { position_m: [0.0; 3], rotation_rad: [0.0; 3] };
    let mut complete = true;
    let keys = POSITION_KEYS.iter().chain(&ROTATION_KEYS);
    for (key, value) in keys.zip(pose.position_m.iter_mut().chain(&mut pose.rotation_rad)) {
        match ini.number(EXTRINSICS, key)? {
            Some(number) => *value = number,
            None => complete = false,
        }
    }
    Ok(complete.then_some(pose))
}
