//! The files of a render: what is written, under which names, into a folder that is rolled back after an error.
//!
//! **May import:** settings.

pub(crate) mod codes;
mod exr;
mod files;
mod folder;
mod images;
pub(crate) mod layers;
mod masks;
mod memory;
mod motion;
mod names;
pub(crate) mod poses;
pub(crate) mod raw;
pub(crate) mod sequence;
mod statistics;
mod subset;
mod tools;
mod wanted;

pub(crate) use self::codes::Exposed;
pub(crate) use self::files::{Traced, TracedCamera, TracedViews, exposure_ev, write};
pub(crate) use self::folder::{CHECKPOINT, CHECKPOINT_MAGIC, checkpoints, existing, inner_name, remove_checkpoints};
pub use self::folder::{OutputFolder, Rollback};
pub(crate) use self::images::HIGHRES_SCALE;
pub(crate) use self::masks::OBJECTS_PNG;
pub(crate) use self::memory::is_room;
pub(crate) use self::statistics::Finished;
pub use self::statistics::{ColorStatistics, EstimatedError, Statistics};
pub(crate) use self::tools::stopped;
pub(crate) use self::wanted::Wanted;
#[cfg(not(feature = "hdf5"))]
pub(crate) use self::wanted::without_hdf5;

/// The cameras in the folder of several poses.
pub(crate) use holo_io::dataset::TRANSFORMS_JSON as TRANSFORMS;
