//! Containers that are written here as their readers describe them, whole and damaged.

use proptest::prelude::*;
use serde_json::json;

use super::*;

/// A section: its kind, its name, its data.
fn section(kind: u8, name: &str, data: &[u8]) -> Vec<u8> {
    let mut out = MAGIC.to_vec();
    out[3] = kind;
    out.extend([0, 0, 0, u8::from(kind == b'P')]);
    out.extend((data.len() as u32).to_be_bytes());
    if !data.is_empty() {
        let mut name = name.as_bytes().to_vec();
        name.resize(NAME, 0);
        out.extend(name);
        out.extend(data);
        out.resize(out.len().next_multiple_of(16), 0);
    }
    out
}

/// Metadata with the keys of real files; numbers differ from those of the presets.
fn metadata(model: &str, size: GridSize) -> Value {
    let (bits, black, corner) = if model == "F01" { (12, 168, "b") } else { (10, 64, "gr") };
    let all = |code: i32| json!({"r": code, "gr": code, "gb": code, "b": code});
    json!({
        "image": {
            "width": size.columns, "height": size.rows,
            "rawDetails": {
                "pixelFormat": {"rightShift": 0, "black": all(black), "white": all((1 << bits) - 1)},
                "pixelPacking": {"endianness": "big", "bitsPerPixel": bits},
                "mosaic": {"tile": "r,gr:gb,b", "upperLeftPixel": corner},
            },
            "color": {
                "ccmRgbToSrgbArray": [2.5, -1.1, -0.4, -0.3, 1.6, -0.3, -0.2, -0.7, 1.9],
                "whiteBalanceGain": {"r": 1.25, "gr": 1, "gb": 1, "b": 1.5},
            },
        },
        "devices": {
            "sensor": {"bitsPerPixel": bits, "pixelPitch": 1.4e-6},
            "lens": {"focalLength": 0.03, "fNumber": 2.1, "exitPupilOffset": {"z": 0.05}},
            "mla": {"lensPitch": 2.1e-5, "rotation": -0.0005, "scaleFactor": {"x": 1, "y": 1.0004},
                    "sensorOffset": {"x": -1e-5, "y": 2e-6, "z": 4e-5}},
        },
        "camera": {"make": "Lytro, Inc.", "model": model},
    })
}

fn codes(model: LytroModel, size: GridSize) -> Array2<u16> {
    let most = if model == LytroModel::F01 { 4096 } else { 1024 };
    Array2::from_shape_fn((size.rows, size.columns), |(row, column)| (row * 371 + column * 119) as u16 % most)
}

/// A container of a model, with a section that nobody asks for.
fn container(model: LytroModel, size: GridSize) -> Vec<u8> {
    let (name, is_old) = if model == LytroModel::F01 { ("F01", true) } else { ("B01", false) };
    let frame =
        json!({"frame": {"imageRef": "sha1-image", "metadataRef": "sha1-meta", "privateMetadataRef": "sha1-no"}});
    let table = match is_old {
        true => json!({"picture": {"frameArray": [frame]}}),
        false => json!({"frames": [frame], "thumbnails": []}),
    };
    let packed = model.packed(codes(model, size).view());
    // As in real files the table comes last, and a F01 has some bytes more.
    [
        section(b'P', "", &[]),
        section(b'C', "sha1-other", b"odd"),
        section(b'C', "sha1-meta", metadata(name, size).to_string().as_bytes()),
        section(b'C', "sha1-image", &packed),
        section(b'M', "sha1-table", table.to_string().as_bytes()),
        if is_old { vec![7; 21] } else { Vec::new() },
    ]
    .concat()
}

const SIZE: GridSize = GridSize::new(6, 8);

#[test]
fn containers_of_both_models_have_codes_sensor_and_camera() {
    let folder = tempfile::tempdir().unwrap();
    for (model, name, filter, black) in [
        (LytroModel::F01, "IMG_0001.lfp", ColorFilter::Bggr, 168.0),
        (LytroModel::Illum, "IMG_0001.LFR", ColorFilter::Grbg, 64.0),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, container(model, SIZE)).unwrap();
        assert_eq!(detect_format(&path).unwrap(), FileFormat::Lytro);
        assert!(LytroImage::is_at(&path).unwrap());
        let image = LytroImage::read(&path, &Limits::default()).unwrap();
        assert_eq!(image.codes.index_axis(Axis(2), 0), codes(model, SIZE));
        let sensor = image.info.sensor;
        assert_eq!((sensor.filter, sensor.black, sensor.color_matrix[1]), (filter, black, [-0.3, 1.6, -0.3]));
        assert_eq!(sensor.white_balance, [1.25, 1.0, 1.5]);
        let (array, lens) = (image.camera.array(), image.camera.main_lens());
        assert_eq!((array.pitch_m, array.rotation_rad, array.scale_y), (2.1e-5, -0.0005, 1.0004));
        assert_eq!((array.offset_m, array.gap_m), ([-1e-5, 2e-6], 4e-5));
        assert_eq!((lens.focal_length_m, lens.f_number, lens.exit_pupil_m), (0.03, 2.1, Some(0.05)));
        assert_eq!(image.camera.sensor().size, SIZE);
        // Black is 0, the largest code is 1.
        let (mosaic, white) = (image.mosaic(), f64::from(sensor.white()));
        for ((row, column), light) in mosaic.indexed_iter() {
            let expected = (f64::from(image.codes[[row, column, 0]]) - black) / (white - black);
            assert!((f64::from(*light) - expected).abs() < 1e-6, "{light} {expected}");
        }
        // In a white image all colors have one mean.
        let white = image.white();
        let mean = |row: usize, column: usize| {
            let own: Vec<f32> =
                white.indexed_iter().filter(|((v, u), _)| (v % 2, u % 2) == (row, column)).map(|(_, x)| *x).collect();
            own.iter().sum::<f32>() / own.len() as f32
        };
        assert!([mean(0, 1), mean(1, 0), mean(1, 1)].iter().all(|own| (own / mean(0, 0) - 1.0).abs() < 1e-5));
    }
}

