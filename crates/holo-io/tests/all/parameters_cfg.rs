//! `parameters.cfg`: the text of the HCI tools, byte for byte, and files of other programs.

use crate::rigs;
use std::fs;

use holo_core::{GridSize, LightFieldShape, Projection, Rig};
use holo_io::{CameraPose, Error, ParametersCfg};
use proptest::prelude::*;

/// The rig of the HCI scene `cotton`.
fn cotton() -> Rig {
    rigs::cotton(LightFieldShape::new(GridSize::new(9, 9), GridSize::new(512, 512)).unwrap())
}

fn full() -> ParametersCfg {
    let mut parameters = ParametersCfg::from_rig(&cotton());
    parameters.center_cam =
        Some(CameraPose { position_m: [1.0, -3.0, 2.5], rotation_rad: [std::f64::consts::FRAC_PI_2, 0.0, -0.25] });
    parameters.scene = "cotton".into();
    parameters.category = "training".into();
    parameters.version = "v0".into();
    parameters.authors = "A. Author, B. Author".into();
    parameters.contact = "contact@example.org".into();
    parameters.cycles_seed = Some(1_834_710_023);
    parameters.set_disparity_range_px(-1.42, 1.61);
    parameters.frustum_disp_min = Some(-2.0);
    parameters.frustum_disp_max = Some(2.0);
    parameters.depth_map_scale = Some(10.0);
    parameters
}

#[test]
fn the_text_is_that_of_the_hci_tools() {
    let mut parameters = full();
    // 0.1 * ... in binary; the published file of the scene has 8.605 too.
    assert!((parameters.offset.unwrap() - 8.605).abs() < 5e-4);
    parameters.offset = Some(8.605);
    let expected = "\
[intrinsics]
focal_length_mm = 100.0
image_resolution_x_px = 512
image_resolution_y_px = 512
sensor_size_mm = 35.0
fstop = 100.0

[extrinsics]
num_cams_x = 9
num_cams_y = 9
baseline_mm = 25.0
focus_distance_m = 4.25
center_cam_x_m = 1.0
center_cam_y_m = -3.0
center_cam_z_m = 2.5
center_cam_rx_rad = 1.5707963267948966
center_cam_ry_rad = 0.0
center_cam_rz_rad = -0.25
offset = 8.605

[meta]
scene = cotton
category = training
date = \nversion = v0
authors = A. Author, B. Author
contact = contact@example.org
cycles_seed = 1834710023
disp_min = -1.6
disp_max = 1.8
frustum_disp_min = -2.0
frustum_disp_max = 2.0
depth_map_scale = 10.0

";
    assert_eq!(parameters.to_text().unwrap(), expected);
    assert_eq!(ParametersCfg::from_text(expected).unwrap(), parameters);
    let disparity = parameters.rig().unwrap().disparity();
    assert!((disparity.from_depth_m(3.5) - 1.8439).abs() < 5e-5);
}

#[test]
fn infinity_is_zero_in_the_file() {
    let rig = cotton().to_builder().focus_distance_m(f64::INFINITY).build().unwrap();
    let parameters = ParametersCfg::from_rig(&rig);
    assert_eq!(parameters.offset, Some(0.0));
    let text = parameters.to_text().unwrap();
    assert!(text.contains("\nfocus_distance_m = 0.0\n") && text.contains("\noffset = 0.0\n"));
    assert_eq!(ParametersCfg::from_text(&text).unwrap().rig().unwrap(), rig);
    let other = text.replace("focus_distance_m = 0.0", "focus_distance_m = 0");
    assert_eq!(ParametersCfg::from_text(&other).unwrap().focus_distance_m, f64::INFINITY);
}

#[test]
fn keys_that_extend_the_hci_format_are_added_only_where_needed() {
    let text = full().to_text().unwrap();
    assert!(!text.contains("baseline_y_mm") && !text.contains("projection"));
    let rig = cotton().to_builder().baseline_y_m(0.5).projection(Projection::Orthographic).build().unwrap();
    let text = ParametersCfg::from_rig(&rig).to_text().unwrap();
    assert!(text.contains("\nbaseline_y_mm = 500.0\nprojection = orthographic\n"));
    assert_eq!(ParametersCfg::from_text(&text).unwrap().rig().unwrap(), rig);
    let error = ParametersCfg::from_text(&text.replace("orthographic", "fisheye")).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }), "{error}");
}

