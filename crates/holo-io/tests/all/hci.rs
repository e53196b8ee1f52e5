//! HCI folders: exact round trips, the names of the HCI tools, and damaged folders.

use crate::python;
use std::fs;
use std::path::Path;

use crate::rigs::cotton as rig;
use holo_core::{DynImage, DynLightField, GridSize, Layout, LightField, LightFieldOwned, LightFieldShape, Projection};
use holo_io::{
    ColorEncoding, Compression, Error, HciFolder, HciImage, HciQuantity, HciResolution, HciTruth, Limits,
    ParametersCfg, write_pfm, write_png,
};
use ndarray::{Array2, Array3, Axis, s};
use proptest::prelude::*;

fn shape(views: [usize; 2], lenses: [usize; 2]) -> LightFieldShape {
    LightFieldShape::new(GridSize::new(views[0], views[1]), GridSize::new(lenses[0], lenses[1])).unwrap()
}

/// Samples that are different at every position, in memory as a raw image.
fn field<T: Copy>(shape: LightFieldShape, channels: usize, sample: impl Fn(u64) -> T) -> LightFieldOwned<T> {
    let mut field = LightField::filled(shape, channels, Layout::ElementalGrid, sample(0)).unwrap();
    // A step that changes all bits.
    let mut value = 0_u64;
    field.samples_mut().map_inplace(|place| {
        value = value.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *place = sample(value >> 33);
    });
    field
}

fn bytes(shape: LightFieldShape, channels: usize) -> LightFieldOwned<u8> {
    field(shape, channels, |value| value as u8)
}

fn maps(shape: LightFieldShape) -> LightFieldOwned<f32> {
    let mut maps = field(shape, 1, |value| value as f32 / 1000.0);
    maps.samples_mut()[[0, 0, 0, 0, 0]] = f32::INFINITY;
    maps
}

fn write(path: &Path, views: &LightFieldOwned<u8>, parameters: &ParametersCfg) -> Result<(), Error> {
    let image = HciImage {
        views: Some(views.as_light_field_ref().into()),
        parameters,
        disparity_px: HciTruth::None,
        depth_m: HciTruth::None,
        high_resolution: None,
    };
    image.write(path, Compression::Fast).map(|_| ())
}

