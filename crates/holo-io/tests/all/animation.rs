//! Animations by the extension of their name. What ffmpeg makes of frames is tested with the binary.

use holo_io::{Error, write_animation, write_mp4_animation};
use ndarray::Array3;

#[test]
fn the_extension_is_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let frames = [Array3::<u8>::zeros((4, 6, 3)), Array3::<u8>::from_elem((4, 6, 3), 200)];
    let views = frames.each_ref().map(|frame| frame.view());
    for (name, magic) in [("a.gif", &b"GIF89a"[..]), ("a.PNG", b"\x89PNG")] {
        let path = folder.path().join(name);
        write_animation(&path, &views, 10.0).unwrap();
        assert!(std::fs::read(path).unwrap().starts_with(magic), "{name}");
    }
    for name in ["a.tif", "a", "a.avi"] {
        let path = folder.path().join(name);
        let error = write_animation(&path, &views, 10.0).unwrap_err();
        assert!(matches!(error, Error::BadInput { .. }) && error.to_string().contains("GIF or MP4"), "{error}");
        assert!(!path.exists());
    }
}

#[test]
fn what_no_mp4_can_hold_is_refused_before_anything_runs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mp4");
    let refused = |result: Result<(), Error>| assert!(matches!(result, Err(Error::BadInput { .. })));
    let (gray, other) = (Array3::<u8>::zeros((3, 4, 1)), Array3::<u8>::zeros((3, 5, 1)));
    refused(write_mp4_animation::<u8>(&path, &[], 25.0));
    refused(write_mp4_animation(&path, &[gray.view(), other.view()], 25.0));
    refused(write_mp4_animation(&path, &[gray.view()], f64::NAN));
    refused(write_mp4_animation(&path, &[Array3::<u8>::zeros((3, 4, 4)).view()], 25.0));
    refused(write_mp4_animation(&path, &[Array3::<f32>::zeros((3, 4, 3)).view()], 25.0));
    refused(write_mp4_animation(&path, &[Array3::<u8>::zeros((0, 4, 3)).view()], 25.0));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
