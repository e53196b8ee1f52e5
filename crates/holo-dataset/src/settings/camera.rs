//! The camera of a render, and where it stands.

use std::path::Path;

use holo_core::{GridSize, Remainder, Sensor};
use holo_io::{ArrayCamera, CameraArray, CameraFile, WorldUp};
use holo_render::Reuse;

use super::RenderSettings;
use super::given::Given;
use super::table::RigSettings;
use super::types::{Focus, Pixels, Spacing};
use super::value::{Malformed, SettingType};
use crate::Error;

/// What makes one light field or raw image from one place.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Camera {
    /// A grid of parallel pinhole cameras, one a view.
    Rig(RigSettings),
    /// A main lens and a microlens array in front of a sensor.
    Plenoptic(Box<CameraFile>),
    /// A single pinhole camera, whose size and focal length come from [`Poses::Array`]: the images of all poses share one
    /// folder.
    Pinhole,
}

/// Where the camera stands.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Poses {
    /// Where the camera of the scene stands: [`SceneSettings::camera`](super::SceneSettings::camera).
    #[default]
    Scene,
    /// Many places, each with a name.
    Array {
        /// The places. The size and the focal length of each are those of a pinhole, or of every view of a rig.
        cameras: CameraArray,
        /// The axis that points up in the world of the `transforms.json` that is written.
        up: WorldUp,
    },
}

impl Default for Camera {
    fn default() -> Self {
        Self::Rig(RigSettings::default())
    }
}

impl From<RigSettings> for Camera {
    fn from(rig: RigSettings) -> Self {
        Self::Rig(rig)
    }
}

impl From<CameraFile> for Camera {
    fn from(file: CameraFile) -> Self {
        Self::Plenoptic(Box::new(file))
    }
}

impl Camera {
    /// Returns the rig; `None` for other cameras.
    #[must_use]
    pub fn rig(&self) -> Option<&RigSettings> {
        match self {
            Self::Rig(rig) => Some(rig),
            Self::Plenoptic(_) | Self::Pinhole => None,
        }
    }

    /// Returns the rig, to change it.
    ///
    /// # Errors
    /// A message for other cameras.
    pub fn rig_mut(&mut self) -> Result<&mut RigSettings, Malformed> {
        match self {
            Self::Rig(rig) => Ok(rig),
            Self::Plenoptic(_) => Err("a plenoptic camera has its own; remove it, or change the camera file".into()),
            Self::Pinhole => {
                Err("cameras of a file have their own; give `views` too for a light field at every pose".into())
            }
        }
    }

    /// Returns the plenoptic camera; `None` for other cameras.
    #[must_use]
    pub fn plenoptic(&self) -> Option<&CameraFile> {
        match self {
            Self::Plenoptic(camera) => Some(camera),
            Self::Rig(_) | Self::Pinhole => None,
        }
    }

    /// Returns the pixels of an image of the camera, if it knows them.
    pub(crate) fn size(&self) -> Option<GridSize> {
        match self {
            Self::Rig(RigSettings { pixels: Pixels::Lenses(lenses), .. }) => Some(*lenses),
            Self::Rig(RigSettings { pixels: Pixels::Sensor(sensor), views, .. }) => {
                sensor.divide(*views, Remainder::Crop).ok().map(|divided| divided.shape.lenses())
            }
            Self::Rig(_) | Self::Pinhole => None,
            Self::Plenoptic(camera) => Some(camera.camera.sensor().size),
        }
    }
}

impl RenderSettings {
    /// Refuses what has no effect with the camera. As a default it is no request.
    pub(super) fn check_effect(&self, given: &Given) -> Result<(), Error> {
        let is_shared = given.get("reuse").is_some() && self.light.reuse == Reuse::Views;
        match &self.camera {
            Camera::Plenoptic(_) | Camera::Pinhole if is_shared => Err(Error::BadRequest(
                "`reuse views` shares light between the views of a rig, and this camera has none; remove it".into(),
            )),
            _ => Ok(()),
        }
    }

