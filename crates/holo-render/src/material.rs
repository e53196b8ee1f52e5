//! What surfaces are where rays meet them: where the hit lies, what is there, how it scatters light.
//!
//! [`Surfaces`] are sixteen points on surfaces, [`Appearance`] looks up what textures and materials say about them,
//! [`bsdf`] evaluates and samples what they do with light, [`Holes`] lets rays through where a surface is transparent by its
//! alpha. **May enter:** geometry, hits ([`crate::accel`]), random numbers, scenes.

mod alpha;
mod appearance;
pub(crate) mod bsdf;
mod surface;
mod texture;

pub(crate) use alpha::{Cover, Holes};
pub(crate) use appearance::{Appearance, Kinds};
pub(crate) use surface::{HitPoints, Surfaces};
