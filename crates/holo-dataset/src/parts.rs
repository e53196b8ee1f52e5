//! The progress of work that is a part of something else.

use holo_render::Progress;

/// Passes cancellation on, and reports nothing: for a step that is not counted.
#[derive(Clone, Copy)]
pub struct CancelOnly<'a>(pub &'a dyn Progress);

impl Progress for CancelOnly<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// The progress of one of several images of the same size, as that of all of them.
#[derive(Clone, Copy)]
pub struct PartProgress<'a> {
    /// The progress of all.
    pub inner: &'a dyn Progress,
    /// The number of the image, from 0.
    pub k: usize,
    /// The number of images.
    pub of: usize,
}

impl Progress for PartProgress<'_> {
    fn advance(&self, done: u64, total: u64) {
        self.inner.advance(self.k as u64 * total + done, self.of as u64 * total);
    }

    fn cancelled(&self) -> bool {
        self.inner.cancelled()
    }
}
