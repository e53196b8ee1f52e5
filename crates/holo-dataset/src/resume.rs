//! Continuing: which folder is up to date, checkpoints of long renders, and shards that become one image.
//!
//! **May import:** settings, output.

pub(crate) mod checkpoint;
pub(crate) mod identity;
pub(crate) mod merge;
mod outcome;

pub use self::checkpoint::Checkpoints;
pub(crate) use self::checkpoint::finished_manifest;
pub use self::merge::merge;
pub(crate) use self::outcome::done;
