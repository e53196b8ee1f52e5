//! The files of holoscopic imaging: raw images, float maps, environment maps, camera parameters, manifests.
//!
//! # Conventions
//!
//! - Arrays are `(rows, columns)` or `(rows, columns, channels)`, the top row first, with any strides: writers take
//!   views of any memory order and never copy the image as a whole. What does not fit into memory is written band by
//!   band ([`PngWriter`], [`ExrWriter`], `MatWriter`, `Hdf5Writer`). Nothing is flipped: PFM stores the bottom row
//!   first, and only inside its file.
//! - In files and in text a size is columns x rows; in code rows come first ([`GridSize`](holo_core::GridSize)).
//! - Depth is planar and in meters, `+infinity` where nothing was hit. Disparity is in pixels between adjacent views,
//!   positive nearer than the focus plane. Millimeters occur only in fields whose name says so, because their files do.
//! - A file appears whole or not at all: it is written under a temporary name in its folder, synced, and renamed
//!   ([`AtomicFile`]).
//! - Writers take a path or a place in an open folder ([`Folder`], [`Destination`]), which no link and no `..` leaves.
//! - Text of files is escaped before it is shown ([`shown`]).
//! - `decode_*` read from any [`Read`](std::io::Read) and `encode_*` write into any [`Write`](std::io::Write), with
//!   neither temporary file nor digest nor sync, which are then the caller's choice. HDF5 needs a file: its library
//!   opens paths.
//! - Writers return the size and SHA-256 of what they wrote ([`FileDigest`]), which is what a [`Manifest`] lists.
//! - Equal inputs give equal bytes: no clock, no path and no random number gets into a file.
//! - Readers take a budget ([`Limits`]) and compare it with what a file announces before they allocate. A damaged file
//!   is an [`Error::Broken`], never a panic.
//!
//! # Formats
//!
//! | format | write | read |
//! |---|---|---|
//! | PNG, 8 and 16 bit | [`write_png`], [`write_disparity_png`], [`PngWriter`] | [`read_png`], [`read_png_info`] |
//! | animated PNG | [`write_png_animation`] | |
//! | animated GIF | [`write_gif_animation`] | |
//! | MP4 | [`write_mp4_animation`], by the program `ffmpeg` | |
//! | PNGs, TIFFs or SGI images, one a view | | [`read_views`] |
//! | PNG as a stream | [`encode_png`] | [`decode_png`] |
//! | TIFF, 8 and 16 bit, 32- and 64-bit float | [`write_tiff`] | [`read_tiff`], [`read_tiff_info`] |
//! | TIFF as a stream | [`encode_tiff`] | [`decode_tiff`] |
//! | PFM | [`write_pfm`], [`write_pfm_rgb`] | [`read_pfm`], [`read_pfm_gray`], [`read_pfm_info`] |
//! | PFM as a stream | [`Pfm::encode`] | [`decode_pfm`] |
//! | optical flow, `.flo` | [`write_flo`] | [`read_flo`], [`decode_flo`] |
//! | EXR, 32- or 16-bit float | [`write_exr`], [`write_exr_with`], [`ExrWriter`] | [`read_exr`], [`read_exr_rgb`] |
//! | header of an EXR | | [`read_exr_info`] |
//! | EXR as a stream | [`encode_exr`], [`encode_exr_with`] | [`decode_exr`], [`decode_exr_rgb`] |
//! | MAT, versions 5 and 7.3 | [`write_mat`] | [`read_mat`], [`read_mat_variable`], [`read_mat_info`] |
//! | light field as MAT | [`write_mat_light_field`]; `MatWriter` lens row by lens row | [`read_mat_light_field`] |
//! | MAT, version 5, as a stream | [`encode_mat`] | [`decode_mat`] |
//! | HDF5 | `write_hdf5`; `Hdf5Writer` lens row by lens row | `Hdf5LightField`: all, one view, one lens |
//! | HDF5 of a sequence | `write_hdf5_sequence` | frame by frame |
//! | Radiance HDR | | [`read_hdr`], [`read_hdr_info`]; as a stream [`decode_hdr`] |
//! | `parameters.cfg` | [`ParametersCfg::write`] | [`ParametersCfg::read`] |
//! | cameras anywhere, `transforms.json` | [`CameraArray::write`] | [`CameraArray::read`] |
//! | plenoptic camera, TOML | [`CameraFile::to_toml`] | [`CameraFile::read`] |
//! | display, TOML or Looking Glass calibration | | [`DisplayFile::read`] |
//! | plenoptic camera, for other programs | [`interop`] | |
//! | `manifest.json` | [`Manifest::write`] | [`Manifest::read`], [`Manifest::verify`] |
//! | DNG of a sensor's codes | [`write_dng`] | its header: [`read_dng_info`] |
//! | PNG, PFM or TIFF, by the file extension | [`write_image`] | |
//! | PNG, PFM, TIFF or EXR in linear light | | [`read_linear`] |
//! | any light field: folder, raw PNG, TIFF or EXR, raw image of a plenoptic camera, MAT, HDF5 | | [`read_light_field`], [`LightFieldReader`] |
//! | what a folder holds a light field in | | [`LightFieldFolder`] |
//! | the rig of any of them | | [`read_rig`] |
//! | dataset folder | file by file | [`dataset::DatasetFolder`] |
//! | folder of a plenoptic camera | file by file | [`dataset::PlenopticFolder`] |
//! | dataset of many folders | [`dataset::DatasetIndex::write`] | [`dataset::DatasetIndex::read`], [`dataset::list`] |
//! | HCI folder | [`HciImage::write`] | [`HciFolder::open`] |
//! | folder of the Stanford Lego gantry | | [`GantryFolder::open`] |
//! | the format of any of these files | | [`detect_format`] |
//! | what any of these files and folders contains, without its pixels | | [`probe`] |
//!
//! The names of the files in a dataset folder are in [`dataset`]. [`layout_of_file_name`] distinguishes its two raw
//! images.
//!
//! # Features
//!
//! `hdf5`: HDF5 and MAT files of version 7.3. It builds the HDF5 library from its C source, which needs CMake. All other
//! formats are always there.
//!
//! # Panics in decoders
//!
//! The crates `exr`, `matfile`, `tiff` and `image-extras` may panic on a damaged file. A panic guard turns such a panic into an [`Error`]. A
//! program whose panic hook prints should call [`is_guarding`] first and print nothing where it is true. The HDF5
//! library is C code: read `.h5` and version 7.3 files only from sources you trust.
//!
//! # What is not here
//!
//! The writers leave the pixels as they are: exposure, the sRGB curve and the change of layout are the caller's. The
//! crate prints nothing, ends no process, and creates folders only on request.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// The table above names what the features add.
#![cfg_attr(not(feature = "hdf5"), allow(rustdoc::broken_intra_doc_links))]

