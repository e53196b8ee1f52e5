//! Dataset folders: the names in them, reading one, and finding many.
//!
//! # Source
//!
//! Section IV of the paper names the folders and the raw images; the other files are this project's.

mod description;
#[cfg(feature = "png")]
mod folder;
mod list;

use std::path::{Path, PathBuf};

use holo_core::GridSize;

use crate::Error;

pub use description::{Description, SceneEntry};
#[cfg(feature = "png")]
pub use folder::DatasetFolder;
pub use list::{DatasetEntry, list};

/// The elemental grid: the raw image behind the lenses.
pub const ELEMENTAL_PNG: &str = "scene_el.png";
/// The viewpoint grid: all views side by side.
pub const VIEWPOINT_PNG: &str = "scene_vpi.png";
/// Disparity of the central view in pixels between adjacent views.
pub const DISPARITY_PFM: &str = "scene_disparity.pfm";
/// The same as a picture.
pub const DISPARITY_PNG: &str = "scene_disparity.png";
/// Depth of the central view in metres.
pub const DEPTH_PFM: &str = "scene_depth.pfm";
/// All layers of the central view, linear and without exposure: colour, depth, normals and what else was rendered.
pub const CENTRAL_EXR: &str = "scene_central.exr";
/// The elemental grid in linear light, without exposure.
pub const ELEMENTAL_EXR: &str = "scene_el.exr";
/// The viewpoint grid in linear light, without exposure.
pub const VIEWPOINT_EXR: &str = "scene_vpi.exr";
/// The light field as a 5D array of the raw image's integers, for MATLAB.
pub const LIGHT_FIELD_MAT: &str = "scene_5d.mat";
/// The light field as a 5D array of linear radiance, with maps of ground truth.
pub const LIGHT_FIELD_HDF5: &str = "scene_5d.h5";
/// The camera parameters.
pub const PARAMETERS_CFG: &str = "parameters.cfg";
/// The settings and digests.
pub const MANIFEST_JSON: &str = "manifest.json";
/// What a dataset of many folders consists of, in its root.
pub const DATASET_JSON: &str = "dataset.json";
/// The same for people.
pub const DATASET_MD: &str = "DATASET.md";

/// Returns the folder of one dataset: `<scene>/<S>x<T>`, views as columns x rows.
///
/// # Errors
///
/// [`Error::BadInput`] if the scene's name is not the name of one folder: empty, `..`, or with a separator in it.
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
    if !stays_inside(scene) || scene.contains('/') {
        return Err(Error::bad_input(Path::new(scene), "a scene's name must be usable as the name of one folder"));
    }
    Ok(Path::new(scene).join(format!("{}x{}", views.columns, views.rows)))
}

/// Whether a name is a relative path that stays inside its folder on every system.
pub(crate) fn stays_inside(name: &str) -> bool {
    let plain = |part: &str| !matches!(part, "" | "." | "..") && !part.contains(['\\', ':', '\0']);
    name.split('/').all(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_leave_the_folder_are_told_from_those_that_stay() {
        for name in ["scene_el.png", "hci/input_Cam000.png", "..x", "a b"] {
            assert!(stays_inside(name), "{name}");
        }
        for name in ["", "/etc/passwd", "../x", "a/../b", "a//b", "./a", "a/", "C:x", "a\\..\\b", "a\0"] {
            assert!(!stays_inside(name), "{name}");
        }
    }
}
