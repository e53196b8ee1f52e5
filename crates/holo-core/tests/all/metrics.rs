//! The measures of the benchmark against the results of the toolkit's formulas in Python.

use holo_core::metrics::{NormalGeometry, Region, bumpiness, disparity_scores, median_angle_error_deg};
use holo_core::{GridSize, LightFieldShape, Rig};
use ndarray::Array2;

// The output of `toolkit_reference.py` with scikit-image 0.26.0.
const BAD_PIXELS: [f64; 3] = [20.37037037037037, 12.962962962962962, 3.7037037037037033];
const MEAN_SQUARE: f64 = 0.27030608904214554;
const Q25: f64 = 0.048828125;
const BUMPINESS: f64 = 2.081463679001641;
const ANGLE_PINHOLE: f64 = 1.9682055566361827;
const ANGLE_TOOLKIT: f64 = 3.0579245388728467;

const SIZE: usize = 24;

fn maps() -> (Array2<f32>, Array2<f32>) {
    // Multiples of 1/4096 below 1: exact in f32.
    let truth =
        Array2::from_shape_fn((SIZE, SIZE), |(row, column)| (2 * row + 3 * column + (row * column) % 5) as f32 / 512.0);
    let estimate = Array2::from_shape_fn((SIZE, SIZE), |(row, column)| {
        let within = |rows: std::ops::Range<usize>, columns: std::ops::Range<usize>, error: f32| {
            if rows.contains(&row) && columns.contains(&column) { error } else { 0.0 }
        };
        let ripple = ((row * row + 3 * row * column + column) % 7) as f32 / 4096.0;
        let steps = within(10..13, 5..9, 0.25) - within(15..20, 4..10, 0.0625) + within(5..8, 12..20, 0.015625);
        truth[[row, column]] + ripple + steps
    });
    (estimate, truth)
}

#[test]
fn measures_agree_with_the_toolkit() {
    let (estimate, truth) = maps();
    let region = Region::with_border(3);
    // Both sides in f64, some thousand roundings of numbers up to 100. The arc cosine loses half of the digits near 0:
    // at 1 degree it is good to 2^-52/sin(1 degree), 1e-12 degrees.
    let close = |value: f64, expected: f64| assert!((value - expected).abs() < 1e-9, "{value} for {expected}");
    let scores = disparity_scores(&estimate, &truth, &region).unwrap();
    for (percent, expected) in scores.bad_pixels_percent.into_iter().zip(BAD_PIXELS) {
        close(percent, expected);
    }
    close(scores.mean_squared_error_x100, MEAN_SQUARE);
    close(scores.q25_x100, Q25);
    close(bumpiness(&estimate, &truth, &region).unwrap().value, BUMPINESS);

    let rig = Rig::builder(LightFieldShape::new(GridSize::new(9, 9), GridSize::new(SIZE, SIZE)).unwrap())
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_m(0.02)
        .focus_distance_m(3.0)
        .build()
        .unwrap();
    for (geometry, expected) in [(NormalGeometry::Pinhole, ANGLE_PINHOLE), (NormalGeometry::Toolkit, ANGLE_TOOLKIT)] {
        close(median_angle_error_deg(&estimate, &truth, &rig, geometry, &region).unwrap().value, expected);
    }
}
