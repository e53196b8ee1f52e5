//! OpenEXR: exact round trips, files of other programs, and errors for damaged files.

use std::fs;

use crate::common::{data, ramp};
use crate::encoded::encoded;
use holo_core::GridSize;
use holo_io::{
    Error, ExrChannel, Limits, decode_exr, decode_exr_rgb, encode_exr, read_exr, read_exr_info, read_exr_rgb, read_pfm,
    read_pfm_gray, write_exr,
};
use ndarray::{Array2, Array3, ArrayView2, Axis, Slice, array};
use proptest::prelude::*;

fn bits<'a>(values: impl IntoIterator<Item = &'a f32>) -> Vec<u32> {
    values.into_iter().map(|value| value.to_bits()).collect()
}

fn encode(channels: &[(&str, ArrayView2<'_, f32>)]) -> Result<Vec<u8>, Error> {
    let channels: Vec<_> = channels.iter().map(|&(name, plane)| ExrChannel::float(name, plane)).collect();
    encoded(|out| encode_exr(out, &channels))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_shape_stride_and_bit_pattern_reads_back(
        rows in 1_usize..40, columns in 1_usize..40, channels in 1_usize..5, kind in 0_usize..4, order in any::<u64>(),
        pattern in prop::collection::vec(any::<u32>(), 1..40),
    ) {
        let mut at = 0;
        let mut next = || { at += 1; f32::from_bits(pattern[at % pattern.len()]) };
        let mut planes: Vec<(String, Array2<f32>)> = Vec::new();
        for channel in 0..channels {
            let plane = match kind {
                0 => Array2::from_shape_simple_fn((columns, rows), &mut next).reversed_axes(),
                1 => Array2::from_shape_simple_fn((rows * 3, columns), &mut next)
                    .slice_axis_move(Axis(0), Slice::from(..).step_by(-3)),
                2 => {
                    let mut plane = Array2::from_shape_simple_fn((rows, columns), &mut next);
                    plane.invert_axis(Axis(1));
                    plane
                }
                _ => Array2::from_shape_simple_fn((rows, columns), &mut next),
            };
            // Names in any order, one longer than the 31 bytes that the format's first version had.
            let name = format!("View{}.{}", order.rotate_left(channel as u32 * 7) % 97, "Z".repeat(1 + channel * 20));
            planes.push((name, plane));
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.exr");
        let list: Vec<_> = planes.iter().map(|(name, plane)| ExrChannel::float(name, plane.view())).collect();
        let written = write_exr(&path, &list).unwrap();
        prop_assert_eq!(written, holo_io::hash_file(&path).unwrap());
        prop_assert_eq!(fs::read(&path).unwrap(), encoded(|out| encode_exr(out, &list)).unwrap());
        let image = read_exr(&path, &Limits::default()).unwrap();
        let names: Vec<_> = image.channels.iter().map(|(name, _)| name.clone()).collect();
        prop_assert!(names.is_sorted());
        prop_assert_eq!(names.len(), channels);
        for (name, plane) in &planes {
            let read = image.channel(name).expect("every channel is there");
            prop_assert_eq!(read.dim(), (rows, columns));
            prop_assert_eq!(bits(read), bits(plane));
        }
        let info = read_exr_info(&path).unwrap();
        prop_assert_eq!(info.size, GridSize::new(rows, columns));
        prop_assert_eq!((info.channels, info.compression.as_str(), info.parts), (names, "zip block", 1));
    }
}

#[test]
fn an_image_of_many_blocks_has_the_same_bytes_for_any_number_of_threads() {
    let plane = Array2::from_shape_fn((1000, 37), |(row, column)| ((row * 37 + column) as f32).sqrt());
    let write = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| encode(&[("G", plane.view()), ("R", plane.view()), ("B", plane.view())]).unwrap())
    };
    let bytes = write(1);
    assert_eq!(bytes, write(3));
    let image = decode_exr(&bytes[..], &Limits::default()).unwrap();
    assert_eq!(image.channels.len(), 3);
    assert!(image.channels.iter().all(|(_, read)| read == plane));
    let rgb = decode_exr_rgb(&bytes[..], &Limits::default()).unwrap();
    assert!(rgb.axis_iter(Axis(2)).all(|read| read == plane));
}

#[test]
fn invalid_arguments_are_refused_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.exr");
    let (small, large) = (Array2::zeros((2, 2)), Array2::zeros((2, 3)));
    let empty = Array2::zeros((0, 3));
    let long = "x".repeat(256);
    let channel = ExrChannel::float;
    for channels in [
        &[][..],
        &[channel("R", empty.view())],
        &[channel("R", small.view()), channel("G", large.view())],
        &[channel("R", small.view()), channel("R", small.view())],
        &[channel("", small.view())],
        &[channel("a\0b", small.view())],
        &[channel(&long, small.view())],
    ] {
        let error = write_exr(&path, channels).unwrap_err();
        assert!(matches!(error, Error::BadInput { .. }), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    write_exr(&path, &[channel(&long[..255], small.view())]).unwrap();
    assert!(read_exr(&path, &Limits::default()).unwrap().channel(&long[..255]).is_some());
    assert!(matches!(
        write_exr(folder.path().join("none").join("x.exr"), &[channel("R", small.view())]),
        Err(Error::Io { .. })
    ));
}

#[test]
fn files_of_openexr_are_read() {
    for (name, compression) in [
        ("openexr_half_zip.exr", "zip block"),
        ("openexr_half_tiled.exr", "zip block"),
        ("openexr_half_pxr24.exr", "pxr24"),
        ("openexr_half_piz.exr", "piz"),
        ("openexr_half_zips.exr", "zip line"),
        ("openexr_parts.exr", "zip block"),
    ] {
        let image = read_exr_rgb(data(name), &Limits::default()).unwrap();
        assert_eq!(
            image,
            Array3::from_shape_fn((20, 19, 3), |(row, column, channel)| ramp(row, column, channel)),
            "{name}"
        );
        assert_eq!(read_exr_info(data(name)).unwrap().compression, compression);
    }
    let plane = |channel| Array2::from_shape_fn((20, 19), |(row, column)| ramp(row, column, channel));
    let image = read_exr(data("openexr_half_zip.exr"), &Limits::default()).unwrap();
    assert_eq!(image.channel("A"), Some(&plane(3)));
    let image = read_exr(data("openexr_parts.exr"), &Limits::default()).unwrap();
    assert_eq!(
        image.channels.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>(),
        ["depth.Z", "beauty.B", "beauty.G", "beauty.R"]
    );
    assert_eq!(image.channel("depth.Z"), Some(&plane(7)));
    let image = read_exr_rgb(data("openexr_luminance_rle.exr"), &Limits::default()).unwrap();
    assert!(image.axis_iter(Axis(2)).all(|read| read == plane(0)));
}

#[test]
fn floats_keep_every_bit() {
    let image = read_exr(data("openexr_float_piz.exr"), &Limits::default()).unwrap();
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        for ((row, column), &ours) in image.channel(name).unwrap().indexed_iter() {
            match (name, row, column) {
                ("R", 3, 4) => assert_eq!(ours, f32::INFINITY),
                ("R", 0, 1) => assert_eq!(ours, 0.1),
                ("G", 0, 0) => assert_eq!(ours.to_bits(), (-0.0_f32).to_bits()),
                ("B", 1, 1) => assert!(ours.is_nan()),
                _ => assert_eq!(ours, ramp(row, column, channel)),
            }
        }
    }
}

#[test]
fn half_float_and_integer_may_be_mixed() {
    let image = read_exr(data("openexr_mixed_none.exr"), &Limits::default()).unwrap();
    for (row, column) in ndarray::indices((20, 19)) {
        let at = |name: &str| image.channel(name).unwrap()[[row, column]];
        let whole = ramp(row, column, 0);
        let expected = [whole, ramp(row, column, 1), ramp(row, column, 2), whole * 3.0 + 1_048_576.0];
        assert_eq!(["R", "G", "B", "id"].map(at), expected);
    }
}

#[test]
fn identifiers_of_integers_are_read_in_every_coding() {
    for name in ["openexr_id_zip.exr", "openexr_id_piz.exr", "openexr_id_rle_tiled.exr", "openexr_id_pxr24.exr"] {
        let image = read_exr(data(name), &Limits::default()).unwrap();
        for (row, column) in ndarray::indices((20, 19)) {
            let at = |name: &str| image.channel(name).unwrap()[[row, column]];
            let whole = ramp(row, column, 0);
            assert_eq!((at("R"), at("id")), (whole, whole * 3.0 + 1_048_576.0), "{name} at {row} {column}");
        }
    }
}

#[test]
fn lossy_codings_lose_no_more_than_in_openexr() {
    // The result of OpenEXR itself differs from the ramp by at most these numbers.
    for (name, bound) in [("openexr_half_dwaa.exr", 0.97), ("openexr_half_b44.exr", 8.0)] {
        let image = read_exr_rgb(data(name), &Limits::default()).unwrap();
        for ((row, column, channel), ours) in image.indexed_iter() {
            assert!((ours - ramp(row, column, channel)).abs() <= bound, "{name}: {ours} at {row} {column} {channel}");
        }
    }
    let newer = read_exr_rgb(data("openexr_half_htj2k.exr"), &Limits::default()).unwrap_err();
    assert!(matches!(newer, Error::Unsupported { .. }), "{newer}");
}

#[test]
fn the_image_is_the_display_window() {
    // The data window has the size of the display window and begins 5 rows below and 3 columns left of it.
    let image = read_exr_rgb(data("openexr_windows_zips.exr"), &Limits::default()).unwrap();
    assert_eq!(image.dim(), (20, 19, 3));
    for ((row, column, channel), &ours) in image.indexed_iter() {
        let expected = if row >= 5 && column < 16 { ramp(row - 5, column + 3, channel) } else { 0.0 };
        assert_eq!(ours, expected, "{row} {column} {channel}");
    }
}

#[test]
fn files_of_blender_are_read() {
    let image = read_exr_rgb(data("blender.exr"), &Limits::default()).unwrap();
    assert_eq!(image, Array3::from_shape_fn((9, 12, 3), |(row, column, channel)| ramp(row, column, channel)));
    // One part a layer; the color is Combined, although Diffuse Color and the noisy image have R, G and B too.
    let path = data("blender_multilayer.exr");
    let combined = read_pfm(data("blender_combined.pfm"), &Limits::default()).unwrap().values;
    assert_eq!(read_exr_rgb(&path, &Limits::default()).unwrap(), combined);
    let layers = read_exr(&path, &Limits::default()).unwrap();
    let depth = read_pfm_gray(data("blender_depth.pfm"), &Limits::default()).unwrap();
    assert_eq!(layers.channel("ViewLayer.Depth.Z"), Some(&depth));
    assert_eq!(layers.pass("Depth", "Z"), Some(&depth));
    // Blender 5 writes `Diffuse Color`, earlier versions `DiffCol`.
    assert!(layers.channel("ViewLayer.DiffCol.R").is_none() && layers.pass("DiffCol", "R").is_some());
    assert_eq!(layers.pass("DiffCol", "G"), layers.channel("ViewLayer.Diffuse Color.G"));
    let red = layers.channel("ViewLayer.Combined.R").unwrap();
    assert_eq!(red, combined.index_axis(Axis(2), 0));
    let info = read_exr_info(&path).unwrap();
    assert_eq!((info.parts, info.channels.len(), info.has_color), (5, 15, true));
}

#[test]
fn the_error_of_a_file_without_color_lists_its_channels() {
    let plane = array![[1.0, 2.0]];
    let bytes = encode(&[("N.X", plane.view()), ("N.Y", plane.view()), ("N.Z", plane.view())]).unwrap();
    let error = decode_exr_rgb(&bytes[..], &Limits::default()).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }) && error.to_string().contains("N.X, N.Y, N.Z"), "{error}");
}

