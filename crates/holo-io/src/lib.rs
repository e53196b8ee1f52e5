//! The files of holoscopic imaging: raw images, float maps, camera parameters, manifests.
//!
//! # Conventions
//!
//! - Arrays are `(rows, columns)` or `(rows, columns, channels)`, the top row first, with any strides: writers take views
//!   of any memory order and never copy the image as a whole. Nothing is ever flipped; where a format stores the bottom
//!   row first (PFM), that stays inside its file.
//! - In files and in text a size is columns x rows; in code rows come first ([`GridSize`](holo_core::GridSize)).
//! - Depth is planar and in metres, `+infinity` where nothing was hit. Disparity is in pixels between adjacent views,
//!   positive nearer than the focus plane. Millimetres occur only in fields whose name says so, because their files do.
//! - A file appears whole or not at all: it is written under a temporary name in its folder, synced, and renamed
//!   ([`AtomicFile`]).
//! - Writers return the size and SHA-256 of what they wrote ([`Written`]), which is what a [`Manifest`] lists.
//! - Equal inputs give equal bytes: no clock, no path and no random number gets into a file.
//! - Readers take a budget ([`Limits`]) and compare it with what a file announces before they ask for memory. A damaged
//!   file is an [`Error::Broken`], never a panic.
//!
//! # Formats
//!
//! | format | write | read |
//! |---|---|---|
//! | PNG, 8 and 16 bit | [`write_png_u8`], [`write_png_u16`], [`write_disparity_png`] | [`read_png`], [`read_png_info`] |
//! | PNG in memory | [`encode_png_u8`], [`encode_png_u16`] | [`decode_png`] |
//! | PFM | [`write_pfm`], [`write_pfm_colour`] | [`read_pfm`], [`read_pfm_grey`], [`read_pfm_info`] |
//! | PFM in memory | [`Pfm::to_bytes`] | [`decode_pfm`] |
//! | `parameters.cfg` | [`ParametersCfg::write`] | [`ParametersCfg::read`] |
//! | `manifest.json` | [`Manifest::write`] | [`Manifest::read`], [`Manifest::verify`] |
//! | raw PNG with its `parameters.cfg` | | [`RawImage::read`] |
//! | any of these | | [`recognise`] |
//!
//! The names of the files in a dataset folder are in [`dataset`]; [`layout_of_file_name`] tells its two raw images apart.
//!
//! # Features
//!
//! `png` (on by default): everything that needs a PNG codec. PFM, `parameters.cfg` and the manifest are always there.
//!
//! # What is not here
//!
//! No pixel is computed: exposure, the sRGB curve and the change of layout happen before. Nothing is printed and no
//! process is ended. Folders are not created.
#![forbid(unsafe_code)]
#![warn(missing_docs)]
// The table above names what the feature adds.
#![cfg_attr(not(feature = "png"), allow(rustdoc::broken_intra_doc_links))]

mod atomic;
pub mod dataset;
mod error;
mod limits;
mod manifest;
mod millimetres;
mod parameters_cfg;
mod pfm;
#[cfg(feature = "png")]
mod png;
mod raw_image;
mod recognise;

pub use atomic::{
    AtomicFile, Sha256, Written, hash_file, remove_stale_temporary_files, remove_temporary_files, write_file,
};
pub use error::Error;
pub use limits::Limits;
pub use manifest::{Manifest, ManifestRig, Problem, ProblemKind, Setting};
pub use parameters_cfg::{CameraPose, ParametersCfg, date_from_epoch};
pub use pfm::{Pfm, PfmInfo, decode_pfm, read_pfm, read_pfm_grey, read_pfm_info, write_pfm, write_pfm_colour};
#[cfg(feature = "png")]
pub use png::{
    Compression, Meaning, PngInfo, PngSamples, decode_png, encode_png_u8, encode_png_u16, read_png, read_png_info,
    write_disparity_png, write_png_u8, write_png_u16,
};
#[cfg(feature = "png")]
pub use raw_image::RawImage;
pub use raw_image::layout_of_file_name;
pub use recognise::{FileKind, recognise};
