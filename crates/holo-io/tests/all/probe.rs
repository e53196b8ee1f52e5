//! `probe`: the description of any file or folder in one line.

use crate::rigs;
use std::fs;

use holo_core::{GridSize, Layout, LightField, LightFieldShape, Rig};
use holo_io::{
    ColorEncoding, Compression, Error, FileFormat, FileInfo, HciImage, HciTruth, Manifest, ParametersCfg, probe,
    write_pfm, write_png,
};
use ndarray::{Array2, Array3};

fn rig() -> Rig {
    rigs::cotton(LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5)).unwrap())
}

#[test]
fn files_are_described_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("misleading.txt");
    let line = || probe(&path).unwrap().to_string();
    write_png(&path, Array3::<u16>::zeros((2, 3, 1)).view(), ColorEncoding::Linear, Compression::Fast).unwrap();
    assert_eq!(line(), "PNG image, 3 x 2 pixels, 1 channel of 16 bits");
    write_pfm(&path, Array2::zeros((2, 3)).view()).unwrap();
    assert_eq!(line(), "PFM float image, 3 x 2 pixels, gray");
    ParametersCfg::from_rig(&rig()).write(&path).unwrap();
    assert_eq!(line(), "camera parameters of 3 x 2 views of 5 x 4 pixels");
    Manifest::default().write(&path).unwrap();
    assert_eq!(line(), "manifest of 0 files");
    fs::write(&path, b"glTF\x02\0\0\0").unwrap();
    assert_eq!(probe(&path).unwrap(), FileInfo::Other(FileFormat::GltfBinary));
    assert_eq!(line(), "glTF scene, binary (.glb)");
    fs::write(&path, b"").unwrap();
    assert_eq!(line(), "empty file");
    fs::write(&path, b"\xff\xd8\xff\xe0 a JPEG, which is no format of ours").unwrap();
    assert_eq!(
        line(),
        "unknown file of 39 bytes that begins with ff d8 ff e0 20 61 20 4a 50 45 47 2c 20 77 68 69 \
         (\\xff\\xd8\\xff\\xe0 a JPEG, whi)"
    );
    // A damaged file of a known format is an error, not unknown.
    fs::write(&path, b"\x89PNG\r\n\x1a\n").unwrap();
    assert!(matches!(probe(&path), Err(Error::Broken { .. })));
    assert!(matches!(probe(folder.path().join("none")), Err(Error::Io { .. })));
}

#[test]
fn an_exr_has_its_channels() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/openexr_half_zip.exr");
    let found = probe(path).unwrap();
    let FileInfo::Exr { size, channels } = &found else { panic!("{found}") };
    assert!(size.count() > 0 && !channels.is_empty());
    assert!(found.to_string().starts_with("OpenEXR image, "), "{found}");
}

#[test]
fn an_environment_map_has_its_size() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/blender.hdr");
    let found = probe(path).unwrap();
    assert!(found.to_string().starts_with("Radiance HDR image, "), "{found}");
}

#[test]
fn folders_are_detected_by_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    assert_eq!(probe(path).unwrap().to_string(), "folder of no known kind, 0 entries");
    fs::write(path.join("notes.txt"), b"x").unwrap();
    assert_eq!(probe(path).unwrap().to_string(), "folder of no known kind, 1 entry");

    // A folder with parameters and no views is not an HCI folder.
    let parameters = ParametersCfg::from_rig(&rig());
    parameters.write(path.join("parameters.cfg")).unwrap();
    assert!(matches!(probe(path).unwrap(), FileInfo::UnknownFolder { entries: 2 }));
    let views = LightField::filled(*rig().shape(), 3, Layout::ElementalGrid, 9_u8).unwrap();
    let image = HciImage {
        views: Some(views.as_light_field_ref().into()),
        parameters: &parameters,
        disparity_px: HciTruth::None,
        depth_m: HciTruth::None,
        high_resolution: None,
    };
    image.write(path, Compression::Fast).unwrap();
    assert_eq!(probe(path).unwrap().to_string(), "HCI folder, 3 x 2 views of 5 x 4 pixels");

    let gantry = tempfile::tempdir().unwrap();
    fs::write(gantry.path().join("out_00_00_-381.909271_1103.376221.png"), b"").unwrap();
    assert_eq!(probe(gantry.path()).unwrap().to_string(), "Stanford gantry folder, 1 x 1 views");
    fs::write(gantry.path().join("out_01_01_1_2.png"), b"").unwrap();
    assert!(matches!(probe(gantry.path()), Err(Error::Broken { .. })));

    let root = tempfile::tempdir().unwrap();
    let dataset = root.path().join("boxes/3x2");
    fs::create_dir_all(&dataset).unwrap();
    Manifest { rig: Some(rig()), ..Manifest::default() }.write(dataset.join("manifest.json")).unwrap();
    assert_eq!(probe(&dataset).unwrap().to_string(), "dataset folder, 3 x 2 views of 5 x 4 pixels, no light field");
    assert_eq!(probe(root.path()).unwrap().to_string(), "folder of 1 dataset");
    // A folder with the name of a manifest is not a manifest.
    fs::remove_file(dataset.join("manifest.json")).unwrap();
    fs::create_dir(dataset.join("manifest.json")).unwrap();
    assert!(matches!(probe(&dataset).unwrap(), FileInfo::UnknownFolder { entries: 1 }));
}
