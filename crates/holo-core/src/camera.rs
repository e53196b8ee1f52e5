//! Cameras: the rig of parallel pinhole cameras that stands for an ideal holoscopic camera. **May enter:** layouts, Eq. 3.

mod builder;
mod intrinsics;
mod rig;

pub use builder::RigBuilder;
pub use intrinsics::{Intrinsics, automatic_baseline_m};
pub use rig::{Rig, RigRay};
