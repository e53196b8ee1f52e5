//! What the images of cameras anywhere make together: the image of one wide aperture, and views between the cameras.

use holo_core::refocus::{ApertureShape, FocalPlane, FocalSurface, Kernel, SyntheticAperture};
use holo_core::{
    Correspondence, Effort, GridSize, OffsetView, Pinhole, PlaneSweepOptions, PosedView, SynthesizedImage,
    ViewSynthesis, evenly_chosen_views, plane_sweep_of_views,
};
use holo_io::{ArrayFolder, Limits};
use holo_scene::Transform;
use ndarray::{Array2, Array3};

use crate::Error;
use crate::settings::Point;
use crate::shot::looking;

/// Where a view of an array stands and looks, in the world of glTF, m. What is not said is that of the camera of the array that is
/// nearest to it; without `eye` nearest to the middle of all.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ArrayViewpoint {
    /// Where it stands.
    pub eye: Option<[f64; 3]>,
    /// What it looks at.
    pub target: Option<[f64; 3]>,
    /// What is up in its image.
    pub up: Option<[f64; 3]>,
}

impl ArrayViewpoint {
    /// Returns the number of the camera that is nearest to the viewpoint; without `eye` to the middle of all.
    ///
    /// # Errors
    ///
    /// [`Error::BadRequest`] without cameras; those of [`ArrayFolder::pinhole`].
    pub fn nearest(&self, array: &ArrayFolder) -> Result<usize, Error> {
        let cameras = pinholes(array)?;
        let count = cameras.len();
        let at = self.eye.unwrap_or_else(|| {
            std::array::from_fn(|axis| {
                cameras.iter().map(|camera| camera.position_m()[axis]).sum::<f64>() / count as f64
            })
        });
        let away = |camera: &Pinhole| (0..3).map(|k| (camera.position_m()[k] - at[k]).powi(2)).sum::<f64>();
        // The first of equally near ones: rounding does not choose.
        let nearest = cameras.iter().map(away).fold(f64::INFINITY, f64::min) * (1.0 + 1e-9);
        let found = cameras.iter().position(|camera| away(camera) <= nearest);
        found.ok_or_else(|| Error::BadRequest(format!("{}: it has no cameras", array.folder().path().display())))
    }

    /// Returns the camera at the viewpoint, with the pixels and the focal length of the nearest camera of the array.
    ///
    /// # Errors
    ///
    /// [`Error::BadRequest`] if it looks nowhere, or upward along its line of sight; those of [`ArrayFolder::pinhole`].
    pub fn camera(&self, array: &ArrayFolder) -> Result<Pinhole, Error> {
        let base = array.pinhole(self.nearest(array)?)?;
        if (self.eye, self.target, self.up) == (None, None, None) {
            return Ok(base);
        }
        let eye = self.eye.unwrap_or(base.position_m());
        let ahead = |k: usize| eye[k] - base.axes()[2][k];
        let pose = match (self.target, self.up) {
            (None, None) => Transform { columns: base.axes(), translation: eye },
            (target, up) => looking(eye, target.unwrap_or_else(|| std::array::from_fn(ahead)), up.map(Point))?,
        };
        Ok(Pinhole::new(pose.columns, pose.translation, base.focal_px(), base.size())?)
    }
}

/// The cameras of an array.
fn pinholes(array: &ArrayFolder) -> Result<Vec<Pinhole>, Error> {
    Ok((0..array.cameras().len()).map(|k| array.pinhole(k)).collect::<Result<_, _>>()?)
}

