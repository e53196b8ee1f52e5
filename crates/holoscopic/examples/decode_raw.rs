//! Decodes the raw image of an unfocused plenoptic camera, which the `camera.toml` beside it describes, to views.

use holoscopic::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let light_field = read_light_field("illum/raw.exr", &ReadOptions::default())?.into_linear()?;
    for ((row, column), view) in light_field.views() {
        let image = DynImage::from_linear(view, SampleKind::U16)?;
        write_image(format!("view_{row:02}_{column:02}.png"), &image)?;
    }
    Ok(())
}
