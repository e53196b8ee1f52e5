//! Folders that hold a light field, whatever they hold it in: which file is read, and what it holds.

use std::fs;
use std::path::Path;

use crate::common::{light_field, shape};
use holo_core::{DynLightField, GridSize, Layout, LightFieldOwned, LightFieldShape, Rig};
use holo_io::dataset::{self, Representation};
use holo_io::{
    CameraFile, ColorEncoding, Compression, Error, ExrChannel, HciImage, HciTruth, LightFieldFolder, LightFieldFormat,
    LightFieldReader, Limits, Manifest, MatOptions, MatOrder, ParametersCfg, ReadOptions, hash_file, list_images,
    probe, read_light_field, read_rig, write_exr, write_mat_light_field, write_pfm, write_png,
};
use ndarray::{Array2, Array3, Axis};

fn rig() -> Rig {
    Rig::builder(shape())
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_m(0.01)
        .focus_distance_m(6.0)
        .build()
        .unwrap()
}

fn floats() -> LightFieldOwned<f32> {
    light_field().map(|&code| f32::from(code) / 255.0).unwrap()
}

/// Writes a light field in one representation; returns what is read of it.
fn write(folder: &Path, representation: Representation) -> DynLightField {
    let path = folder.join(representation.file_name().unwrap());
    let layout = representation.layout().unwrap_or(Layout::ElementalGrid);
    match representation {
        Representation::ElementalPng | Representation::ViewpointPng => {
            let image = DynLightField::from(light_field()).into_grid(layout).unwrap();
            write_png(&path, &image, ColorEncoding::Srgb, Compression::Fast).unwrap();
        }
        Representation::ElementalExr | Representation::ViewpointExr => {
            let image = match layout {
                Layout::ElementalGrid => floats().to_elemental_grid().unwrap(),
                Layout::ViewpointGrid => floats().to_viewpoint_grid().unwrap(),
            };
            write_color(&path, &image);
            return floats().into();
        }
        Representation::Mat => {
            let options = MatOptions::default();
            write_mat_light_field(&path, &light_field(), Some(&rig()), MatOrder::Lenses, &options).unwrap();
        }
        Representation::Hci => {
            fs::create_dir_all(&path).unwrap();
            let field = DynLightField::from(light_field());
            let image = HciImage {
                views: Some((&field).into()),
                parameters: &ParametersCfg::from_rig(&rig()),
                disparity_px: HciTruth::None,
                depth_m: HciTruth::None,
                high_resolution: None,
            };
            image.write(&path, Compression::Fast).unwrap();
        }
        #[cfg(feature = "hdf5")]
        Representation::Hdf5 => {
            holo_io::write_hdf5(&path, &floats(), &rig(), &[], &[], &holo_io::Hdf5Options::default()).unwrap();
            return floats().into();
        }
        other => panic!("{other}"),
    }
    light_field().into()
}

fn write_color(path: &Path, image: &Array3<f32>) {
    let planes = ["R", "G", "B"].iter().zip(image.axis_iter(Axis(2)));
    let channels: Vec<_> = planes.map(|(name, plane)| ExrChannel::float(name, plane)).collect();
    write_exr(path, &channels).unwrap();
}

/// The representations that this build writes, in the order of preference.
fn all() -> Vec<Representation> {
    let is_written = |found: &Representation| cfg!(feature = "hdf5") || *found != Representation::Hdf5;
    Representation::OF_DATASET.into_iter().filter(is_written).collect()
}

/// Writes the manifest of all files in a folder, as `holo render` does.
fn seal(folder: &Path, rig: Option<Rig>) {
    let mut manifest = Manifest { rig, ..Manifest::default() };
    for inner in ["", "hci"] {
        let Ok(entries) = fs::read_dir(folder.join(inner)) else { continue };
        for entry in entries.map(Result::unwrap).filter(|entry| entry.file_type().unwrap().is_file()) {
            let name = entry.file_name().into_string().unwrap();
            let name = if inner.is_empty() { name } else { format!("{inner}/{name}") };
            manifest.files.insert(name, hash_file(entry.path()).unwrap());
        }
    }
    manifest.write(folder.join(dataset::MANIFEST_JSON)).unwrap();
}

fn remove(folder: &Path, representation: Representation) {
    let path = folder.join(representation.file_name().unwrap());
    if path.is_dir() { fs::remove_dir_all(path).unwrap() } else { fs::remove_file(path).unwrap() }
}

