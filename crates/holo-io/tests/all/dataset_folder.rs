//! Dataset folders: light field, rig and maps read back; files that the manifest does not list are ignored.

use std::fs;
use std::path::Path;

use holo_core::{DynLightField, GridSize, Layout, LightField, LightFieldOwned, LightFieldShape, Rig};
use holo_io::dataset::{self, DatasetEntry, DatasetFolder};
use holo_io::{ColorEncoding, Compression, Error, Limits, Manifest, ParametersCfg, write_pfm, write_png};
use ndarray::Array2;

fn rig() -> Rig {
    Rig::builder(LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 7)).unwrap())
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_x_m(0.01)
        .baseline_y_m(0.02)
        .focus_distance_m(f64::INFINITY)
        .build()
        .unwrap()
}

fn light_field() -> LightFieldOwned<u8> {
    let mut light_field = LightField::filled(*rig().shape(), 3, Layout::ElementalGrid, 0_u8).unwrap();
    let mut value = 0_u8;
    light_field.samples_mut().map_inplace(|place| {
        value = value.wrapping_mul(13).wrapping_add(41);
        *place = value;
    });
    light_field
}

fn map() -> Array2<f32> {
    Array2::from_shape_fn((5, 7), |(row, column)| if row == 0 { f32::INFINITY } else { (row * 7 + column) as f32 })
}

/// Writes a dataset with the given files, as `holo render` does.
fn write(path: &Path, names: &[&str], with_rig: bool) -> Manifest {
    let mut manifest = Manifest::default();
    let png = |name: &str, image: ndarray::Array3<u8>| {
        write_png(path.join(name), image.view(), ColorEncoding::Srgb, Compression::Fast).unwrap()
    };
    for &name in names {
        let written = match name {
            dataset::ELEMENTAL_PNG => png(name, light_field().to_elemental_grid().unwrap()),
            dataset::VIEWPOINT_PNG => png(name, light_field().to_viewpoint_grid().unwrap()),
            dataset::PARAMETERS_CFG => ParametersCfg::from_rig(&rig()).write(path.join(name)).unwrap(),
            name => write_pfm(path.join(name), map().view()).unwrap(),
        };
        manifest.files.insert(name.to_owned(), written);
    }
    manifest.rig = with_rig.then(rig);
    manifest.write(path.join(dataset::MANIFEST_JSON)).unwrap();
    manifest
}

const ALL: [&str; 5] = [
    dataset::ELEMENTAL_PNG,
    dataset::VIEWPOINT_PNG,
    dataset::PARAMETERS_CFG,
    dataset::DEPTH_PFM,
    dataset::DISPARITY_PFM,
];

#[test]
fn a_dataset_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let limits = Limits::default();
    for (names, with_rig) in [(&ALL[..], true), (&ALL[..], false), (&ALL[1..3], true), (&ALL[..1], true)] {
        for entry in fs::read_dir(folder.path()).unwrap() {
            fs::remove_file(entry.unwrap().path()).unwrap();
        }
        let manifest = write(folder.path(), names, with_rig);
        let opened = DatasetFolder::open(folder.path()).unwrap();
        assert_eq!((opened.manifest(), opened.path()), (&manifest, folder.path()));
        assert_eq!(opened.rig(), &rig());
        assert_eq!(opened.shape(), *rig().shape());
        let listed = names.contains(&dataset::PARAMETERS_CFG);
        assert_eq!(opened.parameters(), listed.then(|| ParametersCfg::from_rig(&rig())).as_ref());
        assert_eq!(opened.raw_image().unwrap().0, folder.path().join(names[0]));
        assert_eq!(opened.read(&limits).unwrap(), DynLightField::U8(light_field()));
        let maps = names.contains(&dataset::DEPTH_PFM).then(map);
        assert_eq!(opened.depth_m(&limits).unwrap(), maps);
        assert_eq!(opened.disparity_px(&limits).unwrap(), maps);
    }
}

#[test]
fn what_the_manifest_does_not_list_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let limits = Limits::default();
    write(folder.path(), &ALL, true);
    write(folder.path(), &ALL[2..3], true);
    let opened = DatasetFolder::open(folder.path()).unwrap();
    assert_eq!((opened.raw_image(), opened.depth_m(&limits).unwrap()), (None, None));
    assert!(matches!(opened.read(&limits), Err(Error::Unsupported { .. })));
}

