//! The names of dataset folders, and the detection of file formats.

use std::fs;

use holo_core::GridSize;
use holo_io::{Error, FileFormat, dataset, detect_format};

#[test]
fn folders_are_named_after_scene_and_views() {
    assert_eq!(dataset::folder("a b", GridSize::new(3, 200)).unwrap(), std::path::Path::new("a b/200x3"));
    for scene in ["", ".", "..", "a/b", "a\\b", "c:"] {
        assert!(matches!(dataset::folder(scene, GridSize::new(1, 1)), Err(Error::BadInput { .. })), "{scene:?}");
    }
}

#[test]
fn folders_of_plenoptic_cameras_have_their_names() {
    assert_eq!(dataset::camera_folder("a b", "bench camera").unwrap(), std::path::Path::new("a b/bench camera"));
    for camera in ["", "..", "a/b", "c:", "20x20", "frame_0012", "dot.", "line\nfeed", "what?"] {
        assert!(matches!(dataset::camera_folder("a", camera), Err(Error::BadInput { .. })), "{camera:?}");
    }
    assert!(matches!(dataset::camera_folder("..", "camera"), Err(Error::BadInput { .. })));
}

#[test]
fn formats_are_detected_by_contents() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("misleading.png");
    let padded = |text: &str| format!("{}{text}", " ".repeat(100_000));
    let formats: [(&[u8], FileFormat); 26] = [
        (b"\x89PNG\r\n\x1a\nrest", FileFormat::Png),
        (b"\x89PNG\r\n\x1a", FileFormat::Unknown),
        (b"Pf\n1 1\n-1\n", FileFormat::Pfm),
        (b"PF 1 1", FileFormat::Pfm),
        (b"Pfennig", FileFormat::Unknown),
        (b"\x76\x2f\x31\x01\x02\0\0\0", FileFormat::Exr),
        (b"\x76\x2f\x31", FileFormat::Unknown),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", FileFormat::Hdr),
        (b"#?RGBE\n", FileFormat::Hdr),
        (b"#!RGBE\n", FileFormat::Unknown),
        (b"glTF\x02\0\0\0", FileFormat::GltfBinary),
        (br#"{"scenes":[{"format":7}],"asset":{"version":"2.0"}}"#, FileFormat::GltfJson),
        (b"\xef\xbb\xbf{\"asset\":{}}", FileFormat::GltfJson),
        (br#" {"format":"holo manifest 1","asset":1}"#, FileFormat::Manifest),
        (br#"{"files":{},"format":"holo manifest 77"}"#, FileFormat::Manifest),
        (br#"{"format":"other"}"#, FileFormat::Unknown),
        (br#"{"asset":{}"#, FileFormat::Unknown),
        (b"[intrinsics]\nx = 1\n[extrinsics]\n", FileFormat::ParametersCfg),
        (b"\xef\xbb\xbf# HCI\r\n [extrinsics] \r\n[intrinsics]\r\n", FileFormat::ParametersCfg),
        (b"[intrinsics]\n", FileFormat::Unknown),
        (b"# LIF1.0\nSLAB 0 lion\n  SLAB_UV 0 0\n", FileFormat::LightPack),
        (b"the SLAB_UV of a text", FileFormat::Unknown),
        (b"\x01\xda\x01\x01\0\x03", FileFormat::Sgi),
        (b"\x01\xda\x02\x01", FileFormat::Unknown),
        (b"", FileFormat::Unknown),
        (b"\0", FileFormat::Unknown),
    ];
    for (contents, format) in formats {
        fs::write(&path, contents).unwrap();
        assert_eq!(detect_format(&path).unwrap(), format, "{}", String::from_utf8_lossy(contents));
    }
    // Only the beginning of a text is searched, here behind white space.
    fs::write(&path, padded("{\"asset\":{}}")).unwrap();
    assert_eq!(detect_format(&path).unwrap(), FileFormat::Unknown);
    let long = format!("{{\"buffers\":[\"{}\"],\"asset\":{{}}}}", "x".repeat(200_000));
    fs::write(&path, long).unwrap();
    assert_eq!(detect_format(&path).unwrap(), FileFormat::GltfJson);
    fs::write(&path, "[".repeat(1_000_000)).unwrap();
    assert_eq!(detect_format(&path).unwrap(), FileFormat::Unknown);
    fs::write(&path, format!("{{\"x\":{}", "[".repeat(1_000_000))).unwrap();
    assert_eq!(detect_format(&path).unwrap(), FileFormat::Unknown);
    for path in [folder.path().to_owned(), folder.path().join("missing")] {
        assert!(matches!(detect_format(&path), Err(Error::Io { .. })));
    }
}
