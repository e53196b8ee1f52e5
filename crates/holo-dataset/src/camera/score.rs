//! How well a calibrated camera is the true one, by the corners of boards.

mod pose;

use std::collections::BTreeMap;
use std::path::Path;

use holo_core::plenoptic::{Microlens, MicrolensIndex, PlenopticCamera};
use holo_io::interop::LensletGridModel;
use holo_io::{CameraFile, Folder};

use self::pose::{Movement, Sight};
use super::quantity::NamedQuantity;
use super::quantity::QuantityValue::{Count, List, Number};
use crate::Error;
use crate::output::raw::{CAMERA_TOML, first_indices};

/// The largest table of corners, bytes.
const MAX_BYTES: u64 = 1 << 30;

/// A corner in a micro-image.
pub(super) struct Corner {
    pub lens: MicrolensIndex,
    /// Pixels, whose centers are at 0.5.
    pub position_px: [f64; 2],
    /// The signed radius of its blur.
    pub blur_px: f64,
    /// Frame and number of the corner.
    pub cluster: [usize; 2],
    /// Meters before the camera that looks along -z.
    point_m: [f64; 3],
}

/// Root mean square, and largest, of some lengths.
#[derive(Default)]
struct Spread {
    count: usize,
    squares: f64,
    most: f64,
}

impl Spread {
    fn add(&mut self, length: f64) {
        self.count += 1;
        self.squares += length * length;
        self.most = self.most.max(length);
    }

    fn rms_and_most(&self) -> Vec<f64> {
        vec![(self.squares / self.count as f64).sqrt(), self.most]
    }
}

/// Returns how well `result` is the camera of a folder that [`TargetJob`](super::TargetJob) wrote: its numbers beside the true ones,
/// the centers of its micro-images and microlenses, where it sees the corners of the boards, and the depths that it finds from them.
///
/// A microlens is compared with that whose micro-image is nearest. The calibrated camera is moved to where it sees the corners best, as no
/// calibration knows where a camera stands. A corner's depth is that where its chief rays, through all microlenses that see it, are
/// nearest to each other.
///
/// # Errors
/// [`Error::Io`] if a file of the folder cannot be read; [`Error::BadRequest`] if the sensors differ; [`Error::Failed`] if the table
/// of corners is damaged or has none.
pub fn calibration_score(result: &CameraFile, truth: &Path) -> Result<Vec<NamedQuantity>, Error> {
    let folder = Folder::open(truth)?;
    let truth = CameraFile::read_in(&folder, CAMERA_TOML)?.camera;
    let (result, size) = (&result.camera, truth.sensor().size);
    if result.sensor().size != size {
        let found = result.sensor().size;
        return Err(Error::BadRequest(format!(
            "the calibrated camera has {} x {} px, and the true one {} x {}",
            found.columns, found.rows, size.columns, size.rows
        )));
    }
    let corners = read_corners(&folder, &truth)?;
    let mut rows = numbers(result, &truth);
    let mut row = |key: &str, name: &str, value, unit| rows.push(NamedQuantity::new(key, name, value, unit));
    let (on_sensor, on_array) = centers(result, &truth);
    row("microlenses", "microlenses", Count(on_sensor.count), "");
    row("centers_px", "micro-image centers: error, RMS and largest", List(on_sensor.rms_and_most()), "px");
    row("centers_um", "microlens centers: error, RMS and largest", List(on_array.rms_and_most()), "\u{b5}m");
    let sight = |corner: &Corner| {
        let lens = same_lens(result, &truth, corner.lens).index;
        Sight { point_m: corner.point_m, lens, position_px: corner.position_px }
    };
    let sights: Vec<Sight> = corners.iter().map(sight).collect();
    let movement = Movement::best(result, &sights);
    let (mut seen, mut rays) = (Spread::default(), BTreeMap::<[usize; 2], Vec<[f64; 4]>>::new());
    let mut depths = BTreeMap::new();
    for (corner, sight) in corners.iter().zip(&sights) {
        let point_m = movement.of(corner.point_m);
        if let Some(found) = result.project(point_m, sight.lens) {
            let [x, y] = [0, 1].map(|k| found.position_px[k] - corner.position_px[k]);
            seen.add(x.hypot(y));
        }
        let center_m = result.lens_center_m(sight.lens);
        if let Some(ray) = result.ray(result.place_m(corner.position_px), center_m, sight.lens) {
            let [[x, y], [dx, dy]] = [ray.origin_m, ray.direction];
            rays.entry(corner.cluster).or_default().push([x, y, dx, dy]);
            depths.insert(corner.cluster, -point_m[2]);
        }
    }
    row("moved_mm", "camera moved to see the corners best", Number(1e3 * movement.length_m()), "mm");
    row("turned_deg", "and turned", Number(movement.angle_deg()), "degrees");
    row("corners", "corners in micro-images", Count(corners.len()), "");
    row("reprojection_px", "true corners in the images: error, RMS and largest", List(seen.rms_and_most()), "px");
    let mut errors: Vec<f64> = Vec::new();
    for (cluster, rays) in &rays {
        let depth_m = meeting_depth_m(rays).filter(|depth_m| depth_m.is_finite());
        errors.extend(depth_m.map(|depth_m| depth_m / depths[cluster] - 1.0));
    }
    let (count, sum) = (errors.len() as f64, errors.iter().sum::<f64>());
    let rms = (errors.iter().map(|x| x * x).sum::<f64>() / count).sqrt();
    row("depths", "corners with a depth", Count(errors.len()), "");
    row("depth_bias", "depth of corners: mean error", Number(100.0 * sum / count), "%");
    row("depth_rms", "depth of corners: error, RMS", Number(100.0 * rms), "%");
    Ok(rows)
}