#[test]
fn folders_that_are_unfinished_or_contradict_themselves_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let limits = Limits::default();
    let path = |name: &str| folder.path().join(name);
    write(folder.path(), &ALL, true);

    write_pfm(path(dataset::DEPTH_PFM), map().t()).unwrap();
    let small = ndarray::Array3::<u8>::zeros((15, 27, 3));
    write_png(path(dataset::ELEMENTAL_PNG), small.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    let opened = DatasetFolder::open(folder.path()).unwrap();
    let text = opened.depth_m(&limits).unwrap_err().to_string();
    assert!(text.contains("it has 5 x 7 pixels, but the rig of 4 x 3 views of 7 x 5 pixels needs 7 x 5"), "{text}");
    let text = opened.read(&limits).unwrap_err().to_string();
    assert!(text.contains("it has 27 x 15 pixels") && text.contains("needs 28 x 15"), "{text}");
    fs::remove_file(path(dataset::ELEMENTAL_PNG)).unwrap();
    assert!(matches!(opened.read(&limits), Err(Error::Io { .. })));

    let mut other = ParametersCfg::from_rig(&rig());
    other.num_cams = GridSize::new(4, 3);
    other.write(path(dataset::PARAMETERS_CFG)).unwrap();
    let text = DatasetFolder::open(folder.path()).unwrap_err().to_string();
    assert!(text.contains("it specifies 3 x 4 views of 7 x 5 pixels, but manifest.json specifies 4 x 3"), "{text}");
    fs::remove_file(path(dataset::PARAMETERS_CFG)).unwrap();
    assert!(matches!(DatasetFolder::open(folder.path()), Err(Error::Io { .. })));

    write(folder.path(), &[dataset::DEPTH_PFM], false);
    assert!(matches!(DatasetFolder::open(folder.path()), Err(Error::Broken { .. })));
    fs::remove_file(path(dataset::MANIFEST_JSON)).unwrap();
    assert_eq!(DatasetFolder::open(folder.path()).unwrap_err().path(), path(dataset::MANIFEST_JSON));
    assert!(matches!(DatasetFolder::open(path(dataset::DEPTH_PFM)), Err(Error::Io { .. })));
}

#[test]
fn finished_datasets_are_listed_in_order() {
    let root = tempfile::tempdir().unwrap();
    let mut expected: Vec<DatasetEntry> = [("boxes", 9, 9), ("boxes", 20, 3), ("boxes", 100, 100), ("town", 1, 2)]
        .map(|(scene, columns, rows)| {
            let views = GridSize::new(rows, columns);
            let path = root.path().join(dataset::folder(scene, views).unwrap());
            fs::create_dir_all(&path).unwrap();
            fs::write(path.join(dataset::MANIFEST_JSON), "{}").unwrap();
            let entry = DatasetEntry { scene: scene.to_owned(), camera: format!("{columns}x{rows}"), path };
            assert_eq!(entry.views(), Some(views));
            entry
        })
        .into();
    // Plenoptic cameras are those with a camera file; a pose of a sequence has folders of frames.
    for (folder, files) in [
        ("boxes/bench", &[dataset::MANIFEST_JSON, dataset::CAMERA_TOML][..]),
        ("boxes/frame_0001", &[dataset::MANIFEST_JSON, dataset::CAMERA_TOML]),
        ("boxes/other", &[dataset::MANIFEST_JSON]),
        ("boxes/unfinished", &[dataset::CAMERA_TOML]),
    ] {
        fs::create_dir_all(root.path().join(folder)).unwrap();
        files.iter().for_each(|file| fs::write(root.path().join(folder).join(file), "{}").unwrap());
    }
    let (scene, camera) = ("boxes".to_owned(), "bench".to_owned());
    expected.insert(3, DatasetEntry { scene, camera, path: root.path().join("boxes/bench") });
    assert_eq!(expected[3].views(), None);
    for unfinished in ["boxes/5x5", "boxes/textures", "empty"] {
        fs::create_dir_all(root.path().join(unfinished)).unwrap();
    }
    fs::write(root.path().join("boxes/7x7"), b"a file").unwrap();
    fs::write(root.path().join("manifest.json"), b"{}").unwrap();
    assert_eq!(dataset::list(root.path()).unwrap(), expected);
    assert_eq!(dataset::list(root.path().join("empty")).unwrap(), []);
    assert!(matches!(dataset::list(root.path().join("none")), Err(Error::Io { .. })));
    assert!(matches!(dataset::list(root.path().join("boxes/7x7")), Err(Error::Io { .. })));
}
