use holo_core::GridSize;
use holo_core::plenoptic::Distortion;
use holo_core::sensor::ColorFilter;

use super::*;

const WHOLE: &str = r#"
name = "bench camera"
[sensor]
size_px = [560, 420]
pixel_um = 5.0
fill = 0.9
offset_um = [1.0, -2.0]
[mla]
grid = "square"
pitch_um = 70.85
rotation_deg = 0.11
offset_um = [7.0, -4.0]
gap_um = 400.0
focal_um = [400.0]
aperture = { shape = "square", width_um = 70.85 }
[main_lens]
focal_mm = 40.0
f_number = 5.5
aperture = "round"
exit_pupil_mm = 60.0
focus_m = 0.5
"#;

#[test]
fn all_keys_are_read() {
    let file = CameraFile::parse(WHOLE, "stem").unwrap();
    let camera = &file.camera;
    assert_eq!((file.name.as_str(), file.is_approximate), ("bench camera", false));
    assert_eq!(camera.sensor().size, GridSize::new(420, 560));
    assert_eq!((camera.sensor().pixel_m, camera.sensor().fill), (5e-6, 0.9));
    assert_eq!(camera.sensor().offset_m, [1e-6, -2e-6]);
    assert_eq!(camera.array().pitch_m, 70.85e-6);
    assert_eq!(camera.array().rotation_rad, 0.11f64.to_radians());
    assert_eq!(camera.array().aperture, LensAperture::Square { half_width_m: 70.85e-6 / 2.0 });
    assert_eq!(camera.array().focus, MicrolensFocus::Lengths(vec![400e-6]));
    assert_eq!((camera.main_lens().focal_length_m, camera.main_lens().exit_pupil_m), (0.04, Some(0.06)));
    assert!((1.0 / camera.inverse_focus_per_m() - 0.5).abs() < 1e-12);
    let refocused = file.clone().with_focus_m(2.0).unwrap().with_f_number(8.0).unwrap();
    assert!((1.0 / refocused.camera.inverse_focus_per_m() - 2.0).abs() < 1e-12);
    assert_eq!(refocused.camera.main_lens().f_number, 8.0);
    assert!(file.clone().with_focus_m(0.0).is_err() && file.with_f_number(-1.0).is_err());
}

/// The keys of tilted arrays, clear gaps and real main lenses are read and written again.
#[test]
fn keys_of_real_lenses_survive() {
    let text = WHOLE
        .replace("gap_um = 400.0", "gap_um = 400.0\ngaps = \"clear\"\ntilt_deg = [0.1, -0.2]")
        .replace("aperture = \"round\"", "aperture = { blades = 7, rotation_deg = 10.0 }")
        .replace("focus_m = 0.5", "focus_m = 0.5\nstops = [{ distance_mm = 25.0, diameter_mm = 14.0 }]\ndistortion = { radial_m2 = [-120.0, 0.0, 0.0], tangential_m = [0.01, 0.0] }");
    let file = CameraFile::parse(&text, "").unwrap();
    let (array, lens) = (file.camera.array(), file.camera.main_lens());
    assert!(array.has_clear_gaps && array.tilt_rad == [0.1f64, -0.2].map(f64::to_radians));
    assert_eq!(lens.aperture, PupilShape::Polygon { blades: 7, rotation_rad: 10f64.to_radians() });
    assert_eq!((lens.stops.len(), lens.stops[0].distance_m, lens.stops[0].diameter_m), (1, 0.025, 0.014));
    assert_eq!(lens.distortion, Distortion { radial: [-120.0, 0.0, 0.0], tangential: [0.01, 0.0] });
    let again = CameraFile::parse(&file.to_toml(), "").unwrap();
    assert_eq!(again.camera.main_lens(), lens);
    assert!(
        (again.camera.array().tilt_rad[1] - array.tilt_rad[1]).abs() < 1e-15 && again.camera.array().has_clear_gaps
    );
}

