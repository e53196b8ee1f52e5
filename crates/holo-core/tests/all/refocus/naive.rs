//! The reference implementation of shift-and-sum: every pixel, every view, every tap, in f64.

use holo_core::refocus::{Aperture, Kernel};
use holo_core::{LightFieldOwned, Sample};
use ndarray::Array3;

/// The weight of a pixel at a distance from the sample position.
fn kernel_weight(kernel: Kernel, distance: f64) -> f64 {
    let x = distance.abs();
    match kernel {
        Kernel::Bilinear => (1.0 - x).max(0.0),
        // Keys, 1981, with a = -1/2.
        Kernel::CatmullRom if x < 1.0 => 1.5 * x.powi(3) - 2.5 * x.powi(2) + 1.0,
        Kernel::CatmullRom if x < 2.0 => -0.5 * x.powi(3) + 2.5 * x.powi(2) - 4.0 * x + 2.0,
        Kernel::CatmullRom => 0.0,
        _ => unreachable!("the tests name two kernels"),
    }
}

pub fn refocused<T: Sample>(
    light_field: &LightFieldOwned<T>,
    aperture: &Aperture,
    kernel: Kernel,
    reference: (f64, f64),
    vertical_ratio: f64,
    disparity_px: &dyn Fn(usize, usize) -> f64,
) -> Array3<f64> {
    let samples = light_field.samples();
    let (rows, columns, view_rows, view_columns, channels) = samples.dim();
    Array3::from_shape_fn((rows, columns, channels), |(v, u, c)| {
        let d = disparity_px(v, u);
        let (mut sum, mut total) = (0.0, 0.0);
        for t in 0..view_rows {
            for s in 0..view_columns {
                let row = v as f64 - d * vertical_ratio * (t as f64 - reference.0);
                let column = u as f64 - d * (s as f64 - reference.1);
                let inside = |place: f64, count: usize| place >= -0.5 && place < count as f64 - 0.5;
                if !inside(row, rows) || !inside(column, columns) {
                    continue;
                }
                let weight = f64::from(aperture.weights()[[t, s]]);
                total += weight;
                for i in row.floor() as isize - 1..=row.floor() as isize + 2 {
                    for j in column.floor() as isize - 1..=column.floor() as isize + 2 {
                        let tap = kernel_weight(kernel, row - i as f64) * kernel_weight(kernel, column - j as f64);
                        let at = |place: isize, count: usize| place.clamp(0, count as isize - 1) as usize;
                        sum += weight * tap * samples[[at(i, rows), at(j, columns), t, s, c]].to_f64();
                    }
                }
            }
        }
        sum / total
    })
}
