//! Raw images of 65,536 x 43,000 pixels, written in less than 500 MB of memory. Each test takes minutes, and gigabytes
//! in the temporary folder:
//!
//! `cargo test --release -p holo-io --features hdf5 --test large_images NAME -- --ignored --nocapture`, one NAME at a
//! time: peak memory is measured for the process.
#![cfg(target_os = "linux")]

use std::time::Instant;

use holo_core::{GridSize, SampleKind};
use holo_io::{
    ColorEncoding, Compression, ExrCompression, ExrSamples, ExrWriter, FileDigest, PngWriter, read_exr_info,
    read_png_info,
};
use ndarray::{Array3, ArrayView3, Axis};

const SIZE: GridSize = GridSize { rows: 43_000, columns: 65_536 };
const BAND: usize = 64;

/// Peak memory of this process so far, in bytes.
fn peak() -> u64 {
    let text = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap();
    line.split_whitespace().next().unwrap().parse::<u64>().unwrap() * 1024
}

/// Passes an image to `take` band by band: slow gradients with edges, which compress.
fn bands<T: Copy + Default>(value: impl Fn(usize, usize, usize) -> T, mut take: impl FnMut(ArrayView3<'_, T>)) {
    let mut band = Array3::from_elem((BAND, SIZE.columns, 3), T::default());
    for first in (0..SIZE.rows).step_by(BAND) {
        let rows = BAND.min(SIZE.rows - first);
        for (row, mut line) in band.outer_iter_mut().enumerate() {
            let line = line.as_slice_mut().unwrap();
            for (column, pixel) in line.chunks_exact_mut(3).enumerate() {
                (0..3).for_each(|channel| pixel[channel] = value(first + row, column, channel));
            }
        }
        take(band.slice_axis(Axis(0), (..rows).into()));
    }
}

fn report(what: &str, start: Instant, written: FileDigest) {
    let (seconds, megabytes, peak) = (start.elapsed().as_secs_f64(), written.bytes as f64 / 1e6, peak());
    println!("{what}: {seconds:.1} s, {megabytes:.0} MB, peak of memory {:.0} MB", peak as f64 / 1e6);
    assert!(peak < 500_000_000, "{what} took {peak} bytes");
}

#[test]
#[ignore = "minutes, and gigabytes of disk"]
fn png_of_64k_is_written_in_bounded_memory() {
    let folder = tempfile::tempdir().unwrap();
    for compression in [Compression::Best, Compression::Fast] {
        let path = folder.path().join("raw.png");
        let start = Instant::now();
        let mut writer = PngWriter::create(&path, SIZE, 3, SampleKind::U8, ColorEncoding::Srgb, compression).unwrap();
        bands(
            |row, column, channel| (row / 16 + (column >> 6) * (channel + 1)) as u8,
            |rows| writer.write_rows(rows).unwrap(),
        );
        report(&format!("PNG, RGB of 8 bits, {compression:?}"), start, writer.finish().unwrap());
        let info = read_png_info(&path).unwrap();
        assert_eq!((info.size, info.channels, info.bits), (SIZE, 3, 8));
    }
}

#[test]
#[ignore = "minutes, and gigabytes of disk"]
fn exr_of_64k_is_written_in_bounded_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("raw.exr");
    let start = Instant::now();
    let channels = ["R", "G", "B"].map(|name| (name, ExrSamples::Half));
    let mut writer = ExrWriter::create(&path, SIZE, &channels, ExrCompression::Zip).unwrap();
    bands(
        |row, column, channel| ((row / 16 + (column >> 6) * (channel + 1)) % 256) as f32 / 256.0,
        |rows| {
            writer.write_rows(&[0, 1, 2].map(|channel| rows.index_axis(Axis(2), channel))).unwrap();
        },
    );
    report("EXR, RGB of half, ZIP", start, writer.finish().unwrap());
    assert_eq!(read_exr_info(&path).unwrap().size, SIZE);
}

/// 65,500 x 43,000 pixels: 655 x 430 microlenses, 100 x 100 views.
#[cfg(feature = "hdf5")]
fn rig() -> holo_core::Rig {
    holo_core::Rig::builder(holo_core::LightFieldShape::new(GridSize::new(100, 100), GridSize::new(430, 655)).unwrap())
        .intrinsics(holo_core::Intrinsics { focal_length_m: 0.05, sensor_size_m: 0.036 })
        .baseline_m(1e-4)
        .focus_distance_m(1.0)
        .projection(holo_core::Projection::Perspective)
        .build()
        .unwrap()
}

/// Passes a light field to `take` lens row by lens row.
#[cfg(feature = "hdf5")]
fn lens_rows<T: Copy + Default>(
    value: impl Fn(usize, usize, usize) -> T,
    mut take: impl FnMut(ndarray::ArrayView5<'_, T>),
) {
    let mut row = ndarray::Array5::from_elem((1, 655, 100, 100, 3), T::default());
    for v in 0..430 {
        for (index, sample) in row.as_slice_mut().unwrap().iter_mut().enumerate() {
            *sample = value(v, index / 30_000, index % 30_000);
        }
        take(row.view());
    }
}

#[cfg(feature = "hdf5")]
#[test]
#[ignore = "minutes, and gigabytes of disk"]
fn hdf5_of_64k_is_written_in_bounded_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_5d.h5");
    let start = Instant::now();
    let options = holo_io::Hdf5Options::default();
    let mut writer = holo_io::Hdf5Writer::create(&path, &rig(), 3, &[], &options).unwrap();
    lens_rows(|v, u, at| ((v + u) % 64 + at / 3000) as f32 / 256.0, |row| writer.write_lens_rows(row).unwrap());
    report("HDF5, RGB of float32, gzip 1", start, writer.finish().unwrap());
    let file = holo_io::Hdf5LightField::open(&path, &holo_io::Limits::default()).unwrap();
    assert_eq!(file.shape(), *rig().shape());
}

#[cfg(feature = "hdf5")]
#[test]
#[ignore = "minutes, and gigabytes of disk"]
fn mat_of_64k_is_written_in_bounded_memory() {
    let folder = tempfile::tempdir().unwrap();
    for is_compressed in [true, false] {
        let path = folder.path().join("scene_5d.mat");
        let start = Instant::now();
        let mut writer = holo_io::MatWriter::create(&path, &rig(), 3, is_compressed).unwrap();
        lens_rows(|v, u, at| ((v + u) % 64 + at / 300) as u8, |row| writer.write_lens_rows(row).unwrap());
        report(&format!("MAT 7.3, RGB of uint8, compressed: {is_compressed}"), start, writer.finish().unwrap());
        let infos = holo_io::read_mat_info(&path).unwrap();
        assert_eq!(infos.iter().find(|info| info.name == "H").unwrap().size, [430, 655, 100, 100, 3]);
    }
}
