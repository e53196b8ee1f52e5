//! What the images of cameras anywhere make together: the image of one wide aperture, and views between the cameras.

use holo_core::refocus::{ApertureShape, FocalSurface, Kernel, SyntheticAperture};
use holo_core::{Pinhole, PosedView, SynthesizedImage, ViewSynthesis};
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
    /// Returns the camera at the viewpoint, with the pixels and the focal length of the nearest camera of the array.
    ///
    /// # Errors
    ///
    /// [`Error::BadRequest`] if it looks nowhere, or upward along its line of sight; those of [`ArrayFolder::pinhole`].
    pub fn camera(&self, array: &ArrayFolder) -> Result<Pinhole, Error> {
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
        let Some(base) = cameras.iter().find(|camera| away(camera) <= nearest) else {
            return Err(Error::BadRequest(format!("{}: it has no cameras", array.folder().path().display())));
        };
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
/// [`Error::BadRequest`] if no camera lies within the aperture; those of [`SyntheticAperture`] and of reading images.
pub fn synthetic_aperture(
    array: &ArrayFolder,
    view: Pinhole,
    aperture: ApertureShape,
    kernel: Kernel,
    surface: FocalSurface<'_>,
) -> Result<Array3<f32>, Error> {
    let mut sum = SyntheticAperture::new(view, kernel);
    let mut is_empty = true;
    for (k, camera) in pinholes(array)?.iter().enumerate() {
        let away: [f64; 3] = std::array::from_fn(|axis| camera.position_m()[axis] - view.position_m()[axis]);
        let along = |axis: [f64; 3]| (0..3).map(|k| axis[k] * away[k]).sum::<f64>();
        let [right, up, _] = view.axes();
        let weight = aperture.weight([along(up), along(right)]);
        if weight > 0.0 {
            let image = array.image(k, &Limits::default())?;
            sum.add(camera, image.view(), weight, surface)?;
            is_empty = false;
        }
    }
    if is_empty {
        return Err(Error::BadRequest("no camera lies within the aperture around the view; make it wider".into()));
    }
    Ok(sum.image()?)
}

/// Returns the view of a camera anywhere, from the images and the depths of the cameras of an array nearest to it. Only those are
/// read.
///
/// # Errors
///
/// [`Error::BadRequest`] if a camera has no depth; those of [`ViewSynthesis::at_camera`] and of reading images.
pub fn synthesize_from_array(array: &ArrayFolder, view: &Pinhole, kernel: Kernel) -> Result<SynthesizedImage, Error> {
    let cameras = pinholes(array)?;
    let limits = Limits::default();
    let read = |k: usize| -> Result<(Pinhole, Array3<f32>, Array2<f32>), Error> {
        let depth_m = array.depth_m(k, &limits)?.ok_or_else(|| {
            let name = holo_core::visible(&array.cameras()[k].name);
            Error::BadRequest(format!(
                "{}: camera '{name}' has no depth; render the array with the layer `depth`",
                array.folder().path().display()
            ))
        })?;
        Ok((cameras[k], array.image(k, &limits)?, depth_m))
    };
    let near = ViewSynthesis::cameras_near(&cameras, view);
    let read = near.into_iter().map(read).collect::<Result<Vec<_>, _>>()?;
    let posed: Vec<PosedView<'_, f32>> = read
        .iter()
        .map(|(camera, image, depth_m)| PosedView { camera: *camera, image: image.view(), depth_m: depth_m.view() })
        .collect();
    Ok(ViewSynthesis::default().kernel(kernel).at_camera(&posed, view)?)
}
