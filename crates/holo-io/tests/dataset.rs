//! Dataset folders: names, kinds of files, and raw images with the parameters beside them.

use std::fs;

use holo_core::{DynImage, GridSize, Rig};
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

#[cfg(feature = "png")]
mod raw {
    use holo_core::Layout;
    use holo_core::{LightField, LightFieldShape};
    use holo_io::{ColorEncoding, Compression, Limits, ParametersCfg, RawImage, write_png};
    use ndarray::Array3;

    use super::*;

    #[test]
    fn a_raw_image_is_read_with_the_parameters_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let split = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 7)).unwrap();
        let image =
            Array3::from_shape_fn((15, 28, 3), |(row, column, channel)| (row * 13 + column * 3 + channel) as u8);
        let write = |name: &str, image: &Array3<u8>| {
            write_png(folder.path().join(name), image.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
        };
        let read = |name: &str, layout| RawImage::read(folder.path().join(name), layout, &Limits::default());
        write("scene_el.png", &image);
        let error = read("scene_el.png", None).unwrap_err();
        assert_eq!(error.path(), folder.path().join("parameters.cfg"));

        let rig = Rig::builder(split)
            .focal_length_m(0.05)
            .sensor_size_m(0.036)
            .baseline_m(0.01)
            .focus_distance_m(6.0)
            .build()
            .unwrap();
        ParametersCfg::from_rig(&rig).write(folder.path().join(dataset::PARAMETERS_CFG)).unwrap();
        let raw = read("scene_el.png", None).unwrap();
        assert_eq!((raw.layout, raw.parameters.rig().unwrap()), (Layout::ElementalGrid, rig));
        let DynImage::U8(samples) = raw.samples else { panic!("8 bits expected") };
        let light_field = LightField::from_elemental_grid(samples, split).unwrap();
        assert_eq!(light_field.samples()[[4, 6, 2, 3, 1]], image[[14, 27, 1]]);

        write("picture.png", &image);
        assert!(matches!(read("picture.png", None), Err(Error::BadInput { .. })));
        assert_eq!(read("picture.png", Some(Layout::ViewpointGrid)).unwrap().layout, Layout::ViewpointGrid);
        write("small_el.png", &Array3::zeros((15, 27, 3)));
        let error = read("small_el.png", None).unwrap_err();
        assert!(
            error.to_string().contains("it has 27 x 15 pixels, but parameters.cfg says 4 x 3 views of 7 x 5"),
            "{error}"
        );
    }
}
