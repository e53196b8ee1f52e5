//! The manifest: equal bytes for equal inputs, exact round trips, and detection of changed files.

use std::collections::BTreeMap;
use std::fs;

use holo_core::{GridSize, LightFieldShape, Rig};
use holo_io::{Error, FileDigest, Manifest, ManifestValue, MismatchKind, Sha256, write_file};
use proptest::prelude::*;

fn rig() -> Rig {
    Rig::builder(LightFieldShape::new(GridSize::new(100, 80), GridSize::new(53, 79)).unwrap())
        .focal_length_m(0.0351)
        .sensor_size_m(0.036)
        .baseline_x_m(0.001)
        .baseline_y_m(0.002)
        .focus_distance_m(f64::INFINITY)
        .build()
        .unwrap()
}

fn example() -> Manifest {
    let mut manifest = Manifest {
        seed: u64::MAX,
        rig: Some(rig()),
        disparity_px: Some((-2.5098, 1.8439)),
        exposure_ev: Some(0.1 + 0.2),
        ..Manifest::default()
    };
    manifest.versions.insert("holo".into(), "0.1.0".into());
    manifest.versions.insert("embree".into(), "4.4.0".into());
    manifest.libraries.insert("libembree4.so.4".into(), FileDigest { bytes: 4, sha256: Sha256([0xab; 32]) });
    manifest.settings.insert("spp".into(), 16_u32.into());
    manifest.settings.insert("sky".into(), vec![0.2, 0.24, 0.32].into());
    manifest.settings.insert("sensor".into(), GridSize::new(5304, 7952).into());
    manifest.settings.insert("camera".into(), ManifestValue::None);
    manifest.settings.insert("focus_m".into(), f64::INFINITY.into());
    let written = FileDigest { bytes: 3, sha256: Sha256([0xab; 32]) };
    manifest.files.insert("scene_el.png".into(), written);
    manifest.files.insert("hci/input_Cam000.png".into(), written);
    manifest
}

#[test]
fn the_text_is_fixed() {
    let digest = "ab".repeat(32);
    let expected = format!(
        r#"{{
  "format": "holo manifest 2",
  "versions": {{
    "embree": "4.4.0",
    "holo": "0.1.0"
  }},
  "libraries": {{
    "libembree4.so.4": {{
      "bytes": 4,
      "sha256": "{digest}"
    }}
  }},
  "seed": 18446744073709551615,
  "settings": {{
    "camera": null,
    "focus_m": "inf",
    "sensor": {{
      "columns": 7952,
      "rows": 5304
    }},
    "sky": [
      0.2,
      0.24,
      0.32
    ],
    "spp": 16
  }},
  "rig": {{
    "views": {{
      "columns": 80,
      "rows": 100
    }},
    "lenses": {{
      "columns": 79,
      "rows": 53
    }},
    "baseline_m": {{
      "x": 0.001,
      "y": 0.002
    }},
    "focal_length_mm": 35.1,
    "sensor_size_mm": 36.0,
    "focus_distance_m": "inf",
    "projection": "perspective"
  }},
  "disparity_px": {{
    "min": -2.5098,
    "max": 1.8439
  }},
  "exposure_ev": 0.30000000000000004,
  "files": {{
    "hci/input_Cam000.png": {{
      "bytes": 3,
      "sha256": "{digest}"
    }},
    "scene_el.png": {{
      "bytes": 3,
      "sha256": "{digest}"
    }}
  }}
}}
"#
    );
    assert_eq!(example().to_json().unwrap(), expected);
    assert_eq!(Manifest::from_json(&expected).unwrap(), example());
    assert_eq!(example().rig.unwrap(), rig());
}

#[test]
fn a_rig_of_no_views_is_an_error_of_the_file() {
    let text = example().to_json().unwrap();
    let damaged = text.replacen("\"rows\": 100", "\"rows\": 0", 1);
    assert_ne!(damaged, text);
    assert!(matches!(Manifest::from_json(&damaged), Err(Error::Broken { .. })));
}

