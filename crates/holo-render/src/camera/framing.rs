//! Framing: derives a rig from a camera of the scene.
//!
//! A glTF camera has a pose and a field of view. Sensor size, baseline and focus distance come from the caller or from
//! the rules stated here.

mod aspect;
mod default_camera;

use holo_core::{GridSize, Intrinsics, LightFieldShape, Projection, Rig, automatic_baseline_m, shown};

use crate::error::Error;
use holo_scene::{Camera, CameraProjection, Scene, Transform};

pub use self::aspect::AspectChange;

/// The parameters of a rig apart from its focus distance; see [`Framing::new`] for the defaults.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Framing {
    /// View counts and spatial resolution (views and lenses).
    pub shape: LightFieldShape,
    /// The camera of the scene.
    pub camera: CameraChoice,
    /// Focal length, m; `None`: from the field of view of the camera.
    pub focal_length_m: Option<f64>,
    /// Length of the larger image side on the sensor, m.
    pub sensor_size_m: f64,
    /// Distance between adjacent views.
    pub baseline: Baseline,
    /// Projection of the views.
    pub projection: Projection,
}

/// The choice of a camera of the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CameraChoice {
    /// The first camera in node order; for a scene without cameras, a three-quarter view of the whole scene.
    #[default]
    First,
    /// By index in [`Scene::cameras`].
    Index(usize),
    /// By name.
    Name(String),
}

/// The distance between adjacent views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Baseline {
    /// The views sample the aperture of an f/N lens: focal length / N / (views - 1), with the larger of the two view
    /// counts.
    FNumber(f64),
    /// In meters, the same along both axes.
    Meters(f64),
}

/// A camera pose with intrinsics and baseline; the focus distance is still open.
#[derive(Clone, Debug)]
pub struct Framed {
    /// Camera to world coordinates.
    pub pose: Transform,
    /// Focal length and sensor size.
    pub intrinsics: Intrinsics,
    /// Distance between adjacent views, m.
    pub baseline_m: f64,
    /// A description of the camera for messages.
    pub camera: String,
    /// The angles of view, if the image has another aspect ratio than the camera.
    pub aspect_change: Option<AspectChange>,
    pub(crate) shape: LightFieldShape,
    pub(crate) projection: Projection,
}

impl Framing {
    /// The first camera of the scene with its field of view on a sensor of 36 mm; perspective views that sample the
    /// aperture of an f/5 lens.
    #[must_use]
    pub const fn new(shape: LightFieldShape) -> Self {
        Self {
            shape,
            camera: CameraChoice::First,
            focal_length_m: None,
            sensor_size_m: 0.036,
            baseline: Baseline::FNumber(5.0),
            projection: Projection::Perspective,
        }
    }

    setters! {
        shape: LightFieldShape,
        camera: CameraChoice,
        focal_length_m: Option<f64>,
        sensor_size_m: f64,
        baseline: Baseline,
        projection: Projection,
    }

    /// Selects the camera and computes focal length and baseline.
    ///
    /// # Errors
    /// [`Error::BadSetting`] if there is no such camera, if it is orthographic, or if the scene is empty;
    /// [`Error::Core`] for parameters that are invalid for a rig.
    pub fn frame(&self, scene: &Scene) -> Result<Framed, Error> {
        let lenses = self.shape.lenses();
        let Some(camera) = choose(scene, &self.camera)? else { return default_camera::frame(self, scene) };
        let half_slope = half_slope(camera, lenses)?;
        let focal_length_m = self.focal_length_m.unwrap_or(self.sensor_size_m / (2.0 * half_slope));
        // A focal length that was given decides the angles of view.
        let aspect_change =
            self.focal_length_m.is_none().then(|| AspectChange::new(camera, lenses, half_slope)).flatten();
        let description = format!("camera '{}'", shown(&camera.name));
        self.framed(camera.pose, description, focal_length_m).map(|framed| Framed { aspect_change, ..framed })
    }

