//! `holo remap`: one grid into the other.

use holo_core::{Layout, LightFieldOwned};
use holo_io::{Compression, Meaning};

use super::raw::{self, Raw};
use crate::arguments::RemapOptions;
use crate::failure::Failure;

pub fn run(options: &RemapOptions) -> Result<(), Failure> {
    let (image, from) = raw::read(&options.input, options.from, options.views)?;
    let to = match (options.to, from) {
        (Some(to), _) => raw::layout(to),
        (None, Layout::ElementalGrid) => Layout::ViewpointGrid,
        (None, Layout::ViewpointGrid) => Layout::ElementalGrid,
    };
    let out = &options.output;
    match image {
        Raw::U8(field) => holo_io::write_png_u8(out, grid(field, to).view(), Meaning::Srgb, Compression::Published)?,
        Raw::U16(field) => holo_io::write_png_u16(out, grid(field, to).view(), Meaning::Srgb, Compression::Published)?,
    };
    Ok(())
}

/// The grid, without a copy where the memory already is that grid.
fn grid<T: Copy + Send + Sync>(field: LightFieldOwned<T>, to: Layout) -> ndarray::Array3<T> {
    match to {
        Layout::ElementalGrid => field.into_elemental_grid().unwrap_or_else(|field| field.to_elemental_grid()),
        Layout::ViewpointGrid => field.into_viewpoint_grid().unwrap_or_else(|field| field.to_viewpoint_grid()),
    }
}
