//! Animated PNG: frames and delays read back, and invalid arguments are refused.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::Path;

use holo_core::DynImage;
use holo_io::{ColorEncoding, Error, Limits, read_png, write_png_animation};
use ndarray::{Array3, ArrayView3};

fn frame(number: u16) -> Array3<u16> {
    Array3::from_shape_fn((5, 7, 3), |(row, column, c)| number * 9001 + (row * 700 + column * 90 + c) as u16)
}

/// All frames of a file as bytes, and the delay of each as a fraction of a second.
fn frames(path: &Path) -> (Vec<Vec<u8>>, Vec<(u16, u16)>) {
    let mut reader = png::Decoder::new(BufReader::new(File::open(path).unwrap())).read_info().unwrap();
    let count = reader.info().animation_control().unwrap().num_frames;
    assert_eq!(reader.info().animation_control().unwrap().num_plays, 0, "it loops forever");
    let (mut all, mut delays) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        let control = reader.info().frame_control().unwrap();
        delays.push((control.delay_num, control.delay_den));
        all.push(bytes);
    }
    (all, delays)
}

#[test]
fn every_frame_reads_back_for_any_strides() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("animation.png");
    let deep: Vec<_> = (0..4).map(frame).collect();
    let views: Vec<ArrayView3<u16>> = deep.iter().map(|p| p.view().reversed_axes().permuted_axes([1, 2, 0])).collect();
    let written = write_png_animation(&path, &views, 12.5, ColorEncoding::Srgb).unwrap();
    assert_eq!(written, holo_io::hash_file(&path).unwrap());
    let (found, delays) = frames(&path);
    assert_eq!(delays, [(100, 1250); 4]);
    for (bytes, view) in found.iter().zip(&views) {
        let expected: Vec<u8> = view.iter().flat_map(|sample| sample.to_be_bytes()).collect();
        assert_eq!(*bytes, expected);
    }
    // Without support for animation, the first frame is read.
    let DynImage::U16(first) = read_png(&path, &Limits::default()).unwrap() else { panic!("8 bits") };
    assert_eq!(first, views[0]);
}

#[test]
fn one_gray_frame_is_an_animation_too() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("one.png");
    let one = Array3::<u8>::from_elem((1, 1, 1), 77);
    write_png_animation(&path, &[one.view()], 600.0, ColorEncoding::Linear).unwrap();
    assert_eq!(frames(&path), (vec![vec![77]], vec![(100, 60_000)]));
}

#[test]
fn invalid_animations_are_refused_and_leave_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("animation.png");
    let (one, other) = (Array3::<u8>::zeros((2, 3, 3)), Array3::<u8>::zeros((3, 2, 3)));
    let many_channels = Array3::<u8>::zeros((2, 3, 5));
    let none: [ArrayView3<u8>; 0] = [];
    for (frames, rate, part) in [
        (&none[..], 25.0, "needs a frame"),
        (&[one.view(), other.view()], 25.0, "but the first has"),
        (&[many_channels.view()], 25.0, "channels"),
        (&[one.view()], 0.0, "0.01 to 600"),
        (&[one.view()], f64::NAN, "0.01 to 600"),
    ] {
        let error = write_png_animation(&path, frames, rate, ColorEncoding::Srgb).unwrap_err();
        assert!(matches!(error, Error::BadInput { .. }) && error.to_string().contains(part), "{error}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_with_the_error_of_the_system() {
    for side in [1, 300] {
        let noise = Array3::from_shape_fn((side, side, 3), |(a, b, c)| (a * 7919 + b * 104_729 + c * c * 31) as u8);
        let error =
            write_png_animation("/dev/full", &[noise.view(), noise.view()], 25.0, ColorEncoding::Srgb).unwrap_err();
        assert!(error.to_string().contains("free some space"), "{error}");
    }
}
