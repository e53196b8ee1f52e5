//! Cameras that programs on libpleno calibrated.

use holo_core::GridSize;
use holo_core::plenoptic::{
    ArrayFocus, Distortion, ImageSensor, MainLens, MicrolensArray, MicrolensFocus, MicrolensGrid, PlenopticCamera,
};
use serde_json::Value;

use super::Libpleno;

/// The largest number of microlenses along a side.
const MOST_LENSES: f64 = 1e6;

impl Libpleno {
    /// Reads `intrinsics.js`, as COMPOTE writes it: numbers, or numbers in quotes.
    ///
    /// # Accuracy
    /// What is written of a camera is read with rounding of f64. libpleno turns neither its sensor nor its main lens; the place of the
    /// array is that of the microlens in its middle. Distortion acts on the image of the main lens there, here on the array: the same
    /// to first order.
    ///
    /// # Errors
    /// Says what is missing or impossible, by its key.
    pub fn read(intrinsics: &str) -> Result<PlenopticCamera, String> {
        let file: Value = serde_json::from_str(intrinsics).map_err(|why| format!("it is no JSON: {why}"))?;
        let (sensor, depth_m) = sensor(&file)?;
        let mesh = Mesh::new(&file)?;
        let middle = mesh.middle();
        let [x, y, z] = mesh.node_m(middle);
        let tilt = mesh.columns[2].map(|value| -value / mesh.columns[2][2]);
        let pitch_m = 1e-3 * mesh.pitch_mm[0];
        let mut array = MicrolensArray::new(mesh.grid, pitch_m, depth_m + z);
        array.scale_y = mesh.pitch_mm[1] / mesh.pitch_mm[0];
        array.rotation_rad = (-mesh.columns[0][1]).atan2(mesh.columns[0][0]);
        array.tilt_rad = [-tilt[0].atan(), tilt[1].atan()];
        array.offset_m = [-x - sensor.offset_m[0], y - sensor.offset_m[1]];
        if let Some(lengths) = mesh.focal_lengths_m(&file, middle)? {
            array.focus = MicrolensFocus::Lengths(lengths);
        }
        let mut lens =
            MainLens::new(1e-3 * number(&file, "/main_lens/f")?, number(&file, "/main_lens/aperture")?, f64::INFINITY);
        lens.focus = ArrayFocus::Distance { mla_distance_m: -z };
        lens.distortion = distortion(&file)?;
        PlenopticCamera::new(sensor, array, lens).map_err(|why| why.to_string())
    }
}

/// The sensor, and its distance from the main lens.
fn sensor(file: &Value) -> Result<(ImageSensor, f64), String> {
    let size = [count(file, "/sensor/width")?, count(file, "/sensor/height")?];
    let pixel_m = 1e-3 * number(file, "/sensor/scale")?;
    let place = numbers::<3>(file, "/sensor/pose/translation/0")?.map(|mm| 1e-3 * mm);
    let mut sensor = ImageSensor::new(GridSize::new(size[1], size[0]), pixel_m);
    let half = size.map(|count| pixel_m * (count as f64 - 1.0) / 2.0);
    sensor.offset_m = [-(place[0] + half[0]), place[1] + half[1]];
    Ok((sensor, -place[2]))
}

/// The mesh of the microlenses.
struct Mesh {
    grid: MicrolensGrid,
    /// Columns and rows.
    size: [usize; 2],
    pitch_mm: [f64; 2],
    /// The columns of its rotation.
    columns: [[f64; 3]; 3],
    place_mm: [f64; 3],
}

