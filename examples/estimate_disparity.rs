//! Estimates the disparity of the central view by multi-view stereo and compares it with the ground truth.
//!
//! `cargo run --example estimate_disparity -- FOLDER estimate.pfm` on a folder with ground truth (of `holo render` or
//! of the HCI benchmark), or without arguments on a synthetic light field.

use holo_core::metrics::{Region, disparity_scores};
use holo_core::{DynLightField, GridSize, LightField, PlaneSweepOptions, for_each_sample, plane_sweep};
use holo_io::{LightFieldReader, ReadOptions, write_pfm};
use ndarray::{Array2, Array5};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (light_field, truth_px, range_px, out) = match arguments.as_slice() {
        [input, out] => {
            let reader = LightFieldReader::open(input, &ReadOptions::default())?;
            let truth_px = reader.central_disparity_px()?.ok_or("the folder has no map of disparity")?;
            let range_px = reader.disparity_range_px();
            (reader.read()?.light_field, truth_px, range_px, out.into())
        }
        _ => {
            let (light_field, truth_px) = textured_planes()?;
            (light_field, truth_px, Some((-1.5, 1.5)), std::env::temp_dir().join("holo_example_disparity.pfm"))
        }
    };

    let mut options = PlaneSweepOptions::default();
    if let Some((min, max)) = range_px {
        options = options.range_px(min as f32, max as f32);
    }
    let estimate = for_each_sample!(DynLightField, &light_field, field => plane_sweep(field, &options))?;
    write_pfm(&out, estimate.disparity_px.view())?;

    let region = Region { border_px: 8, mask: None };
    let scores = disparity_scores(&estimate.disparity_px, &truth_px, &region)?;
    println!(
        "mean absolute error {:.4} px, MSE x 100 {:.3}",
        scores.mean_absolute_error_px, scores.mean_squared_error_x100
    );
    println!("estimate: {}", out.display());
    Ok(())
}

/// Two textured halves at disparities of 1 and -1 px, and their map.
fn textured_planes() -> Result<(DynLightField, Array2<f32>), holo_core::Error> {
    let (views, size) = (GridSize::new(7, 7), GridSize::new(48, 64));
    let disparity_px = |v: usize| if v < 24 { 1.0_f32 } else { -1.0 };
    let samples = Array5::from_shape_fn((size.rows, size.columns, views.rows, views.columns, 1), |(v, u, t, s, _)| {
        let (shift_t, shift_s) = (t as f32 - 3.0, s as f32 - 3.0);
        let (row, column) = (v as f32 + disparity_px(v) * shift_t, u as f32 + disparity_px(v) * shift_s);
        // Several sine waves: a texture without flat regions and without repetitions.
        0.5 + 0.2 * (0.7 * row + 1.1 * column).sin()
            + 0.2 * (1.7 * column - 0.3 * row).sin()
            + 0.1 * (0.4 * row * 1.3).sin()
    });
    let truth_px = Array2::from_shape_fn((size.rows, size.columns), |(v, _)| disparity_px(v));
    Ok((LightField::new(samples)?.into(), truth_px))
}
