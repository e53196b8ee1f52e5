//! `read_light_field`: all formats of folders and files, their rigs, and errors that name missing options.

use std::path::{Path, PathBuf};

use crate::common::{light_field, shape};
use holo_core::{DynLightField, GridSize, Layout, LightField, LightFieldOwned, LightFieldShape, Rig, ViewOrder};
use holo_io::{
    ColorEncoding, Compression, Error, HciImage, HciTruth, LightFieldFormat, LightFieldReader, Limits, Manifest,
    MatOptions, MatOrder, ParametersCfg, ReadOptions, dataset, read_light_field, read_rig, write_mat_light_field,
    write_pfm, write_png,
};
use ndarray::{Array2, Array3};

fn rig() -> Rig {
    Rig::builder(shape())
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_x_m(0.01)
        .baseline_y_m(0.02)
        .focus_distance_m(6.0)
        .build()
        .unwrap()
}

fn parameters() -> ParametersCfg {
    let mut parameters = ParametersCfg::from_rig(&rig());
    (parameters.disp_min, parameters.disp_max) = (Some(-1.5), Some(2.5));
    parameters
}

fn write_views(folder: &Path, name: impl Fn(usize) -> String) {
    for (index, (_, view)) in light_field().views().enumerate() {
        write_png(folder.join(name(index)), view, ColorEncoding::Srgb, Compression::Fast).unwrap();
    }
}

fn write_raw(path: &Path) {
    let raw = light_field().to_elemental_grid().unwrap();
    write_png(path, raw.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
}

fn read(path: &Path) -> Result<holo_io::LightFieldFile, Error> {
    read_light_field(path, &ReadOptions::default())
}

#[test]
fn a_raw_image_is_read_with_its_sidecar_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_el.png");
    write_raw(&path);
    let Err(Error::MissingOption { option: "views", what, .. }) = read(&path) else { panic!("views are not known") };
    assert!(what.contains("parameters.cfg does not specify"), "{what}");

    parameters().write(folder.path().join(dataset::PARAMETERS_CFG)).unwrap();
    let file = read(&path).unwrap();
    assert_eq!(file.light_field, light_field().into());
    assert_eq!((file.rig, file.layout), (Some(rig()), Some(Layout::ElementalGrid)));
    assert_eq!((file.format, file.color_encoding), (LightFieldFormat::RawImage, ColorEncoding::Srgb));
    assert_eq!(file.disparity_range_px, Some((-1.5, 2.5)));
    assert!(file.warnings.is_empty());
    // Views of the options that are those of the parameters keep the rig, others remove it.
    let given = |views| read_light_field(&path, &ReadOptions::default().views(views));
    assert_eq!(given(GridSize::new(3, 4)).unwrap().rig, Some(rig()));
    let other = given(GridSize::new(5, 2)).unwrap();
    assert_eq!((other.rig, other.light_field.shape().lenses()), (None, GridSize::new(3, 14)));
    let error = given(GridSize::new(4, 4)).unwrap_err();
    assert!(error.to_string().contains("28x15 pixels do not divide into 4x4 views"), "{error}");
}

#[test]
fn a_raw_image_needs_a_layout_and_matching_parameters() {
    let folder = tempfile::tempdir().unwrap();
    parameters().write(folder.path().join(dataset::PARAMETERS_CFG)).unwrap();
    let path = folder.path().join("image.png");
    write_raw(&path);
    assert!(matches!(read(&path), Err(Error::MissingOption { option: "layout", .. })));
    let file = read_light_field(&path, &ReadOptions::default().layout(Layout::ViewpointGrid)).unwrap();
    assert_eq!(file.layout, Some(Layout::ViewpointGrid));
    assert_ne!(file.light_field, light_field().into());

    let small = folder.path().join("small_el.png");
    write_png(&small, Array3::<u8>::zeros((15, 24, 3)).view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    let error = read(&small).unwrap_err().to_string();
    assert!(error.contains("its 24x15 pixels are not the 4x3 views of 7x5 px"), "{error}");
    assert!(error.ends_with("set `views`"), "{error}");
}

#[test]
fn parameters_that_make_no_rig_are_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene_el.png");
    write_raw(&path);
    let mut broken = parameters();
    broken.focal_length_mm = 0.0;
    broken.write(folder.path().join(dataset::PARAMETERS_CFG)).unwrap();
    let file = read(&path).unwrap();
    assert_eq!((file.rig, file.warnings.len()), (None, 1));
    assert!(file.warnings[0].contains("parameters.cfg"), "{:?}", file.warnings);
    assert!(matches!(read_rig(&path, &Limits::default()), Err(Error::Core { .. })));
}