/// A folder with 2 x 3 views of 4 x 5 pixels and no ground truth.
fn small() -> (tempfile::TempDir, LightFieldOwned<u8>) {
    let shape = shape([2, 3], [4, 5]);
    let folder = tempfile::tempdir().unwrap();
    let views = bytes(shape, 3);
    write(folder.path(), &views, &ParametersCfg::from_rig(&rig(shape))).unwrap();
    (folder, views)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn any_grid_reads_back_bit_for_bit(
        t in 1_usize..5, s in 1_usize..5, v in 1_usize..6, u in 1_usize..6, rgb: bool, deep: bool, all: bool,
        infinite: bool, published: bool,
    ) {
        let shape = shape([t, s], [v, u]);
        let mut rig = rig(shape);
        if infinite {
            rig = rig.to_builder().focus_distance_m(f64::INFINITY).build().unwrap();
        }
        let parameters = ParametersCfg::from_rig(&rig);
        let channels = if rgb { 3 } else { 1 };
        let (shallow, deeper) = (bytes(shape, channels), field(shape, channels, |value| value as u16));
        let maps = maps(shape);
        let (row, column) = shape.central_view();
        let central = maps.view(row, column).unwrap().index_axis_move(Axis(2), 0).to_owned();
        let image = HciImage {
            views: Some(if deep { deeper.as_light_field_ref().into() } else { shallow.as_light_field_ref().into() }),
            parameters: &parameters,
            disparity_px: HciTruth::Central(central.view()),
            depth_m: if all { HciTruth::All(maps.as_light_field_ref()) } else { HciTruth::None },
            high_resolution: None,
        };
        let folder = tempfile::tempdir().unwrap();
        let compression = if published { Compression::Best } else { Compression::Fast };
        let written = image.write(folder.path(), compression).unwrap();
        let names: Vec<String> = written.iter().map(|(name, _)| name.clone()).collect();
        prop_assert_eq!(&names, &image.file_names());
        prop_assert_eq!(names.last().unwrap(), "parameters.cfg");
        prop_assert_eq!(fs::read_dir(folder.path()).unwrap().count(), names.len());
        for (name, written) in written {
            prop_assert_eq!(holo_io::hash_file(folder.path().join(name)).unwrap(), written);
        }

        let limits = Limits::default();
        let read = HciFolder::open(folder.path()).unwrap();
        prop_assert_eq!(read.rig().unwrap(), rig);
        prop_assert_eq!(read.parameters(), &parameters);
        let expected = if deep { DynLightField::U16(deeper) } else { DynLightField::U8(shallow) };
        prop_assert_eq!(&read.read(&limits).unwrap(), &expected);
        let one = match (&expected, read.read_view(t - 1, s - 1, &limits).unwrap()) {
            (DynLightField::U8(all), DynImage::U8(one)) => all.view(t - 1, s - 1).unwrap() == one,
            (DynLightField::U16(all), DynImage::U16(one)) => all.view(t - 1, s - 1).unwrap() == one,
            _ => false,
        };
        prop_assert!(one);
        let truth = |quantity| read.central_truth(quantity, HciResolution::Low, &limits).unwrap();
        prop_assert_eq!(truth(HciQuantity::Disparity).unwrap(), &central);
        prop_assert_eq!(truth(HciQuantity::Depth), all.then_some(central));
        prop_assert_eq!(read.truth_of_all_views(HciQuantity::Disparity, &limits).unwrap(), None);
        prop_assert_eq!(read.truth_of_all_views(HciQuantity::Depth, &limits).unwrap(), all.then_some(maps));
    }
}

#[test]
fn more_than_999_views_have_the_numbers_of_the_hci_tools() {
    let shape = shape([26, 40], [2, 3]);
    let folder = tempfile::tempdir().unwrap();
    let views = bytes(shape, 3);
    write(folder.path(), &views, &ParametersCfg::from_rig(&rig(shape))).unwrap();
    for name in ["input_Cam000.png", "input_Cam999.png", "input_Cam1000.png", "input_Cam1039.png"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
    assert!(!folder.path().join("input_Cam0000.png").exists() && !folder.path().join("input_Cam1040.png").exists());
    let read = HciFolder::open(folder.path()).unwrap();
    assert_eq!(read.read(&Limits::default()).unwrap(), DynLightField::U8(views.clone()));
    // Four digits everywhere, as in other programs.
    for index in 0..1000 {
        let name = |digits: usize| folder.path().join(format!("input_Cam{index:0digits$}.png"));
        fs::rename(name(3), name(4)).unwrap();
    }
    let read = HciFolder::open(folder.path()).unwrap();
    assert_eq!(read.read(&Limits::default()).unwrap(), DynLightField::U8(views));
}

#[test]
fn the_central_view_of_even_counts_is_a_real_one() {
    let shape = shape([2, 4], [3, 3]);
    let maps = maps(shape);
    let views = bytes(shape, 1);
    let folder = tempfile::tempdir().unwrap();
    let parameters = ParametersCfg::from_rig(&rig(shape));
    let image = HciImage {
        views: Some(views.as_light_field_ref().into()),
        parameters: &parameters,
        disparity_px: HciTruth::All(maps.as_light_field_ref()),
        depth_m: HciTruth::None,
        high_resolution: None,
    };
    image.write(folder.path(), Compression::Fast).unwrap();
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert_eq!(read("gt_disp_lowres.pfm"), read("gt_disp_lowres_Cam006.pfm"));
    // Without an unnumbered file the central map is the numbered one.
    fs::remove_file(folder.path().join("gt_disp_lowres.pfm")).unwrap();
    let opened = HciFolder::open(folder.path()).unwrap();
    let central = opened.central_truth(HciQuantity::Disparity, HciResolution::Low, &Limits::default()).unwrap();
    assert_eq!(central.unwrap(), maps.view(1, 2).unwrap().index_axis_move(Axis(2), 0));
    // With one map missing, there are no maps of all views.
    fs::remove_file(folder.path().join("gt_disp_lowres_Cam005.pfm")).unwrap();
    let opened = HciFolder::open(folder.path()).unwrap();
    assert_eq!(opened.truth_of_all_views(HciQuantity::Disparity, &Limits::default()).unwrap(), None);
}

#[test]
fn unequal_baselines_and_orthographic_views_keep_their_rig() {
    let shape = shape([3, 3], [2, 2]);
    let rig = rig(shape).to_builder().baseline_y_m(0.5).projection(Projection::Orthographic).build().unwrap();
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &bytes(shape, 3), &ParametersCfg::from_rig(&rig)).unwrap();
    assert_eq!(HciFolder::open(folder.path()).unwrap().rig().unwrap(), rig);
    // The HCI tools read the horizontal baseline.
    let text = fs::read_to_string(folder.path().join("parameters.cfg")).unwrap();
    assert!(text.contains("\nbaseline_mm = 25.0\n"), "{text}");
}

