//! The names of the files in a dataset folder, and which names stay inside a folder.

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
