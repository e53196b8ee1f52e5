//! What a renderer needs to know of the world: meshes, materials, textures, lights, cameras.
//!
//! A [`Scene`] is plain data in world coordinates (right-handed, +Y up, meters). Build it in code, load it from glTF
//! ([`gltf`]), or take one of the fifteen of the gallery (`gallery`, behind the feature of that name). Nothing is checked
//! while a scene is being filled; [`Scene::validate`] checks everything at once, so that an index out of range or a NaN
//! vertex is an error and never a panic.
//!
//! # Example
//! ```
//! # fn main() -> Result<(), holo_scene::Error> {
//! use holo_scene::{Instance, Material, Mesh, Scene, Transform};
//!
//! let triangle = Mesh {
//!     name: "sail".into(),
//!     positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
//!     triangles: vec![[0, 1, 2]],
//!     ..Mesh::default()
//! };
//! let scene = Scene {
//!     materials: vec![Material::default()],
//!     meshes: vec![triangle],
//!     instances: vec![Instance { name: "boat".into(), mesh: 0, transform: Transform::from_translation([0.0, 1.0, -3.0]) }],
//!     ..Scene::default()
//! };
//! scene.validate()?;
//! let glb = holo_scene::gltf::to_glb(&scene)?;
//! let loaded = holo_scene::gltf::load_slice(&glb, &Default::default())?;
//! assert_eq!(loaded.scene, scene);
//! # Ok(())
//! # }
//! ```

#![forbid(unsafe_code)]

#[cfg(feature = "gallery")]
pub mod gallery;
pub mod gltf;

mod error;
mod material;
mod scene;
mod transform;
mod validate;

pub use error::Error;
pub use material::{Alpha, Material, NormalMap, TextureTransform, TextureUse, Volume};
pub use scene::{Camera, CameraLens, Environment, Instance, Light, LightKind, Mesh, Scene, Texture, Wrap};
pub use transform::Transform;

/// The largest radiance, radiant intensity or illuminance that a scene may hold: far beyond any light, and its products
/// with what a path carries stay finite in f32.
pub const MAX_RADIANCE: f32 = 1e30;
