//! Materials: surface interactions at ray hits, and their BSDFs.
//!
//! A [`SurfaceInteraction`] is a packet of sixteen hit points with normals and base colors. [`Appearance`] evaluates
//! textures and material parameters. [`bsdf`] evaluates and samples the scattering. [`media`] fill bodies of glass. [`AlphaTested`] lets rays pass
//! through surfaces according to their alpha. **May import:** geometry, hits ([`crate::accel`]), random numbers,
//! scenes.

mod alpha;
mod appearance;
pub(crate) mod bsdf;
pub(crate) mod media;
mod surface;
mod texture;

pub(crate) use alpha::{AlphaTest, AlphaTested};
pub(crate) use appearance::{Appearance, Lane, MaterialFlags};
pub(crate) use surface::{HitPoints, SurfaceInteraction};
