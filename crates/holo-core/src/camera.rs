//! The rig of parallel pinhole cameras that models an ideal holoscopic camera, and pinhole cameras anywhere. **May import:**
//! layouts, Eq. 3, random numbers of the sensor.

mod baseline_ratio;
mod builder;
mod correspondence;
mod intrinsics;
mod jitter;
mod pinhole;
mod rig;
mod rotation;
mod two_plane;

pub use baseline_ratio::BaselineRatio;
pub use builder::RigBuilder;
pub use correspondence::Correspondence;
pub use intrinsics::{Intrinsics, automatic_baseline_m};
pub use jitter::{CameraDeviation, CameraJitter};
pub use pinhole::Pinhole;
pub(crate) use pinhole::Relative;
pub use rig::{Rig, RigRay};
pub use rotation::{rotation_near, rotation_of};