impl Mesh {
    fn new(file: &Value) -> Result<Self, String> {
        let key = |name: &str| format!("/mla/mesh/{name}");
        let grid = match count(file, &key("geometry"))? {
            0 => MicrolensGrid::Square,
            1 => MicrolensGrid::HexRows,
            other => return Err(format!("mla.mesh.geometry: {other} is no grid of rows, 0 or 1")),
        };
        let size = [count(file, &key("width"))?, count(file, &key("height"))?];
        if size.contains(&0) {
            return Err("mla.mesh: it has no microlenses".into());
        }
        let mut columns = [[0.0; 3]; 3];
        for (k, column) in columns.iter_mut().enumerate() {
            *column = numbers(file, &key(&format!("pose/rotation/{k}")))?;
        }
        if columns[2][2].abs() < 0.5 {
            return Err("mla.mesh.pose.rotation: the array stands across the axis".into());
        }
        let (pitch_mm, place_mm) = (numbers(file, &key("pitch/0"))?, numbers(file, &key("pose/translation/0"))?);
        Ok(Self { grid, size, pitch_mm, columns, place_mm })
    }

    /// Column and row of the micro-image in the middle, in an unshifted row.
    fn middle(&self) -> [usize; 2] {
        let row = self.size[1] / 2;
        let row = match self.grid {
            MicrolensGrid::Square => row,
            // Even rows are shifted.
            _ => (row / 2 * 2 + 1).min(self.size[1] - 1),
        };
        [self.size[0] / 2, row]
    }

    /// The center of the microlens of a micro-image, in libpleno's frame, m. Microlenses count from the opposite corner.
    fn node_m(&self, [column, row]: [usize; 2]) -> [f64; 3] {
        let (k, l) = ((self.size[0] - 1 - column) as f64, self.size[1] - 1 - row);
        let (shift, height) = match self.grid {
            MicrolensGrid::Square => (0.0, 1.0),
            _ => (if l.is_multiple_of(2) { 0.5 } else { 0.0 }, 0.75f64.sqrt()),
        };
        let (x, y) = (self.pitch_mm[0] * (k + shift), self.pitch_mm[1] * height * l as f64);
        std::array::from_fn(|i| 1e-3 * (self.columns[0][i] * x + self.columns[1][i] * y + self.place_mm[i]))
    }

    /// The focal lengths of the types, counted from that of a micro-image; `None` without any.
    fn focal_lengths_m(&self, file: &Value, middle: [usize; 2]) -> Result<Option<Vec<f64>>, String> {
        let Some(list) = file.pointer("/mla/focal_lengths").and_then(Value::as_array).filter(|list| !list.is_empty())
        else {
            return Ok(None);
        };
        let lengths: Option<Vec<f64>> = list.iter().map(|value| Some(1e-3 * as_number(value)?)).collect();
        let lengths = lengths.ok_or("mla.focal_lengths: it has numbers")?;
        let types = lengths.len();
        if types > 1 && (types != 3 || self.grid == MicrolensGrid::Square || self.size[1] % 2 == 1) {
            return Err(format!(
                "mla.focal_lengths: {types} types are not those of a hexagonal grid with an even number of rows"
            ));
        }
        let first = middle[1] % 2 + middle[0];
        Ok(Some((0..types).map(|k| lengths[(first + k) % types]).collect()))
    }
}

fn distortion(file: &Value) -> Result<Distortion, String> {
    if file.pointer("/distortions").is_none() {
        return Ok(Distortion::NONE);
    }
    let radial: [f64; 3] = numbers(file, "/distortions/radial/0")?;
    let tangential: [f64; 2] = numbers(file, "/distortions/tangential/0")?;
    Ok(Distortion {
        radial: [radial[0] * 1e6, radial[1] * 1e12, radial[2] * 1e18],
        tangential: [tangential[1] * 1e3, -tangential[0] * 1e3],
    })
}

fn as_number(value: &Value) -> Option<f64> {
    let number = value.as_f64().or_else(|| value.as_str()?.trim().parse().ok());
    number.filter(|number| number.is_finite())
}

fn number(file: &Value, pointer: &str) -> Result<f64, String> {
    let found = file.pointer(pointer).and_then(as_number);
    found.ok_or_else(|| format!("{}: a number is missing", pointer[1..].replace('/', ".")))
}

fn count(file: &Value, pointer: &str) -> Result<usize, String> {
    let found = number(file, pointer)?;
    if found.fract() == 0.0 && (0.0..=MOST_LENSES).contains(&found) {
        return Ok(found as usize);
    }
    Err(format!("{}: {found} is no number of pixels or microlenses", pointer[1..].replace('/', ".")))
}

