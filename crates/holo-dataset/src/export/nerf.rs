//! Images of pinhole cameras as radiance fields are trained on them.
//!
//! | target | files |
//! |---|---|
//! | `nerf` | `transforms_train.json`, `transforms_test.json` (every eighth image), `images/NAME.png`, `points3d.ply` |
//! | `nerfstudio` | `transforms.json`, `images/NAME.png`, `points3d.ply` |
//!
//! The input is a folder of `holo render --transforms`. Its cameras are in the world of its `transforms.json`, and so are the
//! points: places of pixels by their depth, with their colors, where the folder has depth.

use std::path::Path;

use holo_core::{DynImage, GridSize, Sample, for_each_sample};
use holo_io::{ArrayCamera, CameraArray, Folder, Limits, WorldUp};
use serde_json::{Value, json};

use super::{ExportTarget, Writer};
use crate::Error;
use crate::output::{OutputFolder, TRANSFORMS};

pub(super) const NERF: ExportTarget = ExportTarget {
    name: "nerf",
    help: "3D Gaussian splatting, instant-ngp, NeRF: transforms_train.json and transforms_test.json",
    usage: "Programs take this folder as their source (`train.py -s` of 3D Gaussian splatting).",
    writer: Writer::Pinholes(|folder, input| write(folder, input, write_splits)),
};

pub(super) const NERFSTUDIO: ExportTarget = ExportTarget {
    name: "nerfstudio",
    help: "nerfstudio: transforms.json with intrinsics, and points",
    usage: "ns-train takes this folder as --data.",
    writer: Writer::Pinholes(|folder, input| write(folder, input, write_list)),
};

const TRAIN: &str = "transforms_train.json";
const TEST: &str = "transforms_test.json";
const POINTS: &str = "points3d.ply";

/// Every so many images one is for tests, as readers of other sets do it.
const TEST_EVERY: usize = 8;

/// About so many points are made of all images.
const MANY_POINTS: usize = 100_000;

/// A point with its color.
type ColoredPoint = ([f32; 3], [u8; 3]);

/// Writes the lists of cameras; the text names the points, if there are some.
type WriteCameras = fn(&mut OutputFolder, &Folder, &CameraArray, bool) -> Result<(), Error>;

fn write(out: &mut OutputFolder, input: &Path, write_cameras: WriteCameras) -> Result<usize, Error> {
    let folder = Folder::open(input)?;
    // Numbers stay those of the file, whatever its axis is that points up.
    let array = CameraArray::read_in(&folder, TRANSFORMS, WorldUp::Y, None)?;
    let images = Images { folder, stride: stride(&array) };
    out.subfolder("images")?;
    let mut points = Vec::new();
    for camera in &array.cameras {
        let name = format!("images/{}.png", camera.name);
        let bytes = images.folder.read(&name, Limits::default().max_bytes)?;
        points.extend(images.points(camera, &bytes)?);
        out.add(name.clone(), holo_io::write_file(out.file(&name), &bytes)?);
    }
    if !points.is_empty() {
        out.add(POINTS, holo_io::write_file(out.file(POINTS), &ply(&points))?);
    }
    write_cameras(out, &images.folder, &array, !points.is_empty())?;
    Ok(array.cameras.len())
}

/// The pixels from one point to the next, along both axes.
fn stride(array: &CameraArray) -> usize {
    let pixels: usize = array.cameras.iter().filter_map(|camera| camera.size).map(GridSize::count).sum();
    ((pixels as f64 / MANY_POINTS as f64).sqrt().ceil() as usize).max(1)
}

/// The images of a folder.
struct Images {
    folder: Folder,
    stride: usize,
}

impl Images {
    /// The points that a camera sees; none without a map of depth.
    fn points(&self, camera: &ArrayCamera, image: &[u8]) -> Result<Vec<ColoredPoint>, Error> {
        let map = format!("depth/{}.pfm", camera.name);
        if !self.folder.path_of(&map).is_file() {
            return Ok(Vec::new());
        }
        let depth = holo_io::read_pfm_in(&self.folder, &map, &Limits::default())?.values;
        let color = holo_io::decode_png(image, &Limits::default())?;
        let (rows, columns, _) = depth.dim();
        let size = color.size();
        if (size.rows, size.columns) != (rows, columns) || color.channels() < 3 {
            let what = format!("{map} and the image have different sizes, or there are no colors");
            return Err(Error::Failed(format!("{}: {what}", self.folder.path().display())));
        }
        let [right, up, back, position] = camera.axes_and_position;
        let mut points = Vec::new();
        for v in (self.stride / 2..rows).step_by(self.stride) {
            for u in (self.stride / 2..columns).step_by(self.stride) {
                let z = f64::from(depth[[v, u, 0]]);
                if !z.is_finite() {
                    continue;
                }
                let x = (u as f64 + 0.5 - columns as f64 / 2.0) / camera.focal_px * z;
                let y = (rows as f64 / 2.0 - v as f64 - 0.5) / camera.focal_px * z;
                let place = std::array::from_fn(|i| (position[i] + x * right[i] + y * up[i] - z * back[i]) as f32);
                points.push((place, code(&color, v, u)));
            }
        }
        Ok(points)
    }
}

