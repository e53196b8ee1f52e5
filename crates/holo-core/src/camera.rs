//! The rig of parallel pinhole cameras that models an ideal holoscopic camera, and pinhole cameras anywhere. **May import:**
//! layouts, Eq. 3, random numbers of the sensor.

mod baseline_ratio;
mod builder;
mod correspondence;
pub(crate) mod disparity;
mod intrinsics;
mod jitter;
pub mod optics;
mod pinhole;
mod rig;
mod rotation;
#[cfg(feature = "serde")]
pub(crate) mod serialize;
mod two_plane;

pub use baseline_ratio::BaselineRatio;
pub use builder::RigBuilder;
pub use correspondence::Correspondence;
pub use intrinsics::{Intrinsics, automatic_baseline_m};
pub use jitter::{CameraDeviation, CameraJitter};
pub use pinhole::Pinhole;
pub(crate) use pinhole::Relative;
pub use rig::{Rig, RigRay};
pub(crate) use rotation::cross;
pub use rotation::{rotation_near, rotation_of};