#[test]
fn a_folder_of_images_is_read_in_natural_order() {
    let folder = tempfile::tempdir().unwrap();
    // As text, image_10 comes before image_9.
    write_views(folder.path(), |index| format!("image_{index}.png"));
    std::fs::write(folder.path().join("notes.txt"), "x").unwrap();
    let error = read(folder.path()).unwrap_err();
    assert!(error.to_string().contains("it does not specify the grid of its 12 views"), "{error}");
    let options = ReadOptions::default().views(GridSize::new(3, 4));
    let file = read_light_field(folder.path(), &options).unwrap();
    assert_eq!(file.light_field, light_field().into());
    assert_eq!((file.format, file.rig), (LightFieldFormat::ImageFolder, None));
    let error = read_light_field(folder.path(), &options.views(GridSize::new(3, 3))).unwrap_err();
    assert!(error.to_string().contains("it has 12 images, but 3x3 views need 9"), "{error}");

    let snake = read_light_field(folder.path(), &options.order(ViewOrder::Serpentine)).unwrap().light_field;
    let (there, back) = (light_field(), snake.to_f32().unwrap());
    assert_eq!(snake.view(0, 1).unwrap(), there.view(0, 1).unwrap().into());
    assert_eq!(snake.view(1, 0).unwrap(), there.view(1, 3).unwrap().into());
    assert_eq!(back.channels(), 3);

    parameters().write(folder.path().join(dataset::PARAMETERS_CFG)).unwrap();
    assert_eq!(read_light_field(folder.path(), &options).unwrap().rig, Some(rig()));
}

/// Names tell the grid, and the motion between the images tells if the order is another one.
#[test]
fn names_and_motion_tell_the_order_of_images() {
    let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(30, 40)).unwrap();
    let mut field = LightFieldOwned::filled(shape, 1, Layout::ViewpointGrid, 0_u8).unwrap();
    for t in 0..3 {
        for s in 0..4 {
            for ((v, u, _), sample) in field.view_mut(t, s).unwrap().indexed_iter_mut() {
                let [x, y] = [u as f64 + 0.7 * s as f64, v as f64 + 0.7 * t as f64];
                *sample = (128.0 + 40.0 * (0.6 * x + 0.2 * y).sin() + 40.0 * (0.7 * y - 0.3 * x).sin()) as u8;
            }
        }
    }
    // Column by column, every second one from below; the names count columns and places on the way.
    let folder = tempfile::tempdir().unwrap();
    let views = shape.views();
    for index in 0..12 {
        let (t, s) = ViewOrder::ColumnSerpentine.view(index, views).unwrap();
        let name = format!("IMG_0007_{index:03}_{:02}_{:02}.png", index / 3, index % 3);
        let view = field.view(t, s).unwrap();
        write_png(folder.path().join(name), view, ColorEncoding::Srgb, Compression::Fast).unwrap();
    }
    let file = read(folder.path()).unwrap();
    assert_eq!(file.light_field.shape().views(), GridSize::new(4, 3));
    let [grid, order] = &file.warnings[..] else { panic!("{:?}", file.warnings) };
    assert!(grid.contains("12 images") && grid.contains("3x4"), "{grid}");
    assert!(order.contains("of column-serpentine (4x3 views)"), "{order}");
    // As it says, there is nothing more to say.
    let options = ReadOptions::default().order(ViewOrder::ColumnSerpentine);
    let file = read_light_field(folder.path(), &options).unwrap();
    assert_eq!((file.light_field, file.warnings.len()), (field.into(), 1));
}

#[test]
fn hci_and_gantry_folders_are_recognized() {
    let folder = tempfile::tempdir().unwrap();
    let map = Array2::from_shape_fn((5, 7), |(v, u)| (v * 7 + u) as f32);
    let hci = folder.path().join("hci");
    std::fs::create_dir(&hci).unwrap();
    HciImage {
        views: Some((&DynLightField::from(light_field())).into()),
        parameters: &parameters(),
        disparity_px: HciTruth::Central(map.view()),
        depth_m: HciTruth::None,
        high_resolution: None,
    }
    .write(&hci, Compression::Fast)
    .unwrap();
    let reader = LightFieldReader::open(&hci, &ReadOptions::default()).unwrap();
    assert_eq!((reader.format(), reader.shape(), reader.rig()), (LightFieldFormat::HciFolder, shape(), Some(&rig())));
    assert_eq!((reader.central_disparity_px().unwrap(), reader.central_depth_m().unwrap()), (Some(map), None));
    let file = reader.read().unwrap();
    assert_eq!((file.light_field, file.disparity_range_px), (light_field().into(), Some((-1.5, 2.5))));
    let error = read_light_field(&hci, &ReadOptions::default().views(GridSize::new(4, 3))).unwrap_err();
    assert!(error.to_string().contains("it has 4x3 views, not 3x4"), "{error}");

    let gantry = folder.path().join("gantry");
    std::fs::create_dir(&gantry).unwrap();
    write_views(&gantry, |index| {
        // Rows are counted from below.
        format!("out_{:02}_{:02}_{}.5_{}.25_.png", 2 - index / 4, index % 4, index / 4, index % 4)
    });
    let file = read(&gantry).unwrap();
    assert_eq!((file.light_field, file.format), (light_field().into(), LightFieldFormat::GantryFolder));
    assert_eq!(file.rig, None);
}