    /// A camera pose with this focal length.
    fn framed(&self, pose: Transform, camera: String, focal_length_m: f64) -> Result<Framed, Error> {
        let baseline_m = match self.baseline {
            Baseline::Meters(baseline) => baseline,
            Baseline::FNumber(f_number) => automatic_baseline_m(focal_length_m, f_number, self.shape.views())?,
        };
        let intrinsics = Intrinsics { focal_length_m, sensor_size_m: self.sensor_size_m };
        let (shape, projection) = (self.shape, self.projection);
        let framed = Framed { pose, intrinsics, baseline_m, camera, aspect_change: None, shape, projection };
        // Validates everything but the focus distance now, before the scene is built.
        framed.rig_with(Projection::Perspective, f64::INFINITY)?;
        Ok(framed)
    }
}

impl Framed {
    /// The rig focused at a distance, m (may be infinite).
    ///
    /// # Errors
    /// [`Error::Core`] for parameters that are invalid for a rig; an orthographic rig needs a finite distance.
    pub fn rig(&self, focus_distance_m: f64) -> Result<Rig, Error> {
        self.rig_with(self.projection, focus_distance_m)
    }

    pub(crate) fn rig_with(&self, projection: Projection, focus_distance_m: f64) -> Result<Rig, Error> {
        Ok(Rig::builder(self.shape)
            .intrinsics(self.intrinsics)
            .baseline_m(self.baseline_m)
            .focus_distance_m(focus_distance_m)
            .projection(projection)
            .build()?)
    }
}

/// The cameras of a scene that a message names.
const SHOWN_CAMERAS: usize = 12;

fn choose<'a>(scene: &'a Scene, choice: &CameraChoice) -> Result<Option<&'a Camera>, Error> {
    let list = || match scene.cameras.len() {
        0 => "it has none".to_string(),
        count => {
            let names = scene.cameras.iter().take(SHOWN_CAMERAS).map(|camera| format!("'{}'", shown(&camera.name)));
            let more = if count > SHOWN_CAMERAS { ", ..." } else { "" };
            format!("it has {}{more}", names.collect::<Vec<_>>().join(", "))
        }
    };
    match choice {
        CameraChoice::First => Ok(scene.cameras.first()),
        CameraChoice::Index(index) => match scene.cameras.get(*index) {
            Some(camera) => Ok(Some(camera)),
            None => Err(Error::BadSetting(format!("the scene has no camera number {index}: {}", list()))),
        },
        CameraChoice::Name(name) => match scene.cameras.iter().find(|c| c.name == *name) {
            Some(camera) => Ok(Some(camera)),
            None => Err(Error::BadSetting(format!("the scene has no camera '{}': {}", shown(name), list()))),
        },
    }
}

