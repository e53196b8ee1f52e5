// The README shows programs that render.
#![cfg_attr(feature = "render", doc = include_str!("../README.md"))]
#![cfg_attr(
    not(feature = "render"),
    doc = "Light fields of holoscopic cameras and their files. The feature `render` adds scenes and the renderer."
)]
#![forbid(unsafe_code)]

/// The crate `holo-core`: light field, rig, disparity, refocusing, stereo, scores, plenoptic cameras.
pub use holo_core as core;
/// The crate `ndarray`, whose arrays hold images and light fields.
pub use holo_core::ndarray;
/// The crate `holo-dataset`: render jobs and datasets.
#[cfg(feature = "render")]
pub use holo_dataset as jobs;
/// The crate `holo-io`: the files of the field, read and written.
pub use holo_io as io;
/// The crate `holo-render`: from a scene and a camera to a light field in memory.
#[cfg(feature = "render")]
pub use holo_render as render;
/// The crate `holo-scene`: meshes, materials, lights and cameras; glTF in and out; the gallery.
#[cfg(feature = "render")]
pub use holo_scene as scene;

/// The names that most programs need.
pub mod prelude {
    pub use holo_core::metrics::{Region, disparity_scores};
    pub use holo_core::refocus::Refocus;
    pub use holo_core::{DynImage, GridSize, LightField, Rig, SampleKind, plane_sweep};
    #[cfg(feature = "render")]
    pub use holo_dataset::{Output, RenderJob, RenderSettings, RigSettings, RunOptions, SceneSource};
    pub use holo_io::{CameraFile, LightFieldReader, ReadOptions, read_light_field, write_image};
}
