//! Fuzz targets as plain functions: each takes any bytes and panics where a property does not hold.
#![forbid(unsafe_code)]

mod gltf;
pub mod io;

pub use gltf::gltf;
