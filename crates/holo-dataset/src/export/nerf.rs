//! Images of pinhole cameras as radiance fields are trained on them.
//!
//! | target | files |
//! |---|---|
//! | `nerf` | `transforms_train.json`, `transforms_test.json` (every eighth image), `images/NAME.png`, `points3d.ply` |
//! | `nerfstudio` | `transforms.json`, `images/NAME.png`, `points3d.ply` |
//!
//! The input is a folder of `holo render --transforms`, whose cameras are in the world of its `transforms.json`, or a light
//! field: its views are cameras in the frame of the rig, `TTT_SSS`, with their principal points outside the middle if the focus is
//! finite. Points are places of pixels by their depth, with their colors: of all images of a folder, of the central view of a
//! light field.

use std::path::Path;

use holo_core::{ColorEncoding, DynImage, GridSize, Projection, Rig, Sample, for_each_sample};
use holo_io::{CameraArray, Compression, Folder, Limits, WorldUp};
use ndarray::ArrayView2;
use serde_json::{Value, json};

use super::source::LoadedField;
use super::{ExportTarget, Writer};
use crate::Error;
use crate::output::{OutputFolder, TRANSFORMS};

pub(super) const NERF: ExportTarget = ExportTarget {
    name: "nerf",
    help: "3D Gaussian splatting, instant-ngp, NeRF: transforms_train.json and transforms_test.json",
    usage: "Programs take this folder as their source (`train.py -s` of 3D Gaussian splatting).",
    has_groups: false,
    has_objects: false,
    writer: Writer::Posed(CameraLists { check: check_splits, write: write_splits }),
};

pub(super) const NERFSTUDIO: ExportTarget = ExportTarget {
    name: "nerfstudio",
    help: "nerfstudio: transforms.json with intrinsics, and points",
    usage: "ns-train takes this folder as --data.",
    has_groups: false,
    has_objects: false,
    writer: Writer::Posed(CameraLists { check: |_| Ok(()), write: write_list }),
};

const TRAIN: &str = "transforms_train.json";
const TEST: &str = "transforms_test.json";
const POINTS: &str = "points3d.ply";

/// Every so many images one is for tests, as readers of other sets do it.
const TEST_EVERY: usize = 8;

/// About so many points are made of all images with depth.
const MANY_POINTS: usize = 100_000;

/// How far the principal point may be from the middle for readers that have it there, px.
const MIDDLE_PX: f64 = 1e-6;

/// A point with its color.
type ColoredPoint = ([f32; 3], [u8; 3]);

/// A pinhole camera with its image.
pub(super) struct PosedCamera {
    /// The name of the image, without its ending.
    name: String,
    axes_and_position: [[f64; 3]; 4],
    focal_px: f64,
    /// The principal point from the upper left corner: right and down, px.
    center_px: [f64; 2],
    size: GridSize,
}

/// The lists of cameras that a program reads.
#[derive(Clone, Copy, Debug)]
pub(super) struct CameraLists {
    /// Refuses cameras that it cannot read.
    check: fn(&[PosedCamera]) -> Result<(), Error>,
    /// Writes the lists into a folder of the export, with `/` at its end, or `""`; the text names the points, if there are some.
    write: fn(&mut OutputFolder, &str, &[PosedCamera], bool) -> Result<(), Error>,
}

