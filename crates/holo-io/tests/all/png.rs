//! PNG: exact round trips, errors for damaged files, and refused images, which leave no file.

use std::fs;

use holo_core::DynImage;
use holo_io::{
    ColorEncoding, Compression, Error, Limits, decode_png, read_png, read_png_info, write_disparity_png, write_png,
};
use ndarray::{Array2, Array3, ArrayView3, Axis, Slice, s};
use proptest::prelude::*;

const BOTH: [Compression; 2] = [Compression::Fast, Compression::Best];

/// Pseudorandom numbers.
fn noise(seed: u64) -> impl FnMut() -> u64 {
    let mut state = seed.wrapping_mul(2) + 1;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state >> 33
    }
}

/// An image of shape `(rows, columns, channels)` with one of several memory orders.
fn with_strides<T: Copy + Default>(
    kind: usize,
    (rows, columns, channels): (usize, usize, usize),
    mut next: impl FnMut() -> T,
) -> Array3<T> {
    let mut make = |shape: (usize, usize, usize)| Array3::from_shape_simple_fn(shape, &mut next);
    match kind {
        // Planes of channels.
        0 => make((channels, rows, columns)).permuted_axes([1, 2, 0]),
        // Columns first.
        1 => make((columns, rows, channels)).permuted_axes([1, 0, 2]),
        // Flipped vertically.
        2 => {
            let mut image = make((rows, columns, channels));
            image.invert_axis(Axis(0));
            image
        }
        // Mirrored, channels reversed.
        3 => {
            let mut image = make((rows, columns, channels));
            image.invert_axis(Axis(1));
            image.invert_axis(Axis(2));
            image
        }
        // Every second row, every third column of a larger image, backwards.
        4 => make((rows * 2, columns * 3, channels))
            .slice_axis_move(Axis(0), Slice::from(..).step_by(-2))
            .slice_axis_move(Axis(1), Slice::from(..).step_by(3)),
        _ => make((rows, columns, channels)),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn every_shape_and_stride_reads_back(
        rows in 1_usize..24, columns in 1_usize..24, channels in 1_usize..=4,
        kind in 0_usize..6, seed: u64, flat: bool, published: bool,
    ) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("image.png");
        let compression = BOTH[usize::from(published)];
        let mut next = noise(seed);
        let mut value = || if flat { 77 } else { next() };

        let image = with_strides(kind, (rows, columns, channels), || value() as u8);
        let written = write_png(&path, image.view(), ColorEncoding::Srgb, compression).unwrap();
        prop_assert_eq!(written, holo_io::hash_file(&path).unwrap());
        prop_assert_eq!(read_png(&path, &Limits::default()).unwrap(), DynImage::U8(image));

        let image = with_strides(kind, (rows, columns, channels), || value() as u16);
        write_png(&path, image.view(), ColorEncoding::Linear, compression).unwrap();
        prop_assert_eq!(read_png(&path, &Limits::default()).unwrap(), DynImage::U16(image));
        let info = read_png_info(&path).unwrap();
        prop_assert_eq!((info.size.rows, info.size.columns, info.channels, info.bits), (rows, columns, channels, 16));
    }
}

/// Noise, a repeating part and a flat part, larger than several bands.
fn large_image() -> Array3<u8> {
    let mut next = noise(5);
    let tile: Vec<u8> = (0..300).map(|_| next() as u8).collect();
    Array3::from_shape_fn((1009, 1499, 3), |(row, column, channel)| match row {
        0..400 => (row / 8 + column / 16 + (next() % 7) as usize) as u8,
        400..800 => tile[(column * 3 + channel) % 300],
        _ => 200,
    })
}

#[test]
fn an_image_of_many_bands_reads_back_and_does_not_depend_on_threads() {
    let folder = tempfile::tempdir().unwrap();
    let image = large_image();
    let mut digests = Vec::new();
    for threads in [1, 2, 5] {
        let path = folder.path().join(format!("{threads}.png"));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        digests.push(pool.install(|| write_png(&path, image.view(), ColorEncoding::Srgb, Compression::Best)).unwrap());
        assert_eq!(read_png(&path, &Limits::default()).unwrap(), DynImage::U8(image.clone()));
    }
    assert!(digests.windows(2).all(|pair| pair[0] == pair[1]));
    let scratch = write_png(folder.path().join("s.png"), image.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    assert!(digests[0].bytes < scratch.bytes, "{} against {}", digests[0].bytes, scratch.bytes);
}

#[test]
fn the_header_specifies_the_samples() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    for compression in BOTH {
        let image = Array3::from_elem((2, 3, 1), 0x1234_u16);
        write_png(&path, image.view(), ColorEncoding::Srgb, compression).unwrap();
        let bytes = fs::read(&path).unwrap();
        // Width, height, depth, color type, compression, filter, interlace.
        assert_eq!(bytes[16..29], [0, 0, 0, 3, 0, 0, 0, 2, 16, 0, 0, 0, 0]);
        assert!(bytes.windows(4).any(|name| name == b"sRGB"));
        // An independent decoder reads the same numbers, big-endian.
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        let mut raw = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut raw).unwrap();
        assert_eq!(raw, [0x12, 0x34].repeat(6));

        write_png(&path, image.view(), ColorEncoding::Linear, compression).unwrap();
        let bytes = fs::read(&path).unwrap();
        for claim in [b"sRGB", b"gAMA", b"iCCP", b"cHRM"] {
            assert!(!bytes.windows(4).any(|name| name == claim));
        }
    }
}

