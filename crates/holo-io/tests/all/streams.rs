//! Images written band by band: the same bytes for any bands, and no file without `finish`.

use std::fs;
use std::path::Path;

use crate::encoded::encoded;
use holo_core::{DynImage, GridSize, SampleKind};
use holo_io::{
    ColorEncoding, Compression, Error, ExrChannel, ExrCompression, ExrSamples, ExrWriter, Limits, PngWriter,
    decode_exr, encode_exr_with, encode_png, hash_file, read_png,
};
use ndarray::{Array2, Array3, ArrayView2, Axis, Slice, s};
use proptest::prelude::*;

const CODINGS: [ExrCompression; 4] =
    [ExrCompression::Zip, ExrCompression::Zips, ExrCompression::Piz, ExrCompression::None];

fn count(folder: &Path) -> usize {
    fs::read_dir(folder).unwrap().count()
}

/// The value of a 16-bit float by its definition in IEEE 754.
fn half(bits: u16) -> f32 {
    let (sign, exponent, fraction) = (bits >> 15, i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let magnitude = match exponent {
        0 => fraction * 2_f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2_f64.powi(exponent - 25),
    };
    (if sign == 1 { -magnitude } else { magnitude }) as f32
}

/// Positions at which `rows` rows are divided into bands.
fn cuts(rows: usize, seeds: &[usize]) -> Vec<usize> {
    let mut cuts: Vec<usize> = seeds.iter().map(|seed| seed % (rows + 1)).chain([0, rows]).collect();
    cuts.sort_unstable();
    cuts
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn bands_of_an_exr_are_the_file(
        rows in 1_usize..80, columns in 1_usize..30, coding in 0_usize..4, half_first: bool, threads in 1_usize..4,
        seeds in prop::collection::vec(any::<usize>(), 0..6), pattern in prop::collection::vec(any::<u32>(), 1..50),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("raw.exr");
        let coding = CODINGS[coding];
        // A channel of arbitrary 32-bit floats and one of arbitrary 16-bit floats; the names are not in the order of
        // the file.
        let floats = Array2::from_shape_fn((rows, columns), |(row, column)| {
            f32::from_bits(pattern[(row * columns + column) % pattern.len()])
        });
        let halves = Array2::from_shape_fn((columns, rows), |(column, row)| {
            half(pattern[(row * 7 + column * 3) % pattern.len()] as u16)
        }).reversed_axes();
        let (float, half) = if half_first { ("b", "a") } else { ("a", "b") };
        let whole = encoded(|out| encode_exr_with(out, &[ExrChannel::float(float, floats.view()), ExrChannel::half(half, halves.view())], coding,
        )).unwrap();
        let formats = [(float, ExrSamples::Float), (half, ExrSamples::Half)];
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let written = pool.install(|| {
            let mut writer = ExrWriter::create(&path, GridSize::new(rows, columns), &formats, coding).unwrap();
            for cut in cuts(rows, &seeds).windows(2) {
                let band = s![cut[0]..cut[1], ..];
                writer.write_rows(&[floats.slice(band), halves.slice(band)]).unwrap();
            }
            writer.finish().unwrap()
        });
        prop_assert_eq!(&fs::read(&path).unwrap(), &whole);
        prop_assert_eq!(written, hash_file(&path).unwrap());
        prop_assert_eq!(count(folder.path()), 1);
        let image = decode_exr(&whole[..], &Limits::default()).unwrap();
        for (name, plane, is_half) in [(float, &floats, false), (half, &halves, true)] {
            for (read, value) in image.channel(name).unwrap().iter().zip(plane) {
                // A half keeps no more of NaN than that it is one.
                prop_assert!(read.to_bits() == value.to_bits() || (is_half && read.is_nan() && value.is_nan()));
            }
        }
    }

    #[test]
    fn bands_of_a_png_are_the_file(
        rows in 1_usize..60, columns in 1_usize..40, channels in 1_usize..=4, published: bool, threads in 1_usize..4,
        seeds in prop::collection::vec(any::<usize>(), 0..6), pattern in prop::collection::vec(any::<u16>(), 1..50),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("raw.png");
        let compression = if published { Compression::Best } else { Compression::Fast };
        let image = Array3::from_shape_fn((rows, columns, channels), |(row, column, channel)| {
            pattern[(row * columns * channels + column * channels + channel) % pattern.len()]
        });
        let small = image.mapv(|sample| (sample >> 8) as u8);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let size = GridSize::new(rows, columns);
        let written = pool.install(|| {
            let mut writer =
                PngWriter::create(&path, size, channels, SampleKind::U16, ColorEncoding::Linear, compression).unwrap();
            for cut in cuts(rows, &seeds).windows(2) {
                writer.write_rows(image.slice(s![cut[0]..cut[1], .., ..])).unwrap();
            }
            writer.finish().unwrap()
        });
        let expected = encoded(|out| encode_png(out, image.view(), ColorEncoding::Linear, compression)).unwrap();
        prop_assert_eq!(fs::read(&path).unwrap(), expected);
        prop_assert_eq!(written, hash_file(&path).unwrap());
        prop_assert_eq!(read_png(&path, &Limits::default()).unwrap(), DynImage::U16(image));
        pool.install(|| {
            let mut writer =
                PngWriter::create(&path, size, channels, SampleKind::U8, ColorEncoding::Srgb, compression).unwrap();
            for cut in cuts(rows, &seeds).windows(2) {
                writer.write_rows(small.slice(s![cut[0]..cut[1], .., ..])).unwrap();
            }
            writer.finish().unwrap()
        });
        let expected = encoded(|out| encode_png(out, small.view(), ColorEncoding::Srgb, compression)).unwrap();
        prop_assert_eq!(fs::read(&path).unwrap(), expected);
    }
}

#[test]
fn images_of_many_groups_do_not_depend_on_bands_or_threads() {
    let folder = tempfile::tempdir().unwrap();
    let image = Array3::from_shape_fn((3000, 1100, 3), |(row, column, channel)| {
        ((row * row / 7 + column * 3) % 251 + channel) as u8
    });
    let whole = encoded(|out| encode_png(out, image.view(), ColorEncoding::Srgb, Compression::Best)).unwrap();
    let plane = Array2::from_shape_fn((3000, 1100), |(row, column)| ((row * 1100 + column) as f32).sqrt());
    let piz = encoded(|out| encode_exr_with(out, &[ExrChannel::half("Y", plane.view())], ExrCompression::Piz)).unwrap();
    for (threads, band) in [(1, 1), (2, 997), (3, 3000)] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let size = GridSize::new(3000, 1100);
        let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
        pool.install(|| {
            let mut writer =
                PngWriter::create(&png, size, 3, SampleKind::U8, ColorEncoding::Srgb, Compression::Best).unwrap();
            image.axis_chunks_iter(Axis(0), band).for_each(|rows| writer.write_rows(rows).unwrap());
            writer.finish().unwrap();
            let mut writer = ExrWriter::create(&exr, size, &[("Y", ExrSamples::Half)], ExrCompression::Piz).unwrap();
            plane.axis_chunks_iter(Axis(0), band).for_each(|rows| writer.write_rows(&[rows]).unwrap());
            writer.finish().unwrap();
        });
        assert!(
            fs::read(&png).unwrap() == whole && fs::read(&exr).unwrap() == piz,
            "{threads} threads, bands of {band}"
        );
    }
}

