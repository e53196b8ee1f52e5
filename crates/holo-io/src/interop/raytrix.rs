//! The calibration of a focused camera as Raytrix's software writes it.

use std::fmt::Write as _;

use holo_core::plenoptic::{MicrolensGrid, MicrolensIndex, PlenopticCamera};

use crate::Error;

/// Returns the calibration (XML) of a camera in the form of Raytrix, which PlenopticToolbox2.0 reads beside the image of the
/// same name.
///
/// # Units
///
/// Pixels from the middle of the image, x to the right and y up; the lattice is in microlenses.
///
/// # Errors
/// [`Error::Camera`] if the array is square or a hexagonal grid of columns, or scaled along one axis.
pub fn raytrix_calibration(camera: &PlenopticCamera) -> Result<String, Error> {
    let (array, size) = (camera.array(), camera.sensor().size);
    match array.grid {
        MicrolensGrid::HexRows => {}
        MicrolensGrid::Square => {
            return Err(Error::Camera("Raytrix's calibrations are of hexagonal grids; mla.grid is square".into()));
        }
        MicrolensGrid::HexColumns => {
            return Err(Error::Camera(
                "readers of Raytrix's calibrations differ on grids of columns; mla.grid is hex-columns".into(),
            ));
        }
    }
    if (array.scale_y - 1.0).abs() > 1e-2 {
        return Err(Error::Camera(format!(
            "Raytrix's calibrations have no vertical scale; mla.scale_y is {}",
            array.scale_y
        )));
    }
    let middle = [size.columns as f64 / 2.0, size.rows as f64 / 2.0];
    let lens = camera.owner(camera.place_m(middle));
    let [x, y] = camera.micro_image_center_px(lens);
    let (offset, rotation) = ([x - middle[0], middle[1] - y], array.rotation_rad);
    let pitch = camera.micro_image_pitch_px();
    // The lattice runs to the left and up, as in files of a R29: so the texts and the code of readers agree on the types.
    let base = [[-1.0, 0.0], [-0.5, -0.866_025_403_784], [-3.0, -1.732_050_807_569]];
    let mut text = String::from("<?xml version=\"1.0\"?>\n<RayCalibData version=\"1.0\">\n");
    // Writing to a string does not fail.
    let mut pair = |name: &str, units: &str, [x, y]: [f64; 2]| {
        let _ = write!(text, "  <{name} units=\"{units}\">\n    <x>{x:.12}</x>\n    <y>{y:.12}</y>\n  </{name}>\n");
    };
    pair("offset", "pix", offset);
    pair("lens_base_x", "lens", base[0]);
    pair("lens_base_y", "lens", base[1]);
    pair("sub_grid_base", "lens", base[2]);
    for (name, units, value) in [
        ("diameter", "pix", pitch),
        ("rotation", "rad", rotation),
        ("lens_border", "pix", 1.0),
        ("tcp", "virtual_depth", 2.0),
    ] {
        let _ = writeln!(text, "  <{name} units=\"{units}\">{value:.12}</{name}>");
    }
    text += "  <distortion type=\"radial\">\n    <function>constant</function>\n    <parameter count=\"0\">0</parameter>\n    \
             <offset units=\"pix\">\n      <x>0.000000000000</x>\n      <y>0.000000000000</y>\n    </offset>\n  \
             </distortion>\n";
    let at = |columns: i32| array.type_of(MicrolensIndex { row: lens.row, column: lens.column + columns });
    for (id, columns) in [0, -1, 1].into_iter().enumerate() {
        let [low, high] = depth_range(camera, at(columns));
        let _ = write!(
            text,
            "  <lens_type id=\"{id}\">\n    <offset units=\"lens\">\n      <x>{columns:.12}</x>\n      <y>{:.12}</y>\n    \
             </offset>\n    <depth_range units=\"virtual_depth\">\n      <min>{low:.12}</min>\n      <max>{high:.12}</max>\n    \
             </depth_range>\n  </lens_type>\n",
            0.0,
            columns = f64::from(columns)
        );
    }
    Ok(text + "</RayCalibData>\n")
}

/// The virtual depths about the one that a type of microlens is focused at, up to those of its neighbors.
fn depth_range(camera: &PlenopticCamera, lens_type: usize) -> [f64; 2] {
    const LIMITS: [f64; 2] = [1.0, 100.0];
    let focus = |focal_m: f64| {
        let depth = 1.0 / (1.0 - camera.array().gap_m / focal_m);
        if depth.is_finite() { depth.abs().clamp(LIMITS[0], LIMITS[1]) } else { LIMITS[1] }
    };
    let all: Vec<f64> = camera.microlens_focal_lengths_m().iter().map(|&focal_m| focus(focal_m)).collect();
    let own = all[lens_type];
    let nearest = |wanted: fn(f64, f64) -> bool, none: f64| {
        let others = all.iter().copied().filter(|&other| wanted(other, own)).map(|other| (other * own).sqrt());
        others.min_by(|a, b| (a - own).abs().total_cmp(&(b - own).abs())).unwrap_or(none)
    };
    [nearest(|other, own| other < own, LIMITS[0]), nearest(|other, own| other > own, LIMITS[1])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CameraFile;

    /// The lattice that PlenopticToolbox2.0 makes of the file has the micro-images and types of the camera.
    #[test]
    fn the_lattice_is_that_of_the_camera() {
        for name in ["raytrix-r29", "raytrix-r12-a"] {
            // Tilted arrays have no lattice.
            let mut camera = CameraFile::preset(name).unwrap().camera;
            let mut array = camera.array().clone();
            array.tilt_rad = [0.0; 2];
            array.rotation_rad = 0.003;
            camera = PlenopticCamera::new(*camera.sensor(), array, camera.main_lens().clone()).unwrap();
            let text = raytrix_calibration(&camera).unwrap();
            let number = |tag: &str, from: usize| -> f64 {
                let start = from + text[from..].find(&format!("<{tag}")).unwrap();
                let begin = start + text[start..].find('>').unwrap() + 1;
                text[begin..].split('<').next().unwrap().trim().parse().unwrap()
            };
            let size = camera.sensor().size;
            let (x, y) = (number("x", 0), number("y", 0));
            let (pitch, rotation) = (number("diameter", 0), number("rotation", 0));
            let (sin, cos) = rotation.sin_cos();
            let middle = camera.owner(camera.place_m([x + size.columns as f64 / 2.0, size.rows as f64 / 2.0 - y]));
            for (i, j) in [(0i32, 0i32), (1, 0), (0, 1), (5, -9), (-20, 31)] {
                let [along, up] = [-f64::from(j) - 0.5 * f64::from(i), 0.866_025_403_784 * f64::from(i)];
                let at = [
                    x + pitch * (cos * along - sin * up) + size.columns as f64 / 2.0,
                    size.rows as f64 / 2.0 - (y + pitch * (sin * along + cos * up)),
                ];
                let lens = camera.owner(camera.place_m(at));
                let found = camera.micro_image_center_px(lens);
                assert!((found[0] - at[0]).hypot(found[1] - at[1]) < 1e-6, "{name}: {at:?} {found:?}");
                // The tool's type of lattice point (i, j), with that of the first as 0.
                let own = camera.array().type_of(lens) as i32 - camera.array().type_of(middle) as i32;
                assert_eq!((j - i).rem_euclid(3), (-own).rem_euclid(3), "{name} {i} {j}");
            }
        }
        let square = CameraFile::preset("h3dv").unwrap().camera;
        assert!(raytrix_calibration(&square).unwrap_err().to_string().contains("square"));
    }
}
