//! One command a file.

pub mod animate;
pub mod array;
pub mod benchmark;
pub mod camera;
pub mod compose;
pub mod correspond;
pub mod dataset;
pub mod depth;
pub mod develop;
pub mod display;
pub mod epi;
pub mod eval;
pub mod export;
pub mod extract;
pub mod info;
pub mod merge;
pub mod optics;
pub mod pack;
pub mod preview;
pub mod quilt;
pub mod refocus;
pub mod remap;
pub mod render;
pub mod rotate;
pub mod scene;
pub mod synthesize;
pub mod verify;
pub mod view;

mod array_view;
mod files;
