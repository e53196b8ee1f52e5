//! Images and maps: a format a file, animations, and reading of any of them.

pub(crate) mod animation;
pub(crate) mod dng;
pub(crate) mod exr;
pub(crate) mod flo;
pub(crate) mod gif;
pub(crate) mod hdr;
pub(crate) mod image_file;
pub(crate) mod linear_image;
pub(crate) mod mosaic;
pub(crate) mod mp4;
pub(crate) mod pfm;
pub(crate) mod png;
pub(crate) mod sgi;
pub(crate) mod tiff;
