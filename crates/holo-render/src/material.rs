//! Materials: surface interactions at ray hits, and their BSDFs.
//!
//! A [`SurfaceInteraction`] is a packet of sixteen hit points with normals and base colors. [`Appearance`] evaluates
//! textures and material parameters, the color of camera rays as the mean over their [`Footprints`]. [`bsdf`] evaluates and samples the scattering. [`media`] fill bodies of glass. [`AlphaTested`] lets rays pass
//! through surfaces according to their alpha. **May import:** geometry, hits ([`crate::accel`]), random numbers,
//! scenes.

mod alpha;
mod appearance;
pub(crate) mod bsdf;
mod flags;
mod footprint;
pub(crate) mod media;
pub(crate) mod shading_normal;
mod surface;
mod texture;

pub(crate) use alpha::{AlphaTest, AlphaTested};
pub(crate) use appearance::{Appearance, Lane};
pub(crate) use flags::MaterialFlags;
pub(crate) use footprint::Footprints;
pub(crate) use surface::{HitPoints, SurfaceInteraction};
