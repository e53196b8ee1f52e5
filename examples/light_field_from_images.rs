//! Converts a folder of PNGs, one per view, to one light field and its raw image.
//!
//! `cargo run --example light_field_from_images -- FOLDER 9x9 raw_el.png`, or without arguments on synthetic images.

use holo_core::{GridSize, Layout};
use holo_io::{ColorEncoding, Compression, ReadOptions, read_light_field, write_image, write_png};
use ndarray::Array3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let scratch = tempfile::tempdir()?;
    let (folder, views, out) = match arguments.as_slice() {
        [folder, views, out] => (folder.into(), views.parse()?, out.into()),
        _ => {
            write_images(scratch.path())?;
            (scratch.path().to_owned(), GridSize::new(2, 6), std::env::temp_dir().join("holo_example_raw_el.png"))
        }
    };

    // Natural order: view2.png comes before view10.png.
    let file = read_light_field(&folder, &ReadOptions::default().views(views))?;
    let light_field = file.light_field; // (v, u, t, s, c) in the type of the images
    println!("{} views of {} px, {}", views, light_field.shape().lenses(), light_field.kind().name());
    write_image(&out, &light_field.into_grid(Layout::ElementalGrid)?)?;
    println!("raw image: {}", out.display());
    Ok(())
}

/// Twelve views of a bright square that moves by two pixels from view to view.
fn write_images(folder: &std::path::Path) -> Result<(), holo_io::Error> {
    for number in 0..12 {
        let (t, s) = (number / 6, number % 6);
        let image = Array3::from_shape_fn((40, 60, 3), |(row, column, _)| {
            let inside = (10..20).contains(&(row + 2 * t)) && (20..30).contains(&(column + 2 * s));
            if inside { 220_u8 } else { 30 }
        });
        let path = folder.join(format!("view{number}.png"));
        write_png(path, image.view(), ColorEncoding::Srgb, Compression::Fast)?;
    }
    Ok(())
}
