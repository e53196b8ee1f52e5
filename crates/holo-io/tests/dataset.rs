//! Dataset folders: names and kinds of files.

use std::fs;

use holo_core::GridSize;
use holo_io::{Error, FileKind, dataset, recognise};

#[test]
fn folders_are_named_after_scene_and_views() {
    assert_eq!(dataset::folder("a b", GridSize::new(3, 200)).unwrap(), std::path::Path::new("a b/200x3"));
    for scene in ["", ".", "..", "a/b", "a\\b", "c:"] {
        assert!(matches!(dataset::folder(scene, GridSize::new(1, 1)), Err(Error::BadInput { .. })), "{scene:?}");
    }
}

#[test]
fn kinds_are_told_by_contents() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("misleading.png");
    let padded = |text: &str| format!("{}{text}", " ".repeat(100_000));
    let kinds: [(&[u8], FileKind); 22] = [
        (b"\x89PNG\r\n\x1a\nrest", FileKind::Png),
        (b"\x89PNG\r\n\x1a", FileKind::Unknown),
        (b"Pf\n1 1\n-1\n", FileKind::Pfm),
        (b"PF 1 1", FileKind::Pfm),
        (b"Pfennig", FileKind::Unknown),
        (b"\x76\x2f\x31\x01\x02\0\0\0", FileKind::Exr),
        (b"\x76\x2f\x31", FileKind::Unknown),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", FileKind::Hdr),
        (b"#?RGBE\n", FileKind::Hdr),
        (b"#!RGBE\n", FileKind::Unknown),
        (b"glTF\x02\0\0\0", FileKind::GltfBinary),
        (br#"{"scenes":[{"format":7}],"asset":{"version":"2.0"}}"#, FileKind::GltfJson),
        (b"\xef\xbb\xbf{\"asset\":{}}", FileKind::GltfJson),
        (br#" {"format":"holo manifest 1","asset":1}"#, FileKind::Manifest),
        (br#"{"files":{},"format":"holo manifest 77"}"#, FileKind::Manifest),
        (br#"{"format":"other"}"#, FileKind::Unknown),
        (br#"{"asset":{}"#, FileKind::Unknown),
        (b"[intrinsics]\nx = 1\n[extrinsics]\n", FileKind::ParametersCfg),
        (b"\xef\xbb\xbf# HCI\r\n [extrinsics] \r\n[intrinsics]\r\n", FileKind::ParametersCfg),
        (b"[intrinsics]\n", FileKind::Unknown),
        (b"", FileKind::Unknown),
        (b"\0", FileKind::Unknown),
    ];
    for (contents, kind) in kinds {
        fs::write(&path, contents).unwrap();
        assert_eq!(recognise(&path).unwrap(), kind, "{}", String::from_utf8_lossy(contents));
    }
    // Only the first part of a text is searched, for white space has no meaning there.
    fs::write(&path, padded("{\"asset\":{}}")).unwrap();
    assert_eq!(recognise(&path).unwrap(), FileKind::Unknown);
    let long = format!("{{\"buffers\":[\"{}\"],\"asset\":{{}}}}", "x".repeat(200_000));
    fs::write(&path, long).unwrap();
    assert_eq!(recognise(&path).unwrap(), FileKind::GltfJson);
    fs::write(&path, "[".repeat(1_000_000)).unwrap();
    assert_eq!(recognise(&path).unwrap(), FileKind::Unknown);
    fs::write(&path, format!("{{\"x\":{}", "[".repeat(1_000_000))).unwrap();
    assert_eq!(recognise(&path).unwrap(), FileKind::Unknown);
    for path in [folder.path().to_owned(), folder.path().join("missing")] {
        assert!(matches!(recognise(&path), Err(Error::Io { .. })));
    }
}