#[test]
fn presets_survive_their_files() {
    for preset in presets() {
        let file = CameraFile::preset(preset.name).unwrap();
        let text = file.to_toml();
        let again = CameraFile::parse(&text, "").unwrap_or_else(|why| panic!("{}: {why}\n{text}", preset.name));
        // Lengths in micrometers are decimal numbers again, except for those that are quotients.
        let lengths = |file: &CameraFile| {
            let (sensor, array, lens) = (file.camera.sensor(), file.camera.array(), file.camera.main_lens());
            let focal = file.camera.microlens_focal_lengths_m();
            let mut all = vec![sensor.pixel_m, sensor.fill, array.pitch_m, array.gap_m, array.scale_y, lens.f_number];
            all.extend([array.aperture.half_width_m(), lens.focal_length_m, file.camera.mla_distance_m()]);
            all.extend(focal.iter().chain(&array.offset_m).chain(&sensor.offset_m));
            all.extend([file.camera.exit_pupil_m(), array.rotation_rad]);
            all
        };
        for (a, b) in lengths(&file).into_iter().zip(lengths(&again)) {
            assert!((a - b).abs() <= 1e-12 * a.abs(), "{}: {a} {b}", preset.name);
        }
        assert_eq!(file.camera.sensor().size, again.camera.sensor().size);
        assert_eq!(file.camera.array().grid, again.camera.array().grid);
        assert_eq!(file.camera.main_lens().aperture, again.camera.main_lens().aperture);
        assert_eq!((again.name.as_str(), again.is_approximate), (preset.name, preset.is_approximate));
        assert_eq!(file.sensor_noise, again.sensor_noise);
        assert_eq!(file.sensor_noise.is_some(), preset.sensor.is_some());
    }
    let changed = "preset = \"lytro-illum\"\n[main_lens]\nf_number = 4.0\nfocus_m = inf";
    let changed = CameraFile::parse(changed, "mine").unwrap();
    assert_eq!((changed.name.as_str(), changed.is_approximate), ("lytro-illum", true));
    assert_eq!((changed.camera.main_lens().f_number, changed.camera.inverse_focus_per_m()), (4.0, 0.0));
}

#[test]
fn sensors_have_their_noise() {
    let with = |keys: &str| CameraFile::parse(&WHOLE.replacen("fill = 0.9", keys, 1), "").unwrap();
    assert_eq!(with("fill = 0.9").sensor_noise, None);
    let noise = with("model = \"imx250\"\nread_noise_e = 5.0\ncfa = \"mono\"").sensor_noise.unwrap();
    let imx250 = SensorPreset::by_name("imx250").unwrap().model;
    assert_eq!(noise.model, SensorModel { read_noise_e: 5.0, filter: ColorFilter::Mono, ..imx250 });
    // Without a model, a full well is the largest code.
    let own = with("cfa = \"GRBG\"\nbits = 10\nblack = 23.0\nfull_well_e = 2000.0\nelectrons_at_one = 1500.0");
    let noise = own.sensor_noise.unwrap();
    assert_eq!((noise.model.dn_per_e, noise.electrons_at_one), (0.5, ElectronsAtOne::Given(1500.0)));
    assert_eq!(CameraFile::parse(&own.to_toml(), "").unwrap().sensor_noise, own.sensor_noise);
    // 8.6 thousand electrons of the Illum at 1000 cd/m^2, 10 ms and half of the photons: pi L sin^2 of 10 um at 37 um.
    let illum = CameraFile::preset("lytro-illum").unwrap().camera;
    assert!((illum.photometric_electrons(1000.0, 0.01, 0.5) / 8572.0 - 1.0).abs() < 1e-3);
}