#[test]
fn optional_keys_may_be_missing() {
    let (folder, views) = small();
    let least = "[intrinsics]\nfocal_length_mm=100\nimage_resolution_x_px=5\nimage_resolution_y_px=4\nsensor_size_mm=35\n\
                 [extrinsics]\nnum_cams_x=3\nnum_cams_y=2\nbaseline_mm=1\nfocus_distance_m=0\n";
    let parameters = folder.path().join("parameters.cfg");
    fs::write(&parameters, least).unwrap();
    let read = HciFolder::open(folder.path()).unwrap();
    assert_eq!(read.rig().unwrap().focus_distance_m(), f64::INFINITY);
    assert_eq!(read.read(&Limits::default()).unwrap(), DynLightField::U8(views));
    for quantity in [HciQuantity::Depth, HciQuantity::Disparity] {
        for resolution in [HciResolution::Low, HciResolution::High] {
            assert_eq!(read.central_truth(quantity, resolution, &Limits::default()).unwrap(), None);
        }
    }
    // With numbers that make no rig, the views are read nevertheless.
    fs::write(&parameters, least.replace("focal_length_mm=100", "focal_length_mm=0")).unwrap();
    let read = HciFolder::open(folder.path()).unwrap();
    assert!(matches!(read.rig(), Err(Error::Core { .. })));
    read.read(&Limits::default()).unwrap();
    fs::write(&parameters, least.replace("num_cams_x=3", "num_cams_x=0")).unwrap();
    assert!(matches!(HciFolder::open(folder.path()), Err(Error::Core { .. })));
    // A huge grid is refused without a loop over its views.
    fs::write(&parameters, least.replace("num_cams_x=3", "num_cams_x=1000000000000")).unwrap();
    assert!(matches!(HciFolder::open(folder.path()), Err(Error::Broken { .. })));
}