mod arrays;
mod cameras;
mod files;
mod images;
mod records;
pub use records::dataset;
mod error;
pub use light_field::gantry;
pub use light_field::hci;
pub mod interop;
mod light_field;

#[cfg(feature = "hdf5")]
pub use arrays::hdf5::{
    Hdf5Arrays, Hdf5LightField, Hdf5Map, Hdf5Options, Hdf5Writer, is_light_field_hdf5, write_hdf5, write_hdf5_maps,
    write_hdf5_sequence,
};
#[cfg(feature = "hdf5")]
pub use arrays::mat::MatWriter;
pub use arrays::mat::{
    MatArray, MatClass, MatInfo, MatLightField, MatOptions, MatOrder, MatValue, MatVariable, MatVersion, decode_mat,
    encode_mat, read_mat, read_mat_info, read_mat_light_field, read_mat_variable, write_mat, write_mat_light_field,
};
pub use arrays::npy::encode_npy;
pub use cameras::camera_file::{CameraFile, SensorNoise, read_prescription};
pub use cameras::display_file::DisplayFile;
pub use cameras::parameters_cfg::{CameraPose, ParametersCfg, date_from_epoch};
pub use cameras::transforms::{ArrayCamera, CameraArray, WorldUp};
pub use error::Error;
pub use files::atomic::{
    AtomicFile, TemporaryFilesRemoved, remove_stale_temporary_files, remove_temporary_files, write_file,
};
pub use files::detect_format::{FileFormat, detect_format};
pub use files::digest::{FileDigest, Sha256, hash_file};
pub use files::dng_header::{DngInfo, read_dng_info};
pub use files::folder::{Destination, EntryKind, Folder, FolderFile, FolderLock};
pub use files::limits::Limits;
pub use files::panic_guard::is_guarding;
pub use holo_core::{ColorEncoding, meters_to_millimeters, millimeters_to_meters, shown};
pub use images::animation::write_animation;
pub use images::dng::write_dng;
pub use images::exr::{
    ExrChannel, ExrCompression, ExrImage, ExrInfo, ExrSamples, ExrWriter, decode_exr, decode_exr_rgb, encode_exr,
    encode_exr_with, read_exr, read_exr_info, read_exr_rgb, write_exr, write_exr_with,
};
pub use images::flo::{decode_flo, read_flo, write_flo};
pub use images::gif::write_gif_animation;
pub use images::hdr::{HdrInfo, decode_hdr, read_hdr, read_hdr_info};
pub use images::image_file::write_image;
pub use images::linear_image::read_linear;
pub use images::mosaic::MosaicInfo;
pub use images::mp4::write_mp4_animation;
pub use images::pfm::{
    Pfm, PfmInfo, decode_pfm, read_pfm, read_pfm_gray, read_pfm_in, read_pfm_info, write_pfm, write_pfm_rgb,
};
pub use images::png::{
    Compression, PngInfo, PngWriter, decode_png, encode_png, read_png, read_png_info, write_disparity_png, write_png,
    write_png_animation,
};
pub use images::tiff::{TiffInfo, decode_tiff, encode_tiff, read_tiff, read_tiff_info, write_tiff};
pub use light_field::LightFieldFolder;
pub use light_field::array_folder::ArrayFolder;
pub use light_field::gantry::{GantryFolder, GantryPosition};
pub use light_field::hci::{HciFolder, HciHighResolution, HciImage, HciQuantity, HciResolution, HciSubset, HciTruth};
pub use light_field::probe::{FileInfo, probe};
pub use light_field::raw_image::layout_of_file_name;
pub use light_field::views::read_views;
pub use light_field::{
    LightFieldFile, LightFieldFormat, LightFieldReader, ReadOptions, list_images, read_light_field, read_rig,
};
pub use records::manifest::{Manifest, ManifestValue, Mismatch, MismatchKind};