fn open(path: &Path) -> Result<LightFieldReader, Error> {
    LightFieldReader::open(path, &ReadOptions::default())
}

#[test]
fn a_dataset_folder_is_read_whatever_it_holds() {
    for representation in all() {
        for has_manifest in [true, false] {
            let folder = tempfile::tempdir().unwrap();
            let expected = write(folder.path(), representation);
            if has_manifest {
                seal(folder.path(), Some(rig()));
            } else {
                ParametersCfg::from_rig(&rig()).write(folder.path().join(dataset::PARAMETERS_CFG)).unwrap();
            }
            let reader = open(folder.path()).unwrap();
            assert_eq!(reader.representation(), Some(representation));
            assert_eq!(reader.representations(), [representation]);
            assert_eq!((reader.format(), reader.rig()), (LightFieldFormat::DatasetFolder, Some(&rig())));
            assert_eq!(reader.layout(), representation.layout());
            let file = reader.read().unwrap();
            let encoding = if file.light_field.kind().is_float() { ColorEncoding::Linear } else { ColorEncoding::Srgb };
            assert_eq!((file.light_field, file.color_encoding), (expected, encoding), "{representation}");
            assert_eq!(read_rig(folder.path(), &Limits::default()).unwrap(), Some(rig()), "{representation}");
        }
    }
}

#[test]
fn the_first_that_is_there_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let all = all();
    let expected: Vec<_> = all.iter().map(|found| write(path, *found)).collect();
    seal(path, Some(rig()));
    for (k, found) in all.iter().enumerate() {
        let reader = open(path).unwrap();
        assert_eq!((reader.representation(), reader.representations()), (Some(*found), &all[k..]));
        assert_eq!(reader.read().unwrap().light_field, expected[k], "{found}");
        remove(path, *found);
    }
    // All are gone: the error names the first.
    let error = open(path).unwrap_err();
    assert!(matches!(error, Error::Io { .. }) && error.to_string().contains(dataset::ELEMENTAL_PNG), "{error}");
    // Its rig is in the manifest.
    assert_eq!(read_rig(path, &Limits::default()).unwrap(), Some(rig()));
    // What the manifest does not list is not read.
    write(path, Representation::Hci);
    fs::write(
        path.join(dataset::MANIFEST_JSON),
        Manifest { rig: Some(rig()), ..Manifest::default() }.to_json().unwrap(),
    )
    .unwrap();
    assert!(LightFieldFolder::open(path).unwrap().representations().is_empty());
}

#[test]
fn some_views_and_maps_alone_are_no_light_field() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), Representation::Hci);
    fs::remove_file(folder.path().join("hci/input_Cam003.png")).unwrap();
    let depth = Array2::from_elem((5, 7), 2.5_f32);
    write_pfm(folder.path().join(dataset::DEPTH_PFM), depth.view()).unwrap();
    seal(folder.path(), Some(rig()));
    let reader = open(folder.path()).unwrap();
    assert_eq!((reader.representation(), reader.shape(), reader.rig()), (None, shape(), Some(&rig())));
    assert_eq!(reader.central_depth_m().unwrap(), Some(depth));
    let error = reader.read().unwrap_err();
    assert!(matches!(error, Error::NoLightField { .. }) && error.to_string().contains("no raw image"), "{error}");
    assert!(probe(folder.path()).unwrap().to_string().ends_with(", no light field"));
}

#[test]
fn a_file_of_another_size_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let other = Rig::builder(LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 8)).unwrap())
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_m(0.01)
        .focus_distance_m(6.0)
        .build()
        .unwrap();
    for representation in all() {
        write(folder.path(), representation);
        seal(folder.path(), Some(other));
        let error = open(folder.path()).unwrap_err();
        assert!(
            matches!(error, Error::Broken { .. }) && error.to_string().contains("rig"),
            "{representation}: {error}"
        );
        remove(folder.path(), representation);
    }
}

