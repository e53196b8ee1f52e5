//! Other programs read the files of this crate exactly: Pillow or OpenCV for PNG, the OpenEXR library for EXR.
//!
//! Needs a Python that has them: `HOLO_PYTHON`, or `python3`. Without one, it says so and passes, or fails with
//! `HOLO_REQUIRE_PEERS=1`.

use crate::python;
use holo_io::{ColorEncoding, Compression, ExrChannel, ExrCompression, write_exr_with, write_png};
use ndarray::{Array2, Array3};

#[test]
fn other_programs_read_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    let mut state = 1_u64;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as u16
    };
    for channels in [1, 2, 3, 4] {
        for (compression, kind) in [(Compression::Fast, "s"), (Compression::Best, "p")] {
            let deep = Array3::from_shape_simple_fn((37, 23, channels), &mut next);
            let path = folder.path().join(format!("{channels}{kind}16.png"));
            write_png(&path, deep.view(), ColorEncoding::Linear, compression).unwrap();
            // OpenCV has no gray with alpha: it reads three equal channels.
            if channels != 2 {
                files.push((path, deep.iter().map(|sample| format!("{sample:04x}")).collect::<String>()));
                let flat = deep.mapv(|sample| sample as u8);
                let path = folder.path().join(format!("{channels}{kind}8.png"));
                write_png(&path, flat.view(), ColorEncoding::Srgb, compression).unwrap();
                files.push((path, flat.iter().map(|sample| format!("{sample:02x}")).collect()));
            }
        }
    }
    // Integers up to 2047 are exact in half, and so are quarters of them and infinity.
    let halves = Array2::from_shape_simple_fn((70, 31), || f32::from(next() % 2048) / 4.0);
    let mut floats = Array2::from_shape_simple_fn((70, 31), || f32::from_bits(u32::from(next()) << 15 | 7));
    floats[[0, 0]] = f32::INFINITY;
    for (compression, name) in [
        (ExrCompression::Zip, "zip"),
        (ExrCompression::Zips, "zips"),
        (ExrCompression::Piz, "piz"),
        (ExrCompression::None, "none"),
    ] {
        let path = folder.path().join(format!("{name}.exr"));
        let channels = [
            ExrChannel::half("ViewLayer.Combined.R", halves.view()),
            ExrChannel::float("ViewLayer.Depth.Z", floats.view()),
        ];
        write_exr_with(&path, &channels, compression).unwrap();
        let half = |value: &f32| {
            // Exact numbers from 0 to 511.75 only.
            let bits = value.to_bits();
            if bits == 0 { 0 } else { ((bits >> 23) - 112) << 10 | bits >> 13 & 1023 }
        };
        let mut expected: String = halves.iter().map(|value| format!("{:04x}", half(value))).collect();
        expected.extend(floats.iter().map(|value| format!("{:08x}", value.to_bits())));
        files.push((path, expected));
    }
    let paths = files.iter().map(|(path, _)| path.as_path());
    let Some(text) = python::run_file("read_images.py", paths) else { return };
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), files.len());
    for ((path, expected), line) in files.iter().zip(lines) {
        match line {
            "-" => python::missing(&format!("a program that reads {}", path.display())),
            line => assert!(line == expected, "{}", path.display()),
        }
    }
}
