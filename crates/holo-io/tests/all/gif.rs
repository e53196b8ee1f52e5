//! Animated GIF, read back by the crate and by Pillow.

use crate::python;
use holo_io::{Error, write_gif_animation};
use ndarray::{Array3, ArrayView3};

/// Few enough colors that none is changed.
fn frames() -> Vec<Array3<u16>> {
    (0..4_usize)
        .map(|k| {
            Array3::from_shape_fn((6, 9, 3), |(row, column, c)| {
                ((k * 60 + row / 2 * 40 + column / 3 * (20 + c)) % 256 * 257) as u16
            })
        })
        .collect()
}

#[test]
fn frames_are_those_that_were_written() {
    const SCRIPT: &str = r#"
from PIL import Image, ImageSequence
image = Image.open(sys.argv[1])
print(image.size, image.n_frames, image.info["loop"])
for frame in ImageSequence.Iterator(image):
    print(frame.info["duration"], frame.convert("RGB").tobytes().hex())
"#;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("animation.gif");
    let frames = frames();
    let views: Vec<ArrayView3<'_, u16>> = frames.iter().map(|frame| frame.view()).collect();
    write_gif_animation(&path, &views, 25.0).unwrap();
    assert!(std::fs::read(&path).unwrap().starts_with(b"GIF89a"));
    let Some(text) = python::run(&["PIL"], SCRIPT, &[path.to_str().unwrap()]) else { return };
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("(9, 6) 4 0"));
    for (frame, line) in frames.iter().zip(lines) {
        let expected: String = frame.iter().map(|sample| format!("{:02x}", sample / 257)).collect();
        assert_eq!(line, format!("40 {expected}"));
    }
}

#[test]
fn gray_is_gray_and_the_rest_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.gif");
    let gray = Array3::<u8>::from_shape_fn((3, 4, 1), |(row, column, _)| (row * 40 + column) as u8);
    write_gif_animation(&path, &[gray.view()], 600.0).unwrap();
    std::fs::remove_file(&path).unwrap();
    let (other, alpha, float) =
        (Array3::<u8>::zeros((3, 5, 1)), Array3::<u8>::zeros((3, 4, 4)), Array3::<f32>::zeros((3, 4, 3)));
    let empty = Array3::<u8>::zeros((0, 4, 3));
    let refused = |result: Result<_, Error>| assert!(matches!(result, Err(Error::BadInput { .. })));
    refused(write_gif_animation::<u8>(&path, &[], 25.0));
    refused(write_gif_animation(&path, &[gray.view(), other.view()], 25.0));
    refused(write_gif_animation(&path, &[alpha.view()], 25.0));
    refused(write_gif_animation(&path, &[float.view()], 25.0));
    refused(write_gif_animation(&path, &[empty.view()], 25.0));
    refused(write_gif_animation(&path, &[gray.view()], 0.0));
    refused(write_gif_animation(&path, &[gray.view()], f64::NAN));
    assert!(!path.exists());
}
