//! Renders a 3D scene into a raw holoscopic image (a light field), with exact depth, disparity and other ground truth.
//!
//! The renderer traces the rays of all views microlens by microlens, so that the rays of a packet stay coherent. It is
//! a path tracer with next-event estimation; a single bounce gives direct light. Rays are traced by Embree 4 if it can
//! be loaded at run time, otherwise by a BVH in pure Rust.
//!
//! ```text
//! scene (glTF or code) -> geometry in camera coordinates -> rays lens by lens -> light field
//! ```
//!
//! # Conventions
//! - **World**: right-handed, +Y up, meters (the frame of glTF). A camera looks along its -Z. See [`holo_scene`].
//! - **Light fields**: axes (v, u, t, s, c): microlens row and column, view row and column, channel, as in
//!   [`holo_core`].
//! - **Depth** is planar z along the optical axis, m; +infinity where a ray misses. Disparity is Eq. 3 between adjacent
//!   views, px. [`layers`] lists all outputs beside color (arbitrary output variables, AOVs).
//! - **Color** is linear RGB radiance in the units of KHR_lights_punctual. [`exposure`] converts it to display values.
//! - **Determinism**: the result depends on the scene and the [`Request`], not on the number of threads or their
//!   timing.
//!
//! # Example
//! ```
//! use holo_core::{GridSize, LightFieldShape};
//! use holo_render::{Backend, Framing, Renderer, Request};
//!
//! # fn main() -> Result<(), holo_render::Error> {
//! let scene = holo_scene::gallery::scene("garden").expect("a scene of the gallery");
//! let shape = LightFieldShape::new(GridSize::new(8, 8), GridSize::new(20, 30))?; // views, lenses
//! let framed = Framing::new(shape).frame(&scene)?;
//! let renderer = Renderer::new(&scene, &framed.pose, Backend::Auto, None)?;
//! let rig = framed.rig(renderer.automatic_focus_m(&framed)?)?;
//! let request = Request::new(rig).sky([0.2, 0.24, 0.32]).max_bounces(3);
//! let rendered = renderer.render(&request, &())?;
//! let raw = rendered.color.expect("the scene is lit").to_elemental_grid()?;
//! assert_eq!(raw.dim(), (20 * 8, 30 * 8, 3));
//! # Ok(())
//! # }
//! ```

// Allowed in two modules: the binding to Embree and the SIMD dispatch.
#![deny(unsafe_code)]

/// Setters of public fields. Each returns the changed options.
macro_rules! setters {
    ($($name:ident: $type:ty),* $(,)?) => {$(
        #[doc = concat!("Sets [`", stringify!($name), "`](field@Self::", stringify!($name), ").")]
        #[must_use]
        pub fn $name(mut self, $name: $type) -> Self {
            self.$name = $name;
            self
        }
    )*};
}

mod accel;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub use render::bench;
mod camera;
mod error;
mod film;
mod geometry;
mod integrator;
mod light;
mod material;
#[cfg(test)]
#[path = "../../../tests/all/common/peer.rs"]
mod peer;
mod render;
mod sampling;
mod simd;

pub use accel::{Backend, cache_folder};
pub use camera::framing::{AspectChange, Baseline, CameraChoice, Framed, Framing};
pub use error::Error;
pub use film::error_distribution::ErrorDistribution;
pub use film::layers::{Layer, LayerSet, Layers};
pub use film::{exposure, layers};
pub use integrator::progress::{Progress, Tenths};
pub use integrator::{Integrator, RayCounts};
pub use render::{
    Camera, Checkpoint, Denoise, FinishedTile, Frame, GroundTruth, Motion, RawStatistics, Rendered, Renderer, Request,
    Reuse, TextureFilter, TileId, TileKind, Transport, Views, World,
};
pub use sampling::{SamplesPerPixel, Sampling};
