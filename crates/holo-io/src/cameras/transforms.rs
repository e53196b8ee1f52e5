//! `transforms.json`: cameras anywhere, as NeRF, Instant NGP, nerfstudio and Gaussian splatting read and write them.
//!
//! A file has a list `frames`, each with `file_path` and `transform_matrix` (camera to world; a camera looks along its -Z
//! with +Y up), and intrinsics in pixels, for all frames or in each: `fl_x`, `fl_y`, `cx`, `cy`, `w`, `h`, or the angle of
//! view `camera_angle_x`. Arrays of real cameras differ in their response and in time: `gain` and `time_s`, which are keys of this
//! project, say by how much. Blender and these programs have a world with Z up, glTF one with Y up; [`WorldUp`] says which the
//! file has. In memory poses are always in the world of glTF.
//!
//! # Source
//!
//! <https://docs.nerf.studio/quickstart/data_conventions.html>; the data sets of Mildenhall et al., "NeRF", ECCV 2020.

use std::path::Path;

use holo_core::GridSize;
use serde_json::{Map, Value, json};

use crate::files::folder::Destination;
use crate::files::limits::read_small_file;
use crate::{Error, FileDigest, Folder, write_file};

/// Maximum size of a file, bytes: some ten thousand cameras.
const MAX_BYTES: u64 = 64 << 20;

/// How far the principal point may be from the center of the image, px, and the focal lengths from each other, relative.
const TOLERANCE: f64 = 1e-6;

/// Camera models that are pinholes where all coefficients of distortion are 0.
const PINHOLES: [&str; 3] = ["PINHOLE", "SIMPLE_PINHOLE", "OPENCV"];

/// Coefficients of lens distortion.
const DISTORTION: [&str; 6] = ["k1", "k2", "k3", "k4", "p1", "p2"];

/// Endings of the names of images, which are not part of the name of a camera.
const IMAGES: [&str; 15] =
    ["png", "jpg", "jpeg", "exr", "hdr", "tif", "tiff", "webp", "bmp", "gif", "pfm", "ppm", "dng", "heic", "avif"];

/// Cameras anywhere in the world.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraArray {
    /// The cameras, in the order of the file.
    pub cameras: Vec<ArrayCamera>,
}

/// A pinhole camera with square pixels and its principal point in the middle of the image.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrayCamera {
    /// Its name: the file name of its image without folder and without the ending of an image, or `camera_0003` without one.
    pub name: String,
    /// Its +X, +Y and +Z axes and its position in the world of glTF (+Y up), m; as in the file, not normalized.
    pub axes_and_position: [[f64; 3]; 4],
    /// Focal length, px.
    pub focal_px: f64,
    /// Rows and columns of the image; `None` where the file does not say.
    pub size: Option<GridSize>,
    /// What the light of the scene is multiplied by in its image, red, green and blue: key `gain`; 1 where the file does not say.
    pub gain: [f64; 3],
    /// How much later than the others it sees a moving scene, s: key `time_s`; 0 where the file does not say.
    pub time_s: f64,
}

/// A camera at the origin of the world, 1 px of focal length, without a size.
impl Default for ArrayCamera {
    fn default() -> Self {
        Self {
            name: "camera_0000".into(),
            axes_and_position: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0; 3]],
            focal_px: 1.0,
            size: None,
            gain: [1.0; 3],
            time_s: 0.0,
        }
    }
}

/// The axis of a file's world that points up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum WorldUp {
    /// +Z, as in Blender and nerfstudio.
    #[default]
    Z,
    /// +Y, as in glTF.
    Y,
}

impl WorldUp {
    fn gltf_of(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            // `+ 0.0` turns -0 into 0.
            Self::Z => [x, z, -y + 0.0],
            Self::Y => [x, y, z],
        }
    }

    fn file_of(self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Z => [x, -z + 0.0, y],
            Self::Y => [x, y, z],
        }
    }
}

impl CameraArray {
    /// Reads a file. `size` is that of images whose size the file does not say, which the angle of view needs.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is no such file; [`Error::Unsupported`] for lens
    /// distortion, pixels that are not square, or a principal point outside the middle of the image.
    pub fn read(path: impl AsRef<Path>, up: WorldUp, size: Option<GridSize>) -> Result<Self, Error> {
        let path = path.as_ref();
        let bytes = read_small_file(path, MAX_BYTES)?;
        Self::from_json(&bytes, path, up, size)
    }

