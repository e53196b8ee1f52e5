//! Estimates the disparity of the central view by multi-view stereo and compares it with the ground truth.

use holoscopic::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let reader = LightFieldReader::open("out", &ReadOptions::default())?;
    let truth_px = reader.central_disparity_px()?.ok_or("there is no ground truth")?;
    let file = reader.read()?;
    let estimate = plane_sweep(&file.light_field.to_f32()?, &file.plane_sweep_options())?;
    let scores = disparity_scores(&estimate.disparity_px, &truth_px, &Region::default())?;
    println!("mean absolute error {:.4} px", scores.mean_absolute_error_px);
    println!("off by more than 0.07 px: {:.1} % of the pixels", scores.bad_pixels_percent[2]);
    Ok(())
}