const LEAST: &str = "\
[intrinsics]
focal_length_mm=100
image_resolution_x_px=5
image_resolution_y_px=4
sensor_size_mm=35
[extrinsics]
num_cams_x=3
num_cams_y=2
baseline_mm=1
focus_distance_m=7
";

#[test]
fn only_the_numbers_of_the_rig_are_needed() {
    let parameters = ParametersCfg::from_text(LEAST).unwrap();
    assert_eq!((parameters.num_cams, parameters.image_resolution_px), (GridSize::new(2, 3), GridSize::new(4, 5)));
    assert_eq!((parameters.center_cam, parameters.offset, parameters.disp_min), (None, None, None));
    assert_eq!(parameters.scene, "");
    for line in LEAST.lines().filter(|line| !line.starts_with('[')) {
        let key = line.split('=').next().unwrap();
        let error = ParametersCfg::from_text(&LEAST.replace(&format!("{line}\n"), "")).unwrap_err();
        assert!(error.to_string().ends_with(&format!("has no {key}")), "{error}");
    }
    for end in 0..LEAST.len() {
        // No panic; a file without the last digits of the last number is valid.
        let _ = ParametersCfg::from_text(&LEAST[..end]);
    }
}

#[test]
fn variants_of_other_programs_are_read() {
    let strange = "\u{feff}; a comment
[extrinsics]
Num_Cams_X = 3.0
  # not a value
num_cams_y =2
BASELINE_MM= 1e0
focus_distance_m = 7

[intrinsics]
focal_length_mm = 100
image_resolution_x_px = 5
image_resolution_y_px = 4
sensor_size_mm = 35
[meta]
scene = a = b
authors = one,
\ttwo
contact = 100%%
"
    .replace('\n', "\r\n");
    let read = ParametersCfg::from_text(&strange).unwrap();
    assert_eq!(read.rig().unwrap(), ParametersCfg::from_text(LEAST).unwrap().rig().unwrap());
    assert_eq!((read.scene.as_str(), read.authors.as_str(), read.contact.as_str()), ("a = b", "one, two", "100%"));
    assert!(read.to_text().unwrap().contains("\ncontact = 100%%\n"));
    // Latin-1, as of older editors.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parameters.cfg");
    fs::write(&path, [LEAST.as_bytes(), b"[meta]\nauthors = Sch\xe4fer\n"].concat()).unwrap();
    assert_eq!(ParametersCfg::read(&path).unwrap().authors, "Schäfer");
}

#[test]
fn unknown_keys_are_kept() {
    let text = format!("{LEAST}mine = 5\n[other]\nkey = 100%% value\n[meta]\nnew_key = x\n");
    let read = ParametersCfg::from_text(&text).unwrap();
    let other: Vec<_> =
        read.other.iter().map(|((section, key), value)| (section.as_str(), key.as_str(), value.as_str())).collect();
    assert_eq!(other, [("extrinsics", "mine", "5"), ("meta", "new_key", "x"), ("other", "key", "100% value")]);
    assert_eq!(ParametersCfg::from_text(&read.to_text().unwrap()).unwrap(), read);
}

#[test]
fn damage_is_named_with_its_line() {
    for (line, message) in [
        ("what is this", "line 11: neither a [section] nor key = value"),
        ("[]", "line 11: a section needs a name in square brackets"),
        ("[x", "line 11: a section needs a name in square brackets"),
        ("= 5", "line 11: a value without a key"),
        ("num_cams_x = 4", "line 11: the key num_cams_x occurs twice in [extrinsics]"),
        ("offset = five", "line 11: offset = \"five\" is not a number"),
        ("[meta]\ncycles_seed = 1.5", "line 12: cycles_seed = \"1.5\" is not a whole number"),
    ] {
        let error = ParametersCfg::from_text(&format!("{LEAST}{line}\n")).unwrap_err();
        assert_eq!(error.to_string(), format!("(stream): broken parameters.cfg file: {message}"));
    }
    for count in ["-3", "3.5", "nan", "1e300", ""] {
        let text = LEAST.replace("num_cams_x=3", &format!("num_cams_x={count}"));
        assert!(matches!(ParametersCfg::from_text(&text), Err(Error::Broken { .. })), "{count:?}");
    }
    let error = ParametersCfg::from_text(&format!("key = before\n{LEAST}")).unwrap_err();
    assert!(error.to_string().ends_with("line 1: a key before the first [section]"));
    // A count of zero is a number; building the rig refuses it.
    let parameters = ParametersCfg::from_text(&LEAST.replace("num_cams_x=3", "num_cams_x=0")).unwrap();
    assert!(matches!(parameters.rig(), Err(Error::Core { .. })));
}