#[cfg(feature = "hdf5")]
#[test]
fn maps_are_those_of_the_folder_or_of_the_file() {
    use holo_io::Hdf5Map;

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(dataset::LIGHT_FIELD_HDF5);
    let [inside, beside] = [1.5, 2.5].map(|depth| Array2::from_elem((5, 7), depth));
    let maps = [(Hdf5Map::Depth, inside.view())];
    holo_io::write_hdf5(&path, &floats(), &rig(), &[], &maps, &holo_io::Hdf5Options::default()).unwrap();
    seal(folder.path(), Some(rig()));
    assert_eq!(open(folder.path()).unwrap().central_depth_m().unwrap(), Some(inside.clone()));
    write_pfm(folder.path().join(dataset::DEPTH_PFM), beside.view()).unwrap();
    seal(folder.path(), Some(rig()));
    assert_eq!(open(folder.path()).unwrap().central_depth_m().unwrap(), Some(beside));
    // A file of maps alone is passed over.
    holo_io::write_hdf5_maps(&path, &rig(), &[], &maps, &holo_io::Hdf5Options::default()).unwrap();
    write(folder.path(), Representation::ElementalExr);
    seal(folder.path(), Some(rig()));
    assert_eq!(open(folder.path()).unwrap().representations(), [Representation::ElementalExr]);
}

/// Images that this project writes are no views, whatever else is in the folder.
#[test]
fn own_images_are_no_views() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    write(path, Representation::ElementalPng);
    write(path, Representation::ViewpointPng);
    let map = Array3::<u8>::zeros((5, 7, 1));
    write_png(path.join(dataset::DISPARITY_PNG), map.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    assert!(list_images(path).unwrap().is_empty());
    let grids = [Representation::ElementalPng, Representation::ViewpointPng];
    assert_eq!(LightFieldFolder::open(path).unwrap().representations(), grids);
    let Err(Error::MissingOption { option: "views", what, .. }) = open(path) else { panic!("views are not known") };
    assert!(what.contains("parameters.cfg"), "{what}");
    let given = read_light_field(path, &ReadOptions::default().views(GridSize::new(3, 4))).unwrap();
    assert_eq!((given.light_field, given.rig), (light_field().into(), None));

    // Without parameters twelve images of other names are the views; with them the raw image is read.
    for (index, (_, view)) in light_field().views().enumerate() {
        write_png(path.join(format!("v{index}.png")), view, ColorEncoding::Srgb, Compression::Fast).unwrap();
    }
    let reader = LightFieldReader::open(path, &ReadOptions::default().views(GridSize::new(3, 4))).unwrap();
    assert_eq!(
        (reader.format(), reader.representation()),
        (LightFieldFormat::ImageFolder, Some(Representation::Views))
    );
    assert_eq!(reader.read().unwrap().light_field, light_field().into());
    ParametersCfg::from_rig(&rig()).write(path.join(dataset::PARAMETERS_CFG)).unwrap();
    let reader = open(path).unwrap();
    assert_eq!((reader.representation(), reader.rig()), (Some(Representation::ElementalPng), Some(&rig())));
    assert_eq!(reader.raw_image(), Some(path.join(dataset::ELEMENTAL_PNG)));
    assert_eq!(reader.read().unwrap().light_field, light_field().into());
}

/// A square camera of 120 x 90 pixels.
const CAMERA: &str = r#"
name = "small"
[sensor]
size_px = [120, 90]
pixel_um = 5.0
[mla]
grid = "square"
pitch_um = 71.2
offset_um = [7.0, -4.0]
gap_um = 400.0
[main_lens]
focal_mm = 40.0
f_number = 5.8
focus_m = 0.8
"#;

fn raw() -> Array3<f32> {
    Array3::from_shape_fn((90, 120, 3), |(row, column, channel)| ((row * 7 + column * 3 + channel) % 50) as f32 / 50.0)
}

#[test]
fn the_raw_image_of_a_plenoptic_camera_is_decoded() {
    let camera = CameraFile::parse(CAMERA, "").unwrap().camera;
    let white = camera.white_image().unwrap();
    for name in [dataset::RAW_EXR, dataset::RAW_PNG] {
        for has_manifest in [false, true] {
            let folder = tempfile::tempdir().unwrap();
            fs::write(folder.path().join(dataset::CAMERA_TOML), CAMERA).unwrap();
            let path = folder.path().join(name);
            let image = if name == dataset::RAW_EXR {
                write_color(&path, &raw());
                raw()
            } else {
                let codes = raw().mapv(|value| (value * 65_535.0).round() as u16);
                write_png(&path, codes.view(), ColorEncoding::Linear, Compression::Fast).unwrap();
                codes.mapv(|code| (f64::from(code) / 65_535.0) as f32)
            };
            if has_manifest {
                seal(folder.path(), None);
            }
            let text = probe(folder.path()).unwrap().to_string();
            let expected = format!(
                "folder of the plenoptic camera 'small', 120 x 90 pixels, {} micro-images",
                camera.lens_count()
            );
            assert_eq!(text, expected);

            let views = camera.decodable_views().unwrap();
            let decoded = camera.decode(image.view(), white.view(), views).unwrap();
            let reader = open(folder.path()).unwrap();
            assert_eq!(reader.representation().unwrap().file_name(), Some(name));
            assert_eq!((reader.format(), reader.rig()), (LightFieldFormat::Plenoptic, Some(&decoded.rig)));
            assert_eq!(reader.shape(), decoded.light_field.shape());
            let file = reader.read().unwrap();
            assert_eq!((file.light_field, file.color_encoding), (decoded.light_field.into(), ColorEncoding::Linear));
            assert_eq!(read_rig(folder.path(), &Limits::default()).unwrap(), Some(decoded.rig));

            // The image alone, and another number of views.
            let three = ReadOptions::default().views(GridSize::new(3, 3));
            let file = read_light_field(&path, &three).unwrap();
            let decoded = camera.decode(image.view(), white.view(), 3).unwrap();
            assert_eq!((file.light_field, file.rig), (decoded.light_field.into(), Some(decoded.rig)));
            let oblong = ReadOptions::default().views(GridSize::new(3, 4));
            assert!(matches!(LightFieldReader::open(folder.path(), &oblong), Err(Error::MissingOption { .. })));
        }
    }
}

