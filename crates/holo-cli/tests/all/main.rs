//! The program as its users run it, in one test program: building many takes longer than running them.

#[path = "../../../../tests/all/common/pins.rs"]
mod pins;
#[path = "../../../holo-io/tests/all/python.rs"]
mod python;

mod animation;
mod any_folder;
mod camera_array;
mod common;
mod dataset;
mod determinism;
mod develop;
mod error_chains;
mod export;
mod export_plenoptic;
mod failures;
mod generate;
mod help;
mod hostile_folders;
mod images;
mod info;
mod json_report;
mod layers;
mod low_memory;
mod lytro;
mod merge;
mod mutated_scenes;
mod outputs_and_folders;
mod pinned;
mod plenoptic_cameras;
mod posed_rigs;
mod preview;
mod raw_images;
mod render_outputs;
mod rounds;
mod scene_files;
mod scene_gallery;
mod signals;
mod subsets;
mod tools;
mod viewer;
mod viewpoint;
mod wrong_use;