#[test]
fn the_budget_is_exact() {
    let plane = Array2::zeros((10, 10));
    let bytes = encode(&[("R", plane.view()), ("G", plane.view()), ("B", plane.view()), ("Z", plane.view())]).unwrap();
    // A block is 16 lines of 4 channels even where the image is smaller: 16 * 10 * 16 = 2560 bytes, more than 1600.
    let allowed = |max_bytes| Limits { max_bytes };
    assert!(decode_exr(&bytes[..], &allowed(2560)).is_ok());
    assert!(matches!(decode_exr(&bytes[..], &allowed(2559)), Err(Error::TooLarge { needed: 2560, .. })));
    assert!(matches!(decode_exr(&bytes[..], &allowed(1599)), Err(Error::TooLarge { needed: 1600, what: "image", .. })));
    assert!(decode_exr_rgb(&bytes[..], &allowed(2560)).is_ok());
    assert!(matches!(decode_exr_rgb(&bytes[..], &allowed(1199)), Err(Error::TooLarge { needed: 1200, .. })));
}

/// Where the four numbers of a window begin in a file.
fn window_at(bytes: &[u8], name: &str) -> usize {
    let attribute = [name.as_bytes(), b"\0box2i\0\x10\0\0\0"].concat();
    bytes.windows(attribute.len()).position(|window| window == attribute).expect("the window") + attribute.len()
}