/// Writes the images of a folder; returns their number.
pub(super) fn write_folder(out: &mut OutputFolder, input: &Path, lists: CameraLists) -> Result<usize, Error> {
    let folder = Folder::open(input)?;
    // Numbers stay those of the file, whatever its axis is that points up.
    let array = CameraArray::read_in(&folder, TRANSFORMS, WorldUp::Y, None)?;
    let no_size =
        || Error::BadRequest(format!("{}: cameras have no size in pixels", folder.path_of(TRANSFORMS).display()));
    let mut cameras = Vec::new();
    for camera in array.cameras {
        let size = camera.size.ok_or_else(no_size)?;
        let center_px = [size.columns as f64 / 2.0, size.rows as f64 / 2.0];
        let (axes_and_position, focal_px) = (camera.axes_and_position, camera.focal_px);
        cameras.push(PosedCamera { name: camera.name, axes_and_position, focal_px, center_px, size });
    }
    (lists.check)(&cameras)?;
    out.subfolder("images")?;
    let stride = stride(cameras.iter().map(|camera| camera.size.count()).sum());
    let mut points = Vec::new();
    for camera in &cameras {
        let name = format!("images/{}.png", camera.name);
        let bytes = folder.read(&name, Limits::default().max_bytes)?;
        let map = format!("depth/{}.pfm", camera.name);
        if folder.path_of(&map).is_file() {
            let depth = holo_io::read_pfm_in(&folder, &map, &Limits::default())?.values;
            let color = holo_io::decode_png(&bytes[..], &Limits::default())?;
            if color.size() != camera.size
                || depth.dim() != (camera.size.rows, camera.size.columns, 1)
                || color.channels() < 3
            {
                let what = format!("{map}, the image and the camera have different sizes, or there are no colors");
                return Err(Error::Failed(format!("{}: {what}", folder.path().display())));
            }
            points.extend(camera.points(depth.index_axis(ndarray::Axis(2), 0), stride, |v, u| code(&color, v, u)));
        }
        out.add(name.clone(), holo_io::write_file(out.file(&name), &bytes)?);
    }
    finish(out, "", &cameras, &points, lists)
}

/// Writes the views of a light field into a folder of the export, with `/` at its end, or `""`; returns their number.
pub(super) fn write_field(
    out: &mut OutputFolder,
    inner: &str,
    loaded: &LoadedField,
    lists: CameraLists,
) -> Result<usize, Error> {
    let views = loaded.field.shape().views();
    let Some(rig) = loaded.rig.filter(|rig| rig.projection() == Projection::Perspective) else {
        return Err(loaded
            .lacks("it has no perspective rig, which places its views", "render it with `projection` perspective"));
    };
    let cameras: Vec<PosedCamera> =
        (0..views.count()).map(|k| camera_of_view(&rig, k / views.columns, k % views.columns)).collect();
    (lists.check)(&cameras)?;
    out.subfolder(&format!("{inner}images"))?;
    for (camera, (_, view)) in cameras.iter().zip(loaded.field.views()) {
        let name = format!("{inner}images/{}.png", camera.name);
        out.add(name.clone(), holo_io::write_png(out.file(&name), view, ColorEncoding::Srgb, Compression::Fast)?);
    }
    let (t, s) = (views.rows / 2, views.columns / 2);
    let mut points = Vec::new();
    if let (Some(depth), true) = (&loaded.depth_m, loaded.field.channels() >= 3) {
        let (central, stride) = (loaded.field.view(t, s)?, stride(depth.len()));
        points =
            cameras[t * views.columns + s].points(depth.view(), stride, |v, u| [0, 1, 2].map(|c| central[[v, u, c]]));
    }
    finish(out, inner, &cameras, &points, lists)
}

/// Returns the camera of a view, in the plane of the rig, which looks along -Z. By its principal point, every view sees a point of
/// the focus plane at the same pixel.
fn camera_of_view(rig: &Rig, t: usize, s: usize) -> PosedCamera {
    let (x, y, per_m) = (rig.view_x_m(s), rig.view_y_m(t), rig.inverse_focus_per_m());
    PosedCamera {
        name: format!("{t:03}_{s:03}"),
        axes_and_position: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [x, y, 0.0]],
        focal_px: rig.column(1.0) - rig.column(0.0),
        center_px: [rig.column(x * per_m), rig.row(y * per_m)],
        size: rig.shape().lenses(),
    }
}

/// Writes points and cameras; returns the number of cameras.
fn finish(
    out: &mut OutputFolder,
    inner: &str,
    cameras: &[PosedCamera],
    points: &[ColoredPoint],
    lists: CameraLists,
) -> Result<usize, Error> {
    if !points.is_empty() {
        let name = format!("{inner}{POINTS}");
        out.add(name.clone(), holo_io::write_file(out.file(&name), &ply(points))?);
    }
    (lists.write)(out, inner, cameras, !points.is_empty())?;
    Ok(cameras.len())
}

/// The pixels from one point to the next along both axes, for a number of pixels with depth.
fn stride(pixels: usize) -> usize {
    ((pixels as f64 / MANY_POINTS as f64).sqrt().ceil() as usize).max(1)
}

