//! From a 3D scene straight to a raw holoscopic image, with exact depth, disparity and other layers of ground truth.
//!
//! ```text
//! scene (glTF or code) -> geometry in camera coordinates -> rays lens by lens -> light field
//! ```
//!
//! # Conventions
//! - World: right-handed, +Y up, metres (glTF's frame). A camera looks along its -Z. See [`holo_scene`].
//! - Rays, rigs and the order of indices are those of [`holo_core`]: axes (v, u, t, s, c), lens first, view second.
//! - Depth is planar z along the optical axis; a miss is +infinity. Disparity is Eq. 3 between adjacent views. All outputs
//!   beside colour, by name: [`layers`].
//! - Colour is linear RGB radiance in the units of KHR_lights_punctual; only [`exposure`] makes display values of it.
//! - The result depends on the scene and the settings, never on threads or their timing.
//!
//! # Example
//! ```
//! use holo_core::{GridSize, LightFieldShape, Projection};
//! use holo_render::{Backend, Baseline, CameraChoice, Framing, Renderer, Request};
//!
//! # fn main() -> Result<(), holo_render::Error> {
//! let scene = holo_scene::gallery::scene("garden").expect("a scene of the gallery");
//! let framing = Framing {
//!     shape: LightFieldShape::new(GridSize::new(8, 8), GridSize::new(20, 30))?, // views, lenses
//!     camera: CameraChoice::First,
//!     focal_length_m: None,
//!     sensor_size_m: 0.036,
//!     baseline: Baseline::FNumber(5.0),
//!     projection: Projection::Perspective,
//! };
//! let framed = framing.frame(&scene)?;
//! let renderer = Renderer::new(&scene, &framed.pose, Backend::Auto, 0)?;
//! let rig = framed.rig(renderer.automatic_focus_m(&framed)?)?;
//! let request = Request {
//!     sky: [0.2, 0.24, 0.32],
//!     max_bounces: 3,
//!     ..Request::new(rig)
//! };
//! let rendered = renderer.render(&request, &())?;
//! let raw = rendered.color.expect("the scene is lit").to_elemental_grid()?;
//! assert_eq!(raw.dim(), (20 * 8, 30 * 8, 3));
//! # Ok(())
//! # }
//! ```

// Allowed in two files: the Embree seam and the SIMD dispatch.
#![deny(unsafe_code)]

mod accel;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod bench;
mod camera;
mod error;
mod film;
mod geometry;
mod integrator;
mod light;
mod material;
#[cfg(test)]
#[path = "../../../tests/common/peer.rs"]
mod peer;
mod progress;
mod render;
mod sampling;
mod simd;

pub use accel::Backend;
pub use camera::framing::{Baseline, CameraChoice, Framed, Framing};
pub use error::Error;
pub use film::layers::{Layer, LayerSet, Layers};
pub use film::{exposure, layers};
pub use integrator::{Integrator, RayCounts};
pub use progress::Progress;
pub use render::{GroundTruth, Rendered, Renderer, Request, Views};
pub use sampling::Sampling;
