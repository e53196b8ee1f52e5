//! Loading glTF: a file for every feature, an invalid file for every error.

mod animation;
mod blender;
mod cameras_and_lights;
mod files;
mod hierarchy;
mod instancing;
mod materials;
mod meshes;
mod posed;
mod specular_glossiness;
pub mod support;
mod surfaces;
mod validate;