#[test]
fn equal_images_give_equal_bytes_whatever_their_strides() {
    let folder = tempfile::tempdir().unwrap();
    for compression in BOTH {
        let mut next = noise(3);
        let image = with_strides(4, (37, 41, 3), || next() as u8);
        let dense = image.as_standard_layout().into_owned();
        let one = write_png(folder.path().join("a.png"), image.view(), ColorEncoding::Srgb, compression).unwrap();
        let other = write_png(folder.path().join("b.png"), dense.view(), ColorEncoding::Srgb, compression).unwrap();
        assert_eq!(one, other);
    }
}

#[test]
fn a_file_truncated_anywhere_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    let mut next = noise(1);
    let image = Array3::from_shape_simple_fn((7, 5, 3), || next() as u8);
    for compression in BOTH {
        write_png(&path, image.view(), ColorEncoding::Srgb, compression).unwrap();
        let bytes = fs::read(&path).unwrap();
        assert!(decode_png(&bytes[..], &Limits::default()).is_ok());
        for end in 0..bytes.len() {
            let error = decode_png(&bytes[..end], &Limits::default()).expect_err(&format!("cut at {end}"));
            assert!(matches!(error, Error::Broken { .. }), "cut at {end}: {error}");
        }
    }
}

#[test]
fn a_changed_byte_is_an_error_or_the_same_image() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    let image = Array3::from_shape_fn((5, 4, 2), |(row, column, channel)| (row * 50 + column * 10 + channel) as u8);
    write_png(&path, image.view(), ColorEncoding::Srgb, Compression::Best).unwrap();
    let bytes = fs::read(&path).unwrap();
    let image = DynImage::U8(image);
    for at in 0..bytes.len() {
        for change in [0x01, 0x20, 0x80, 0xff] {
            let mut changed = bytes.clone();
            changed[at] ^= change;
            if let Ok(read) = decode_png(&changed[..], &Limits::default()) {
                assert_eq!(read, image, "byte {at} changed by {change:#x} went unnoticed");
            }
        }
    }
}

#[test]
fn the_limit_is_checked_before_memory_is_allocated() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    write_png(&path, Array3::<u16>::zeros((10, 10, 3)).view(), ColorEncoding::Linear, Compression::Fast).unwrap();
    assert!(read_png(&path, &Limits { max_bytes: 600 }).is_ok());
    let error = read_png(&path, &Limits { max_bytes: 599 }).unwrap_err();
    assert!(matches!(error, Error::TooLarge { needed: 600, allowed: 599, .. }), "{error}");

    // The same file with a header that announces 2^31 - 1 pixels a side, with a correct checksum.
    let mut bytes = fs::read(&path).unwrap();
    bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    let checksum = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&checksum.to_be_bytes());
    for limits in [Limits::default(), Limits::NONE] {
        let error = decode_png(&bytes[..], &limits).unwrap_err();
        assert!(matches!(error, Error::TooLarge { .. }), "{error}");
    }
}

/// The checksum of a chunk, bit by bit.
fn crc32(data: &[u8]) -> u32 {
    !data.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0xedb8_8320 } else { sum >> 1 })
    })
}

/// A PNG from a header and unfiltered rows (each with its filter byte), in stored deflate blocks.
fn handmade(header: [u8; 13], before: &[(&[u8; 4], &[u8])], rows: &[u8]) -> Vec<u8> {
    let mut zlib = vec![0x78, 0x01, 1];
    zlib.extend((rows.len() as u16).to_le_bytes());
    zlib.extend((!(rows.len() as u16)).to_le_bytes());
    zlib.extend(rows);
    let (a, b) = rows.iter().fold((1_u32, 0_u32), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65_521;
        (a, (a + b) % 65_521)
    });
    zlib.extend((b << 16 | a).to_be_bytes());
    let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
    let mut chunk = |name: &[u8; 4], data: &[u8]| {
        let body = [name, data].concat();
        file.extend((data.len() as u32).to_be_bytes());
        file.extend(&body);
        file.extend(crc32(&body).to_be_bytes());
    };
    chunk(b"IHDR", &header);
    before.iter().for_each(|(name, data)| chunk(name, data));
    chunk(b"IDAT", &zlib);
    chunk(b"IEND", &[]);
    file
}