#[test]
fn a_dataset_folder_has_the_rig_of_its_manifest_and_its_maps() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write_raw(&path.join(dataset::ELEMENTAL_PNG));
    let map = Array2::from_elem((5, 7), 2.5_f32);
    write_pfm(path.join(dataset::DEPTH_PFM), map.view()).unwrap();
    let files: Vec<PathBuf> = [dataset::ELEMENTAL_PNG, dataset::DEPTH_PFM].map(|name| path.join(name)).into();
    let mut manifest = Manifest::default();
    for file in files {
        let digest = holo_io::hash_file(&file).unwrap();
        manifest.files.insert(file.file_name().unwrap().to_str().unwrap().to_owned(), digest);
    }
    (manifest.rig, manifest.disparity_px) = (Some(rig()), Some((-0.5, 0.75)));
    manifest.write(path.join(dataset::MANIFEST_JSON)).unwrap();
    let reader = LightFieldReader::open(path, &ReadOptions::default()).unwrap();
    assert_eq!(reader.raw_image(), Some(path.join(dataset::ELEMENTAL_PNG)));
    assert_eq!((reader.central_depth_m().unwrap(), reader.central_disparity_px().unwrap()), (Some(map), None));
    let file = reader.read().unwrap();
    assert_eq!((file.light_field, file.rig), (light_field().into(), Some(rig())));
    assert_eq!((file.disparity_range_px, file.layout), (Some((-0.5, 0.75)), Some(Layout::ElementalGrid)));
    assert_eq!(read_rig(path.join(dataset::MANIFEST_JSON), &Limits::default()).unwrap(), Some(rig()));
}

#[test]
fn a_mat_file_has_its_rig_or_that_of_its_sidecar_parameters() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.mat");
    for order in [MatOrder::Lenses, MatOrder::LightFieldToolbox] {
        write_mat_light_field(&path, &light_field(), Some(&rig()), order, &MatOptions::default()).unwrap();
        let reader = LightFieldReader::open(&path, &ReadOptions::default()).unwrap();
        assert_eq!((reader.shape(), reader.rig()), (shape(), Some(&rig())));
        let file = reader.read().unwrap();
        assert_eq!((file.light_field, file.format), (light_field().into(), LightFieldFormat::Mat));
        assert_eq!((file.color_encoding, file.layout), (ColorEncoding::Srgb, None));
    }
    assert_eq!(read_rig(&path, &Limits::default()).unwrap(), Some(rig()));
    // MATLAB's doubles, one channel, and no rig of its own.
    let gray = LightField::new(light_field().samples().slice_move(ndarray::s![.., .., .., .., ..1]).mapv(f64::from));
    let gray = gray.unwrap();
    write_mat_light_field(&path, &gray, None, MatOrder::Lenses, &MatOptions::default()).unwrap();
    let file = read(&path).unwrap();
    assert_eq!((file.rig, file.color_encoding), (None, ColorEncoding::Linear));
    assert_eq!(file.light_field, gray.into());
    parameters().write(folder.path().join(dataset::PARAMETERS_CFG)).unwrap();
    assert_eq!(read(&path).unwrap().rig, Some(rig()));
    assert_eq!(read_rig(&path, &Limits::default()).unwrap(), Some(rig()));
}

#[cfg(feature = "hdf5")]
#[test]
fn an_hdf5_file_has_its_rig() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.h5");
    let floats = light_field().map(|&sample| f32::from(sample) / 255.0).unwrap();
    holo_io::write_hdf5(&path, &floats, &rig(), &[], &[], &holo_io::Hdf5Options::default()).unwrap();
    let file = read(&path).unwrap();
    assert_eq!((file.light_field, file.rig), (floats.into(), Some(rig())));
    assert_eq!((file.format, file.color_encoding), (LightFieldFormat::Hdf5, ColorEncoding::Linear));
    assert_eq!(read_rig(&path, &Limits::default()).unwrap(), Some(rig()));
}

#[test]
fn other_files_and_folders_are_named() {
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(read(folder.path()), Err(Error::NoLightField { .. })));
    let text = folder.path().join("notes.txt");
    std::fs::write(&text, "not an image").unwrap();
    assert!(matches!(read(&text), Err(Error::NoLightField { .. })));
    assert!(matches!(read(&folder.path().join("missing.png")), Err(Error::Io { .. })));
    assert_eq!(read_rig(&text, &Limits::default()).unwrap(), None);
    assert_eq!(read_rig(folder.path(), &Limits::default()).unwrap(), None);
    // The limit is for the samples of all views.
    write_views(folder.path(), |index| format!("{index}.png"));
    let options = ReadOptions::default().views(GridSize::new(3, 4)).limits(Limits { max_bytes: 1000 });
    assert!(matches!(read_light_field(folder.path(), &options), Err(Error::TooLarge { .. })));
}
