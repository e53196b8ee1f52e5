//! Moving pixels and writing files: bandwidth, and the error, which must be none.

use holo_core::{DynImage, DynLightField, GridSize, LightField, Remainder, Sensor, rearrange::naive};
use holo_io::{
    ColorEncoding, Compression, ExrChannel, ExrCompression, Limits, MatOptions, MatOrder, read_exr,
    read_mat_light_field, read_png, write_exr_with, write_mat_light_field, write_png,
};
use ndarray::{Array3, Axis};

use crate::sheet::{Seconds, Sheet, short, timed};
use crate::{Section, Wish};

pub fn section(wish: &Wish) -> Section {
    let mut sheet = Sheet::new(&["what", "seconds", "GB/s", "size, of the pixels'", "samples that differ"]);
    let sensor = if wish.quick { Sensor::Uhd4k } else { Sensor::Paper8k };
    let split = sensor.divide(GridSize::new(100, 100), Remainder::Crop).expect("the paper's split").shape;
    let raw = split.raw_size();
    // Slow changes, edges, and noise of a hundredth, as in a render.
    let mut state = 1_u32;
    let image = Array3::from_shape_fn((raw.rows, raw.columns, 3), |(row, column, c)| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let shade = row / 23 + column / 17 * 2 + c * 40 + usize::from((row / 311 + column / 277) % 2 == 0) * 90;
        (shade % 220) as u8 + (state >> 29) as u8
    });
    let bytes = image.len() as f64;
    let mut highlights = Vec::new();
    let mut push = |what: &str, seconds: Seconds, size: Option<u64>, wrong: usize| {
        if !what.starts_with("copy") && !what.ends_with("read") && !what.contains("Scratch") {
            let speed = format!("{} GB/s", short(bytes / seconds.median / 1e9));
            highlights.push([what.into(), speed, format!("{wrong} samples differ")]);
        }
        sheet.push([
            what.into(),
            seconds.text(),
            short(bytes / seconds.median / 1e9),
            size.map_or(String::new(), |size| short(size as f64 / bytes)),
            wrong.to_string(),
        ]);
    };
    let (copied, copy) = timed(wish.rounds, || image.clone());
    push("copy (one thread)", copied, None, differing(&copy, &image));
    drop(copy);
    let field = LightField::from_elemental_grid(image.view(), split).expect("its own split");
    let (seconds, grid) = timed(wish.rounds, || field.to_viewpoint_grid().expect("memory for a copy"));
    let oracle = naive::to_viewpoint_grid(image.view(), split).expect("its own split");
    push("elemental images to views (Eq. 4)", seconds, None, differing(&grid, &oracle));
    drop(oracle);
    let back = LightField::from_viewpoint_grid(grid.view(), split).expect("its own split");
    let (seconds, returned) = timed(wish.rounds, || back.to_elemental_grid().expect("memory for a copy"));
    push("views to elemental images", seconds, None, differing(&returned, &image));
    drop((grid, returned));

    let folder = std::env::temp_dir().join(format!("holo-report-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the files");
    let limits = Limits::default();
    let rounds = wish.rounds.min(3);
    let path = folder.join("image.png");
    for (name, compression) in [("Scratch", Compression::Fast), ("Published", Compression::Best)] {
        let write = || write_png(&path, image.view(), ColorEncoding::Srgb, compression).expect("a file");
        let (seconds, written) = timed(rounds, write);
        let (reading, samples) = timed(rounds, || read_png(&path, &limits).expect("the file"));
        let DynImage::U8(samples) = samples else { panic!("8 bits were written") };
        let wrong = differing(&samples, &image);
        push(&format!("PNG, {name}, write"), seconds, Some(written.bytes), wrong);
        push(&format!("PNG, {name}, read"), reading, None, wrong);
    }
    let path = folder.join("image.mat");
    let options = MatOptions::default();
    let write = || write_mat_light_field(&path, &field, None, MatOrder::default(), &options).expect("a file");
    let (seconds, written) = timed(rounds, write);
    let (reading, read) = timed(rounds, || read_mat_light_field(&path, &limits).expect("the file"));
    let DynLightField::U8(read) = read.light_field else { panic!("8 bits were written") };
    let wrong = read.samples().into_iter().zip(field.samples()).filter(|(a, b)| a != b).count();
    push("MAT 5, write", seconds, Some(written.bytes), wrong);
    push("MAT 5, read", reading, None, wrong);
    drop(read);
    let linear = image.mapv(|code| f32::from(code) / 256.0);
    let planes: Vec<_> = (0..3).map(|channel| linear.index_axis(Axis(2), channel)).collect();
    let path = folder.join("image.exr");
    let write = || {
        let channels: Vec<_> =
            ["R", "G", "B"].into_iter().zip(&planes).map(|(name, plane)| ExrChannel::half(name, *plane)).collect();
        write_exr_with(&path, &channels, ExrCompression::Piz).expect("a file")
    };
    let (seconds, written) = timed(rounds, write);
    let (reading, read) = timed(rounds, || read_exr(&path, &limits).expect("the file"));
    let wrong: usize = ["R", "G", "B"]
        .into_iter()
        .zip(&planes)
        .map(|(name, plane)| {
            let samples = read.channel(name).expect("a channel that was written");
            samples.iter().zip(plane).filter(|(a, b)| a != b).count()
        })
        .sum();
    push("EXR, half, PIZ, write", seconds, Some(written.bytes), wrong);
    push("EXR, half, PIZ, read", reading, None, wrong);
    let _ = std::fs::remove_dir_all(&folder);
    Section {
        title: "Pixels and files",
        text: format!(
            "{} x {} RGB of 8 bits, {} x {} views. Files are synced and hashed on their way. GB/s of pixels, not of the file.",
            raw.columns,
            raw.rows,
            split.views().columns,
            split.views().rows
        ),
        highlights,
        sheet,
        plots: Vec::new(),
    }
}

fn differing(a: &Array3<u8>, b: &Array3<u8>) -> usize {
    if a.dim() != b.dim() { a.len() } else { a.iter().zip(b).filter(|(a, b)| a != b).count() }
}