/// Returns the image of a wide aperture around a view, sharp on a surface: the mean of the images of an array. Images are read one
/// by one. The shape of the aperture lies in the plane of the view and has its size in meters.
///
/// # Errors
///
/// [`Error::BadRequest`] if no camera lies within the aperture, or of several at most one sees anything of the surface; those of
/// [`SyntheticAperture`] and of reading images.
pub fn synthetic_aperture(
    array: &ArrayFolder,
    view: Pinhole,
    aperture: ApertureShape,
    kernel: Kernel,
    surface: FocalSurface<'_>,
) -> Result<Array3<f32>, Error> {
    let mut sum = SyntheticAperture::new(view, kernel);
    let (mut within, mut seeing) = (0, 0);
    for (k, camera) in pinholes(array)?.iter().enumerate() {
        let away: [f64; 3] = std::array::from_fn(|axis| camera.position_m()[axis] - view.position_m()[axis]);
        let along = |axis: [f64; 3]| (0..3).map(|k| axis[k] * away[k]).sum::<f64>();
        let [right, up, _] = view.axes();
        let weight = aperture.weight([along(up), along(right)]);
        if weight > 0.0 {
            let image = array.image(k, &Limits::default())?;
            sum.add(camera, image.view(), weight, surface)?;
            within += 1;
            seeing += usize::from(sees(camera, &image, &view, surface)?);
        }
    }
    if within == 0 {
        return Err(Error::BadRequest("no camera lies within the aperture around the view; make it wider".into()));
    }
    if seeing == 0 || seeing == 1 && within > 1 {
        return Err(Error::BadRequest(format!(
            "the {within} cameras within the aperture do not see the same surface: {seeing} of them see that of the view; give \
             another surface, or a view that they look at"
        )));
    }
    Ok(sum.image()?)
}

/// Whether a camera sees anything of a surface before a view, at up to 16 x 16 places of it.
fn sees(camera: &Pinhole, image: &Array3<f32>, view: &Pinhole, surface: FocalSurface<'_>) -> Result<bool, Error> {
    let size = view.size();
    let step = size.larger().div_ceil(16);
    let coarse = GridSize::new(size.rows.div_ceil(step), size.columns.div_ceil(step));
    let middle = view.principal_point().map(|at| (at + 0.5) / step as f64 - 0.5);
    let few = Pinhole::new(view.axes(), view.position_m(), view.focal_px() / step as f64, coarse)?;
    let mut sum = SyntheticAperture::new(few.with_principal_point(middle)?, Kernel::Bilinear);
    match surface {
        FocalSurface::Plane(plane) => sum.add(camera, image.view(), 1.0, plane)?,
        FocalSurface::Depth(depth_m) => {
            let at = |k: usize, count: usize| (step * k + step / 2).min(count - 1);
            let few = Array2::from_shape_fn((coarse.rows, coarse.columns), |(row, column)| {
                depth_m[[at(row, size.rows), at(column, size.columns)]]
            });
            sum.add(camera, image.view(), 1.0, few.view())?;
        }
    }
    Ok(sum.image()?.iter().any(|light| light.is_finite()))
}

/// Returns the view of a camera anywhere, from the images and the depths of the cameras of an array nearest to it. Only those are
/// read.
///
/// # Errors
///
/// [`Error::BadRequest`] if a camera has no depth, or none shows anything of the view; those of [`ViewSynthesis::at_camera`] and of
/// reading images.
pub fn synthesize_from_array(array: &ArrayFolder, view: &Pinhole, kernel: Kernel) -> Result<SynthesizedImage, Error> {
    let cameras = pinholes(array)?;
    let limits = Limits::default();
    let read = |k: usize| -> Result<(Pinhole, Array3<f32>, Array2<f32>), Error> {
        Ok((cameras[k], array.image(k, &limits)?, depth_m(array, k)?))
    };
    let near = ViewSynthesis::cameras_near(&cameras, view);
    let read = near.into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let posed: Vec<PosedView<'_, f32>> = read
        .iter()
        .map(|(camera, image, depth_m)| PosedView { camera: *camera, image: image.view(), depth_m: depth_m.view() })
        .collect();
    let made = ViewSynthesis::default().kernel(kernel).at_camera(&posed, view)?;
    if made.holes.iter().all(|&is_hole| is_hole) {
        return Err(Error::BadRequest(format!(
            "the {} cameras that are nearest to the view show none of its {} pixels; move it, or turn it to what they look at",
            posed.len(),
            made.holes.len()
        )));
    }
    Ok(made)
}