#[test]
fn mistakes_are_named_by_their_keys() {
    for (from, to, expected) in [
        ("pixel_um = 5.0", "pixle_um = 5.0", "did you mean pixel_um?"),
        ("pixel_um = 5.0", "", "sensor.pixel_um is missing"),
        ("pixel_um = 5.0", "pixel_um = -5.0", "sensor.pixel_um is -5"),
        ("pixel_um = 5.0", "pixel_um = \"5\"", "pixel_um"),
        ("size_px = [560, 420]", "size_px = [560]", "size_px"),
        ("size_px = [560, 420]", "size_px = [0, 420]", "sensor.size_px"),
        ("fill = 0.9", "fill = 1.9", "sensor.fill"),
        ("grid = \"square\"", "grid = \"hex\"", "hex-rows"),
        ("grid = \"square\"", "gird = \"square\"", "did you mean grid?"),
        ("focal_um = [400.0]", "focal_um = []", "mla.focal_um"),
        ("focal_um = [400.0]", "focal_um = \"pupils\"", "mla.focal_um"),
        ("focal_um = [400.0]", "focal_um = true", "mla.focal_um"),
        ("shape = \"square\"", "shape = \"star\"", "mla.aperture.shape"),
        ("width_um = 70.85", "width_um = 90.0", "mla.aperture.width_um"),
        ("aperture = \"round\"", "aperture = \"heptagon\"", "main_lens.aperture"),
        ("focus_m = 0.5", "focus_m = 0.0", "main_lens.focus_m"),
        ("focus_m = 0.5", "focus_m = 0.01", "main_lens.focus_m"),
        ("pitch_um = 70.85", "pitch_um = 1e-5", "mla"),
        ("f_number = 5.5", "f_number = 1e-4", "main_lens.f_number"),
        ("focus_m = 0.5", "focus_m = 0.5\nmla_distance_mm = 43.0", "give one of them"),
        ("focus_m = 0.5", "mla_distance_mm = 43.0\nfocus_virtual_depth = 2.0", "focus_virtual_depth"),
        ("fill = 0.9", "storage = \"sensor\"", "storage is not supported by this version"),
        ("fill = 0.9", "cfa = \"GRBG\"", "sensor.bits (or sensor.model) is missing"),
        ("fill = 0.9", "cfa = \"GRGB\"\nbits = 12\nfull_well_e = 1e4", "RGGB, GRBG"),
        ("fill = 0.9", "model = \"imx25\"", "did you mean imx250?"),
        ("fill = 0.9", "model = \"imx250\"\nprnu = -0.5", "photo response"),
        ("fill = 0.9", "model = \"imx250\"\nblack = 5000.0", "sensor: the black level"),
        ("fill = 0.9", "model = \"imx250\"\nelectrons_at_one = \"atuo\"", "sensor.electrons_at_one"),
        (
            "fill = 0.9",
            "model = \"imx250\"\nelectrons_at_one = { luminance_cd_m2 = 0.0, exposure_s = 1.0 }",
            "luminance_cd_m2",
        ),
        ("gap_um = 400.0", "gap_um = 400.0\ntilt_deg = [89.9, 0.0]", "mla.tilt_deg"),
        ("gap_um = 400.0", "gap_um = 400.0\ngaps = \"glass\"", "mla.gaps"),
        ("aperture = \"round\"", "aperture = { blades = 2 }", "main_lens.aperture.blades"),
        ("aperture = \"round\"", "aperture = { baldes = 7 }", "main_lens.aperture"),
        ("focus_m = 0.5", "focus_m = 0.5\nstops = [{ distance_mm = -1.0, diameter_mm = 3.0 }]", "main_lens.stops"),
        ("focus_m = 0.5", "focus_m = 0.5\ndistortion = { radial_m2 = [-1e9, 0.0, 0.0] }", "main_lens.distortion"),
        ("[sensor]", "preset = \"lytro-ilum\"\n[sensor]", "did you mean lytro-illum?"),
        ("[sensor]", "[senser]", "did you mean sensor?"),
    ] {
        let text = WHOLE.replacen(from, to, 1);
        assert_ne!(text, WHOLE, "{from}");
        let error = CameraFile::parse(&text, "").unwrap_err().to_string();
        assert!(error.contains(expected), "{to}: {error}");
    }
    let error = CameraFile::open("lytro-ilum").unwrap_err().to_string();
    assert!(error.contains("did you mean lytro-illum?") && error.contains("raytrix-r12-a"), "{error}");
}

/// Files with a changed, doubled or missing byte are read or give an error that names a key or a line.
#[test]
fn mutated_files_are_named_errors() {
    let keys = [
        "name",
        "preset",
        "sensor",
        "mla",
        "main_lens",
        "size_px",
        "pixel_um",
        "fill",
        "offset_um",
        "grid",
        "pitch_um",
        "scale_y",
        "rotation_deg",
        "gap_um",
        "focal_um",
        "aperture",
        "focal_mm",
        "f_number",
        "exit_pupil_mm",
        "focus_m",
    ];
    let mut state = 1u64;
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let mut errors = 0;
    for _ in 0..2000 {
        let mut bytes = WHOLE.as_bytes().to_vec();
        for _ in 0..1 + next(3) {
            let at = next(bytes.len());
            match next(4) {
                0 => drop(bytes.remove(at)),
                1 => bytes.insert(at, bytes[at]),
                2 => bytes[at] = b" .-e[]\"=#09ixn"[next(14)],
                _ => bytes.truncate(at.max(1)),
            }
        }
        let Ok(text) = String::from_utf8(bytes) else { continue };
        if let Err(error) = CameraFile::parse(&text, "") {
            let error = error.to_string();
            assert!(error.contains("line") || keys.iter().any(|key| error.contains(key)), "{text}\n{error}");
            errors += 1;
        }
    }
    assert!(errors > 500, "{errors}");
}
