//! Light sources: punctual lights, directional lights with an angular diameter, emissive triangles, the environment
//! map.
//!
//! Each light source can be sampled, and provides the pdf of its samples for multiple importance sampling. **May
//! import:** geometry, random numbers, scenes.

mod emitters;
mod environment;
mod punctual;

pub(crate) use emitters::Emitters;
pub(crate) use environment::EnvironmentLight;
pub(crate) use punctual::{PreparedLight, SHADOW_REACH, prepare};
