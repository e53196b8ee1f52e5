//! `holo remap`: one grid into the other; and what else is written as a grid.

use std::path::Path;

use holo_core::{DynLightField, Layout};

use super::files;
use crate::arguments::RemapOptions;
use crate::console::say;
use crate::failure::Failure;

pub fn run(options: &RemapOptions) -> Result<(), Failure> {
    let file = files::read(&options.input)?;
    let other = file.layout.map(|from| match from {
        Layout::ElementalGrid => Layout::ViewpointGrid,
        Layout::ViewpointGrid => Layout::ElementalGrid,
    });
    let to = output_layout(options.to, &options.output, other)?;
    write_grid(file.light_field, to, &options.output)
}

/// The grid to write: what `--to` says, or else the name of the file, or else `default`.
pub fn output_layout(to: Option<Layout>, out: &Path, default: Option<Layout>) -> Result<Layout, Failure> {
    let named = holo_io::layout_of_file_name(out);
    let to = to.or(named).or(default).ok_or_else(|| {
        Failure::Usage(format!("{}: neither --to nor the name (_el, _vpi) says which grid to write", out.display()))
    })?;
    if named.is_some_and(|named| named != to) {
        say!("warning: {} says the other grid by its name; reading it back will need --from", out.display());
    }
    Ok(to)
}

/// Writes a whole light field as an image: integers as PNG or TIFF, floats as PFM or TIFF.
pub fn write_grid(light_field: DynLightField, to: Layout, out: &Path) -> Result<(), Failure> {
    let grid = light_field.into_grid(to)?;
    files::create_folder_of(out)?;
    files::write(out, &grid)
}