fn numbers<const N: usize>(file: &Value, pointer: &str) -> Result<[f64; N], String> {
    let mut out = [0.0; N];
    for (k, value) in out.iter_mut().enumerate() {
        *value = number(file, &format!("{pointer}/{k}"))?;
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::CameraFile;

    /// The camera that is read has the micro-images, the rays and the types of that which was written.
    #[test]
    fn cameras_are_read_as_they_are_written() {
        for (name, rotation, tilt) in [
            ("raytrix-r12-a", 0.002, [0.0; 2]),
            ("raytrix-r12-a", -0.003, [-6e-4, 8e-4]),
            ("raytrix-r29", 0.0, [2e-4, 1e-4]),
            ("home-made", 0.001, [0.0; 2]),
            ("lytro-illum", 0.001, [0.0; 2]),
        ] {
            let preset = CameraFile::preset(name).unwrap().camera;
            let (mut array, mut lens, mut sensor) =
                (preset.array().clone(), preset.main_lens().clone(), *preset.sensor());
            (array.rotation_rad, array.tilt_rad, array.offset_m) = (rotation, tilt, [11e-6, -23e-6]);
            (sensor.offset_m, lens.exit_pupil_m) = ([31e-6, 7e-6], None);
            let camera = PlenopticCamera::new(sensor, array, lens).unwrap();
            let text = Libpleno::new(&camera).unwrap().intrinsics;
            let read = Libpleno::read(&text).unwrap();
            let size = sensor.size;
            for share in [[0.1, 0.2], [0.5, 0.5], [0.93, 0.4], [0.3, 0.88]] {
                let position = [share[0] * size.columns as f64, share[1] * size.rows as f64];
                let lenses = [&camera, &read].map(|camera| camera.microlens(camera.owner(camera.place_m(position))));
                let [own, found] = [0, 1].map(|k| [&camera, &read][k].position_px(lenses[k].image_center_m));
                assert!((own[0] - found[0]).hypot(own[1] - found[1]) < 1e-5, "{name}: {own:?} {found:?}");
                let focal = [0, 1].map(|k| [&camera, &read][k].microlens_focal_lengths_m()[lenses[k].lens_type]);
                assert!((focal[0] - focal[1]).abs() < 1e-15, "{name} {share:?}");
                let rays = [0, 1].map(|k| {
                    let camera = [&camera, &read][k];
                    camera.ray(camera.place_m(position), lenses[k].center_m, lenses[k].index).unwrap()
                });
                for k in 0..2 {
                    // The tilt of both is around another microlens, which the second order of the tilt moves.
                    assert!((rays[0].origin_m[k] - rays[1].origin_m[k]).abs() < 1e-7, "{name} {rays:?}");
                    assert!((rays[0].direction[k] - rays[1].direction[k]).abs() < 1e-7, "{name} {rays:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_wrong_is_said_by_its_key() {
        let camera = CameraFile::preset("raytrix-r12-a").unwrap().camera;
        let good = Libpleno::new(&camera).unwrap().intrinsics;
        let changed = |key: &str, value: Value| {
            let mut file: Value = serde_json::from_str(&good).unwrap();
            *file.pointer_mut(key).unwrap() = value;
            Libpleno::read(&file.to_string())
        };
        assert!(changed("/main_lens/f", "49.5".into()).is_ok());
        for (key, value, expected) in [
            ("/main_lens/f", Value::Null, "main_lens.f"),
            ("/sensor/width", "1e9".into(), "sensor.width"),
            ("/sensor/scale", "NaN".into(), "sensor.scale"),
            ("/mla/mesh/geometry", 2.into(), "geometry"),
            ("/mla/mesh/height", 151.into(), "focal_lengths"),
            ("/mla/mesh/width", 0.into(), "microlenses"),
            ("/mla/mesh/pose/translation/0/2", 12.into(), ""),
        ] {
            let error = changed(key, value).unwrap_err();
            assert!(error.contains(expected), "{key}: {error}");
        }
        assert!(Libpleno::read("{").unwrap_err().contains("JSON"));
    }
}