/// Returns where camera `to` of an array sees the points of the pixels of camera `from`, both counted from 0.
///
/// # Errors
///
/// [`Error::BadRequest`] if a camera has no depth, or both see the scene at different times; those of reading depths and of
/// [`Pinhole::correspondences`].
pub fn correspondences(array: &ArrayFolder, from: usize, to: usize) -> Result<Array2<Correspondence>, Error> {
    let ([first, second], maps) =
        ([array.pinhole(from)?, array.pinhole(to)?], [depth_m(array, from)?, depth_m(array, to)?]);
    if array.cameras()[from].time_s != array.cameras()[to].time_s {
        let [from, to] = [from, to].map(|k| holo_core::visible(&array.cameras()[k].name));
        let what = format!("cameras '{from}' and '{to}' see the scene at different times, so points may have moved");
        return Err(Error::BadRequest(what));
    }
    Ok(first.correspondences(&maps[0], &second, &maps[1])?)
}

/// The depth of camera `k`, which must be there.
fn depth_m(array: &ArrayFolder, k: usize) -> Result<Array2<f32>, Error> {
    array.depth_m(k, &Limits::default())?.ok_or_else(|| {
        let name = holo_core::visible(&array.cameras()[k].name);
        Error::BadRequest(format!(
            "{}: camera '{name}' has no depth; render the array with the layer `depth`, of light fields with the truth of all views",
            array.folder().path().display()
        ))
    })
}

/// How far the corners of an image may move because a camera stands before or behind the plane of the others, px.
const OUT_OF_PLANE_PX: f64 = 0.5;

/// The value of pixels that a turned camera does not see: far from every color.
const UNSEEN: f32 = 1e9;

/// The depth of a camera of an array, estimated from the others.
#[derive(Debug, Clone, PartialEq)]
pub struct ArrayDepth {
    /// Planar depth, m; axes (row, column).
    pub depth_m: Array2<f32>,
    /// From 0 to 1; axes (row, column).
    pub confidence: Array2<f32>,
    /// How many others in a plane with the camera it is from.
    pub others: usize,
}

/// Estimates the depth of camera `k` of an array between two depths, in meters; the farther one may be infinite. Cameras that stand in
/// a plane with it are turned to its direction and its focal length; those that do not are left out.
///
/// # Errors
///
/// [`Error::BadRequest`] if the range is empty, if all other cameras stand out of the plane, or if those in the plane look away; the
/// errors of [`plane_sweep_of_views`] and of reading images.
pub fn estimate_depth(
    array: &ArrayFolder,
    k: usize,
    [near_m, far_m]: [f64; 2],
    effort: Effort,
) -> Result<ArrayDepth, Error> {
    if !(near_m > 0.0 && near_m.is_finite() && far_m > near_m) {
        return Err(Error::BadRequest(format!(
            "depths from {near_m} to {far_m} m are no range; give the nearer one first"
        )));
    }
    let view = array.pinhole(k)?;
    let others = others_in_plane(array, k, &view, near_m)?;
    let widest_m = others.iter().map(|other| other.sideways_m).fold(0.0, f64::max);
    // Of many only those that the estimate takes are read.
    let places: Vec<[f64; 2]> = others.iter().map(|other| other.place_m).collect();
    let others: Vec<_> = evenly_chosen_views(&places, effort).into_iter().map(|k| &others[k]).collect();
    // Disparities and confidences are those of a grid of 9 x 9 cameras as wide.
    let base_m = widest_m / 4.0;
    let limits = Limits::default();
    let central = array.image(k, &limits)?;
    let mut images = Vec::new();
    for other in &others {
        images.push(turned(array.image(other.index, &limits)?, &other.camera, &view)?);
    }
    let placed: Vec<OffsetView<'_, f32>> = others
        .iter()
        .zip(&images)
        .map(|(other, image)| OffsetView {
            down: other.place_m[0] / base_m,
            right: other.place_m[1] / base_m,
            image: image.view(),
        })
        .collect();
    // A point at depth z moves by this over z for every base.
    let scale = view.focal_px() * base_m;
    let options = PlaneSweepOptions::default().range_px((scale / far_m) as f32, (scale / near_m) as f32).effort(effort);
    let estimate = plane_sweep_of_views(central.view(), &placed, &options)?;
    let depth_m = estimate.disparity_px.mapv_into(|disparity_px| (scale / f64::from(disparity_px)) as f32);
    Ok(ArrayDepth { depth_m, confidence: estimate.confidence, others: others.len() })
}

