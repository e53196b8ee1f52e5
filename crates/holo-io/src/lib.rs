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
//! | PNGs or TIFFs, one a view | | [`read_views`] |
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
//! On by default: `png`, everything that needs a PNG codec; `exr`, OpenEXR, through the crate `exr`; `hdr`, Radiance
//! HDR, which needs no other crate; `mat`, MAT files of version 5, whose numbers the crate `matfile` decodes; `tiff`, TIFF, through the crate `tiff`; `gif`, animated
//! GIF; `camera`, camera files, through the crate `toml`. On request: `hdf5`, HDF5, and with `mat` MAT files of version 7.3; it builds the HDF5 library from its C source, which
//! needs CMake. PFM, `parameters.cfg` and the manifest are always there, and so is [`detect_format`] for every format.
//!
//! # Panics in decoders
//!
//! The crates `exr`, `matfile` and `tiff` may panic on a damaged file. A panic guard turns such a panic into an [`Error`]. A
//! program whose panic hook prints should call [`is_guarding`] first and print nothing where it is true. The HDF5
//! library is C code: read `.h5` and version 7.3 files only from sources you trust.
//!
//! # What is not here
//!
//! The writers leave the pixels as they are: exposure, the sRGB curve and the change of layout are the caller's. The
//! crate prints nothing, ends no process and creates no folders.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// The table above names what the features add.
#![cfg_attr(
    not(all(
        feature = "png",
        feature = "exr",
        feature = "hdr",
        feature = "mat",
        feature = "tiff",
        feature = "gif",
        feature = "camera"
    )),
    allow(rustdoc::broken_intra_doc_links)
)]

#[cfg(feature = "png")]
mod animation;
#[cfg(feature = "png")]
mod array_folder;
mod atomic;
#[cfg(feature = "camera")]
mod camera_file;
pub mod dataset;
mod detect_format;
mod digest;
#[cfg(feature = "camera")]
mod display_file;
#[cfg(feature = "tiff")]
mod dng;
mod dng_header;
mod error;
#[cfg(feature = "exr")]
mod exr;
mod flo;
mod folder;
#[cfg(feature = "png")]
pub mod gantry;
#[cfg(feature = "gif")]
mod gif;
#[cfg(feature = "png")]
pub mod hci;
#[cfg(feature = "hdf5")]
mod hdf5;
#[cfg(feature = "hdr")]
mod hdr;
#[cfg(feature = "png")]
mod image_file;
#[cfg(feature = "camera")]
pub mod interop;
#[cfg(any(feature = "png", feature = "mat", feature = "hdf5"))]
mod light_field;
mod limits;
#[cfg(feature = "png")]
mod linear_image;
mod manifest;
#[cfg(feature = "mat")]
mod mat;
mod mosaic;
mod mp4;
mod names;
mod npy;
mod panic_guard;
mod parameters_cfg;
mod pfm;
#[cfg(feature = "png")]
mod png;
#[cfg(feature = "png")]
mod probe;
mod raw_image;
#[cfg(any(feature = "mat", feature = "hdf5"))]
mod rig_values;
mod stream;
#[cfg(feature = "tiff")]
mod tiff;
mod transforms;
#[cfg(feature = "png")]
mod views;
#[cfg(any(feature = "png", feature = "exr", feature = "mat"))]
mod zlib;

#[cfg(feature = "png")]
pub use animation::write_animation;
#[cfg(feature = "png")]
pub use array_folder::ArrayFolder;
pub use atomic::{AtomicFile, TemporaryFilesRemoved, remove_stale_temporary_files, remove_temporary_files, write_file};
#[cfg(feature = "camera")]
pub use camera_file::{CameraFile, SensorNoise, read_prescription};
pub use detect_format::{FileFormat, detect_format};
pub use digest::{FileDigest, Sha256, hash_file};
#[cfg(feature = "camera")]
pub use display_file::DisplayFile;
#[cfg(feature = "tiff")]
pub use dng::write_dng;
pub use dng_header::{DngInfo, read_dng_info};
pub use error::Error;
#[cfg(feature = "exr")]
pub use exr::{
    ExrChannel, ExrCompression, ExrImage, ExrInfo, ExrSamples, ExrWriter, decode_exr, decode_exr_rgb, encode_exr,
    encode_exr_with, read_exr, read_exr_info, read_exr_rgb, write_exr, write_exr_with,
};
pub use flo::{decode_flo, read_flo, write_flo};
pub use folder::{Destination, EntryKind, Folder, FolderFile, FolderLock};
#[cfg(feature = "png")]
pub use gantry::{GantryFolder, GantryPosition};
#[cfg(feature = "gif")]
pub use gif::write_gif_animation;
#[cfg(feature = "png")]
pub use hci::{HciFolder, HciHighResolution, HciImage, HciQuantity, HciResolution, HciSubset, HciTruth};
#[cfg(feature = "hdf5")]
pub use hdf5::{
    Hdf5Arrays, Hdf5LightField, Hdf5Map, Hdf5Options, Hdf5Writer, is_light_field_hdf5, write_hdf5, write_hdf5_maps,
    write_hdf5_sequence,
};
#[cfg(feature = "hdr")]
pub use hdr::{HdrInfo, decode_hdr, read_hdr, read_hdr_info};
pub use holo_core::{ColorEncoding, meters_to_millimeters, millimeters_to_meters, shown};
#[cfg(feature = "png")]
pub use image_file::write_image;
#[cfg(feature = "png")]
pub use light_field::LightFieldFolder;
#[cfg(any(feature = "png", feature = "mat", feature = "hdf5"))]
pub use light_field::{
    LightFieldFile, LightFieldFormat, LightFieldReader, ReadOptions, list_images, read_light_field, read_rig,
};
pub use limits::Limits;
#[cfg(feature = "png")]
pub use linear_image::read_linear;
pub use manifest::{Manifest, ManifestValue, Mismatch, MismatchKind};
#[cfg(all(feature = "mat", feature = "hdf5"))]
pub use mat::MatWriter;
#[cfg(feature = "mat")]
pub use mat::{
    MatArray, MatClass, MatInfo, MatLightField, MatOptions, MatOrder, MatValue, MatVariable, MatVersion, decode_mat,
    encode_mat, read_mat, read_mat_info, read_mat_light_field, read_mat_variable, write_mat, write_mat_light_field,
};
pub use mosaic::MosaicInfo;
pub use mp4::write_mp4_animation;
pub use npy::encode_npy;
pub use panic_guard::is_guarding;
pub use parameters_cfg::{CameraPose, ParametersCfg, date_from_epoch};
pub use pfm::{
    Pfm, PfmInfo, decode_pfm, read_pfm, read_pfm_gray, read_pfm_in, read_pfm_info, write_pfm, write_pfm_rgb,
};
#[cfg(feature = "png")]
pub use png::{
    Compression, PngInfo, PngWriter, decode_png, encode_png, read_png, read_png_info, write_disparity_png, write_png,
    write_png_animation,
};
#[cfg(feature = "png")]
pub use probe::{FileInfo, probe};
pub use raw_image::layout_of_file_name;
#[cfg(feature = "tiff")]
pub use tiff::{TiffInfo, decode_tiff, encode_tiff, read_tiff, read_tiff_info, write_tiff};
pub use transforms::{ArrayCamera, CameraArray, WorldUp};
#[cfg(feature = "png")]
pub use views::read_views;