#[test]
fn unfinished_writers_leave_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let (png, exr) = (folder.path().join("a.png"), folder.path().join("a.exr"));
    fs::write(&png, b"old").unwrap();
    fs::write(&exr, b"old").unwrap();
    let size = GridSize::new(10, 4);
    let (rows, plane) = (Array3::<u8>::zeros((9, 4, 3)), Array2::zeros((9, 4)));
    for compression in [Compression::Fast, Compression::Best] {
        let start = || PngWriter::create(&png, size, 3, SampleKind::U8, ColorEncoding::Srgb, compression).unwrap();
        let mut dropped = start();
        dropped.write_rows(rows.view()).unwrap();
        drop(dropped);
        let mut short = start();
        short.write_rows(rows.view()).unwrap();
        let error = short.finish().unwrap_err();
        assert!(error.to_string().contains("9 of 10 rows were written"), "{error}");
        for wrong in [Array3::<u8>::zeros((11, 4, 3)), Array3::zeros((1, 5, 3)), Array3::zeros((1, 4, 4))] {
            let mut writer = start();
            assert!(matches!(writer.write_rows(wrong.view()), Err(Error::BadInput { .. })));
            assert!(matches!(writer.write_rows(rows.view()), Err(Error::BadInput { .. })), "after an error");
            assert!(matches!(writer.finish(), Err(Error::BadInput { .. })));
        }
    }
    for compression in CODINGS {
        let start = || ExrWriter::create(&exr, size, &[("Y", ExrSamples::Half)], compression).unwrap();
        let mut dropped = start();
        dropped.write_rows(&[plane.view()]).unwrap();
        drop(dropped);
        let mut short = start();
        short.write_rows(&[plane.view()]).unwrap();
        let error = short.finish().unwrap_err();
        assert!(error.to_string().contains("9 of 10 rows were written"), "{error}");
        let (tall, wide) = (Array2::zeros((11, 4)), Array2::zeros((1, 5)));
        for wrong in [&[tall.view()][..], &[wide.view()], &[], &[plane.view(), plane.view()]] {
            let mut writer = start();
            assert!(matches!(writer.write_rows(wrong), Err(Error::BadInput { .. })));
            assert!(matches!(writer.write_rows(&[plane.view()]), Err(Error::BadInput { .. })), "after an error");
            assert!(matches!(writer.finish(), Err(Error::BadInput { .. })));
        }
    }
    assert_eq!((fs::read(&png).unwrap(), fs::read(&exr).unwrap()), (b"old".to_vec(), b"old".to_vec()));
    assert_eq!(count(folder.path()), 2);
}

