//! What the root of a dataset says of its folders, whether they are as they say, and their archives.
//!
//! **May import:** settings, output, resume.

mod catalog;
pub(crate) mod index;
mod own;
mod verify;
mod webdataset;

pub use self::catalog::{Described, finished, write_catalog};
pub(crate) use self::verify::shots_of;
pub use self::verify::{Verification, is_dataset, verify};
pub use self::webdataset::{Archive, WebDataset};