    /// Reads a file of an open folder, like [`CameraArray::read`].
    ///
    /// # Errors
    ///
    /// Those of [`CameraArray::read`] and [`Folder::open_regular`].
    pub fn read_in(folder: &Folder, name: &str, up: WorldUp, size: Option<GridSize>) -> Result<Self, Error> {
        Self::from_json(&folder.read(name, MAX_BYTES)?, &folder.path_of(name), up, size)
    }

    /// Reads a file of an open folder, and the name of the image of each camera, in the folder.
    pub(crate) fn read_with_files(
        folder: &Folder,
        name: &str,
        up: WorldUp,
    ) -> Result<(Self, Vec<Option<String>>), Error> {
        let (bytes, path) = (folder.read(name, MAX_BYTES)?, folder.path_of(name));
        let array = Self::from_json(&bytes, &path, up, None)?;
        let root: Value =
            serde_json::from_slice(&bytes).map_err(|why| Error::broken(&path, "transforms", why.to_string()))?;
        let file = |frame: &Value| {
            let name = frame.get("file_path")?.as_str()?.replace('\\', "/");
            Some(name.strip_prefix("./").map_or(name.clone(), str::to_owned))
        };
        Ok((array, root["frames"].as_array().into_iter().flatten().map(file).collect()))
    }

    fn from_json(bytes: &[u8], path: &Path, up: WorldUp, size: Option<GridSize>) -> Result<Self, Error> {
        let broken = |what: String| Error::broken(path, "transforms", what);
        let root: Value = serde_json::from_slice(bytes).map_err(|why| broken(format!("it is no JSON: {why}")))?;
        let root = root.as_object().ok_or_else(|| broken("it is no JSON object".into()))?;
        let frames = root.get("frames").and_then(Value::as_array);
        let frames = frames.ok_or_else(|| broken("it has no list `frames`".into()))?;
        if frames.is_empty() {
            return Err(broken("its list `frames` is empty".into()));
        }
        let camera = |(k, frame): (usize, &Value)| {
            let own = frame.as_object().ok_or_else(|| broken(format!("frames[{k}] is no object")))?;
            Entry { own, root, path, at: format!("frames[{k}]") }.camera(k, up, size)
        };
        let cameras: Vec<ArrayCamera> = frames.iter().enumerate().map(camera).collect::<Result<_, _>>()?;
        let mut names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
        names.sort_unstable();
        match names.windows(2).find(|pair| pair[0] == pair[1]) {
            Some(pair) => Err(broken(format!("two frames have the image '{}'", crate::shown(pair[0])))),
            None => Ok(Self { cameras }),
        }
    }

    /// Writes a file whose images are `images/NAME.png`.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if a camera has no size; [`Error::Io`] if the file cannot be written.
    pub fn write(&self, path: impl Destination, up: WorldUp) -> Result<FileDigest, Error> {
        let text = self.to_json(path.path(), up, |name| format!("images/{name}.png"))?;
        write_file(path, text.as_bytes())
    }

    /// Writes a file whose poses are those of folders, each with a light field or a raw image, instead of images.
    ///
    /// # Errors
    ///
    /// Those of [`CameraArray::write`].
    pub fn write_folders(&self, path: impl Destination, up: WorldUp) -> Result<FileDigest, Error> {
        let text = self.to_folders_json(path.path(), up)?;
        write_file(path, text.as_bytes())
    }

    /// Returns the text of the file that [`write_folders`](CameraArray::write_folders) writes to `path`.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if a camera has no size.
    pub fn to_folders_json(&self, path: &Path, up: WorldUp) -> Result<String, Error> {
        self.to_json(path, up, str::to_owned)
    }

    fn to_json(&self, path: &Path, up: WorldUp, of: impl Fn(&str) -> String) -> Result<String, Error> {
        let frame = |camera: &ArrayCamera| -> Result<Value, Error> {
            let Some(size) = camera.size else {
                return Err(Error::bad_input(path, format!("camera '{}' has no size", crate::shown(&camera.name))));
            };
            let columns = camera.axes_and_position.map(|column| up.file_of(column));
            let mut rows: Vec<Vec<f64>> =
                (0..3).map(|row| columns.iter().map(|column| column[row]).collect()).collect();
            rows.push(vec![0.0, 0.0, 0.0, 1.0]);
            let mut frame = json!({
                "file_path": of(&camera.name),
                "fl_x": camera.focal_px, "fl_y": camera.focal_px,
                "cx": size.columns as f64 / 2.0, "cy": size.rows as f64 / 2.0,
                "w": size.columns, "h": size.rows,
                "transform_matrix": rows,
            });
            if camera.gain != [1.0; 3] {
                frame["gain"] = json!(camera.gain);
            }
            if camera.time_s != 0.0 {
                frame["time_s"] = json!(camera.time_s);
            }
            Ok(frame)
        };
        let frames: Vec<Value> = self.cameras.iter().map(frame).collect::<Result<_, _>>()?;
        let root = json!({ "camera_model": "PINHOLE", "frames": frames });
        let mut text = serde_json::to_string_pretty(&root).map_err(|why| Error::bad_input(path, why.to_string()))?;
        text.push('\n');
        Ok(text)
    }
}