#[test]
fn half_refuses_values_out_of_range_and_names_the_position() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for name in ["ViewLayer.IndexOB.X", "ViewLayer.Object Index.X", "IndexMA.X", "V.CryptoObject00.r"] {
        let error = ExrWriter::create(&path, GridSize::new(2, 2), &[(name, ExrSamples::Half)], ExrCompression::Zip)
            .unwrap_err();
        assert!(matches!(error, Error::BadInput { .. }) && error.to_string().contains("identifiers"), "{error}");
    }
    // Rows 0 to 18 are valid; the value is in row 19 + 3.
    let mut plane = Array2::from_elem((40, 5), f32::INFINITY);
    plane[[22, 4]] = 65_520.0;
    let mut writer =
        ExrWriter::create(&path, GridSize::new(40, 5), &[("R", ExrSamples::Half)], ExrCompression::Zip).unwrap();
    writer.write_rows(&[plane.slice(s![..19, ..])]).unwrap();
    let error = writer.write_rows(&[plane.slice(s![19.., ..])]).unwrap_err();
    assert!(error.to_string().contains("channel R, row 22, column 4: 65520 is beyond 65504"), "{error}");
    assert!(writer.finish().is_err());
    assert_eq!(count(folder.path()), 0);
    // 32-bit floats can represent both.
    plane[[22, 4]] = 1e30;
    let bytes =
        encoded(|out| encode_exr_with(out, &[ExrChannel::float("IndexOB.X", plane.view())], ExrCompression::Piz))
            .unwrap();
    assert_eq!(decode_exr(&bytes[..], &Limits::default()).unwrap().channels[0].1, plane);
}

#[test]
fn blocks_too_large_for_the_format_are_refused_before_memory_is_allocated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let names: Vec<String> = (0..100).map(|number| format!("c{number}")).collect();
    let channels: Vec<_> = names.iter().map(|name| (name.as_str(), ExrSamples::Float)).collect();
    let error = ExrWriter::create(&path, GridSize::new(8, 1 << 20), &channels, ExrCompression::Zip).unwrap_err();
    assert!(matches!(error, Error::BadInput { .. }) && error.to_string().contains("several files"), "{error}");
    for size in [GridSize::new(0, 4), GridSize::new(4, 0), GridSize::new(usize::MAX, 4), GridSize::new(4, usize::MAX)] {
        assert!(ExrWriter::create(&path, size, &channels[..1], ExrCompression::Zip).is_err());
        assert!(PngWriter::create(&path, size, 3, SampleKind::U8, ColorEncoding::Srgb, Compression::Best).is_err());
    }
    assert_eq!(count(folder.path()), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn an_exr_is_written_into_a_device_as_a_whole() {
    let plane = Array2::<f32>::zeros((100, 10));
    let size = GridSize::new(100, 10);
    for (path, works) in [("/dev/null", true), ("/dev/full", false)] {
        let mut writer = ExrWriter::create(path, size, &[("Y", ExrSamples::Float)], ExrCompression::None).unwrap();
        writer.write_rows(&[plane.view()]).unwrap();
        match writer.finish() {
            Ok(written) => {
                let bytes =
                    encoded(|out| encode_exr_with(out, &[ExrChannel::float("Y", plane.view())], ExrCompression::None))
                        .unwrap();
                assert!(works && written.bytes == bytes.len() as u64);
            }
            Err(error) => {
                let Error::Io { error: source, .. } = &error else { panic!("{error}") };
                assert!(!works && source.kind() == std::io::ErrorKind::StorageFull);
            }
        }
        assert!(!fs::metadata(path).unwrap().is_file());
    }
}

#[test]
fn planes_of_any_strides_may_be_mixed() {
    let image = Array3::from_shape_fn((35, 9, 3), |(row, column, channel)| (row * 30 + column * 3 + channel) as f32);
    let every_second = Array2::from_shape_fn((70, 9), |(row, column)| (row * 9 + column) as f32 / 4.0);
    let every_second = every_second.slice_axis(Axis(0), Slice::from(..).step_by(-2));
    let planes: Vec<ArrayView2<'_, f32>> =
        (0..3).map(|channel| image.index_axis(Axis(2), channel)).chain([every_second]).collect();
    let channels: Vec<_> =
        ["R", "G", "B", "Z"].into_iter().zip(&planes).map(|(name, &plane)| ExrChannel::half(name, plane)).collect();
    for coding in CODINGS {
        let read = decode_exr(&encoded(|out| encode_exr_with(out, &channels, coding)).unwrap()[..], &Limits::default())
            .unwrap();
        for channel in &channels {
            assert_eq!(read.channel(channel.name).unwrap(), channel.plane, "{coding:?} {}", channel.name);
        }
    }
}
