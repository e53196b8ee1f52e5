//! What a folder says of itself: manifests and the record of a dataset.

pub mod dataset;
pub(crate) mod manifest;
