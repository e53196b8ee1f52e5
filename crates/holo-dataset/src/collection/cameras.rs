//! The cameras of a dataset: what is asked for, and the settings that each of them renders with.

use holo_core::{GridSize, LightFieldShape, Remainder};
use holo_io::dataset::{DatasetCamera, camera_folder};
use holo_io::{CameraArray, CameraFile};

use crate::Error;
use crate::output::Wanted;
use crate::settings::{Camera, Pixels, RenderSettings, RigSettings};
use crate::shot::{camera_digest, shifted};

/// The cameras of a dataset: each has a folder of every scene.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum DatasetCameras {
    /// Rigs with these numbers of views. Everything else of them is in the settings of the dataset.
    Views(Vec<GridSize>),
    /// Plenoptic cameras. Their names, which name folders, differ.
    Plenoptic(Vec<CameraFile>),
}

impl DatasetCameras {
    /// Checks that a dataset can have these cameras and settings, which needs no scene: to make scenes takes seconds.
    ///
    /// # Errors
    /// As [`DatasetPlan::new`](crate::DatasetPlan::new).
    pub fn check(&self, settings: &RenderSettings) -> Result<(), Error> {
        of(self, settings).map(drop)
    }
}

impl From<&[GridSize]> for DatasetCameras {
    fn from(views: &[GridSize]) -> Self {
        Self::Views(views.to_vec())
    }
}

impl<const N: usize> From<&[GridSize; N]> for DatasetCameras {
    fn from(views: &[GridSize; N]) -> Self {
        Self::Views(views.to_vec())
    }
}

impl From<Vec<GridSize>> for DatasetCameras {
    fn from(views: Vec<GridSize>) -> Self {
        Self::Views(views)
    }
}

impl From<Vec<CameraFile>> for DatasetCameras {
    fn from(files: Vec<CameraFile>) -> Self {
        Self::Plenoptic(files)
    }
}

/// A camera as `dataset.json` has it, and the settings that render it.
type Planned = (DatasetCamera, RenderSettings);

/// Returns the cameras of a dataset.
pub(super) fn of(cameras: &DatasetCameras, settings: &RenderSettings) -> Result<Vec<Planned>, Error> {
    match cameras {
        DatasetCameras::Views(views) => rigs(views, settings),
        DatasetCameras::Plenoptic(files) => plenoptic(files, settings),
    }
}

fn bad<T>(what: impl Into<String>) -> Result<T, Error> {
    Err(Error::BadRequest(what.into()))
}

/// Rigs that share everything but the number of views.
fn rigs(views: &[GridSize], settings: &RenderSettings) -> Result<Vec<Planned>, Error> {
    Wanted::new(settings)?;
    let Camera::Rig(rig) = &settings.camera else {
        return bad("`views` makes light fields of rigs, and the settings are of another camera; remove one of both");
    };
    let mut planned: Vec<Planned> = Vec::new();
    for &views in views {
        let shape = match (settings.poses.cameras(), rig.pixels) {
            (Some(array), pixels) => LightFieldShape::new(views, size_of_poses(array, pixels)?)?,
            (None, Pixels::Sensor(sensor)) => sensor.divide(views, Remainder::Crop)?.shape,
            (None, Pixels::Lenses(lenses)) => LightFieldShape::new(views, lenses)?,
            (None, Pixels::OfPoses) => return bad("the views have no size; give `sensor` or `lenses`"),
        };
        let rig = RigSettings { views, ..rig.clone() };
        let camera = DatasetCamera::Rig(shifted(&rig, shape)?);
        if planned.iter().any(|(other, _)| *other == camera) {
            return bad(format!("`views` has {views} twice"));
        }
        planned.push((camera, RenderSettings { camera: rig.into(), ..settings.clone() }));
    }
    Ok(planned)
}

/// The pixels of a view, which a dataset has one number of.
fn size_of_poses(array: &CameraArray, pixels: Pixels) -> Result<GridSize, Error> {
    let lenses = match pixels {
        Pixels::Lenses(lenses) => Some(lenses),
        Pixels::OfPoses => None,
        Pixels::Sensor(_) => {
            return bad(
                "`sensor` would be divided into views, and the images of `transforms` have a size of their own; remove one",
            );
        }
    };
    let mut found = lenses;
    for camera in &array.cameras {
        let name = holo_io::shown(&camera.name);
        let Some(size) = camera.size.or(lenses) else {
            return bad(format!("camera '{name}' of `transforms` has no size; give `lenses`"));
        };
        match found {
            Some(other) if other != size => {
                return bad(format!(
                    "camera '{name}' of `transforms` has {size} pixels instead of {other}: the views of a dataset have one \
                     size"
                ));
            }
            _ => found = Some(size),
        }
    }
    found.map_or_else(|| bad("`transforms` has no camera"), Ok)
}

/// Plenoptic cameras with names that are folders of their own.
fn plenoptic(files: &[CameraFile], settings: &RenderSettings) -> Result<Vec<Planned>, Error> {
    if settings.camera.rig().is_some_and(|rig| *rig != RigSettings::default()) {
        return bad("`camera-file` has plenoptic cameras, and the settings are of a rig; remove one of both");
    }
    if files.is_empty() {
        return bad("no camera: give `camera-file`");
    }
    let mut planned: Vec<Planned> = Vec::new();
    for file in files {
        let name = file.name.clone();
        if let Err(why) = camera_folder("scene", &name) {
            return bad(format!("`camera-file`: {why}; change its name"));
        }
        // Some systems do not distinguish capital letters.
        if planned.iter().any(|(other, _)| other.name().eq_ignore_ascii_case(&name)) {
            let name = holo_io::shown(&name);
            return bad(format!(
                "two cameras of `camera-file` have the name '{name}' and would share a folder; change one of the names"
            ));
        }
        let (size, sha256) = (file.camera.sensor().size, camera_digest(file).to_string());
        let settings = RenderSettings { camera: file.clone().into(), ..settings.clone() };
        Wanted::new(&settings)?;
        planned.push((DatasetCamera::Plenoptic { name, size, sha256 }, settings));
    }
    Ok(planned)
}