/// The color of a pixel in 8 bits.
fn code(image: &DynImage, v: usize, u: usize) -> [u8; 3] {
    fn of<T: Sample>(value: T, most: f64) -> u8 {
        (Sample::to_f64(value) * 255.0 / most).round() as u8
    }
    let most = if matches!(image, DynImage::U16(_)) { 65_535.0 } else { 255.0 };
    for_each_sample!(DynImage, image, image => std::array::from_fn(|c| of(image[[v, u, c]], most)))
}

/// Points as a binary PLY with normals of 0, which readers expect.
fn ply(points: &[ColoredPoint]) -> Vec<u8> {
    let mut out = format!("ply\nformat binary_little_endian 1.0\nelement vertex {}\n", points.len());
    ["x", "y", "z", "nx", "ny", "nz"].iter().for_each(|name| out.push_str(&format!("property float {name}\n")));
    ["red", "green", "blue"].iter().for_each(|name| out.push_str(&format!("property uchar {name}\n")));
    out.push_str("end_header\n");
    let mut out = out.into_bytes();
    for (place, color) in points {
        place.iter().for_each(|x| out.extend_from_slice(&x.to_le_bytes()));
        out.extend_from_slice(&[0; 12]);
        out.extend_from_slice(color);
    }
    out
}

/// The lists for training and for tests, with one angle of view for all.
fn write_splits(out: &mut OutputFolder, input: &Folder, array: &CameraArray, _: bool) -> Result<(), Error> {
    let bad = |what: &str| Error::BadRequest(format!("{}: {what}", input.path().display()));
    let first = &array.cameras[0];
    let is_one = array.cameras.iter().all(|camera| (camera.focal_px, camera.size) == (first.focal_px, first.size));
    let Some(size) = first.size.filter(|_| is_one) else {
        return Err(bad("the readers take one focal length and one size for all images; render such cameras"));
    };
    if array.cameras.len() < 2 {
        return Err(bad("one image is for training and one for tests; render two cameras or more"));
    }
    let angle = 2.0 * (size.columns as f64 / (2.0 * first.focal_px)).atan();
    for (name, is_test) in [(TRAIN, false), (TEST, true)] {
        let of_split = array.cameras.iter().enumerate().filter(|(k, _)| k.is_multiple_of(TEST_EVERY) == is_test);
        let frames: Vec<Value> = of_split.map(|(_, camera)| frame(camera)).collect();
        let root = json!({ "camera_angle_x": angle, "frames": frames });
        out.add(name, holo_io::write_file(out.file(name), format!("{root:#}\n").as_bytes())?);
    }
    Ok(())
}

/// A camera, whose image is named without its ending.
fn frame(camera: &ArrayCamera) -> Value {
    let columns = camera.axes_and_position;
    let mut rows: Vec<Vec<f64>> = (0..3).map(|row| columns.iter().map(|column| column[row]).collect()).collect();
    rows.push(vec![0.0, 0.0, 0.0, 1.0]);
    json!({ "file_path": format!("./images/{}", camera.name), "transform_matrix": rows })
}

/// The list of all cameras, as it is, with the name of the points.
fn write_list(out: &mut OutputFolder, input: &Folder, _: &CameraArray, has_points: bool) -> Result<(), Error> {
    let bytes = input.read(TRANSFORMS, Limits::default().max_bytes)?;
    let broken = |why: serde_json::Error| Error::Failed(format!("{}: {why}", input.path_of(TRANSFORMS).display()));
    let mut root: Value = serde_json::from_slice(&bytes).map_err(broken)?;
    if let (Some(object), true) = (root.as_object_mut(), has_points) {
        object.insert("ply_file_path".into(), POINTS.into());
    }
    out.add(TRANSFORMS, holo_io::write_file(out.file(TRANSFORMS), format!("{root:#}\n").as_bytes())?);
    Ok(())
}
