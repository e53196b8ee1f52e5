//! One command a file.

pub mod extract;
pub mod info;
pub mod remap;
pub mod render;
pub mod scene;
pub mod verify;

mod exr;
mod layers;
mod output;
mod pictures;
mod prepare;
mod raw;
mod sky;

pub use output::take_back;