#[test]
fn the_minimal_manifest_is_its_format() {
    for format in [1, 2] {
        let text = format!(r#"{{"format":"holo manifest {format}","unknown":[1]}}"#);
        assert_eq!(Manifest::from_json(&text).unwrap(), Manifest::default());
    }
}

#[test]
fn other_versions_are_distinguished_from_damage() {
    let error = Manifest::from_json(r#"{"format":"holo manifest 3","files":7}"#).unwrap_err();
    assert!(matches!(error, Error::Unsupported { .. }), "{error}");
    for text in
        ["", "7", "[]", "{}", "null", r#"{"format":7}"#, r#"{"format":"holo manifest 1","seed":-1}"#, "\u{feff}{}"]
    {
        let error = Manifest::from_json(text).unwrap_err();
        assert!(matches!(error, Error::Broken { .. }), "{text}: {error}");
    }
    let text = example().to_json().unwrap();
    for end in 0..text.len() - 1 {
        assert!(Manifest::from_json(&text[..end]).is_err(), "cut at {end}");
    }
    let nested = format!(r#"{{"format":"holo manifest 1","settings":{{"x":{}}}}}"#, "[".repeat(100_000));
    assert!(Manifest::from_json(&nested).is_err());
}

#[test]
fn names_outside_the_folder_are_refused() {
    let written = FileDigest { bytes: 0, sha256: Sha256([0; 32]) };
    for name in ["/etc/passwd", "../x", "a/../../b", "", "C:\\x"] {
        let manifest = Manifest { files: BTreeMap::from([(name.to_owned(), written)]), ..Manifest::default() };
        assert!(matches!(manifest.to_json(), Err(Error::BadInput { .. })), "{name}");
        let text = format!(
            r#"{{"format":"holo manifest 1","files":{{{:?}:{{"bytes":0,"sha256":"{}"}}}}}}"#,
            name,
            "0".repeat(64)
        );
        assert!(matches!(Manifest::from_json(&text), Err(Error::Broken { .. })), "{name}");
        let folder = tempfile::tempdir().unwrap();
        assert!(matches!(manifest.verify(folder.path())[0].kind, MismatchKind::Outside));
    }
    let text = r#"{"format":"holo manifest 1","files":{"a":{"bytes":0,"sha256":"0"}}}"#;
    assert!(Manifest::from_json(text).unwrap_err().to_string().contains("SHA-256"));
}

#[test]
fn changed_files_are_detected() {
    let folder = tempfile::tempdir().unwrap();
    let mut manifest = Manifest::default();
    fs::create_dir(folder.path().join("hci")).unwrap();
    for name in ["a", "b", "c", "d", "hci/e"] {
        manifest.files.insert(name.into(), write_file(folder.path().join(name), name.as_bytes()).unwrap());
    }
    assert!(manifest.verify(folder.path()).is_empty());
    fs::write(folder.path().join("unlisted"), b"x").unwrap();
    fs::write(folder.path().join("a"), b"A").unwrap();
    fs::write(folder.path().join("b"), b"longer").unwrap();
    fs::remove_file(folder.path().join("c")).unwrap();
    fs::remove_file(folder.path().join("d")).unwrap();
    fs::create_dir(folder.path().join("d")).unwrap();
    let problems = manifest.verify(folder.path());
    assert_eq!(problems.iter().map(|problem| problem.file.as_str()).collect::<Vec<_>>(), ["a", "b", "c", "d"]);
    assert!(matches!(problems[0].kind, MismatchKind::Contents { .. }));
    assert!(matches!(problems[1].kind, MismatchKind::Size { expected: 1, found: 6 }));
    assert!(matches!(problems[2].kind, MismatchKind::Missing));
    assert!(matches!(problems[3].kind, MismatchKind::Missing));
    assert_eq!(problems[1].to_string(), "b: 6 bytes, but the manifest says 1");
    assert_eq!(problems[2].to_string(), "c: missing");
}

#[test]
fn files_too_long_to_be_a_manifest_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("manifest.json");
    fs::File::create(&path).unwrap().set_len(17 << 20).unwrap();
    assert!(matches!(Manifest::read(&path), Err(Error::TooLarge { .. })));
    #[cfg(target_os = "linux")]
    assert!(Manifest::read("/dev/zero").unwrap_err().to_string().contains("a device"));
    assert!(matches!(Manifest::read(folder.path().join("none")), Err(Error::Io { .. })));
}

fn value() -> impl Strategy<Value = ManifestValue> {
    let leaf = prop_oneof![
        Just(ManifestValue::None),
        any::<bool>().prop_map(ManifestValue::Bool),
        any::<i64>().prop_map(ManifestValue::Integer),
        any::<u64>()
            .prop_filter("NaN is not equal to itself", |bits| !f64::from_bits(*bits).is_nan())
            .prop_map(|bits| ManifestValue::Float(f64::from_bits(bits))),
        "[^\u{0}]{0,12}"
            .prop_filter("reads as a number", |text| !["inf", "-inf", "nan"].contains(&text.as_str()))
            .prop_map(ManifestValue::Text),
    ];
    leaf.prop_recursive(4, 24, 5, |inner| {
        prop_oneof![
            prop::collection::vec(inner.clone(), 0..5).prop_map(ManifestValue::List),
            prop::collection::btree_map(".{0,6}", inner, 0..5).prop_map(ManifestValue::Table),
        ]
    })
}

proptest! {
    #[test]
    fn every_manifest_reads_back(
        seed: u64, settings in prop::collection::btree_map(".{0,8}", value(), 0..6),
        numbers in prop::array::uniform4(any::<f64>().prop_filter("NaN is not equal to itself", |n| !n.is_nan())),
        bytes: u64, digest: [u8; 32], views in (1_usize..9, 1_usize..1_000_000), focal_length_m in 1e-6_f64..1e3,
    ) {
        let [min, max, exposure, _] = numbers;
        let manifest = Manifest {
            versions: BTreeMap::from([("holo".into(), "0".into())]),
            libraries: BTreeMap::from([("lib".into(), FileDigest { bytes, sha256: Sha256(digest) })]),
            seed,
            settings,
            rig: rig()
                .to_builder()
                .shape(LightFieldShape::new(GridSize::new(views.0, views.1), GridSize::new(3, 2)).unwrap())
                .focal_length_m(focal_length_m)
                .build()
                .ok(),
            disparity_px: Some((min, max)),
            exposure_ev: Some(exposure),
            files: BTreeMap::from([("scene_el.png".into(), FileDigest { bytes, sha256: Sha256(digest) })]),
        };
        let text = manifest.to_json().unwrap();
        let mut read = Manifest::from_json(&text).unwrap();
        prop_assert_eq!(read.to_json().unwrap(), text);
        // Two lengths in meters may have the same millimeters.
        let (found, expected) = (read.rig.unwrap().focal_length_m(), focal_length_m);
        prop_assert!((found - expected).abs() <= expected * f64::EPSILON);
        read.rig = manifest.rig;
        prop_assert_eq!(read, manifest);
    }
}
