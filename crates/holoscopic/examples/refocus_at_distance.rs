//! Refocuses a light field at a distance of half a meter.

use holoscopic::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = read_light_field("out", &ReadOptions::default())?;
    let rig = file.rig.ok_or("the files do not describe the camera")?;
    let light_field = file.into_linear()?;
    let image = Refocus::new(light_field.shape().views())?.at_distance_m(&light_field, &rig, 0.5)?;
    write_image("sharp_at_500_mm.png", &DynImage::from_linear(image.view(), SampleKind::U8)?)?;
    Ok(())
}
