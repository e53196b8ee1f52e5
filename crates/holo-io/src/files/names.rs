//! Names of the files in a dataset folder, and the check that a name stays inside its folder.

/// The prefix of that value in all versions.
pub(crate) const FORMAT_FAMILY: &str = "holo manifest ";
/// The raw image: the elemental image array, 8- or 16-bit sRGB.
pub const ELEMENTAL_PNG: &str = "scene_el.png";
/// The sub-aperture image array: all views side by side, 8- or 16-bit sRGB.
pub const VIEWPOINT_PNG: &str = "scene_vpi.png";
/// Disparity of the central view in pixels between adjacent views, `(v, u)`.
pub const DISPARITY_PFM: &str = "scene_disparity.pfm";
/// The disparity of the central view as a gray image: brighter is nearer.
pub const DISPARITY_PNG: &str = "scene_disparity.png";
/// 255 where the central view sees the scene, 0 where depth is infinite.
pub const HIT_MASK_PNG: &str = "scene_hit_mask.png";
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
/// The folder of single views in a dataset folder, in the layout of the HCI benchmark.
pub const HCI_FOLDER: &str = "hci";
/// The codes that an image sensor makes of the raw image, 16-bit linear.
pub const CODES_PNG: &str = "scene_raw.png";
/// The weights of the central view that was decoded from the raw image of a plenoptic camera.
pub const WEIGHT_PNG: &str = "scene_weight.png";
/// The raw image of a plenoptic camera in linear light, without exposure.
pub const RAW_EXR: &str = "raw.exr";
/// The raw image of a plenoptic camera, 16-bit linear.
pub const RAW_PNG: &str = "raw_linear.png";
/// The white image of a plenoptic camera, 16-bit linear.
pub const WHITE_PNG: &str = "white.png";
/// The plenoptic camera of a raw image.
pub const CAMERA_TOML: &str = "camera.toml";
/// The poses of many cameras, with the names of their images or folders.
pub const TRANSFORMS_JSON: &str = "transforms.json";
/// The camera parameters.
pub const PARAMETERS_CFG: &str = "parameters.cfg";
/// The settings of the render and the digest of every file.
pub const MANIFEST_JSON: &str = "manifest.json";
/// The index of a dataset of many folders, in its root folder.
pub const DATASET_JSON: &str = "dataset.json";
/// The description of a dataset for human readers, in its root folder.
pub const DATASET_MD: &str = "DATASET.md";

/// Returns the file of a layer of view `k` of `count`, in the folder of the layer, numbered as in HCI folders: view row * columns +
/// view column.
#[must_use]
pub fn layer_of_view(layer: &str, k: usize, count: usize, ending: &str) -> String {
    let digits = 3.max((count - 1).to_string().len());
    format!("{layer}/scene_{layer}_Cam{k:0digits$}.{ending}")
}

/// The images that this project writes beside a light field: none of them is a view of it.
pub(crate) const OWN_IMAGES: [&str; 8] =
    [ELEMENTAL_PNG, VIEWPOINT_PNG, DISPARITY_PNG, HIT_MASK_PNG, CODES_PNG, WEIGHT_PNG, RAW_PNG, WHITE_PNG];

/// Whether a name is a relative path that stays inside its folder on every system, and of characters that can be shown:
/// a line break in a name would be one in every list of names.
pub(crate) fn stays_inside(name: &str) -> bool {
    let is_plain = |c: char| !c.is_control() && !matches!(c, '\\' | ':');
    let plain = |part: &str| !matches!(part, "" | "." | "..") && part.chars().all(is_plain);
    name.split('/').all(plain)
}

/// Whether a path that was not given by the user, but found beside others, is a regular file: no link, pipe or device.
pub(crate) fn is_regular(path: &std::path::Path) -> bool {
    path.symlink_metadata().is_ok_and(|found| found.is_file())
}

/// What the name of a view in an HCI folder begins with; its number and `.png` follow.
pub(crate) const HCI_VIEW: &str = "input_Cam";

/// The number of a view by the name of its file in an HCI folder; `None` for other files.
pub(crate) fn hci_view_number(name: &str) -> Option<usize> {
    hci_number(name.strip_prefix(HCI_VIEW)?.strip_suffix(".png")?)
}

/// Parses digits; `parse` alone would accept a sign.
pub(crate) fn hci_number(number: &str) -> Option<usize> {
    number.bytes().all(|byte| byte.is_ascii_digit()).then(|| number.parse().ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As many digits as the last number needs, at least three.
    #[test]
    fn views_are_numbered_with_equal_digits() {
        let name = |k: usize, count: usize| layer_of_view("depth", k, count, "pfm");
        assert_eq!(name(7, 9), "depth/scene_depth_Cam007.pfm");
        assert_eq!([name(0, 1000), name(999, 1000)], ["depth/scene_depth_Cam000.pfm", "depth/scene_depth_Cam999.pfm"]);
        assert_eq!(
            [name(0, 1001), name(1000, 1001)],
            ["depth/scene_depth_Cam0000.pfm", "depth/scene_depth_Cam1000.pfm"]
        );
    }

    #[test]
    fn names_that_leave_the_folder_are_found() {
        for name in ["scene_el.png", "hci/input_Cam000.png", "..x", "a b"] {
            assert!(stays_inside(name), "{name}");
        }
        for name in ["", "/etc/passwd", "../x", "a/../b", "a//b", "./a", "a/", "C:x", "a\\..\\b", "a\0", "a\nb"] {
            assert!(!stays_inside(name), "{name}");
        }
    }
}
