//! The names of the files that a job can write. Of an older result no file of another name is ever removed, whatever its
//! manifest says.

use holo_render::Layer;

use crate::settings::Tool;

/// The name of linear color among the layers.
pub(crate) const COLOR: &str = "color";

/// The name of the estimated error of color among the layers.
pub(crate) const ERROR: &str = "error";

/// The name of the part of all views that sees a point.
pub(crate) const VISIBILITY: &str = "visibility";

/// The names of the movement of images until the next frame, and of that of points in the world.
pub(crate) const FLOWS: [&str; 2] = ["optical-flow", "scene-flow"];

/// Files of the folder itself.
const FILES: [&str; 9] = [
    "camera.toml",
    "centers.csv",
    "color.pfm",
    "corners.csv",
    "error.pfm",
    "parameters.cfg",
    "raw.exr",
    "transforms.json",
    "visibility.pfm",
];

/// Families of files of the folder itself: what their names begin with, and their endings.
const FAMILIES: [(&str, &[&str]); 6] = [
    ("scene_", &["dng", "exr", "flo", "h5", "json", "mat", "pfm", "png"]),
    ("raw_", &["pfm", "png"]),
    ("white", &["exr", "png"]),
    ("frame_", &["exr", "png"]),
    ("central_", &["pfm"]),
    ("all_", &["pfm"]),
];

/// Subfolders of images: of views in the layout of the HCI benchmark, and of pinhole cameras.
const IMAGES: [&str; 2] = ["hci", "images"];

/// The endings in subfolders of images and of layers.
const OF_IMAGES: [&str; 4] = ["cfg", "flo", "pfm", "png"];

const TOOLS: [Tool; 7] =
    [Tool::LfToolbox, Tool::PlenoptiCam, Tool::Libpleno, Tool::Pip, Tool::Raytrix, Tool::Plenpy, Tool::Lytro];

/// The endings in subfolders for other programs, in lower case.
const OF_TOOLS: [&str; 9] = ["js", "json", "m", "png", "py", "raw", "tiff", "txt", "xml"];

/// The part of a file name for a layer.
pub(crate) fn file_part(name: &str) -> String {
    name.replace('-', "_")
}

/// Whether a job can write a file of this name.
pub(super) fn is_of_a_job(name: &str) -> bool {
    let Some((stem, ending)) = name.rsplit_once('.') else { return false };
    let Some((folder, _)) = stem.split_once('/') else {
        let of_family = |(begin, endings): &(&str, &[&str])| stem.starts_with(begin) && endings.contains(&ending);
        return FILES.contains(&name) || FAMILIES.iter().any(of_family);
    };
    let layers = Layer::ALL.map(Layer::name);
    let mut layers = layers.into_iter().chain([COLOR, ERROR, VISIBILITY]).chain(FLOWS);
    match TOOLS.into_iter().any(|tool| tool.name() == folder) {
        true => OF_TOOLS.contains(&ending.to_ascii_lowercase().as_str()),
        false => {
            let is_folder = IMAGES.contains(&folder) || layers.any(|layer| file_part(layer) == folder);
            is_folder && OF_IMAGES.contains(&ending)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_jobs_are_known_and_others_are_not() {
        for name in [
            "scene_el.png",
            "scene_5d.h5",
            "scene_geometric_normal.pfm",
            "scene_optical_flow.flo",
            "scene_raw.dng",
            "raw.exr",
            "raw_linear.png",
            "raw_virtual-depth.pfm",
            "white_f2.8.exr",
            "central_depth.pfm",
            "hci/input_Cam000.png",
            "hci/parameters.cfg",
            "images/camera_0000.png",
            "ray_length/scene_ray_length_Cam000.pfm",
            "scene_flow/scene_scene_flow_Cam000.pfm",
            "lytro/Cameras/HOLO000001/WhiteImages/MOD_0000.TXT",
            "lytro/Images/IMG_0001__frame.raw",
            "plenpy/decode.py",
            "transforms.json",
        ] {
            assert!(is_of_a_job(name), "{name}");
        }
        for name in [
            "thesis.tex",
            ".git/config",
            "x/keep.txt",
            "hci/keep.txt",
            "hci",
            "manifest.json",
            "scene_el.png.bak",
            "depth/notes",
            "lytro/.bashrc",
            "../scene_el.png",
        ] {
            assert!(!is_of_a_job(name), "{name}");
        }
    }
}
