//! Refocuses a light field: one image in focus where the disparity between adjacent views has a given value.
//!
//! `cargo run --example refocus -- FOLDER_OR_FILE DISPARITY_PX out.png`, or without arguments on a synthetic light
//! field: two stripes at two depths.

use holo_core::refocus::Refocus;
use holo_core::{DynImage, DynLightField, GridSize, LightField, SampleKind};
use holo_io::{ColorEncoding, ReadOptions, read_light_field, write_image};
use ndarray::Array5;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (light_field, encoding, disparity_px, out) = match arguments.as_slice() {
        [input, disparity_px, out] => {
            let file = read_light_field(input, &ReadOptions::default())?;
            (file.light_field, file.color_encoding, disparity_px.parse()?, out.into())
        }
        _ => (two_stripes()?, ColorEncoding::Srgb, 1.0, std::env::temp_dir().join("holo_example_refocused.png")),
    };

    let views = light_field.shape().views();
    // Samples are added in linear light: the sRGB curve is removed before and applied after.
    let linear = light_field.without_alpha()?.into_linear(encoding)?;
    let image = Refocus::new(views)?.at_disparity(&linear, disparity_px)?;
    write_image(&out, &DynImage::from_linear(image.view(), SampleKind::U8)?)?;
    println!("{views} views, in focus at {disparity_px} px: {}", out.display());
    Ok(())
}

/// A stripe in the upper half that moves by 1 px between adjacent views, and one in the lower half that moves by -1 px.
fn two_stripes() -> Result<DynLightField, holo_core::Error> {
    let views = GridSize::new(5, 5);
    let samples = Array5::from_shape_fn((48, 64, views.rows, views.columns, 1), |(v, u, _, s, _)| {
        let shift = s as isize - 2;
        // Nearer points move against the camera.
        let position = u as isize + if v < 24 { shift } else { -shift };
        if (28..36).contains(&position) { 230_u8 } else { 40 }
    });
    Ok(LightField::new(samples)?.into())
}