#[test]
fn alpha_is_dropped_and_colors_stay() {
    let (folder, views) = small();
    for (index, ((_, _), view)) in views.views().enumerate() {
        let with_alpha = Array3::from_shape_fn((4, 5, 4), |(row, column, channel)| {
            if channel == 3 { (row * 50) as u8 } else { view[[row, column, channel]] }
        });
        // Every second view, so that RGB and RGBA are mixed.
        if index % 2 == 0 {
            let path = folder.path().join(format!("input_Cam{index:03}.png"));
            write_png(path, with_alpha.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
        }
    }
    let read = HciFolder::open(folder.path()).unwrap();
    assert_eq!(read.read(&Limits::default()).unwrap(), DynLightField::U8(views.clone()));
    let DynImage::U8(one) = read.read_view(0, 2, &Limits::default()).unwrap() else { panic!("8 bits") };
    assert_eq!(one, views.view(0, 2).unwrap());
}

#[test]
fn views_that_are_missing_or_unlike_the_others_are_named() {
    let (folder, views) = small();
    let path = |name: &str| folder.path().join(name);
    let opened = HciFolder::open(folder.path()).unwrap();
    let message = |opened: &HciFolder| opened.read(&Limits::default()).unwrap_err().to_string();

    let wide: Array3<u8> = Array3::zeros((4, 6, 3));
    write_png(path("input_Cam003.png"), wide.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    let text = message(&opened);
    assert!(text.ends_with("it has 6 x 4 pixels, but parameters.cfg specifies 5 x 4"), "{text}");
    assert!(text.contains("input_Cam003.png: broken HCI folder: it has"), "{text}");
    assert!(matches!(opened.read_view(1, 0, &Limits::default()), Err(Error::Broken { .. })));
    opened.read_view(0, 0, &Limits::default()).unwrap();

    let deep: Array3<u16> = Array3::zeros((4, 5, 3));
    write_png(path("input_Cam003.png"), deep.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    let text = message(&opened);
    assert!(text.contains("RGB in 16 bits, but input_Cam000.png is 5 x 4 pixels of RGB in 8 bits"), "{text}");
    let gray = views.samples().slice(s![.., .., 0, 0, ..1]).to_owned();
    write_png(path("input_Cam003.png"), gray.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    assert!(message(&opened).contains("pixels of gray in 8 bits"));
    fs::write(path("input_Cam003.png"), b"\x89PNG").unwrap();
    assert!(matches!(opened.read(&Limits::default()), Err(Error::Broken { format: "PNG", .. })));

    fs::remove_file(path("input_Cam003.png")).unwrap();
    let error = HciFolder::open(folder.path()).unwrap_err().to_string();
    assert!(error.contains("there is no input_Cam003.png, the view in row 1, column 0 of the 3 x 2"), "{error}");
    fs::copy(path("input_Cam000.png"), path("input_Cam0000.png")).unwrap();
    let error = HciFolder::open(folder.path()).unwrap_err().to_string();
    assert!(error.contains("has the same number"), "{error}");

    for (t, s) in [(2, 0), (0, 3), (usize::MAX, usize::MAX)] {
        assert!(matches!(opened.read_view(t, s, &Limits::default()), Err(Error::Core { .. })));
        let truth = opened.truth_of_view(HciQuantity::Depth, HciResolution::Low, t, s, &Limits::default());
        assert!(matches!(truth, Err(Error::Core { .. })));
    }
}

#[test]
fn the_budget_is_for_all_views_together() {
    let (folder, _) = small();
    let opened = HciFolder::open(folder.path()).unwrap();
    let needed = 2 * 3 * 4 * 5 * 3;
    opened.read(&Limits { max_bytes: needed }).unwrap();
    let error = opened.read(&Limits { max_bytes: needed - 1 }).unwrap_err();
    assert!(matches!(error, Error::TooLarge { needed: 360, allowed: 359, .. }), "{error}");
}

#[test]
fn ground_truth_of_other_sizes_is_refused_unless_it_is_finer() {
    let (folder, _) = small();
    let fine: Array2<f32> = Array2::from_shape_fn((40, 50), |(row, column)| (row * 50 + column) as f32);
    for name in ["gt_depth_lowres.pfm", "gt_depth_highres.pfm", "gt_depth_highres_Cam0001.pfm"] {
        write_pfm(folder.path().join(name), fine.view()).unwrap();
    }
    let opened = HciFolder::open(folder.path()).unwrap();
    let limits = Limits::default();
    let low = opened.central_truth(HciQuantity::Depth, HciResolution::Low, &limits);
    assert!(low.unwrap_err().to_string().ends_with("it has 50 x 40 pixels, but parameters.cfg specifies 5 x 4"));
    assert_eq!(opened.central_truth(HciQuantity::Depth, HciResolution::High, &limits).unwrap().unwrap(), fine);
    let one = opened.truth_of_view(HciQuantity::Depth, HciResolution::High, 0, 1, &limits).unwrap();
    assert_eq!(one.unwrap(), fine);
}

#[test]
fn contradicting_arguments_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let size = shape([2, 3], [4, 5]);
    let views = bytes(size, 3);
    let good = ParametersCfg::from_rig(&rig(size));
    let other = ParametersCfg::from_rig(&rig(shape([3, 2], [4, 5])));
    let error = write(folder.path(), &views, &other).unwrap_err().to_string();
    assert!(
        error.ends_with(
            "the parameters specify 2 x 3 views of 5 x 4 pixels, the images are 3 x 2 views of 5 x 4 pixels"
        ),
        "{error}"
    );
    let unwritable = ParametersCfg { scene: "a\nb".into(), ..good.clone() };
    assert!(matches!(write(folder.path(), &views, &unwritable), Err(Error::BadInput { .. })));
    let small: Array2<f32> = Array2::zeros((5, 4));
    let color: LightFieldOwned<f32> = LightField::filled(size, 3, Layout::ElementalGrid, 0.0).unwrap();
    for truth in [HciTruth::Central(small.view()), HciTruth::All(color.as_light_field_ref())] {
        let views = views.as_light_field_ref().into();
        let image = HciImage {
            views: Some(views),
            parameters: &good,
            disparity_px: HciTruth::None,
            depth_m: truth,
            high_resolution: None,
        };
        assert!(matches!(image.write(folder.path(), Compression::Fast), Err(Error::BadInput { .. })));
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    // A file instead of a folder, and a missing folder.
    let file = folder.path().join("file");
    fs::write(&file, b"x").unwrap();
    for path in [file, folder.path().join("none")] {
        assert!(matches!(write(&path, &views, &good), Err(Error::Io { .. })), "{}", path.display());
        assert!(matches!(HciFolder::open(&path), Err(Error::Io { .. })), "{}", path.display());
    }
}

#[test]
fn a_folder_does_not_look_complete_before_it_is() {
    let (folder, views) = small();
    let parameters = folder.path().join("parameters.cfg");
    let good = ParametersCfg::from_rig(&rig(views.shape()));
    // Writing again replaces all files.
    write(folder.path(), &views, &good).unwrap();
    // A view cannot be written: the older parameters are removed and the new ones are not written.
    let view = folder.path().join("input_Cam004.png");
    fs::remove_file(&view).unwrap();
    fs::create_dir(&view).unwrap();
    assert!(matches!(write(folder.path(), &views, &good), Err(Error::Io { .. })));
    assert!(!parameters.exists());
    assert_eq!(HciFolder::open(folder.path()).unwrap_err().path(), parameters);
    fs::remove_dir(&view).unwrap();
    write(folder.path(), &views, &good).unwrap();

    // Other readers would read leftover views of a larger grid as part of this one: nothing is written.
    let fewer = bytes(shape([2, 2], [4, 5]), 3);
    let error = write(folder.path(), &fewer, &ParametersCfg::from_rig(&rig(fewer.shape()))).unwrap_err();
    assert!(matches!(error, Error::BadInput { .. }), "{error}");
    assert_eq!(HciFolder::open(folder.path()).unwrap().read(&Limits::default()).unwrap(), DynLightField::U8(views));
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_is_an_error() {
    use std::os::unix::fs::PermissionsExt;
    let (folder, views) = small();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o555)).unwrap();
    let refused = write(folder.path(), &views, &ParametersCfg::from_rig(&rig(views.shape())));
    let is_root = fs::write(folder.path().join("probe"), b"x").is_ok();
    // Reading needs no permission to write, and the old files are complete.
    HciFolder::open(folder.path()).unwrap().read(&Limits::default()).unwrap();
    fs::set_permissions(folder.path(), fs::Permissions::from_mode(0o755)).unwrap();
    if is_root {
        eprintln!("not run: needs a user whom permissions bind");
        return;
    }
    assert!(matches!(refused, Err(Error::Io { .. })));
}

/// Reads the folder without code of this crate and prints its contents.
const READER: &str = r#"
import configparser, os, re, sys
import numpy as np
from PIL import Image
folder = sys.argv[1]
config = configparser.ConfigParser(delimiters=("=",))
config.read_file(open(os.path.join(folder, "parameters.cfg")))
columns, rows = config.getint("extrinsics", "num_cams_x"), config.getint("extrinsics", "num_cams_y")
width = config.getint("intrinsics", "image_resolution_x_px")
height = config.getint("intrinsics", "image_resolution_y_px")
for section, keys in (("intrinsics", "focal_length_mm sensor_size_mm fstop"),
                      ("extrinsics", "baseline_mm focus_distance_m offset"),
                      ("meta", "disp_min disp_max depth_map_scale")):
    for key in keys.split():
        print(key, repr(config.getfloat(section, key)))
def pfm(name):
    with open(os.path.join(folder, name), "rb") as f:
        assert f.readline() == b"Pf\n"
        w, h = map(int, f.readline().split())
        scale = float(f.readline())
        assert (w, h, scale) == (width, height, -1.0)
        return np.frombuffer(f.read(), "<f4").reshape(h, w)[::-1]
views = np.stack([np.asarray(Image.open(os.path.join(folder, "input_Cam%03d.png" % i))) for i in range(rows * columns)])
assert views.shape == (rows * columns, height, width, 3) and views.dtype == np.uint8, views.shape
print("views", views.tobytes().hex())
print("central", pfm("gt_disp_lowres.pfm").astype("<f4").tobytes().hex())
print("depth", b"".join(pfm("gt_depth_lowres_Cam%03d.pfm" % i).astype("<f4").tobytes() for i in range(rows * columns)).hex())
"#;

#[test]
fn python_reads_what_is_written() {
    let size = shape([4, 3], [5, 6]);
    let (views, maps) = (bytes(size, 3), maps(size));
    let (t, s) = size.central_view();
    let central = maps.view(t, s).unwrap().index_axis_move(Axis(2), 0);
    let mut parameters = ParametersCfg::from_rig(&rig(size).to_builder().baseline_y_m(0.05).build().unwrap());
    parameters.set_disparity_range_px(-1.42, 1.61);
    parameters.scene = "100 % = all".into();
    let image = HciImage {
        views: Some(views.as_light_field_ref().into()),
        parameters: &parameters,
        disparity_px: HciTruth::Central(central),
        depth_m: HciTruth::All(maps.as_light_field_ref()),
        high_resolution: None,
    };
    let folder = tempfile::tempdir().unwrap();
    image.write(folder.path(), Compression::Best).unwrap();
    let arguments = [folder.path().to_str().unwrap()];
    let Some(text) = python::run(&["numpy", "PIL"], READER, &arguments) else { return };

    let hex = |bytes: Vec<u8>| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<String>();
    let floats = |map: ndarray::ArrayView2<f32>| map.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let all_views = views.views().flat_map(|(_, view)| view.iter().copied().collect::<Vec<u8>>()).collect();
    let all_maps = maps.views().flat_map(|(_, map)| floats(map.index_axis_move(Axis(2), 0))).collect();
    let expected = format!(
        "focal_length_mm 100.0\nsensor_size_mm 35.0\nfstop 100.0\nbaseline_mm 25.0\nfocus_distance_m 4.25\noffset {:?}\n\
         disp_min -1.6\ndisp_max 1.8\ndepth_map_scale 1.0\nviews {}\ncentral {}\ndepth {}\n",
        parameters.offset.unwrap(),
        hex(all_views),
        hex(floats(central)),
        hex(all_maps)
    );
    assert_eq!(text.replace('\r', ""), expected);
}
