//! The rig of parallel pinhole cameras that models an ideal holoscopic camera. **May import:** layouts, Eq. 3.

mod baseline_ratio;
mod builder;
mod intrinsics;
mod rig;
mod two_plane;

pub use baseline_ratio::BaselineRatio;
pub use builder::RigBuilder;
pub use intrinsics::{Intrinsics, automatic_baseline_m};
pub use rig::{Rig, RigRay};
