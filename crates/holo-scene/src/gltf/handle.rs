//! What stands for a validated accessor.

/// A validated accessor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Handle {
    /// Its index in the file, for messages.
    pub(super) number: usize,
    pub(super) count: usize,
    /// Its index in the document for the `gltf` crate.
    pub(super) checked: usize,
}