/// Returns how well a grid of micro-images is that of the camera of a folder that [`TargetJob`](super::TargetJob) wrote: its numbers
/// beside the true ones, and its centers, each compared with the nearest micro-image of the camera that lies on the sensor as a whole.
///
/// # Errors
/// [`Error::Io`] if the camera of the folder cannot be read; [`Error::Failed`] if no micro-image of the grid lies on the sensor.
pub fn grid_score(grid: &LensletGridModel, truth: &Path) -> Result<Vec<NamedQuantity>, Error> {
    let truth = CameraFile::read_in(&Folder::open(truth)?, CAMERA_TOML)?.camera;
    let mut rows = Vec::new();
    if let Ok(own) = LensletGridModel::new(&truth) {
        let both = |key: &str, name: &str, value: &dyn Fn(&LensletGridModel) -> f64, unit| {
            NamedQuantity::new(key, format!("{name}: found, true"), List(vec![value(grid), value(&own)]), unit)
        };
        rows.push(both("h_spacing_px", "distance of micro-images in a row", &|grid| grid.h_spacing, "px"));
        rows.push(both("v_spacing_px", "distance of rows", &|grid| grid.v_spacing, "px"));
        rows.push(both("rotation_deg", "rotation of the grid", &|grid| -grid.rot.to_degrees(), "degrees"));
    }
    let (mut spread, size) = (Spread::default(), truth.sensor().size);
    let reach = truth.micro_image_pitch_px() / 2.0;
    for center in grid.centers_px() {
        let expected = truth.micro_image_center_px(truth.owner(truth.place_m(center)));
        let is_inside = |x: f64, count: usize| x >= reach && x + reach <= count as f64;
        if is_inside(expected[0], size.columns) && is_inside(expected[1], size.rows) {
            spread.add((center[0] - expected[0]).hypot(center[1] - expected[1]));
        }
    }
    if spread.count == 0 {
        return Err(Error::Failed("no micro-image of the grid lies on the sensor of the true camera".into()));
    }
    let mut row = |key: &str, name: &str, value, unit| rows.push(NamedQuantity::new(key, name, value, unit));
    row("microlenses", "microlenses", Count(spread.count), "");
    row("centers_px", "micro-image centers: error, RMS and largest", List(spread.rms_and_most()), "px");
    Ok(rows)
}

/// The numbers of both cameras.
fn numbers(result: &PlenopticCamera, truth: &PlenopticCamera) -> Vec<NamedQuantity> {
    let both = |key: &str, name: &str, value: &dyn Fn(&PlenopticCamera) -> f64, unit| {
        NamedQuantity::new(key, format!("{name}: found, true"), List(vec![value(result), value(truth)]), unit)
    };
    let mut rows = vec![
        both("focal_length_mm", "focal length", &|camera| camera.main_lens().focal_length_m * 1e3, "mm"),
        both("f_number", "f-number", &|camera| camera.main_lens().f_number, ""),
        both("mla_distance_mm", "main lens from the array (D)", &|camera| camera.mla_distance_m() * 1e3, "mm"),
        both("exit_pupil_mm", "exit pupil from the array (D_X)", &|camera| camera.exit_pupil_m() * 1e3, "mm"),
        both("focus_m", "focus distance", &|camera| 1.0 / camera.inverse_focus_per_m(), "m"),
        both("gap_mm", "gap between array and sensor", &|camera| camera.array().gap_m * 1e3, "mm"),
        both("pitch_um", "pitch of the microlenses", &|camera| camera.array().pitch_m * 1e6, "\u{b5}m"),
        both("rotation_deg", "rotation of the array", &|camera| camera.array().rotation_rad.to_degrees(), "degrees"),
        both(
            "tilt_x_deg",
            "tilt of the array to the right",
            &|camera| camera.array().tilt_rad[0].to_degrees(),
            "degrees",
        ),
        both("tilt_y_deg", "tilt of the array up", &|camera| camera.array().tilt_rad[1].to_degrees(), "degrees"),
    ];
    if result.array().type_count() == truth.array().type_count() {
        rows.extend((0..truth.array().type_count()).map(|k| {
            let lens_type = same_type(result, truth, k);
            let lengths = [result.microlens_focal_lengths_m()[lens_type], truth.microlens_focal_lengths_m()[k]];
            let name = format!("focal length of microlenses of type {k}: found, true");
            NamedQuantity::new(format!("microlens_{k}_um"), name, List(lengths.map(|m| 1e6 * m).to_vec()), "\u{b5}m")
        }));
    }
    rows
}