    /// Applies settings, and places cameras at the poses of a `transforms.json`: the plenoptic camera, a rig with the pixels
    /// of the file if a number of views is given, else a pinhole. `lenses` is the size of images whose size the file does
    /// not say. `sensor` is that of a pinhole, or is divided into the views of a rig: the images of all poses have its size.
    ///
    /// # Errors
    /// As [`apply`](Self::apply); [`Error::BadRequest`] if `sensor` has another size than the images of the file;
    /// [`Error::Io`] if the file cannot be read.
    pub fn apply_at_poses(&mut self, mut given: Given, path: &Path, up: WorldUp) -> Result<(), Error> {
        let lenses = given.get("lenses").map(GridSize::parse).transpose();
        let lenses = lenses.map_err(|why| Error::BadRequest(format!("`lenses`: {why}")))?;
        let mut sensor = None;
        self.camera = match std::mem::take(&mut self.camera) {
            Camera::Rig(rig) if given.get("views").is_some() => {
                Camera::Rig(RigSettings { pixels: Pixels::OfPoses, ..rig })
            }
            Camera::Rig(_) | Camera::Pinhole => {
                // It is the size of the images, which the cameras have then.
                sensor = match given.remove("lenses") {
                    None => given.remove("sensor").map(|text| of_images(&text)).transpose()?,
                    // Both exclude each other, and `sensor` is refused below.
                    Some(_) => None,
                };
                Camera::Pinhole
            }
            plenoptic @ Camera::Plenoptic(_) => plenoptic,
        };
        self.apply(&given)?;
        let size = self.camera.size().or(lenses).or(sensor);
        let mut cameras = CameraArray::read(path, up, size)?;
        cameras.cameras.iter_mut().for_each(|camera| camera.size = camera.size.or(size));
        let other = |camera: &&ArrayCamera| sensor.is_some() && camera.size != sensor;
        if let (Some(camera), Some(sensor)) = (cameras.cameras.iter().find(other), sensor) {
            let (name, size) = (&camera.name, camera.size.unwrap_or(sensor));
            return Err(Error::BadRequest(format!(
                "camera '{name}' has {size} pixels, and `sensor` {sensor}; remove it"
            )));
        }
        self.poses = Poses::Array { cameras, up };
        Ok(())
    }
}

/// The size of the images of pinholes with a sensor.
fn of_images(sensor: &str) -> Result<GridSize, Error> {
    let parsed = Sensor::parse(sensor);
    parsed.map(|sensor| sensor.size()).map_err(|why| Error::BadRequest(format!("`sensor={sensor}`: {why}")))
}

impl Poses {
    /// Returns the cameras of a list of poses; `None` for the pose of the scene.
    #[must_use]
    pub fn cameras(&self) -> Option<&CameraArray> {
        match self {
            Self::Scene => None,
            Self::Array { cameras, .. } => Some(cameras),
        }
    }
}

/// Returns a plenoptic camera with the focus and the f-number of `given`, and removes them from it: they are the camera's
/// then.
///
/// # Errors
/// [`Error::BadRequest`] for malformed values; [`Error::Io`] if the camera cannot have them.
pub fn adjusted_camera(mut camera: CameraFile, given: &mut Given) -> Result<CameraFile, Error> {
    let mut own = Given::default();
    for key in ["focus-m", "f-number"] {
        if let Some(text) = given.remove(key) {
            own.insert(key, text)?;
        }
    }
    let mut settings = RenderSettings::default();
    settings.apply(&own)?;
    let Some(rig) = settings.camera.rig() else { return Ok(camera) };
    if let Focus::Meters(depth_m) = rig.focus {
        camera = camera.with_focus_m(depth_m)?;
    }
    if let (Spacing::FNumber(f_number), true) = (rig.spacing, own.get("f-number").is_some()) {
        camera = camera.with_f_number(f_number)?;
    }
    Ok(camera)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_know_the_pixels_of_their_images() {
        let of = |pixels: Pixels| Camera::Rig(RigSettings { pixels, ..RigSettings::default() }).size();
        assert_eq!(of(Pixels::Lenses(GridSize::new(3, 4))), Some(GridSize::new(3, 4)));
        // 5304 x 7952 pixels behind 100 x 100 views, without the rest.
        assert_eq!(of(Pixels::Sensor(Sensor::Paper8k)), Some(GridSize::new(53, 79)));
        assert_eq!(Camera::Pinhole.size(), None);
        let file = CameraFile::preset("lytro-illum").unwrap();
        let size = file.camera.sensor().size;
        assert_eq!(Camera::from(file).size(), Some(size));
    }
}
