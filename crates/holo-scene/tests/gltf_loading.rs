//! Loading glTF: a file for every feature, an invalid file for every error.

#[path = "gltf_loading/animation.rs"]
mod animation;
#[path = "gltf_loading/blender.rs"]
mod blender;
#[path = "gltf_loading/cameras_and_lights.rs"]
mod cameras_and_lights;
#[path = "gltf_loading/files.rs"]
mod files;
#[path = "gltf_loading/hierarchy.rs"]
mod hierarchy;
#[path = "gltf_loading/instancing.rs"]
mod instancing;
#[path = "gltf_loading/materials.rs"]
mod materials;
#[path = "gltf_loading/meshes.rs"]
mod meshes;
#[path = "gltf_loading/posed.rs"]
mod posed;
#[path = "gltf_loading/specular_glossiness.rs"]
mod specular_glossiness;
#[path = "gltf_loading/support.rs"]
mod support;
#[path = "gltf_loading/surfaces.rs"]
mod surfaces;
#[path = "gltf_loading/validate.rs"]
mod validate;
