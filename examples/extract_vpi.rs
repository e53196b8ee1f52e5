//! From a raw holoscopic image to one viewpoint image.
//!
//! `cargo run --example extract_vpi -- scene_el.png VIEWS COLUMN ROW view.png`, or without arguments on a raw image that it
//! makes itself.

use holo_core::{DynImage, GridSize, LightField, LightFieldShape};
use holo_io::{ColorEncoding, Compression, Limits, read_png, write_png};
use ndarray::Array3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (raw, views, [s, t], out) = match arguments.as_slice() {
        [input, views, s, t, out] => match read_png(input, &Limits::default())? {
            DynImage::U8(raw) => (raw, views.parse()?, [s.parse()?, t.parse()?], out.into()),
            _ => return Err("this example reads 8-bit images".into()),
        },
        _ => (made_up(4), 4, [2, 1], std::env::temp_dir().join("holo_example_view.png")),
    };

    let (rows, columns, _) = raw.dim();
    let split = LightFieldShape::new(GridSize::new(views, views), GridSize::new(rows / views, columns / views))?;
    let light_field = LightField::from_elemental_grid(raw, split)?; // copies nothing
    let view = light_field.view(t, s)?; // one pixel from under every lens, as a borrowed image
    write_png(&out, view, ColorEncoding::Srgb, Compression::Best)?;
    println!("view {s},{t} of {views} x {views}: {} x {} px in {}", columns / views, rows / views, out.display());
    Ok(())
}

/// A raw image in which every view has a brightness of its own.
fn made_up(views: usize) -> Array3<u8> {
    Array3::from_shape_fn((60 * views, 80 * views, 3), |(y, x, _)| (16 * (y % views * views + x % views)) as u8)
}
