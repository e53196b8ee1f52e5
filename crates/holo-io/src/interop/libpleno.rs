//! A calibrated camera for libpleno and the programs on it: COMPOTE, BLADE, PRISM.

mod boards;
mod read;

pub use boards::BoardCorner;

use holo_core::meters_to_millimeters as mm;
use holo_core::plenoptic::{MicrolensFocus, MicrolensGrid, MicrolensIndex, PlenopticCamera, PlenopticMode};
use serde_json::{Value, json};

use super::micro_images;
use crate::Error;

/// The files of libpleno that describe a camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Libpleno {
    /// `intrinsics.js`, the whole camera.
    pub intrinsics: String,
    /// `params.js`, the internal parameters that follow from it.
    pub parameters: String,
}

/// The micro-images of a whole grid on the sensor: rows from the first, which libpleno shifts to the right, and as many
/// columns in every row.
struct Grid {
    first: MicrolensIndex,
    rows: usize,
    columns: usize,
    /// Whether the first row is one that is not shifted here: then its columns, and those of every second row, count from the
    /// next one.
    is_next: bool,
}

impl Grid {
    fn new(camera: &PlenopticCamera) -> Result<Self, Error> {
        let all = micro_images(camera);
        let mut rows: Vec<&[_]> = all.chunk_by(|(a, _), (b, _)| a.row == b.row).collect();
        let longest = rows.iter().map(|row| row.len()).max().unwrap_or(0);
        rows.retain(|row| 2 * row.len() > longest);
        let is_hexagonal = camera.array().grid == MicrolensGrid::HexRows;
        // Odd rows are those shifted to the right. Microlenses are counted from the other end, so their number is even.
        let is_next = is_hexagonal && rows.first().is_some_and(|row| row[0].0.row.rem_euclid(2) == 0);
        let rows = if is_hexagonal { &rows[..rows.len() / 2 * 2] } else { &rows[..] };
        let shift = |row: usize| i32::from(is_next && row.is_multiple_of(2));
        let columns = |(row, lenses): (usize, &&[(MicrolensIndex, [f64; 2])])| {
            [0, lenses.len() - 1].map(|k| lenses[k].0.column - shift(row))
        };
        let first = rows.iter().enumerate().map(columns).map(|[first, _]| first).max().unwrap_or(0);
        let last = rows.iter().enumerate().map(columns).map(|[_, last]| last).min().unwrap_or(-1);
        match (rows.first(), usize::try_from(last - first)) {
            (Some(row), Ok(more)) => {
                let first = MicrolensIndex { row: row[0].0.row, column: first };
                Ok(Self { first, rows: rows.len(), columns: more + 1, is_next })
            }
            _ => Err(Error::Camera("no column of micro-images lies in all rows of the sensor".into())),
        }
    }

    fn at(&self, row: usize, column: usize) -> MicrolensIndex {
        let shift = i32::from(self.is_next && row.is_multiple_of(2));
        MicrolensIndex { row: self.first.row + row as i32, column: self.first.column + column as i32 + shift }
    }

    /// The row and column of a micro-image, if it is one of the grid.
    fn place(&self, lens: MicrolensIndex) -> Option<[usize; 2]> {
        let row = usize::try_from(lens.row - self.first.row).ok()?;
        let shift = i32::from(self.is_next && row.is_multiple_of(2));
        let column = usize::try_from(lens.column - self.first.column - shift).ok()?;
        (row < self.rows && column < self.columns).then_some([row, column])
    }
}

/// The number of the grid of microlenses.
fn geometry(camera: &PlenopticCamera) -> Result<u32, Error> {
    let array = camera.array();
    let geometry = match array.grid {
        MicrolensGrid::Square => 0,
        MicrolensGrid::HexRows => 1,
        MicrolensGrid::HexColumns => {
            return Err(Error::Camera("grids of columns are not written for libpleno; mla.grid is hex-columns".into()));
        }
    };
    let types = array.type_count();
    if !matches!((types, geometry), (1, _) | (3, 1)) {
        return Err(Error::Camera(format!(
            "libpleno interleaves one or three types in hexagonal grids; mla.focal_um has {types}"
        )));
    }
    Ok(geometry)
}

/// The number of the mode.
fn mode(camera: &PlenopticCamera) -> u32 {
    match camera.mode(0) {
        PlenopticMode::Unfocused => 0,
        PlenopticMode::Keplerian => 1,
        PlenopticMode::Galilean => 2,
    }
}

