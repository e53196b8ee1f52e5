//! The camera's side: decoding and developing raw images, calibration targets, optics in numbers, placements, and what arrays of
//! cameras see together.
//!
//! **May import:** settings, output, resume, shot.

mod array;
mod benchmark;
mod calibrate;
mod compote;
mod decode;
mod develop;
mod linear_image;
mod optics;
mod placement;
mod quantity;
mod score;
mod some_views;
mod target;

pub use self::array::{
    ArrayDepth, ArrayViewpoint, correspondences, estimate_depth, synthesize_from_array, synthetic_aperture,
};
pub use self::benchmark::{BenchmarkSize, CalibrationBenchmark};
pub use self::calibrate::{Calibrated, KnownCamera};
pub use self::decode::{DecodeJob, write_white_images};
pub use self::develop::{DemosaicMethod, DevelopJob, DevelopOutput, Developed, write_demosaiced};
pub use self::linear_image::{camera_of_raw, read_raw, read_white};
pub use self::optics::{camera_optics, planned_rig, rig_optics};
pub use self::placement::{Placement, Surface, jittered};
pub use self::quantity::{NamedQuantity, QuantityValue};
pub use self::score::{calibration_score, grid_score};
pub use self::some_views::estimate_from_views;
pub use self::target::{BoardPose, TargetJob, read_poses};