fn header(columns: u8, rows: u8, depth: u8, color: u8, interlaced: bool) -> [u8; 13] {
    [0, 0, 0, columns, 0, 0, 0, rows, depth, color, 0, 0, u8::from(interlaced)]
}

#[test]
fn palettes_and_small_depths_are_expanded() {
    let read = |bytes: Vec<u8>| match decode_png(&bytes[..], &Limits::default()).unwrap() {
        DynImage::U8(samples) => samples,
        other => panic!("8 bits expected, not {}", other.kind().name()),
    };
    let palette: &[u8] = &[10, 20, 30, 40, 50, 60, 70, 80, 90];
    // 2 bits a pixel: 0 1 2 1.
    let bytes = handmade(header(4, 1, 2, 3, false), &[(b"PLTE", palette)], &[0, 0b0001_1001]);
    let expected = [10, 20, 30, 40, 50, 60, 70, 80, 90, 40, 50, 60];
    assert_eq!(read(bytes), Array3::from_shape_vec((1, 4, 3), expected.to_vec()).unwrap());
    // The same with a transparent first entry.
    let bytes = handmade(header(4, 1, 2, 3, false), &[(b"PLTE", palette), (b"tRNS", &[0])], &[0, 0b0001_1001]);
    let samples = read(bytes);
    assert_eq!(samples.dim(), (1, 4, 4));
    assert_eq!(samples.slice(s![0, .., 3]).to_vec(), [0, 255, 255, 255]);
    // Gray of 1, 2 and 4 bits covers the full range.
    let samples = read(handmade(header(3, 2, 1, 0, false), &[], &[0, 0b1010_0000, 0, 0b0110_0000]));
    assert_eq!(samples.iter().copied().collect::<Vec<_>>(), [255, 0, 255, 0, 255, 255]);
    let samples = read(handmade(header(4, 1, 2, 0, false), &[], &[0, 0b0001_1011]));
    assert_eq!(samples.iter().copied().collect::<Vec<_>>(), [0, 85, 170, 255]);
    let samples = read(handmade(header(2, 1, 4, 0, false), &[], &[0, 0x3f]));
    assert_eq!(samples.iter().copied().collect::<Vec<_>>(), [51, 255]);
}

#[test]
fn impossible_palettes_are_errors() {
    let longer = [7; 800];
    for bytes in [0, 1, 2, 4, 5, 7, 8, 769, 770, 771, 774] {
        let before: [(&[u8; 4], &[u8]); 2] = [(b"PLTE", &longer[..bytes]), (b"tRNS", &[0])];
        for depth in [2, 8] {
            let row: &[u8] = if depth == 2 { &[0, 0b0001_1001] } else { &[0, 0, 1, 2, 1] };
            for before in [&before[..1], &before] {
                let read = decode_png(&*handmade(header(4, 1, depth, 3, false), before, row), &Limits::default());
                assert!(matches!(read, Err(Error::Broken { .. })), "{bytes} bytes at depth {depth}");
            }
        }
    }
    // Without any palette.
    assert!(decode_png(&*handmade(header(4, 1, 8, 3, false), &[], &[0, 0, 1, 2, 1]), &Limits::default()).is_err());
}

#[test]
fn interlaced_images_are_decoded() {
    let (rows, columns) = (9, 11);
    let value = |row: usize, column: usize| (row * 16 + column) as u16 * 257 + 1;
    // The seven passes of Adam7: first row, first column, row step, column step.
    let passes = [(0, 0, 8, 8), (0, 4, 8, 8), (4, 0, 8, 4), (0, 2, 4, 4), (2, 0, 4, 2), (0, 1, 2, 2), (1, 0, 2, 1)];
    for depth in [8_u8, 16] {
        let mut data = Vec::new();
        for (first_row, first_column, row_step, column_step) in passes {
            for row in (first_row..rows).step_by(row_step) {
                data.push(0);
                for column in (first_column..columns).step_by(column_step) {
                    match depth {
                        8 => data.push(value(row, column) as u8),
                        _ => data.extend(value(row, column).to_be_bytes()),
                    }
                }
            }
        }
        let bytes = handmade(header(columns as u8, rows as u8, depth, 0, true), &[], &data);
        let expected = Array3::from_shape_fn((rows, columns, 1), |(row, column, _)| value(row, column));
        let expected = match depth {
            8 => DynImage::U8(expected.mapv(|value| value as u8)),
            _ => DynImage::U16(expected),
        };
        assert_eq!(decode_png(&bytes[..], &Limits::default()).unwrap(), expected);
        for end in 0..bytes.len() {
            assert!(decode_png(&bytes[..end], &Limits::default()).is_err(), "cut at {end}");
        }
    }
}

