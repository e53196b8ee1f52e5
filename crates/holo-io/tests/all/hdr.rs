//! Radiance HDR: values of the closed form, all codings and orientations, and errors for damaged files.

use crate::common;
use holo_core::GridSize;
use holo_io::{Error, Limits, decode_hdr, read_hdr, read_hdr_info};
use ndarray::{Array3, Axis};
use proptest::prelude::*;

type Pixel = [u8; 4];

fn decode(bytes: &[u8]) -> Result<Array3<f32>, Error> {
    decode_hdr(bytes, &Limits::default())
}

fn file(header: &str, size: &str, data: &[u8]) -> Vec<u8> {
    [format!("#?RADIANCE\n{header}FORMAT=32-bit_rle_rgbe\n\n{size}\n").as_bytes(), data].concat()
}

/// The closed form, in f64: (r, g, b) 2^(e - 136), and black for e = 0.
fn value(pixel: Pixel) -> [f64; 3] {
    let scale = if pixel[3] == 0 { 0.0 } else { 2.0_f64.powi(i32::from(pixel[3]) - 136) };
    [0, 1, 2].map(|channel| f64::from(pixel[channel]) * scale)
}

/// One scanline in the new coding; runs of equal bytes where they are shorter, as long as the format allows.
fn new_coding(pixels: &[Pixel]) -> Vec<u8> {
    let mut bytes = vec![2, 2, (pixels.len() >> 8) as u8, pixels.len() as u8];
    for component in 0..4 {
        let line: Vec<u8> = pixels.iter().map(|pixel| pixel[component]).collect();
        let mut at = 0;
        while at < line.len() {
            let run = line[at..].iter().take_while(|&&byte| byte == line[at]).count().min(127);
            if run > 2 {
                bytes.extend([128 + run as u8, line[at]]);
                at += run;
            } else {
                let literal = (line.len() - at).min(1 + at % 128);
                bytes.push(literal as u8);
                bytes.extend(&line[at..at + literal]);
                at += literal;
            }
        }
    }
    bytes
}

/// One scanline in the old coding. The pixels must not look like a marker.
fn old_coding(pixels: &[Pixel]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut at = 0;
    while at < pixels.len() {
        let run = pixels[at..].iter().take_while(|&&pixel| pixel == pixels[at]).count();
        bytes.extend(pixels[at]);
        let mut left = run - 1;
        while left > 0 {
            bytes.extend([1, 1, 1, left as u8]);
            left >>= 8;
        }
        at += run;
    }
    bytes
}

#[test]
fn every_code_has_the_value_of_the_closed_form() {
    // All mantissas along a scanline, a scanline for every exponent; the two other mantissas vary differently.
    let pixel = |row: usize, column: usize| [column as u8, (255 - column) as u8, (column * 7 + row) as u8, row as u8];
    let mut data = Vec::new();
    for row in 0..256 {
        data.extend(new_coding(&(0..256).map(|column| pixel(row, column)).collect::<Vec<_>>()));
    }
    let image = decode(&file("", "-Y 256 +X 256", &data)).unwrap();
    assert_eq!(image.dim(), (256, 256, 3));
    for ((row, column, channel), &ours) in image.indexed_iter() {
        // Eight bits times a power of two from 2^-135 on: f32 holds all of them, so there is no tolerance.
        assert_eq!(f64::from(ours), value(pixel(row, column))[channel], "{row} {column} {channel}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn every_coding_reads_back(
        rows in 1_usize..6, columns in 1_usize..700, coding in 0_usize..3,
        palette in prop::collection::vec(any::<Pixel>(), 1..5), steps in prop::collection::vec(0_usize..5, 1..60),
    ) {
        // Runs of a few colors, so that both codings have runs.
        let mut at = 0;
        let mut pixels = Vec::new();
        while pixels.len() < rows * columns {
            let step = steps[at % steps.len()];
            // No marker of either coding: normalized colors have no such small mantissas.
            let [r, g, b, e] = palette[at % palette.len()];
            pixels.extend(std::iter::repeat_n([r | 128, g, b, e], 1 << (2 * step)));
            at += 1;
        }
        pixels.truncate(rows * columns);
        let mut data = Vec::new();
        for line in pixels.chunks(columns) {
            match coding {
                0 if columns >= 8 => data.extend(new_coding(line)),
                1 => data.extend(old_coding(line)),
                _ => data.extend(line.as_flattened()),
            }
        }
        let image = decode(&file("", &format!("-Y {rows} +X {columns}"), &data)).unwrap();
        prop_assert_eq!(image.dim(), (rows, columns, 3));
        for (ours, pixel) in image.exact_chunks((1, 1, 3)).into_iter().zip(&pixels) {
            prop_assert_eq!(ours.iter().map(|&x| f64::from(x)).collect::<Vec<_>>(), value(*pixel).to_vec());
        }
    }
}

#[test]
fn all_orientations_give_the_same_upright_image() {
    let upright =
        Array3::from_shape_fn((3, 4, 4), |(row, column, channel)| [100 + row, 100 + column, 7, 136][channel] as u8);
    for (size, flip_rows, flip_columns, columns_first) in [
        ("-Y 3 +X 4", false, false, false),
        ("+Y 3 +X 4", true, false, false),
        ("-Y 3 -X 4", false, true, false),
        ("+Y 3 -X 4", true, true, false),
        ("+X 4 -Y 3", false, false, true),
        ("+X 4 +Y 3", true, false, true),
        ("-X 4 -Y 3", false, true, true),
        ("-X 4 +Y 3", true, true, true),
    ] {
        let mut in_file = upright.clone();
        if flip_rows {
            in_file.invert_axis(Axis(0));
        }
        if flip_columns {
            in_file.invert_axis(Axis(1));
        }
        if columns_first {
            in_file.swap_axes(0, 1);
        }
        let bytes = file("", size, &in_file.iter().copied().collect::<Vec<_>>());
        let image = decode(&bytes).unwrap();
        assert!(image.is_standard_layout());
        // Exponent 136 stands for a scale of 1.
        assert_eq!(image, upright.slice(ndarray::s![.., .., ..3]).mapv(f32::from), "{size}");
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("x.hdr"), &bytes).unwrap();
        assert_eq!(read_hdr_info(folder.path().join("x.hdr")).unwrap().size, GridSize::new(3, 4), "{size}");
    }
}