/// A camera beside another one.
struct Other {
    index: usize,
    camera: Pinhole,
    /// Its offset from the view: down and to the right in the image, m.
    place_m: [f64; 2],
    /// The length of the offset, m.
    sideways_m: f64,
}

/// The cameras that stand in a plane with the view of camera `k` and look to the same side: at least one.
fn others_in_plane(array: &ArrayFolder, k: usize, view: &Pinhole, near_m: f64) -> Result<Vec<Other>, Error> {
    let [right, up, back] = view.axes();
    let (mut others, mut turned_away) = (Vec::new(), 0);
    let (mut least_px, corner_px) = (f64::INFINITY, view.size().larger() as f64 / 2.0);
    for (index, camera) in pinholes(array)?.into_iter().enumerate() {
        let away: [f64; 3] = std::array::from_fn(|axis| camera.position_m()[axis] - view.position_m()[axis]);
        let along = |axis: [f64; 3]| (0..3).map(|k| axis[k] * away[k]).sum::<f64>();
        let place_m = [-along(up), along(right)];
        let sideways_m = place_m[0].hypot(place_m[1]);
        if index == k || sideways_m == 0.0 {
            continue;
        }
        let moved_px = along(back).abs() / near_m * corner_px;
        least_px = least_px.min(moved_px);
        match moved_px <= OUT_OF_PLANE_PX {
            true if looks_away(&camera, view) => turned_away += 1,
            true => others.push(Other { index, camera, place_m, sideways_m }),
            false => {}
        }
    }
    if !others.is_empty() {
        return Ok(others);
    }
    let name = holo_core::visible(&array.cameras()[k].name);
    Err(Error::BadRequest(if turned_away > 0 {
        format!(
            "the {turned_away} other cameras in its plane see nothing of what camera '{name}' does: they look away; choose another camera"
        )
    } else {
        format!(
            "no other camera stands in the plane of camera '{name}'. The camera nearest to that plane moves the corners of the image by \
             {least_px:.1} px at {near_m} m; depth needs at most {OUT_OF_PLANE_PX} px: choose another camera, or a near depth farther away"
        )
    }))
}

/// Whether a camera sees none of the directions that a view looks at.
fn looks_away(camera: &Pinhole, view: &Pinhole) -> bool {
    const PLACES: usize = 16;
    let size = view.size();
    let place = |k: usize, count: usize| (k as f64 + 0.5) * count as f64 / PLACES as f64 - 0.5;
    let is_seen = |k: usize| {
        let direction = view.direction([place(k / PLACES, size.rows), place(k % PLACES, size.columns)]);
        let far: [f64; 3] = std::array::from_fn(|axis| camera.position_m()[axis] + direction[axis]);
        let inside = |at: f64, count: usize| (-0.5..count as f64 - 0.5).contains(&at);
        let GridSize { rows, columns } = camera.size();
        camera.place_of(far).is_some_and(|([row, column], _)| inside(row, rows) && inside(column, columns))
    };
    !(0..PLACES * PLACES).any(is_seen)
}

/// The image of a camera as one at its place sees it that looks as another one does.
fn turned(image: Array3<f32>, camera: &Pinhole, like: &Pinhole) -> Result<Array3<f32>, Error> {
    let there = Pinhole::new(like.axes(), camera.position_m(), like.focal_px(), like.size())?
        .with_principal_point(like.principal_point())?;
    if there == *camera {
        return Ok(image);
    }
    let mut sum = SyntheticAperture::new(there, Kernel::default());
    sum.add(camera, image.view(), 1.0, FocalSurface::Plane(FocalPlane::new(f64::INFINITY)?))?;
    Ok(sum.image()?.mapv_into(|light| if light.is_finite() { light } else { UNSEEN }))
}