/// The errors of the centers of micro-images, px, and of microlenses, um.
fn centers(result: &PlenopticCamera, truth: &PlenopticCamera) -> (Spread, Spread) {
    let (mut on_sensor, mut on_array) = (Spread::default(), Spread::default());
    let size = truth.sensor().size;
    let rows = 0..size.rows;
    for line in truth.lens_lines(rows.clone()) {
        for index in truth.lenses_on_line(line, rows.clone()) {
            let expected = truth.micro_image_center_px(index);
            let is_inside = expected[0] >= 0.0
                && expected[1] >= 0.0
                && expected[0] < size.columns as f64
                && expected[1] < size.rows as f64;
            if !is_inside {
                continue;
            }
            let found = same_lens(result, truth, index);
            let position = result.position_px(found.image_center_m);
            on_sensor.add((position[0] - expected[0]).hypot(position[1] - expected[1]));
            let center = truth.lens_center_m(index);
            on_array.add(1e6 * (found.center_m[0] - center[0]).hypot(found.center_m[1] - center[1]));
        }
    }
    (on_sensor, on_array)
}

/// The microlens of the result whose micro-image is that of a microlens of the true camera.
fn same_lens(result: &PlenopticCamera, truth: &PlenopticCamera, index: MicrolensIndex) -> Microlens {
    let place = result.place_m(truth.micro_image_center_px(index));
    result.microlens(result.owner(place))
}

/// What the type of a microlens is in the result: the first microlens counts from another place there.
fn same_type(result: &PlenopticCamera, truth: &PlenopticCamera, lens_type: usize) -> usize {
    let middle = truth.owner([0.0; 2]);
    let mut beside = (0..3).map(|k| MicrolensIndex { column: middle.column + k, ..middle });
    let lens = beside.find(|lens| truth.array().type_of(*lens) == lens_type).unwrap_or(middle);
    same_lens(result, truth, lens).lens_type
}

/// The depth at which rays (x, y, dx/dz, dy/dz) are nearest to their mean; `None` if they are parallel.
fn meeting_depth_m(rays: &[[f64; 4]]) -> Option<f64> {
    let count = rays.len() as f64;
    let mean: [f64; 4] = std::array::from_fn(|k| rays.iter().map(|ray| ray[k]).sum::<f64>() / count);
    let (mut mixed, mut squares) = (0.0, 0.0);
    for ray in rays {
        let [x, y, dx, dy]: [f64; 4] = std::array::from_fn(|k| ray[k] - mean[k]);
        mixed += x * dx + y * dy;
        squares += dx * dx + dy * dy;
    }
    // Of two rays at least.
    (squares > 0.0 && rays.len() > 1).then(|| -mixed / squares)
}

/// The visible corners of a folder of boards.
pub(super) fn read_corners(folder: &Folder, truth: &PlenopticCamera) -> Result<Vec<Corner>, Error> {
    const NAME: &str = "corners.csv";
    let bytes = folder.read(NAME, MAX_BYTES)?;
    let text = String::from_utf8_lossy(&bytes);
    let (first_row, first_column) = first_indices(truth);
    let mut out = Vec::new();
    for (line, text) in text.lines().enumerate().skip(1) {
        let numbers: Option<Vec<f64>> = text.split(',').map(|cell| cell.trim().parse().ok()).collect();
        let Some(&[k, l, u, v, blur_px, cluster, frame, x, y, z, _, visible]) = numbers.as_deref() else {
            let why = format!("{}: line {}: a corner has twelve numbers", folder.path_of(NAME).display(), line + 1);
            return Err(Error::Failed(why));
        };
        if visible == 0.0 {
            continue;
        }
        out.push(Corner {
            lens: MicrolensIndex { row: l as i32 + first_row, column: k as i32 + first_column },
            position_px: [u + 0.5, v + 0.5],
            blur_px,
            cluster: [frame as usize, cluster as usize],
            point_m: [x, y, z],
        });
    }
    if out.is_empty() {
        return Err(Error::Failed(format!("{}: it has no visible corner", folder.path_of(NAME).display())));
    }
    Ok(out)
}