#[test]
fn absurd_sizes_take_no_memory() {
    let plane = Array2::zeros((10, 10));
    let whole = encode(&[("R", plane.view()), ("G", plane.view()), ("B", plane.view())]).unwrap();
    for (name, right, bottom) in [
        ("dataWindow", i32::MAX, i32::MAX),
        ("dataWindow", 1 << 29, 1 << 29),
        ("dataWindow", 9, 1 << 29),
        ("dataWindow", 1 << 29, 9),
        ("displayWindow", 1 << 29, 1 << 29),
        ("displayWindow", i32::MAX, 9),
        ("dataWindow", -1, 9),
        ("displayWindow", i32::MIN, i32::MIN),
    ] {
        let mut bytes = whole.clone();
        let at = window_at(&bytes, name) + 8;
        bytes[at..at + 4].copy_from_slice(&right.to_le_bytes());
        bytes[at + 4..at + 8].copy_from_slice(&bottom.to_le_bytes());
        for limits in [Limits::default(), Limits { max_bytes: 1 << 20 }] {
            for error in
                [decode_exr(&bytes[..], &limits).unwrap_err(), decode_exr_rgb(&bytes[..], &limits).unwrap_err()]
            {
                assert!(
                    matches!(error, Error::Broken { .. } | Error::TooLarge { .. }),
                    "{name} {right} {bottom}: {error}"
                );
                assert!(!error.to_string().contains("please report"), "{name} {right} {bottom}: {error}");
            }
        }
    }
}

