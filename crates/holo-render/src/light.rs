//! Where light comes from: punctual lights and suns, emissive triangles, the environment around the scene.
//!
//! Each is sampled by its own pdf and says that pdf for rays that meet it by chance; what its light does to a surface is the
//! integrator's business. **May enter:** geometry, random numbers, scenes.

mod emitters;
mod environment;
mod punctual;

pub(crate) use emitters::Emitters;
pub(crate) use environment::EnvironmentLight;
pub(crate) use punctual::{PreparedLight, SHADOW_REACH, prepare};
