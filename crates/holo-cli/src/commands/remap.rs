//! `holo remap`: one grid into the other.

use holo_core::{Layout, LightFieldOwned};
use holo_io::{Compression, Meaning};

use super::raw::{self, Raw};
use crate::arguments::RemapOptions;
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &RemapOptions) -> Result<(), Failure> {
    let (image, from) = raw::read(&options.input, options.from, options.views)?;
    let out = &options.output;
    let named = holo_io::layout_of_file_name(out);
    let other = from.map(|from| match from {
        Layout::ElementalGrid => Layout::ViewpointGrid,
        Layout::ViewpointGrid => Layout::ElementalGrid,
    });
    let to = options.to.map(raw::layout).or(named).or(other).ok_or_else(|| {
        Failure::Usage(format!("{}: neither --to nor the name (_el, _vpi) says which grid to write", out.display()))
    })?;
    if named.is_some_and(|named| named != to) {
        say!("warning: {} says the other grid by its name; reading it back will need --from", out.display());
    }
    match image {
        Raw::U8(field) => holo_io::write_png_u8(out, grid(field, to).view(), Meaning::Srgb, Compression::Published)?,
        Raw::Float(_) => {
            let input = options.input.display();
            return Err(Failure::Usage(format!("{input} holds linear floats, which no PNG can")));
        }
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
