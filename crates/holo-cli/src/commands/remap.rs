//! `holo remap`: one grid into the other; and what else is written as a grid.

use std::path::Path;

use holo_core::{Layout, LightFieldOwned};
use holo_io::{ColorEncoding, Compression};

use super::raw::{self, Raw};
use crate::arguments::{LayoutArgument, RemapOptions};
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &RemapOptions) -> Result<(), Failure> {
    let (image, from) = raw::read_input(&options.input)?;
    let other = from.map(|from| match from {
        Layout::ElementalGrid => Layout::ViewpointGrid,
        Layout::ViewpointGrid => Layout::ElementalGrid,
    });
    let to = output_layout(options.to, &options.output, other)?;
    write_grid(image, to, &options.output, &options.input.input)
}

/// The grid to write: what `--to` says, or else the name of the file, or else `default`.
pub fn output_layout(to: Option<LayoutArgument>, out: &Path, default: Option<Layout>) -> Result<Layout, Failure> {
    let named = holo_io::layout_of_file_name(out);
    let to = to.map(raw::layout).or(named).or(default).ok_or_else(|| {
        Failure::Usage(format!("{}: neither --to nor the name (_el, _vpi) says which grid to write", out.display()))
    })?;
    if named.is_some_and(|named| named != to) {
        say!("warning: {} says the other grid by its name; reading it back will need --from", out.display());
    }
    Ok(to)
}

/// Writes a whole light field as a PNG. `input` is where it comes from.
pub fn write_grid(image: Raw, to: Layout, out: &Path, input: &Path) -> Result<(), Failure> {
    match image {
        Raw::U8(field) => holo_io::write_png(out, grid(field, to)?.view(), ColorEncoding::Srgb, Compression::Best)?,
        Raw::Float(_) => {
            return Err(Failure::Usage(format!("{} holds linear floats, which no PNG can", input.display())));
        }
        Raw::U16(field) => holo_io::write_png(out, grid(field, to)?.view(), ColorEncoding::Srgb, Compression::Best)?,
    };
    Ok(())
}

/// The grid, without a copy where the memory already is that grid.
fn grid<T: Copy + Send + Sync>(field: LightFieldOwned<T>, to: Layout) -> Result<ndarray::Array3<T>, holo_core::Error> {
    match to {
        Layout::ElementalGrid => field.into_elemental_grid().or_else(|field| field.to_elemental_grid()),
        Layout::ViewpointGrid => field.into_viewpoint_grid().or_else(|field| field.to_viewpoint_grid()),
    }
}