#[test]
fn missing_rows_are_an_error_even_in_a_file_with_its_end() {
    let short = handmade(header(2, 3, 8, 0, false), &[], &[0, 1, 2, 0, 3, 4]);
    assert!(matches!(decode_png(&short[..], &Limits::default()), Err(Error::Broken { .. })));
    let none = handmade(header(2, 3, 8, 0, false), &[], &[]);
    assert!(matches!(decode_png(&none[..], &Limits::default()), Err(Error::Broken { .. })));
}

#[test]
fn invalid_images_are_refused_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("image.png");
    for shape in [(0, 3, 3), (3, 0, 3), (3, 3, 0), (3, 3, 5)] {
        for compression in BOTH {
            let error =
                write_png(&path, Array3::<u8>::zeros(shape).view(), ColorEncoding::Srgb, compression).unwrap_err();
            assert!(matches!(error, Error::BadInput { .. }), "{shape:?}: {error}");
        }
    }
    // A view with strides of 0 takes no memory, but has too many rows.
    let one = Array3::<u8>::zeros((1, 1, 1));
    let tall: ArrayView3<'_, u8> = one.broadcast((1 << 31, 1, 1)).unwrap();
    assert!(matches!(write_png(&path, tall, ColorEncoding::Srgb, Compression::Fast), Err(Error::BadInput { .. })));
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_with_its_path_and_the_error_of_the_system() {
    for compression in BOTH {
        for image in [Array3::zeros((1, 1, 3)), large_image()] {
            let error = write_png("/dev/full", image.view(), ColorEncoding::Srgb, compression).unwrap_err();
            let Error::Io { path, error: source, .. } = &error else { panic!("{error}") };
            assert_eq!(
                (path.as_path(), source.kind()),
                (std::path::Path::new("/dev/full"), std::io::ErrorKind::StorageFull)
            );
            assert!(error.to_string().contains("free some space"), "{error}");
        }
    }
    assert!(!fs::metadata("/dev/full").unwrap().is_file());
}

#[test]
fn errors_of_the_path_name_the_path() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, b"x").unwrap();
    let image = Array3::<u8>::zeros((1, 1, 3));
    for path in [file.join("image.png"), folder.path().join("missing/image.png"), folder.path().to_owned()] {
        let error = write_png(&path, image.view(), ColorEncoding::Srgb, Compression::Fast).unwrap_err();
        assert!(matches!(error, Error::Io { .. }) && error.path() == path, "{error}");
    }
    for path in [folder.path().join("missing.png"), folder.path().to_owned()] {
        let error = read_png(&path, &Limits::default()).unwrap_err();
        assert!(matches!(error, Error::Io { .. }) && error.path() == path, "{error}");
    }
    assert!(matches!(read_png(&file, &Limits::default()), Err(Error::Broken { .. })));
    assert!(matches!(read_png_info(&file), Err(Error::Broken { .. })));
}

#[test]
fn disparity_becomes_gray_and_nearer_is_brighter() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_disparity.png");
    let map = ndarray::array![[-2.0_f32, 0.0, 2.0], [f32::NAN, f32::NEG_INFINITY, 9.0]];
    write_disparity_png(&path, map.view(), -2.0, 2.0, Compression::Best).unwrap();
    let expected = Array3::from_shape_vec((2, 3, 1), vec![0, 128, 255, 0, 0, 255]).unwrap();
    assert_eq!(read_png(&path, &Limits::default()).unwrap(), DynImage::U8(expected));
    // The scale is in the file.
    let bytes = std::fs::read(&path).unwrap();
    let text = b"tEXtDescription\0disparity, px between adjacent views: -2 is 0, 2 is 255, linear";
    assert!(bytes.windows(text.len()).any(|window| window == text));
    // A constant map is black.
    write_disparity_png(&path, Array2::zeros((2, 2)).view(), 0.0, 0.0, Compression::Fast).unwrap();
    assert_eq!(read_png(&path, &Limits::default()).unwrap(), DynImage::U8(Array3::zeros((2, 2, 1))));
    for (min, max) in [(1.0, 0.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        let error = write_disparity_png(&path, map.view(), min, max, Compression::Fast).unwrap_err();
        assert!(matches!(error, Error::BadInput { .. }), "{error}");
    }
}