impl PosedCamera {
    /// The points that every so many pixels see.
    fn points(
        &self,
        depth: ArrayView2<f32>,
        stride: usize,
        color: impl Fn(usize, usize) -> [u8; 3],
    ) -> Vec<ColoredPoint> {
        let (rows, columns) = depth.dim();
        let [right, up, back, position] = self.axes_and_position;
        let mut points = Vec::new();
        for v in (stride / 2..rows).step_by(stride) {
            for u in (stride / 2..columns).step_by(stride) {
                let z = f64::from(depth[[v, u]]);
                if !z.is_finite() {
                    continue;
                }
                let x = (u as f64 + 0.5 - self.center_px[0]) / self.focal_px * z;
                let y = (self.center_px[1] - v as f64 - 0.5) / self.focal_px * z;
                let place = std::array::from_fn(|i| (position[i] + x * right[i] + y * up[i] - z * back[i]) as f32);
                points.push((place, color(v, u)));
            }
        }
        points
    }

    /// The matrix from the camera to the world.
    fn matrix(&self) -> Value {
        let columns = self.axes_and_position;
        let mut rows: Vec<Vec<f64>> = (0..3).map(|row| columns.iter().map(|column| column[row]).collect()).collect();
        rows.push(vec![0.0, 0.0, 0.0, 1.0]);
        json!(rows)
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

/// Refuses cameras of several kinds, and principal points outside the middle: the readers know one angle of view for all.
fn check_splits(cameras: &[PosedCamera]) -> Result<(), Error> {
    let bad = |what: &str| Err(Error::BadRequest(what.into()));
    let Some((first, others)) = cameras.split_first().filter(|(_, others)| !others.is_empty()) else {
        return bad("one image is for training and one for tests; render two cameras or more");
    };
    if others.iter().any(|camera| (camera.focal_px, camera.size) != (first.focal_px, first.size)) {
        return bad("the readers take one focal length and one size for all images; render such cameras");
    }
    let middle = [first.size.columns as f64 / 2.0, first.size.rows as f64 / 2.0];
    if cameras.iter().any(|camera| (0..2).any(|k| (camera.center_px[k] - middle[k]).abs() > MIDDLE_PX)) {
        return bad(
            "the readers have the principal point in the middle of an image, and views with a finite focus do not; render with \
             `focus-m` inf, or export for nerfstudio",
        );
    }
    Ok(())
}

/// The lists for training and for tests, with one angle of view for all.
fn write_splits(out: &mut OutputFolder, inner: &str, cameras: &[PosedCamera], _: bool) -> Result<(), Error> {
    let first = &cameras[0];
    let angle = 2.0 * (first.size.columns as f64 / (2.0 * first.focal_px)).atan();
    for (name, is_test) in [(TRAIN, false), (TEST, true)] {
        let of_split = cameras.iter().enumerate().filter(|(k, _)| k.is_multiple_of(TEST_EVERY) == is_test);
        let frame = |(_, camera): (usize, &PosedCamera)| {
            // Their images are named without their ending.
            json!({ "file_path": format!("./images/{}", camera.name), "transform_matrix": camera.matrix() })
        };
        let frames: Vec<Value> = of_split.map(frame).collect();
        write_json(out, &format!("{inner}{name}"), &json!({ "camera_angle_x": angle, "frames": frames }))?;
    }
    Ok(())
}

/// The list of all cameras, each with its intrinsics, and the name of the points.
fn write_list(out: &mut OutputFolder, inner: &str, cameras: &[PosedCamera], has_points: bool) -> Result<(), Error> {
    let frame = |camera: &PosedCamera| {
        json!({
            "file_path": format!("images/{}.png", camera.name),
            "fl_x": camera.focal_px, "fl_y": camera.focal_px,
            "cx": camera.center_px[0], "cy": camera.center_px[1],
            "w": camera.size.columns, "h": camera.size.rows,
            "transform_matrix": camera.matrix(),
        })
    };
    let frames: Vec<Value> = cameras.iter().map(frame).collect();
    let mut root = json!({ "camera_model": "PINHOLE", "frames": frames });
    if has_points {
        root["ply_file_path"] = POINTS.into();
    }
    write_json(out, &format!("{inner}{TRANSFORMS}"), &root)
}

fn write_json(out: &mut OutputFolder, name: &str, value: &Value) -> Result<(), Error> {
    out.add(name, holo_io::write_file(out.file(name), format!("{value:#}\n").as_bytes())?);
    Ok(())
}
