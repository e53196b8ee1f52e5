//! Dataset folders: names of their files, readers of one folder, sequences of them, the index and the list of many.
//!
//! # Source
//!
//! Section IV of the paper names the folders and the raw images; the other files are this project's.

mod camera;
mod folder;
mod index;
mod list;
mod plenoptic;
mod representation;
mod sequence;

use std::path::{Path, PathBuf};

use holo_core::GridSize;

use crate::Error;
use crate::files::names::stays_inside;

pub use camera::DatasetCamera;
pub use folder::DatasetFolder;
pub use index::{DatasetIndex, DatasetPoses, DatasetRecipe, SceneEntry};
pub use list::{DatasetEntry, list};
pub use plenoptic::PlenopticFolder;
pub use representation::Representation;
pub use sequence::SequenceFolder;

pub use crate::files::names::{
    CAMERA_TOML, CENTRAL_EXR, CODES_PNG, DATASET_JSON, DATASET_MD, DEPTH_PFM, DISPARITY_PFM, DISPARITY_PNG,
    ELEMENTAL_EXR, ELEMENTAL_PNG, HCI_FOLDER, HIT_MASK_PNG, LIGHT_FIELD_HDF5, LIGHT_FIELD_MAT, MANIFEST_JSON,
    PARAMETERS_CFG, RAW_EXR, RAW_PNG, SEQUENCE_HDF5, TRANSFORMS_JSON, VIEWPOINT_EXR, VIEWPOINT_PNG, WEIGHT_PNG,
    WHITE_PNG, layer_of_view,
};

/// Returns the relative path of the folder of one scene: `<scene>/<S>x<T>`, views as columns x rows.
///
/// # Errors
///
/// [`Error::BadInput`] if the scene's name cannot be a folder name: empty, `..`, or with a separator in it.
///
/// # Source
///
/// Section IV of the paper.
///
/// # Examples
///
/// ```
/// let folder = holo_io::dataset::folder("still_life", holo_core::GridSize::new(20, 40))?;
/// assert_eq!(folder, std::path::Path::new("still_life/40x20"));
/// # Ok::<(), holo_io::Error>(())
/// ```
pub fn folder(scene: &str, views: GridSize) -> Result<PathBuf, Error> {
    Ok(scene_folder(scene)?.join(views_name(views)))
}

/// Returns the relative path of the folder of one scene and one plenoptic camera: `<scene>/<camera>`.
///
/// # Errors
///
/// [`Error::BadInput`] if the scene's name cannot be a folder name, or the camera's name cannot be one on every system, is
/// that of a number of views such as `20x20`, or that of a frame such as `frame_0012`.
///
/// # Examples
///
/// ```
/// let folder = holo_io::dataset::camera_folder("still_life", "lytro-illum")?;
/// assert_eq!(folder, std::path::Path::new("still_life/lytro-illum"));
/// assert!(holo_io::dataset::camera_folder("still_life", "20x20").is_err());
/// # Ok::<(), holo_io::Error>(())
/// ```
pub fn camera_folder(scene: &str, camera: &str) -> Result<PathBuf, Error> {
    if !is_camera_name(camera) {
        return Err(Error::bad_input(
            Path::new(&*crate::shown(camera)),
            "a camera's name must be usable as the name of one folder, and not be that of a number of views or a frame",
        ));
    }
    Ok(scene_folder(scene)?.join(camera))
}

fn scene_folder(scene: &str) -> Result<&Path, Error> {
    if !stays_inside(scene) || scene.contains('/') {
        return Err(Error::bad_input(
            Path::new(&*crate::shown(scene)),
            "a scene's name must be usable as the name of one folder: without /, \\, : and control characters; rename it",
        ));
    }
    Ok(Path::new(scene))
}

/// The name of the folder of a number of views.
fn views_name(views: GridSize) -> String {
    format!("{}x{}", views.columns, views.rows)
}

/// Whether a plenoptic camera of this name can have a folder. Windows drops dots and spaces at the end of a name, and lists
/// of folders have a line each.
fn is_camera_name(name: &str) -> bool {
    let is_plain = name.trim() == name && !name.ends_with('.') && !name.contains(['/', '"', '*', '<', '>', '?', '|']);
    let is_other = list::views_of(name).is_some() || sequence::frame_of(name).is_some();
    stays_inside(name) && is_plain && !name.chars().any(char::is_control) && !is_other
}
