//! Scene descriptions for renderers: meshes, materials, textures, lights and cameras.
//!
//! A [`Scene`] is plain data in world coordinates (right-handed, +Y up, meters). It can be built in code, loaded from
//! glTF ([`gltf`]), taken from the gallery (module `gallery`, behind the feature of that name), or drawn from a recipe
//! (module `recipe`, behind the same).
//! [`Scene::validate`] checks a whole scene at once, so that an index out of range or a NaN vertex is an error and
//! never a panic. [`gltf::to_glb`] writes a scene as binary glTF, [`gltf::to_glb_animated`] with movements ([`animation`]).
//!
//! This crate does not render; `holo-render` does.
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
//!     instances: vec![Instance {
//!         name: "boat".into(),
//!         mesh: 0,
//!         transform: Transform::from_translation([0.0, 1.0, -3.0]),
//!     }],
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

pub mod animation;
pub mod gltf;

#[cfg(feature = "gallery")]
mod built;
mod environment;
mod error;
mod material;
mod scene;
mod transform;

#[cfg(feature = "gallery")]
pub use built::{gallery, recipe};
pub use error::Error;
pub use material::{
    Alpha, Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Material, NormalMap, Sheen, TextureInfo,
    TextureTransform, Volume,
};
pub use scene::{
    Camera, CameraProjection, Environment, Filter, Instance, Light, LightKind, Mesh, Scene, Texture, Wrap,
};
pub use transform::Transform;

/// The maximum of radiance, intensity (candela) and illuminance (lux) in a scene: far above that of any light, and
/// small enough that products with path throughputs are finite in f32.
pub const MAX_RADIANCE: f32 = 1e30;
