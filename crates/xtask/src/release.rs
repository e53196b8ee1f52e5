//! What is shipped: packages, archives, licenses.

pub(crate) mod dist;
pub(crate) mod licenses;
pub(crate) mod package;