/// The parameters of the projection and the blur, of a mode and the focal lengths of the types.
fn parameters(camera: &PlenopticCamera, mode: u32, focal: &[f64]) -> Value {
    let (array, lens) = (camera.array(), camera.main_lens());
    let (gap, distance) = (mm(array.gap_m), mm(camera.mla_distance_m()));
    let (pixel, pitch_px, types) = (mm(camera.sensor().pixel_m), camera.micro_image_pitch_px(), array.type_count());
    let share = distance / (distance + gap);
    let spacing = pixel * pitch_px;
    let sign = if mode == 1 { 1.0 } else { -1.0 };
    let within: Vec<f64> = focal.iter().map(|f| share * spacing * gap / (2.0 * f)).collect();
    let beyond: Vec<f64> = within.iter().map(|q| q - spacing / 2.0).collect();
    json!({
        "m": sign * gap * mm(lens.focal_length_m) / (2.0 * distance), "scale": pixel,
        "q": beyond, "q_prime": within, "dc": spacing, "dC": share * spacing, "lambda": share,
        "N": lens.f_number, "I": types, "kappa": 1.0,
    })
}

impl Libpleno {
    /// Describes a camera.
    ///
    /// # Units
    ///
    /// Millimeters and pixels. libpleno's frame has x to the right, y down and z to the scene, from the main lens; the image
    /// on its sensor is turned by 180 degrees.
    ///
    /// # Accuracy
    ///
    /// libpleno has its pupil in the main lens: of other cameras the micro-images are right, and their light is not.
    /// Distortion acts on the image of the main lens there, here on the array: the same to first order.
    ///
    /// # Errors
    /// [`Error::Camera`] if the array is a hexagonal grid of columns, or of several types without being hexagonal, or has no
    /// whole row and column on the sensor.
    pub fn new(camera: &PlenopticCamera) -> Result<Self, Error> {
        let (array, sensor, lens) = (camera.array(), camera.sensor(), camera.main_lens());
        let geometry = geometry(camera)?;
        let types = array.type_count();
        let grid = Grid::new(camera)?;
        let (gap, distance) = (mm(array.gap_m), mm(camera.mla_distance_m()));
        let pixel = mm(sensor.pixel_m);
        let (sin, cos) = array.rotation_rad.sin_cos();
        let (width, height) = (sensor.size.columns as f64, sensor.size.rows as f64);
        let offset = sensor.offset_m.map(mm);
        // The first node is shifted by half a pitch in hexagonal grids, along the rows.
        let half = if geometry == 1 { 0.5 } else { 0.0 };
        let pitch_px = camera.micro_image_pitch_px();
        let corner = camera.micro_image_center_px(grid.first).map(|x| x - 0.5);
        let images = [corner[0] - half * pitch_px * cos, corner[1] + half * pitch_px * sin];
        // Microlenses count from the opposite corner, in the turned frame.
        let last = camera.lens_center_m(grid.at(grid.rows - 1, grid.columns - 1)).map(mm);
        let pitch = mm(array.pitch_m);
        let lenses = [-last[0] - half * pitch * cos, last[1] + half * pitch * sin];
        // A gap that grows to the right and up brings the array nearer to the main lens: dz = d gap, 0 on the array's origin.
        let tilt = [-array.tilt_rad[0].tan(), array.tilt_rad[1].tan()];
        let origin = [0, 1].map(|k| mm(sensor.offset_m[k] + array.offset_m[k]));
        let from_origin = [lenses[0] + origin[0], lenses[1] - origin[1]];
        let lenses = [lenses[0], lenses[1], tilt[0] * from_origin[0] + tilt[1] * from_origin[1] - distance];
        let raised = [tilt[0] * cos - tilt[1] * sin, tilt[0] * sin + tilt[1] * cos];
        let turned = json!([[cos, -sin, raised[0]], [sin, cos, raised[1]], [-tilt[0], -tilt[1], 1.0]]);
        let upright = json!([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        let focal = focal_lengths(camera, &grid);
        let (radial, tangential) = (lens.distortion.radial, lens.distortion.tangential);
        let mesh = |pitch: f64| {
            json!({
                "geometry": geometry, "width": grid.columns, "height": grid.rows, "pitch": [[pitch, pitch * array.scale_y]],
            })
        };
        let with_pose = |mut mesh: Value, rotation: Value, translation: Value| {
            mesh["pose"] = json!({"rotation": rotation, "translation": [translation]});
            mesh
        };
        let mode = mode(camera);
        let intrinsics = json!({
            "I": types,
            "dist_focus": mm(image_distance(camera)),
            "mode": mode,
            "distortions": {
                // Of x to the right of the sensor, which is the left of the image; in 1/mm^2, 1/mm^4, 1/mm^6 and 1/mm.
                "radial": [[radial[0] * 1e-6, radial[1] * 1e-12, radial[2] * 1e-18]],
                "tangential": [[-tangential[1] * 1e-3, tangential[0] * 1e-3]],
            },
            "main_lens": {
                "f": mm(lens.focal_length_m), "aperture": lens.f_number,
                "pose": {"rotation": upright, "translation": [[0.0, 0.0, 0.0]]},
            },
            "mia": {"mesh": with_pose(mesh(pitch_px), json!([[cos, -sin], [sin, cos]]), json!(images))},
            "mla": {"focal_lengths": focal, "mesh": with_pose(mesh(pitch), turned, json!(lenses))},
            "sensor": {
                "width": sensor.size.columns, "height": sensor.size.rows, "scale": pixel,
                "pose": {
                    "rotation": upright,
                    "translation": [[
                        -pixel * (width - 1.0) / 2.0 - offset[0], -pixel * (height - 1.0) / 2.0 + offset[1],
                        -(distance + gap),
                    ]],
                },
            },
        });
        let parameters = parameters(camera, mode, &focal);
        Ok(Self { intrinsics: format!("{intrinsics:#}\n"), parameters: format!("{parameters:#}\n") })
    }

    /// Returns `images.js` for white images of several f-numbers and one image, by their paths.
    #[must_use]
    pub fn images(whites: &[(String, f64)], image: &str) -> String {
        let f_number = whites.first().map_or(1.0, |(_, f_number)| *f_number);
        let whites: Vec<Value> =
            whites.iter().map(|(path, f_number)| json!({"path": path, "fnumber": f_number})).collect();
        let object = json!({
            "meta": {"debayered": true, "rgb": true, "format": 8},
            "whites": whites,
            "images": [{"path": image, "fnumber": f_number, "frame": 0}],
            "mask": {"path": whites[0]["path"], "fnumber": f_number},
        });
        format!("{object:#}\n")
    }
}

/// The focal lengths in the order of libpleno's types, mm: that of a micro-image of row l and column k is
/// (l mod (I - 1) + k) mod I.
fn focal_lengths(camera: &PlenopticCamera, grid: &Grid) -> Vec<f64> {
    let focal = match &camera.array().focus {
        MicrolensFocus::Lengths(lengths) => lengths.clone(),
        MicrolensFocus::Pupil => camera.microlens_focal_lengths_m().to_vec(),
    };
    (0..focal.len()).map(|number| mm(focal[camera.array().type_of(grid.at(0, number))])).collect()
}

/// The distance from object to image of the main lens that libpleno calls its focus, m.
fn image_distance(camera: &PlenopticCamera) -> f64 {
    let focus = camera.inverse_focus_per_m().recip();
    let object = if focus.is_finite() && focus > 0.0 { focus } else { 1e3 };
    object + camera.mla_distance_m()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CameraFile;

    fn vector(value: &Value) -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    }

    /// The place of a node, by the rules of libpleno's meshes and poses.
    fn node(mesh: &Value, k: usize, l: usize) -> Vec<f64> {
        let pitch = vector(&mesh["pitch"][0]);
        let (x, y) = match mesh["geometry"].as_u64() {
            Some(1) => (
                pitch[0] * (k as f64 + if l.is_multiple_of(2) { 0.5 } else { 0.0 }),
                pitch[1] * 0.75f64.sqrt() * l as f64,
            ),
            _ => (pitch[0] * k as f64, pitch[1] * l as f64),
        };
        let columns = &mesh["pose"]["rotation"];
        let shift = vector(&mesh["pose"]["translation"][0]);
        let (first, second) = (vector(&columns[0]), vector(&columns[1]));
        (0..shift.len()).map(|i| first[i] * x + second[i] * y + shift[i]).collect()
    }

    /// Micro-images and microlenses of the files are those of the camera, and a microlens is seen from the main lens where its
    /// micro-image is.
    #[test]
    fn meshes_are_those_of_the_camera() {
        for (name, rotation, tilt) in [
            ("raytrix-r12-a", 0.002, [0.0; 2]),
            ("raytrix-r29", -0.001, [0.0; 2]),
            ("h3dv", 0.001, [0.0; 2]),
            ("raytrix-r12-a", 0.0, [-6e-4, 8e-4]),
        ] {
            let mut camera = CameraFile::preset(name).unwrap().camera;
            let mut array = camera.array().clone();
            (array.rotation_rad, array.tilt_rad) = (rotation, tilt);
            let mut lens = camera.main_lens().clone();
            lens.exit_pupil_m = None;
            camera = PlenopticCamera::new(*camera.sensor(), array, lens).unwrap();
            let files = Libpleno::new(&camera).unwrap();
            let file: Value = serde_json::from_str(&files.intrinsics).unwrap();
            let grid = Grid::new(&camera).unwrap();
            let (images, lenses) = (&file["mia"]["mesh"], &file["mla"]["mesh"]);
            let sensor = vector(&file["sensor"]["pose"]["translation"][0]);
            let scale = file["sensor"]["scale"].as_f64().unwrap();
            let size = camera.sensor().size;
            for (row, column) in [(0, 0), (1, 0), (0, 1), (grid.rows - 1, grid.columns - 1), (grid.rows / 2, 7)] {
                let own = grid.at(row, column);
                let center = camera.micro_image_center_px(own).map(|x| x - 0.5);
                if tilt == [0.0; 2] {
                    let found = node(images, column, row);
                    assert!((found[0] - center[0]).hypot(found[1] - center[1]) < 1e-6, "{name}: {found:?} {center:?}");
                }
                let found = node(lenses, grid.columns - 1 - column, grid.rows - 1 - row);
                let lens = camera.lens_center_m(own).map(mm);
                assert!((found[0] + lens[0]).hypot(found[1] - lens[1]) < 1e-5, "{name}: {found:?} {lens:?}");
                // From the pupil in the origin through the microlens to the sensor.
                let reach = sensor[2] / found[2];
                let uv = [0, 1].map(|i| (reach * found[i] - sensor[i]) / scale);
                let turned = [size.columns as f64 - 1.0 - uv[0], size.rows as f64 - 1.0 - uv[1]];
                assert!((turned[0] - center[0]).hypot(turned[1] - center[1]) < 2e-3, "{name}: {turned:?} {center:?}");
                let number = if grid.rows > 0 && camera.array().type_count() == 3 { (row % 2 + column) % 3 } else { 0 };
                let focal = vector(&file["mla"]["focal_lengths"])[number];
                let expected = camera.microlens_focal_lengths_m()[camera.array().type_of(own)];
                assert!((focal - mm(expected)).abs() < 1e-12, "{name} {row} {column}");
            }
            assert!(grid.rows.is_multiple_of(2) || name == "h3dv");
        }
        // The calibration that the preset comes from.
        let camera = CameraFile::preset("raytrix-r12-a").unwrap().camera;
        let file: Value = serde_json::from_str(&Libpleno::new(&camera).unwrap().intrinsics).unwrap();
        let rotation = &file["mla"]["mesh"]["pose"]["rotation"];
        assert!((rotation[0][2].as_f64().unwrap() - 6.371e-4).abs() < 1e-6, "{rotation}");
        assert!((rotation[1][2].as_f64().unwrap() - 8.431e-4).abs() < 1e-6, "{rotation}");
        let tangential = vector(&file["distortions"]["tangential"][0]);
        assert!((tangential[0] + 1.458_53e-4).abs() < 1e-8 && (tangential[1] + 6.3402e-5).abs() < 1e-8);
        let columns = CameraFile::preset("raytrix-r8").unwrap().camera;
        assert!(Libpleno::new(&columns).unwrap_err().to_string().contains("hex-columns"));
    }

    /// Radii of micro-images by libpleno's parameters, those of half light: m / N + q.
    #[test]
    fn parameters_give_the_radii_of_the_micro_images() {
        let camera = CameraFile::preset("raytrix-r12-a").unwrap().camera;
        let files = Libpleno::new(&camera).unwrap();
        let file: Value = serde_json::from_str(&files.parameters).unwrap();
        let (m, n) = (file["m"].as_f64().unwrap(), file["N"].as_f64().unwrap());
        let q = vector(&file["q"]);
        for (k, q) in q.iter().enumerate() {
            let radius = (m / n + q).abs();
            // |m| / N is the pupil's part, |q| that of the microlens.
            let pupil = camera.exit_pupil_radius_m() * camera.array().gap_m / camera.mla_distance_m();
            assert!((m.abs() / n - mm(pupil)).abs() < 1e-6, "{k}: {m}");
            assert!(radius > 0.0 && file["lambda"].as_f64().unwrap() < 1.0);
        }
        // Of a microlens that is a focal length from the sensor, q' is half of its pitch.
        let lytro = CameraFile::preset("lytro-illum").unwrap().camera;
        assert!((lytro.microlens_focal_lengths_m()[0] / lytro.array().gap_m - 1.0).abs() < 1e-9);
        let file: Value = serde_json::from_str(&Libpleno::new(&lytro).unwrap().parameters).unwrap();
        let (q, pitch) = (vector(&file["q_prime"])[0], file["dC"].as_f64().unwrap());
        assert!((2.0 * q / pitch - 1.0).abs() < 1e-9, "{q} {pitch}");
    }
}