#[test]
fn packed_codes_are_read_with_the_metadata_beside_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("MOD_0007.RAW");
    std::fs::write(&path, LytroModel::Illum.packed(codes(LytroModel::Illum, SIZE).view())).unwrap();
    assert!(!LytroImage::is_at(&path).unwrap());
    let deep = json!({"master": {"picture": {"frameArray": [{"frame": {"metadata": metadata("B01", SIZE)}}]}}});
    std::fs::write(folder.path().join("MOD_0007.TXT"), deep.to_string()).unwrap();
    assert!(LytroImage::is_at(&path).unwrap());
    let image = LytroImage::read(&path, &Limits::default()).unwrap();
    assert_eq!(image.codes.index_axis(Axis(2), 0), codes(LytroModel::Illum, SIZE));
    // Fewer codes than pixels.
    std::fs::write(&path, [0; 20]).unwrap();
    let why = LytroImage::read(&path, &Limits::default()).unwrap_err().to_string();
    assert!(why.contains("20 bytes of codes") && why.contains("60"), "{why}");
}

/// A real Illum zoomed to 78 mm cannot focus at 0.5 m, as its preset does. A real F01 has its exit pupil at infinity. Both files
/// give a camera.
#[test]
fn cameras_of_real_metadata_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shot.raw");
    std::fs::write(&path, [0; 72]).unwrap();
    for (model, focal_m, f_number, exit_m, pitch_m, gap_m) in [
        ("B01", 0.07759365439414978, 2.1110498905181885, 0.04604887589812279, 1.9999999494757503e-5, 4.06e-5),
        ("F01", 0.006449999809265136, 1.909999966621399, 1e4, 1.389859962463379e-5, 2.5e-5),
    ] {
        let mut metadata = metadata(model, SIZE);
        let devices = &mut metadata["devices"];
        devices["lens"] = json!({"focalLength": focal_m, "fNumber": f_number, "exitPupilOffset": {"z": exit_m}});
        devices["mla"]["lensPitch"] = pitch_m.into();
        devices["mla"]["sensorOffset"]["z"] = gap_m.into();
        std::fs::write(folder.path().join("shot_metadata.json"), metadata.to_string()).unwrap();
        let camera = LytroImage::read(&path, &Limits::default()).unwrap().camera;
        assert_eq!(camera.exit_pupil_m(), exit_m, "{model}");
    }
}

#[test]
fn what_is_missing_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("shot.raw");
    std::fs::write(&path, [0; 60]).unwrap();
    for (place, value, word) in [
        ("/camera/model", json!("A1"), "A1"),
        ("/image/width", json!(0), "width"),
        ("/image/rawDetails/pixelPacking/bitsPerPixel", json!(14), "14 bits"),
        ("/image/rawDetails/mosaic/upperLeftPixel", json!("x"), "upperLeftPixel"),
        ("/devices/mla/lensPitch", json!(null), "lensPitch"),
        ("/devices/mla/lensPitch", json!(-1.0), "impossible"),
        ("/devices/lens/fNumber", json!("2"), "fNumber"),
    ] {
        let mut metadata = metadata("B01", SIZE);
        *metadata.pointer_mut(place).unwrap() = value;
        std::fs::write(folder.path().join("shot_metadata.json"), metadata.to_string()).unwrap();
        let why = LytroImage::read(&path, &Limits::default()).unwrap_err().to_string();
        assert!(why.contains(word), "{place}: {why}");
    }
    // A file of refocused images has no codes.
    let table = json!({"picture": {"frameArray": [{"frame": {"metadataRef": "sha1-meta"}}]}}).to_string();
    let path = folder.path().join("stack.lfp");
    std::fs::write(&path, [section(b'P', "", &[]), section(b'M', "sha1-t", table.as_bytes())].concat()).unwrap();
    let why = LytroImage::read(&path, &Limits::default()).unwrap_err().to_string();
    assert!(why.contains("refocused"), "{why}");
    std::fs::write(&path, section(b'P', "", &[])).unwrap();
    assert!(LytroImage::read(&path, &Limits::default()).unwrap_err().to_string().contains("no table"));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Cut off or with other bytes, it is an error or an image of the same size; nothing panics.
    #[test]
    fn damaged_containers_are_errors(at in 0_usize..2000, byte in any::<u8>(), cut in 0_usize..2000) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("damaged.lfr");
        let mut bytes = container(LytroModel::Illum, SIZE);
        let count = bytes.len();
        bytes[at % count] = byte;
        if cut % 3 == 0 {
            bytes.truncate(cut % count);
        }
        std::fs::write(&path, bytes).unwrap();
        if let Ok(image) = LytroImage::read(&path, &Limits::default()) {
            let size = image.camera.sensor().size;
            prop_assert_eq!(image.codes.dim(), (size.rows, size.columns, 1));
        }
    }
}
