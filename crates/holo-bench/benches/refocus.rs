//! A focal stack of an 8K light field by shift-and-sum, beside numpy.
//!
//! Run with `cargo bench -p holo-bench --bench refocus`. Nine planes, RGB with 8 bits, for 20 x 20 and 100 x 100 views.
//! All times are from one run; only their ratios are reliable. numpy is measured if `HOLO_PYTHON` (or `python3`) has
//! it: it processes one view after the other with bilinear interpolation of whole arrays (`refocus.py` beside this
//! file). Where all views contribute to a pixel, the images must agree.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use holo_core::refocus::{Kernel, Refocus};
use holo_core::{GridSize, LightField, Remainder, Sensor};
use ndarray::{Array3, s};

/// The number of focus planes, nearest to farthest; the outermost of 20 views are shifted by up to 3 px.
const PLANES: usize = 9;

fn main() {
    println!("{PLANES} planes, {} threads; seconds per plane", rayon::current_num_threads());
    for (views, range_px) in [(20, 0.3), (100, 0.012)] {
        measure(views, range_px);
    }
}

fn measure(views: usize, range_px: f64) {
    let grid = GridSize::new(views, views);
    let split = Sensor::Paper8k.divide(grid, Remainder::Crop).expect("the paper's split").shape;
    let raw = split.raw_size();
    // The same formula in Python.
    let sample = |index: usize| ((index * 7919 + index / 251 * 31) % 251) as u8;
    let image = Array3::from_shape_vec((raw.rows, raw.columns, 3), (0..raw.count() * 3).map(sample).collect());
    let field = LightField::from_elemental_grid(image.expect("as many as the shape has"), split).expect("its size");
    let planes: Vec<f64> =
        (0..PLANES).map(|plane| range_px * (2.0 * plane as f64 / (PLANES - 1) as f64 - 1.0)).collect();
    println!("{views} x {views} views of {} x {} px", split.lenses().columns, split.lenses().rows);
    let mut bilinear = Vec::new();
    let mut own = f64::NAN;
    for (name, kernel) in [("cubic", Kernel::CatmullRom), ("bilinear", Kernel::Bilinear)] {
        let refocus = Refocus::new(grid).expect("views").kernel(kernel);
        let mut best = f64::INFINITY;
        for _ in 0..3 {
            let start = Instant::now();
            bilinear = planes.iter().map(|&d| refocus.at_disparity(&field, d).expect("an image")).collect();
            best = best.min(start.elapsed().as_secs_f64() / PLANES as f64);
        }
        own = best;
        println!("  holo-core, {name:<24} {best:9.4}");
    }
    match numpy(views, planes[0]) {
        Ok((seconds, image)) => {
            println!("  numpy, bilinear                    {seconds:9.4} ({:.1} x)", seconds / own);
            let shape = bilinear[0].dim();
            let theirs = Array3::from_shape_vec(shape, image).expect("an image of the size of a view");
            let margin = (range_px * views as f64).ceil() as usize + 1;
            let inner = s![margin..shape.0 - margin, margin..shape.1 - margin, ..];
            let (own, theirs) = (bilinear[0].slice(inner), theirs.slice(inner));
            let worst = own.iter().zip(theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(worst < 0.01, "the images differ by {worst}");
            println!("  largest difference                 {worst:9.6} of 255");
        }
        Err(why) => println!("  numpy: not measured: {why}"),
    }
}

/// Seconds for one plane, and the image.
fn numpy(views: usize, disparity_px: f64) -> Result<(f64, Vec<f32>), String> {
    let program = holo_bench::python();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/refocus.py");
    let image = std::env::temp_dir().join(format!("holo-bench-refocus-{}.raw", std::process::id()));
    let output = Command::new(program)
        .arg(script)
        .args([views.to_string(), disparity_px.to_string()])
        .arg(&image)
        .output()
        .map_err(|error| error.to_string())?;
    let text = String::from_utf8_lossy(&output.stdout);
    let seconds = text
        .trim()
        .parse()
        .map_err(|_| String::from_utf8_lossy(&output.stderr).lines().last().unwrap_or("no message").to_owned())?;
    let bytes = std::fs::read(&image).map_err(|error| error.to_string())?;
    let _ = std::fs::remove_file(&image);
    Ok((seconds, bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()))
}