#[test]
fn missing_and_duplicate_blocks_are_errors() {
    // 40 rows are 3 blocks, and the first two are equally long.
    let plane = Array2::from_elem((40, 5), 1.5);
    let whole = encode(&[("Y", plane.view())]).unwrap();
    let number = |at: usize| u64::from_le_bytes(whole[at..at + 8].try_into().unwrap()) as usize;
    // The table of where blocks begin ends where the first begins.
    let table = (0..whole.len() - 24).find(|&at| number(at) == at + 24).expect("the table");
    // A block begins with its first row.
    let second = number(table + 8);
    assert_eq!(whole[second..second + 4], 16_i32.to_le_bytes());
    let mut double = whole.clone();
    double[second..second + 4].copy_from_slice(&0_i32.to_le_bytes());
    let error = decode_exr(&double[..], &Limits::default()).unwrap_err();
    assert!(error.to_string().contains("the block at row 0, column 0 occurs twice"), "{error}");
    // An interrupted program leaves the table empty; blocks are found without it.
    let mut without_table = whole.clone();
    without_table[table..table + 24].fill(0);
    assert_eq!(decode_exr(&without_table[..], &Limits::default()).unwrap().channels[0].1, plane);
    // Rows outside of the image.
    let mut outside = whole.clone();
    outside[second..second + 4].copy_from_slice(&48_i32.to_le_bytes());
    assert!(matches!(decode_exr(&outside[..], &Limits::default()), Err(Error::Broken { .. })));
}

#[test]
fn a_block_that_announces_absurd_sizes_is_refused_before_it_is_decoded() {
    // An allocation of more than 2^40 bytes would fail and end the process.
    let whole = fs::read(data("openexr_half_dwaa.exr")).unwrap();
    // The one block: its first row, its length, eleven counters of which the first is the version, 2.
    let counters = (0..whole.len() - 16)
        .find(|&at| whole[at..at + 4] == [0; 4] && whole[at + 8..at + 16] == 2_u64.to_le_bytes())
        .expect("the block")
        + 8;
    assert_eq!(whole.len(), counters + i32::from_le_bytes(whole[counters - 4..counters].try_into().unwrap()) as usize);
    for counter in [1, 6, 7, 8, 9] {
        let mut bytes = whole.clone();
        bytes[counters + 8 * counter..][..8].copy_from_slice(&(1_u64 << 60).to_le_bytes());
        let error = decode_exr(&bytes[..], &Limits::default()).unwrap_err();
        assert!(error.to_string().contains("announces more than it can contain"), "{counter}: {error}");
    }
}
