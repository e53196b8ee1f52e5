//! One command a file.

pub mod extract;
pub mod info;
pub mod remap;
pub mod render;
pub mod scene;
pub mod verify;

mod output;
mod prepare;
mod raw;

pub use output::take_back;
