//! Cameras: the rig of parallel pinhole cameras that stands for an ideal holoscopic camera. **May enter:** layouts, Eq. 3.

mod intrinsics;
mod parameters;
mod rig;

pub use intrinsics::{Intrinsics, automatic_baseline_m};
pub use parameters::RigParameters;
pub use rig::{Rig, RigRay};
