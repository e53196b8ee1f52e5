//! A light field as one HTML page that needs no other file and no network.
//!
//! The page contains the raw image as a PNG and the maps of the central view as floats. Its scripts (`page/`) compute
//! views, refocused images and error maps from them. This crate only converts samples that a browser cannot show to 8
//! bits.
//!
//! # Examples
//!
//! ```
//! use holo_core::{GridSize, Layout, LightField, LightFieldShape};
//! use holo_io::{ColorEncoding, Compression, LightFieldReader, ReadOptions, write_png};
//! use holo_viewer::Page;
//!
//! # let folder = tempfile::tempdir()?;
//! let path = folder.path().join("scene_el.png");
//! let shape = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(4, 5))?;
//! let light_field = LightField::filled(shape, 3, Layout::ElementalGrid, 7_u8)?;
//! write_png(&path, light_field.to_elemental_grid()?.view(), ColorEncoding::Srgb, Compression::Fast)?;
//!
//! let reader = LightFieldReader::open(&path, &ReadOptions::default().views(GridSize::new(3, 3)))?;
//! let mut html = Vec::new();
//! Page::new("a light field", reader)?.write(&mut html)?;
//! assert!(html.starts_with(b"<!DOCTYPE html>"));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

mod contents;
mod page;

pub use contents::{Error, Page};