/// A frame of a file: what it does not say itself, the file says for all.
struct Entry<'a> {
    own: &'a Map<String, Value>,
    root: &'a Map<String, Value>,
    path: &'a Path,
    at: String,
}

impl Entry<'_> {
    fn broken(&self, what: &str) -> Error {
        Error::broken(self.path, "transforms", format!("{}: {what}", self.at))
    }

    fn number(&self, key: &str) -> Result<Option<f64>, Error> {
        let Some(value) = self.own.get(key).or_else(|| self.root.get(key)) else { return Ok(None) };
        let number = value.as_f64().filter(|x| x.is_finite());
        number.map(Some).ok_or_else(|| self.broken(&format!("`{key}` is no number")))
    }

    fn camera(&self, k: usize, up: WorldUp, size: Option<GridSize>) -> Result<ArrayCamera, Error> {
        let size = self.size()?.or(size);
        let focal_px = self.focal_px(size)?;
        self.check_lens(size)?;
        let (gain, time_s) = (self.gain()?, self.number("time_s")?.unwrap_or(0.0));
        Ok(ArrayCamera { name: self.name(k)?, axes_and_position: self.pose(up)?, focal_px, size, gain, time_s })
    }

    fn gain(&self) -> Result<[f64; 3], Error> {
        let Some(value) = self.own.get("gain").or_else(|| self.root.get("gain")) else { return Ok([1.0; 3]) };
        let channels: Option<Vec<f64>> = match value.as_array() {
            Some(channels) => channels.iter().map(Value::as_f64).collect(),
            None => value.as_f64().map(|gain| vec![gain; 3]),
        };
        let channels = channels.filter(|all| all.iter().all(|gain| *gain > 0.0 && gain.is_finite()));
        let gain = channels.and_then(|all| <[f64; 3]>::try_from(all).ok());
        gain.ok_or_else(|| self.broken("`gain` is no number above 0, nor three of them"))
    }

    fn size(&self) -> Result<Option<GridSize>, Error> {
        let (Some(w), Some(h)) = (self.number("w")?, self.number("h")?) else { return Ok(None) };
        let whole = |x: f64| (1.0..=1e6).contains(&x) && x.fract() == 0.0;
        if !(whole(w) && whole(h)) {
            return Err(self.broken("`w` and `h` are no size in pixels"));
        }
        Ok(Some(GridSize::new(h as usize, w as usize)))
    }

    fn focal_px(&self, size: Option<GridSize>) -> Result<f64, Error> {
        let focal_px = match (self.number("fl_x")?, self.number("camera_angle_x")?, size) {
            (Some(focal_px), ..) => focal_px,
            (None, Some(angle), Some(size)) => size.columns as f64 / (2.0 * (angle / 2.0).tan()),
            (None, Some(_), None) => {
                return Err(self.broken(
                    "has an angle of view, but no size in pixels; add `w` and `h` to it or beside `frames`, or give the size \
                     of the images as `lenses=WIDTHxHEIGHT`",
                ));
            }
            (None, None, _) => return Err(self.broken("has no focal length: `fl_x` or `camera_angle_x`")),
        };
        if !(focal_px > 0.0 && focal_px.is_finite()) {
            return Err(self.broken(&format!("its focal length is {focal_px} px")));
        }
        let other = self.number("fl_y")?.unwrap_or(focal_px);
        if (other - focal_px).abs() > TOLERANCE * focal_px {
            let what = format!("{}: `fl_x` and `fl_y` differ; pixels must be square", self.at);
            return Err(Error::unsupported(self.path, what));
        }
        Ok(focal_px)
    }

    /// Refuses what a pinhole with its principal point in the middle is not.
    fn check_lens(&self, size: Option<GridSize>) -> Result<(), Error> {
        let said = |key: &str| self.own.get(key).or_else(|| self.root.get(key));
        let model = said("camera_model").and_then(Value::as_str).unwrap_or(PINHOLES[0]);
        if !PINHOLES.contains(&model) || said("is_fisheye") == Some(&Value::Bool(true)) {
            let what = format!("{}: it is no pinhole camera (`camera_model`, `is_fisheye`)", self.at);
            return Err(Error::unsupported(self.path, what));
        }
        if let Some(key) = DISTORTION.iter().find(|key| !matches!(self.number(key), Ok(None | Some(0.0)))) {
            let what = format!("{}: lens distortion (`{key}`); undistort the cameras", self.at);
            return Err(Error::unsupported(self.path, what));
        }
        let Some(size) = size else { return Ok(()) };
        for (key, middle) in [("cx", size.columns as f64 / 2.0), ("cy", size.rows as f64 / 2.0)] {
            let at = self.number(key)?.unwrap_or(middle);
            if (at - middle).abs() > TOLERANCE {
                let what = format!("{}: `{key}` is {at}; the principal point must be the middle, {middle}", self.at);
                return Err(Error::unsupported(self.path, what));
            }
        }
        Ok(())
    }

    fn pose(&self, up: WorldUp) -> Result<[[f64; 3]; 4], Error> {
        let wrong = || self.broken("`transform_matrix` is no matrix of 4 rows of 4 numbers, the last of them 0 0 0 1");
        let rows = self.own.get("transform_matrix").and_then(Value::as_array).ok_or_else(wrong)?;
        let mut columns = [[0.0; 3]; 4];
        if !matches!(rows.len(), 3 | 4) {
            return Err(wrong());
        }
        for (i, row) in rows.iter().enumerate() {
            let row = row.as_array().filter(|row| row.len() == 4).ok_or_else(wrong)?;
            for (j, value) in row.iter().enumerate() {
                let value = value.as_f64().filter(|x| x.is_finite()).ok_or_else(wrong)?;
                match (i, j) {
                    (3, 0..=2) if value != 0.0 => return Err(wrong()),
                    (3, 3) if value != 1.0 => return Err(wrong()),
                    (3, _) => {}
                    _ => columns[j][i] = value,
                }
            }
        }
        Ok(columns.map(|column| up.gltf_of(column)))
    }

    /// The name of the image without folder and ending. Names may have dots: `r_0.5` ends in nothing that images end in.
    fn name(&self, k: usize) -> Result<String, Error> {
        let Some(path) = self.own.get("file_path") else { return Ok(format!("camera_{k:04}")) };
        let path = path.as_str().ok_or_else(|| self.broken("`file_path` is no text"))?;
        let file = path.rsplit(['/', '\\']).next().unwrap_or_default();
        let is_image = |ending: &str| IMAGES.iter().any(|known| ending.eq_ignore_ascii_case(known));
        let stem = file.rsplit_once('.').filter(|(_, ending)| is_image(ending)).map_or(file, |(stem, _)| stem);
        if stem.is_empty() || !crate::files::names::stays_inside(stem) {
            return Err(self.broken(&format!("`file_path` '{}' names no file", crate::shown(path))));
        }
        Ok(stem.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(value: &Value, size: Option<GridSize>) -> Result<CameraArray, Error> {
        CameraArray::from_json(value.to_string().as_bytes(), Path::new("t.json"), WorldUp::Z, size)
    }

    /// A camera at (1, 2, 3) of a world with Z up, which looks along +Y.
    fn matrix() -> Value {
        json!([[1, 0, 0, 1], [0, 0, -1, 2], [0, 1, 0, 3], [0, 0, 0, 1]])
    }

    /// Files have no "-0".
    #[test]
    fn no_zero_has_a_sign() {
        for turned in [WorldUp::Z.file_of([1.0, 2.0, 0.0]), WorldUp::Z.gltf_of([1.0, 0.0, 2.0])] {
            assert!(turned.iter().all(|x| x.is_sign_positive()), "{turned:?}");
        }
    }

    #[test]
    fn intrinsics_for_all_or_in_each() {
        let file = json!({ "camera_angle_x": 1.0, "w": 200, "h": 100, "frames": [
            { "file_path": "./train/r_0", "transform_matrix": matrix() },
            { "file_path": "images/b.png", "transform_matrix": matrix(), "fl_x": 300.5, "w": 50 },
            { "transform_matrix": matrix() } ] });
        let array = read(&file, None).expect("cameras");
        let names: Vec<&str> = array.cameras.iter().map(|camera| camera.name.as_str()).collect();
        assert_eq!(names, ["r_0", "b", "camera_0002"]);
        assert_eq!(array.cameras[0].focal_px, 100.0 / 0.5_f64.tan());
        assert_eq!((array.cameras[1].focal_px, array.cameras[1].size), (300.5, Some(GridSize::new(100, 50))));
        // In glTF's world it stands at (1, 3, -2), its back towards +Z.
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 3.0, -2.0]];
        assert_eq!(array.cameras[0].axes_and_position, columns);
    }

    #[test]
    fn names_may_have_dots() {
        for (path, name) in [
            ("images/a.b", "a.b"),
            ("images/a.b.png", "a.b"),
            ("r_0.5", "r_0.5"),
            ("IMG_1.JPG", "IMG_1"),
            ("..\\a.exr.d", "a.exr.d"),
        ] {
            let file = json!({ "fl_x": 100, "frames": [{ "file_path": path, "transform_matrix": matrix() }] });
            assert_eq!(read(&file, None).expect(path).cameras[0].name, name);
        }
    }

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("transforms.json");
        let camera = |k: usize| ArrayCamera {
            name: format!("view.{k}"),
            axes_and_position: [
                [0.1 + k as f64, 0.2, 0.3],
                [1.0 / 3.0, 0.7, -0.1],
                [0.0, 1e-17, 1.0],
                [1e6 / 3.0, -2.5, 0.0],
            ],
            focal_px: 1_234.567_890_123,
            size: Some(GridSize::new(30, 40 + k)),
            gain: [[1.0; 3], [0.9, 1.0, 1.0 / 3.0]][k % 2],
            time_s: 0.1 * k as f64,
        };
        let array = CameraArray { cameras: (0..3).map(camera).collect() };
        for up in [WorldUp::Z, WorldUp::Y] {
            array.write(&path, up).expect("written");
            assert_eq!(CameraArray::read(&path, up, None).expect("read"), array);
            array.write_folders(&path, up).expect("written");
            assert_eq!(CameraArray::read(&path, up, None).expect("read"), array);
        }
    }

    #[test]
    fn what_is_wrong_is_said() {
        let with = |change: &dyn Fn(&mut Value)| {
            let mut file = json!({ "fl_x": 100, "w": 20, "h": 10, "frames": [
                { "file_path": "a.png", "transform_matrix": matrix() } ] });
            change(&mut file);
            read(&file, None).expect_err("broken").to_string()
        };
        type Change<'a> = &'a dyn Fn(&mut Value);
        let cases: [(Change, &str); 18] = [
            (&|f| f["frames"] = json!([]), "empty"),
            (&|f| f["frames"] = json!(3), "frames"),
            (&|f| f["frames"][0]["transform_matrix"] = json!([1, 2]), "transform_matrix"),
            (&|f| f["frames"][0]["transform_matrix"][3] = json!([0, 0, 0, 2]), "transform_matrix"),
            (&|f| f["frames"][0]["transform_matrix"][0][0] = json!("x"), "transform_matrix"),
            (&|f| f["fl_x"] = json!(-1), "-1 px"),
            (&|f| f["fl_y"] = json!(90), "square"),
            (&|f| f["cx"] = json!(12), "`cx` is 12"),
            (&|f| f["k1"] = json!(0.1), "distortion"),
            (&|f| f["gain"] = json!([1, 2]), "`gain`"),
            (&|f| f["frames"][0]["gain"] = json!(0), "`gain`"),
            (&|f| f["frames"][0]["time_s"] = json!("late"), "`time_s`"),
            (&|f| f["camera_model"] = json!("OPENCV_FISHEYE"), "no pinhole"),
            (&|f| f["is_fisheye"] = json!(true), "no pinhole"),
            (&|f| f["w"] = json!(1.5), "size"),
            (&|f| f["frames"][0]["file_path"] = json!(".."), "names no file"),
            (&|f| f["frames"][0]["file_path"] = json!("a/.png"), "names no file"),
            (&|f| f["frames"] = json!([f["frames"][0], f["frames"][0]]), "two frames"),
        ];
        for (change, part) in cases {
            let message = with(change);
            assert!(message.contains(part), "no '{part}' in {message}");
        }
        let angle = json!({ "camera_angle_x": 1.0, "frames": [{ "transform_matrix": matrix() }] });
        let message = read(&angle, None).expect_err("no size").to_string();
        assert!(message.contains("`w` and `h`") && message.contains("`lenses=WIDTHxHEIGHT`"), "{message}");
        assert!(read(&angle, Some(GridSize::new(10, 20))).is_ok());
    }
}
