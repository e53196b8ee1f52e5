//! Loading glTF: every feature from a file built by hand, every refusal from a file broken by hand.

#[path = "gltf_loading/files.rs"]
mod files;
#[path = "gltf_loading/hierarchy.rs"]
mod hierarchy;
#[path = "gltf_loading/materials.rs"]
mod materials;
#[path = "gltf_loading/meshes.rs"]
mod meshes;
#[path = "gltf_loading/placed.rs"]
mod placed;
#[path = "gltf_loading/support.rs"]
mod support;
#[path = "gltf_loading/surfaces.rs"]
mod surfaces;
#[path = "gltf_loading/validate.rs"]
mod validate;
