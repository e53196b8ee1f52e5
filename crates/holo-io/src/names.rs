//! Names of the files in a dataset folder, and the check that a name stays inside its folder.

/// The raw image: the elemental image array, 8- or 16-bit sRGB.
pub const ELEMENTAL_PNG: &str = "scene_el.png";
/// The sub-aperture image array: all views side by side, 8- or 16-bit sRGB.
pub const VIEWPOINT_PNG: &str = "scene_vpi.png";
/// Disparity of the central view in pixels between adjacent views, `(v, u)`.
pub const DISPARITY_PFM: &str = "scene_disparity.pfm";
/// The disparity of the central view as a gray image: brighter is nearer.
pub const DISPARITY_PNG: &str = "scene_disparity.png";
/// Planar depth of the central view in meters, `(v, u)`.
pub const DEPTH_PFM: &str = "scene_depth.pfm";
/// All layers of the central view, linear and without exposure: color, depth, normals and other rendered layers.
pub const CENTRAL_EXR: &str = "scene_central.exr";
/// The elemental image array in linear light, without exposure.
pub const ELEMENTAL_EXR: &str = "scene_el.exr";
/// The sub-aperture image array in linear light, without exposure.
pub const VIEWPOINT_EXR: &str = "scene_vpi.exr";
/// The light field as a 5D array of the integers of the raw image, for MATLAB.
pub const LIGHT_FIELD_MAT: &str = "scene_5d.mat";
/// The light field as a 5D array of linear radiance, with ground truth.
pub const LIGHT_FIELD_HDF5: &str = "scene_5d.h5";
/// The light fields of all frames of a sequence as one 6D array, in the folder of the sequence.
pub const SEQUENCE_HDF5: &str = "sequence_5d.h5";
/// The camera parameters.
pub const PARAMETERS_CFG: &str = "parameters.cfg";
/// The settings of the render and the digest of every file.
pub const MANIFEST_JSON: &str = "manifest.json";
/// The index of a dataset of many folders, in its root folder.
pub const DATASET_JSON: &str = "dataset.json";
/// The description of a dataset for human readers, in its root folder.
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
    fn names_that_leave_the_folder_are_found() {
        for name in ["scene_el.png", "hci/input_Cam000.png", "..x", "a b"] {
            assert!(stays_inside(name), "{name}");
        }
        for name in ["", "/etc/passwd", "../x", "a/../b", "a//b", "./a", "a/", "C:x", "a\\..\\b", "a\0"] {
            assert!(!stays_inside(name), "{name}");
        }
    }
}