#[test]
fn exposure_and_color_correction_are_divided_out() {
    let header =
        "# a comment\nEXPOSURE=2\nrender -vp 0 0 0\n\tEXPOSURE=1000\nEXPOSURE= 4.0\nCOLORCORR= 1 2 4\nVIEW= x=y\n";
    let bytes = file(header, "-Y 1 +X 1", &[128, 128, 128, 132]);
    // 128 / 16 = 8, over 2 * 4 and over 1, 2, 4. The indented line belongs to another file.
    assert_eq!(decode(&bytes).unwrap(), ndarray::array![[[1.0, 0.5, 0.25]]]);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("x.hdr"), &bytes).unwrap();
    let info = read_hdr_info(folder.path().join("x.hdr")).unwrap();
    assert_eq!((info.exposure, info.color_correction), (8.0, [1.0, 2.0, 4.0]));
}

#[test]
fn headers_that_other_programs_write_are_read_and_faulty_ones_refused() {
    let pixel = [128, 64, 32, 129];
    let one = ndarray::array![[[1.0, 0.5, 0.25]]];
    for header in [
        "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n",
        "#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n",
        "#?RADIANCE\n\n-Y 1 +X 1\n",
        "#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 1\r\n",
        "#?RADIANCE\n\n-Y  1  +X  1 \n",
    ] {
        let image = decode(&[header.as_bytes(), &pixel].concat()).unwrap_or_else(|error| panic!("{header:?}: {error}"));
        assert_eq!(image, one, "{header:?}");
    }
    for header in [
        "",
        "RADIANCE\n\n-Y 1 +X 1\n",
        "#?RADIANCE\n-Y 1 +X 1\n",
        "#?RADIANCE\n\n-Y 0 +X 1\n",
        "#?RADIANCE\n\n-Y 1 +X 0\n",
        "#?RADIANCE\n\n-Y 1 +X -1\n",
        "#?RADIANCE\n\n-Y +1 +X 1\n",
        "#?RADIANCE\n\n-Y 1 +X 99999999999\n",
        "#?RADIANCE\n\n-Y 1 +Y 1\n",
        "#?RADIANCE\n\n-Y 1 +X 1 1\n",
        "#?RADIANCE\n\n-Y 1\n",
        "#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\n",
        "#?RADIANCE\nEXPOSURE=x\n\n-Y 1 +X 1\n",
        "#?RADIANCE\nEXPOSURE=inf\n\n-Y 1 +X 1\n",
        "#?RADIANCE\nEXPOSURE=1e300\nEXPOSURE=1e300\n\n-Y 1 +X 1\n",
        "#?RADIANCE\nCOLORCORR=1 1\n\n-Y 1 +X 1\n",
    ] {
        let error = decode(&[header.as_bytes(), &pixel].concat()).expect_err(header);
        assert!(matches!(error, Error::Broken { .. }), "{header:?}: {error}");
    }
    let xyze = decode(b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\0\0\0\0").unwrap_err();
    assert!(matches!(xyze, Error::Unsupported { .. }), "{xyze}");
    let endless = decode(&[b"#?RADIANCE\n".as_slice(), &[b'x'; 100_000]].concat()).unwrap_err();
    assert!(endless.to_string().contains("longer than 65536"), "{endless}");
}

#[test]
fn faulty_runs_are_refused_with_their_place() {
    let black = [0; 4];
    for (size, data, what) in [
        // Old coding: before the first pixel, past the end, more than any scanline can have.
        ("-Y 1 +X 3", [[1, 1, 1, 2], black, black].concat(), "before the first pixel"),
        ("-Y 1 +X 3", [black, [1, 1, 1, 3], black].concat(), "a run of at least 3 where 2 pixels are left"),
        ("-Y 1 +X 3", [[black].as_slice(), &[[1, 1, 1, 0]; 40], &[[1, 1, 1, 1]]].concat().concat(), "where 2 pixels"),
        // New coding: another length, no progress, past the end.
        ("-Y 1 +X 9", vec![2, 2, 0, 8, 136, 0], "announces 8 pixels, the header 9"),
        ("-Y 1 +X 8", vec![2, 2, 0, 8, 0, 0], "a run of 0"),
        ("-Y 1 +X 8", vec![2, 2, 0, 8, 137, 0], "a run of 9 where 8"),
        ("-Y 1 +X 8", vec![2, 2, 0, 8, 132, 0, 5, 0], "a run of 5 where 4"),
    ] {
        let error = decode(&file("", size, &data)).unwrap_err().to_string();
        assert!(error.contains(what) && error.contains("scanline 1 of 1"), "{error}");
    }
}

#[test]
fn a_file_that_is_cut_anywhere_is_broken() {
    let line = |seed: usize| (0..20).map(|at| [(at / 5 * 40 + seed) as u8 | 128, 9, 9, 130]).collect::<Vec<Pixel>>();
    for coding in [new_coding, old_coding, |line: &[Pixel]| line.as_flattened().to_vec()] {
        let whole = file("EXPOSURE=2\n", "-Y 3 +X 20", &(0..3).flat_map(|row| coding(&line(row))).collect::<Vec<_>>());
        assert!(decode(&whole).is_ok());
        for end in 0..whole.len() {
            let error = decode(&whole[..end]).expect_err("cut");
            assert!(matches!(error, Error::Broken { .. }), "cut at {end}: {error}");
        }
    }
}

#[test]
fn absurd_sizes_take_no_memory() {
    for size in ["-Y 4000000000 +X 4000000000", "+X 4294967295 -Y 4294967295", "-Y 1 +X 4000000000"] {
        let error = decode(&file("", size, &[0; 64])).unwrap_err();
        assert!(matches!(error, Error::TooLarge { .. }), "{error}");
    }
    let flat = file("", "-Y 2 +X 2", &[0; 16]);
    assert!(decode_hdr(&flat[..], &Limits { max_bytes: 48 }).is_ok());
    let error = decode_hdr(&flat[..], &Limits { max_bytes: 47 }).unwrap_err();
    assert!(matches!(error, Error::TooLarge { needed: 48, allowed: 47, .. }), "{error}");
    // An image of scanlines that are columns is in memory twice.
    let turned = file("", "+X 2 -Y 2", &[0; 16]);
    assert!(matches!(decode_hdr(&turned[..], &Limits { max_bytes: 95 }), Err(Error::TooLarge { needed: 96, .. })));
}

#[test]
fn files_of_blender_and_mitsuba_are_read() {
    // Both wrote row * 8 + column + channel / 8. Of the largest channel, RGBE keeps a mantissa of at least 128, so
    // whichever way a program rounds, it is off by less than one step: 1/128 of the largest channel.
    for name in ["blender.hdr", "mitsuba.hdr"] {
        let image = read_hdr(common::data(name), &Limits::default()).unwrap();
        assert_eq!(image.dim(), (9, 12, 3), "{name}");
        for ((row, column, channel), &ours) in image.indexed_iter() {
            let exact = common::ramp(row, column, channel);
            let step = common::ramp(row, column, 2) / 128.0;
            assert!((ours - exact).abs() < step, "{name}: {ours} for {exact}");
        }
    }
}
