//! Bandwidth and exactness of rearranging pixels and of writing and reading files; no sample may differ.

use std::path::Path;

use holo_core::{DynImage, DynLightField, GridSize, LightField, LightFieldShape, Remainder, Sensor, rearrange::naive};
use holo_io::{
    ColorEncoding, Compression, ExrChannel, ExrCompression, Limits, MatOptions, MatOrder, read_exr,
    read_mat_light_field, read_png, write_exr_with, write_mat_light_field, write_png,
};
use ndarray::{Array3, Axis};

use crate::table::{Seconds, Table, short, timed};
use crate::{RunOptions, Section};

/// The rows of this section, and what they have in common.
struct Rows {
    table: Table,
    highlights: Vec<[String; 3]>,
    /// Bytes of the pixels of the test image.
    bytes: f64,
}

impl Rows {
    /// Adds a row: time, size of the file in bytes, number of samples that differ from the original.
    fn push(&mut self, what: &str, seconds: Seconds, size: Option<u64>, differing: usize) {
        let gb_per_second = short(self.bytes / seconds.median / 1e9);
        if !what.starts_with("copy") && !what.ends_with("read") && !what.contains("Fast") {
            let speed = format!("{gb_per_second} GB/s");
            self.highlights.push([what.into(), speed, format!("{differing} samples differ")]);
        }
        self.table.push([
            what.into(),
            seconds.text(),
            gb_per_second,
            size.map_or(String::new(), |size| short(size as f64 / self.bytes)),
            differing.to_string(),
        ]);
    }
}

pub fn section(options: &RunOptions) -> Section {
    let sensor = if options.quick { Sensor::Uhd4k } else { Sensor::Paper8k };
    let split = sensor.divide(GridSize::new(100, 100), Remainder::Crop).expect("the paper's split").shape;
    let raw = split.raw_size();
    let image = test_image(raw);
    let table = Table::new(&["what", "seconds", "GB/s", "file size / pixel size", "samples that differ"]);
    let mut rows = Rows { table, highlights: Vec::new(), bytes: image.len() as f64 };
    rearrangements(&mut rows, options.rounds, &image, split);

    let folder = std::env::temp_dir().join(format!("holo-report-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the files");
    let rounds = options.rounds.min(3);
    png(&mut rows, rounds, &folder, &image);
    mat(&mut rows, rounds, &folder, &image, split);
    exr(&mut rows, rounds, &folder, &image);
    let _ = std::fs::remove_dir_all(&folder);
    Section {
        text: format!(
            "RGB images of {} x {} pixels with 8 bits per channel, {} x {} views. Times include syncing the file to \
             the disk and its SHA-256. GB/s count pixels, not bytes of the file.",
            raw.columns,
            raw.rows,
            split.views().columns,
            split.views().rows
        ),
        highlights: rows.highlights,
        table: rows.table,
        plots: Vec::new(),
    }
}

/// An image with the statistics of a render: smooth gradients, edges, and noise of about 1 %. Axes: row, column,
/// channel.
fn test_image(size: GridSize) -> Array3<u8> {
    let mut state = 1_u32;
    Array3::from_shape_fn((size.rows, size.columns, 3), |(row, column, c)| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let shade = row / 23 + column / 17 * 2 + c * 40 + usize::from((row / 311 + column / 277) % 2 == 0) * 90;
        (shade % 220) as u8 + (state >> 29) as u8
    })
}

/// Copying, and rearranging elemental images to views and back.
fn rearrangements(rows: &mut Rows, rounds: usize, image: &Array3<u8>, split: LightFieldShape) {
    let (seconds, copy) = timed(rounds, || image.clone());
    rows.push("copy (one thread)", seconds, None, differing(&copy, image));
    drop(copy);
    let field = LightField::from_elemental_grid(image.view(), split).expect("its own split");
    let (seconds, grid) = timed(rounds, || field.to_viewpoint_grid().expect("memory for a copy"));
    let reference = naive::to_viewpoint_grid(image.view(), split).expect("its own split");
    rows.push("elemental images to views (Eq. 4)", seconds, None, differing(&grid, &reference));
    drop(reference);
    let back = LightField::from_viewpoint_grid(grid.view(), split).expect("its own split");
    let (seconds, returned) = timed(rounds, || back.to_elemental_grid().expect("memory for a copy"));
    rows.push("views to elemental images", seconds, None, differing(&returned, image));
}

fn png(rows: &mut Rows, rounds: usize, folder: &Path, image: &Array3<u8>) {
    let path = folder.join("image.png");
    for (name, compression) in [("Fast", Compression::Fast), ("Best", Compression::Best)] {
        let write = || write_png(&path, image.view(), ColorEncoding::Srgb, compression).expect("a file");
        let (seconds, written) = timed(rounds, write);
        let (reading, samples) = timed(rounds, || read_png(&path, &Limits::default()).expect("the file"));
        let DynImage::U8(samples) = samples else { panic!("8 bits were written") };
        let wrong = differing(&samples, image);
        rows.push(&format!("PNG, {name}, write"), seconds, Some(written.bytes), wrong);
        rows.push(&format!("PNG, {name}, read"), reading, None, wrong);
    }
}

fn mat(rows: &mut Rows, rounds: usize, folder: &Path, image: &Array3<u8>, split: LightFieldShape) {
    let field = LightField::from_elemental_grid(image.view(), split).expect("its own split");
    let path = folder.join("image.mat");
    let options = MatOptions::default();
    let write = || write_mat_light_field(&path, &field, None, MatOrder::default(), &options).expect("a file");
    let (seconds, written) = timed(rounds, write);
    let (reading, read) = timed(rounds, || read_mat_light_field(&path, &Limits::default()).expect("the file"));
    let DynLightField::U8(read) = read.light_field else { panic!("8 bits were written") };
    let wrong = read.samples().into_iter().zip(field.samples()).filter(|(a, b)| a != b).count();
    rows.push("MAT 5, write", seconds, Some(written.bytes), wrong);
    rows.push("MAT 5, read", reading, None, wrong);
}

/// Writes multiples of 1/256, which half floats represent exactly.
fn exr(rows: &mut Rows, rounds: usize, folder: &Path, image: &Array3<u8>) {
    let linear = image.mapv(|code| f32::from(code) / 256.0);
    let planes: Vec<_> = (0..3).map(|channel| linear.index_axis(Axis(2), channel)).collect();
    let path = folder.join("image.exr");
    let write = || {
        let channels: Vec<_> =
            ["R", "G", "B"].into_iter().zip(&planes).map(|(name, plane)| ExrChannel::half(name, *plane)).collect();
        write_exr_with(&path, &channels, ExrCompression::Piz).expect("a file")
    };
    let (seconds, written) = timed(rounds, write);
    let (reading, read) = timed(rounds, || read_exr(&path, &Limits::default()).expect("the file"));
    let wrong: usize = ["R", "G", "B"]
        .into_iter()
        .zip(&planes)
        .map(|(name, plane)| {
            let samples = read.channel(name).expect("a channel that was written");
            samples.iter().zip(plane).filter(|(a, b)| a != b).count()
        })
        .sum();
    rows.push("EXR, half, PIZ, write", seconds, Some(written.bytes), wrong);
    rows.push("EXR, half, PIZ, read", reading, None, wrong);
}

/// The number of samples that differ; all of them if the shapes do.
fn differing(a: &Array3<u8>, b: &Array3<u8>) -> usize {
    if a.dim() != b.dim() { a.len() } else { a.iter().zip(b).filter(|(a, b)| a != b).count() }
}