#[test]
fn what_is_wrong_with_a_plenoptic_folder_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let camera = folder.path().join(dataset::CAMERA_TOML);
    let raw_exr = folder.path().join(dataset::RAW_EXR);
    let said = || {
        let error = open(folder.path()).unwrap_err();
        assert!(matches!(error, Error::NoLightField { .. } | Error::Broken { .. } | Error::TooLarge { .. }), "{error}");
        error.to_string()
    };
    write_color(&raw_exr, &raw());
    // Microlenses that are focused far from the array, with micro-images of two pixels.
    let narrow = CAMERA
        .replace("gap_um = 400.0", "gap_um = 400.0\nfocal_um = [500.0]")
        .replace("pixel_um = 5.0", "pixel_um = 30.0");
    fs::write(&camera, narrow).unwrap();
    assert!(said().contains("at least 4, to render views"), "{}", said());
    assert_eq!(read_rig(folder.path(), &Limits::default()).unwrap(), None);
    fs::write(&camera, CAMERA.replace("[120, 90]", "[120, 91]")).unwrap();
    assert!(said().contains("it has 120x90 pixels, but the sensor of the camera 'small'"), "{}", said());
    fs::write(&camera, "name = ").unwrap();
    assert!(said().contains("broken camera file"), "{}", said());
    fs::write(&camera, CAMERA).unwrap();
    let options = ReadOptions::default().limits(Limits { max_bytes: 1000 });
    assert!(matches!(read_light_field(folder.path(), &options), Err(Error::TooLarge { .. })));
    fs::write(&raw_exr, "no image").unwrap();
    let error = open(folder.path()).unwrap_err();
    assert!(error.to_string().contains(dataset::RAW_EXR), "{error}");

    // The folder of calibration targets has a camera and no raw image.
    fs::remove_file(&raw_exr).unwrap();
    seal(folder.path(), None);
    assert!(said().contains("none of raw.exr, raw_linear.png"), "{}", said());
    assert!(probe(folder.path()).unwrap().to_string().ends_with(", no raw image"));
}

/// An elemental image array in floats is read as a file, too.
#[test]
fn an_exr_is_a_raw_image() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own_vpi.exr");
    write_color(&path, &floats().to_viewpoint_grid().unwrap());
    let file = read_light_field(&path, &ReadOptions::default().views(GridSize::new(3, 4))).unwrap();
    assert_eq!((file.light_field, file.layout), (floats().into(), Some(Layout::ViewpointGrid)));
    assert_eq!((file.format, file.color_encoding), (LightFieldFormat::RawImage, ColorEncoding::Linear));
    // One channel is gray.
    let gray = floats().to_viewpoint_grid().unwrap().index_axis_move(Axis(2), 1);
    write_exr(&path, &[ExrChannel::float("Y", gray.view())]).unwrap();
    let file = read_light_field(&path, &ReadOptions::default().views(GridSize::new(3, 4))).unwrap();
    assert_eq!(file.light_field.channels(), 1);
    let other = [ExrChannel::float("Z", gray.view())];
    write_exr(&path, &other).unwrap();
    let error = read_light_field(&path, &ReadOptions::default().views(GridSize::new(3, 4))).unwrap_err();
    assert!(error.to_string().contains("R, G, B nor Y"), "{error}");
}
