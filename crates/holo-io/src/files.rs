//! Files and folders as such: atomic writes, folders by their handles, limits, digests, kinds of files, deflate.

pub(crate) mod atomic;
pub(crate) mod detect_format;
pub(crate) mod digest;
pub(crate) mod dng_header;
pub(crate) mod folder;
pub(crate) mod limits;
pub(crate) mod names;
pub(crate) mod panic_guard;
pub(crate) mod stream;
pub(crate) mod zlib;

pub use detect_format::detect_format;