#[test]
fn texts_that_would_break_the_file_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("parameters.cfg");
    let mut parameters = full();
    parameters.scene = "a\n[meta]".into();
    assert!(matches!(parameters.write(&path), Err(Error::BadInput { .. })));
    for (section, key) in [
        ("meta", ""),
        ("meta", "a=b"),
        ("meta", "#a"),
        ("meta", "[a"),
        ("meta", " a"),
        ("meta", "A"),
        ("meta", "scene"),
        ("a]", "a"),
        ("", "a"),
        ("a\n", "a"),
    ] {
        let mut parameters = full();
        parameters.other.insert((section.into(), key.into()), "x".into());
        assert!(matches!(parameters.write(&path), Err(Error::BadInput { .. })), "{section:?} {key:?}");
    }
    assert!(!path.exists());
    full().write(&path).unwrap();
    assert_eq!(ParametersCfg::read(&path).unwrap(), full());
}

proptest! {
    #[test]
    fn every_parameter_reads_back(
        // No zero, because a focus distance of 0 reads as infinity, and no NaN, because it is not equal to itself.
        numbers in prop::collection::vec(any::<f64>().prop_filter("0 or NaN", |n| n.abs() > 0.0), 20),
        counts in prop::array::uniform4(0_usize..=usize::MAX), seed: i64, missing: u16,
        texts in prop::collection::vec("[^\\p{Cc}\u{feff}]{0,12}", 7), orthographic: bool,
        other in prop::collection::btree_map(("[a-z]{1,8}", "[a-z][a-z0-9_ .:%]{0,6}[a-z]"), "[^\\p{Cc}]{0,9}", 0..4),
    ) {
        let optional = |at: usize| (missing >> at & 1 == 1).then_some(numbers[at]);
        let text = |at: usize| texts[at].trim().to_owned();
        let parameters = ParametersCfg {
            focal_length_mm: numbers[10],
            image_resolution_px: GridSize::new(counts[0], counts[1]),
            sensor_size_mm: numbers[11],
            fstop: optional(0),
            num_cams: GridSize::new(counts[2], counts[3]),
            baseline_mm: numbers[12],
            baseline_y_mm: optional(1),
            focus_distance_m: numbers[13],
            projection: if orthographic { Projection::Orthographic } else { Projection::Perspective },
            center_cam: (missing >> 2 & 1 == 1).then_some(CameraPose {
                position_m: [numbers[14], numbers[15], numbers[16]],
                rotation_rad: [numbers[17], numbers[18], numbers[19]],
            }),
            offset: optional(3),
            scene: text(0), category: text(1), date: text(2), version: text(3), authors: text(4), contact: text(5),
            cycles_seed: (missing >> 9 & 1 == 1).then_some(seed),
            disp_min: optional(4), disp_max: optional(5),
            frustum_disp_min: optional(6), frustum_disp_max: optional(7), depth_map_scale: optional(8),
            other: other.into_iter().map(|(name, value)| (name, value.trim().to_owned())).collect(),
        };
        let written = parameters.to_text().unwrap();
        let read = ParametersCfg::from_text(&written).unwrap();
        prop_assert_eq!(&read, &parameters);
        prop_assert_eq!(read.to_text().unwrap(), written);
    }

    #[test]
    fn no_text_makes_it_panic(text in "(\\[[a-z]{0,3}\\]?|[ \t]?[a-z=%]{0,4}=?[0-9.e-]{0,5}|[\r\n#;]|\\PC){0,20}") {
        let _ = ParametersCfg::from_text(&text);
        let _ = ParametersCfg::from_text(&format!("{LEAST}{text}"));
    }
}