/// The tangent of half the angle of view along the larger image side. An image with at least as many columns as rows
/// gets the larger of the two angles of view of the camera across its width, as Blender's automatic sensor fit does: a
/// landscape camera keeps its horizontal angle, and a portrait camera is turned. A portrait image keeps the vertical
/// angle.
fn half_slope(camera: &Camera, lenses: GridSize) -> Result<f64, Error> {
    match camera.projection {
        CameraProjection::Perspective { vertical_angle_rad, aspect_ratio } => {
            let vertical = (vertical_angle_rad / 2.0).tan();
            if lenses.columns < lenses.rows {
                return Ok(vertical);
            }
            let aspect = aspect_ratio.map_or(lenses.columns as f64 / lenses.rows as f64, |aspect| aspect.max(1.0));
            Ok(vertical * aspect)
        }
        CameraProjection::Orthographic { .. } => Err(Error::BadSetting(format!(
            "camera '{}' is orthographic; choose a perspective camera, and `projection orthographic` if the views \
             shall be parallel projections",
            shown(&camera.name)
        ))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(aspect_ratio: Option<f64>) -> Camera {
        let projection = CameraProjection::Perspective { vertical_angle_rad: 0.8, aspect_ratio };
        Camera { name: "a".into(), pose: Transform::IDENTITY, projection }
    }

    fn framing(lenses: GridSize, camera: CameraChoice) -> Framing {
        Framing {
            shape: LightFieldShape::new(GridSize::new(4, 5), lenses).unwrap(),
            camera,
            focal_length_m: None,
            sensor_size_m: 0.036,
            baseline: Baseline::FNumber(5.0),
            projection: Projection::Perspective,
        }
    }

    #[test]
    fn the_larger_side_keeps_its_angle() {
        let scene = |aspect| Scene { cameras: vec![camera(aspect)], ..Scene::default() };
        let focal = |scene: &Scene, rows, columns| {
            let lenses = GridSize::new(rows, columns);
            framing(lenses, CameraChoice::First).frame(scene).unwrap().intrinsics.focal_length_m
        };
        // Landscape: tan(half horizontal) = aspect * tan(half vertical); the sensor of 36 mm is the width.
        let tan = 0.4f64.tan();
        assert!((focal(&scene(Some(1.5)), 10, 20) - 0.018 / (1.5 * tan)).abs() < 1e-12);
        assert!((focal(&scene(None), 10, 20) - 0.018 / (2.0 * tan)).abs() < 1e-12, "aspect of the image");
        // Portrait: the vertical field of view, over the height.
        assert!((focal(&scene(Some(1.5)), 20, 10) - 0.018 / tan).abs() < 1e-12);
        // A portrait camera has its larger angle along the height: it is that of the width of a landscape image, as if
        // the camera were turned, and of the height of a portrait image.
        assert!((focal(&scene(Some(0.5625)), 10, 20) - 0.018 / tan).abs() < 1e-12);
        assert!((focal(&scene(Some(0.5625)), 20, 10) - 0.018 / tan).abs() < 1e-12);
    }

    #[test]
    fn another_aspect_ratio_is_named_with_the_angles() {
        let change = |aspect, rows, columns| {
            let scene = Scene { cameras: vec![camera(aspect)], ..Scene::default() };
            framing(GridSize::new(rows, columns), CameraChoice::First).frame(&scene).unwrap().aspect_change
        };
        assert_eq!(change(Some(1.5), 10, 15), None);
        assert_eq!(change(Some(1.5), 53, 79), None, "whole pixels");
        assert_eq!(change(None, 10, 15), None);
        // 2 atan(0.5625 tan 0.4) = 0.4662 and 2 atan(tan(0.4) / 1.5) = 0.5484; 0.8 rad are 45.8 degrees.
        let portrait = change(Some(0.5625), 10, 15).unwrap();
        let text = "the camera sees 26.8 x 45.8 degrees (width / height 0.562), the image 45.8 x 31.5 (1.500)";
        assert_eq!(portrait.to_string(), text);
        // A focal length replaces the angles of the camera.
        let scene = Scene { cameras: vec![camera(Some(0.5))], ..Scene::default() };
        let framing = framing(GridSize::new(10, 20), CameraChoice::First).focal_length_m(Some(0.05));
        assert_eq!(framing.frame(&scene).unwrap().aspect_change, None);
    }

    #[test]
    fn the_automatic_baseline_samples_the_aperture() {
        let scene = Scene { cameras: vec![camera(Some(1.5))], ..Scene::default() };
        let framed = framing(GridSize::new(10, 20), CameraChoice::First).frame(&scene).unwrap();
        // 5 columns of views: four steps across the aperture.
        assert!((framed.baseline_m - framed.intrinsics.focal_length_m / 5.0 / 4.0).abs() < 1e-15);
    }

    #[test]
    fn cameras_are_found_or_named_in_the_error() {
        let scene = Scene { cameras: vec![camera(None)], ..Scene::default() };
        let lenses = GridSize::new(10, 20);
        assert!(framing(lenses, CameraChoice::Name("a".into())).frame(&scene).is_ok());
        for choice in [CameraChoice::Name("b".into()), CameraChoice::Index(1)] {
            let message = framing(lenses, choice).frame(&scene).unwrap_err().to_string();
            assert!(message.contains("'a'"), "{message}");
        }
        let nothing = framing(lenses, CameraChoice::First).frame(&Scene::default());
        assert!(nothing.unwrap_err().to_string().contains("nothing to look at"));
    }
}
