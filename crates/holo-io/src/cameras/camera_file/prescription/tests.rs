use super::*;

const CAMGEN: &str = "radius;thickness;material;index;v-no;sa\n58.950;7.520;BAF10;1.670;47.1;25.2 \n169.660;0.240;air;;;25.2\n\
    38.550;8.050;BAF10;1.670;47.1;23.0\n81.540;6.550;SF15;1.699;30.1;23.0\n25.500;11.410;air;;;18.0\n;9.000;air;;;17.1\n\
    -28.990;2.360;F5;1.603;38.0;17.0\n81.540;12.130;LAK11;1.658;57.3;20.0\n-40.770;0.380;air;;;20.0\n\
    874.130;6.440;LAF3;1.717;48.0;20.0\n-79.460;72.228;air;;;20.0\n";

const PBRT: &str = "# D-GAUSS F/2\n50\n# radius axpos N aperture\n29.475 3.76 1.67 25.2\n84.83 0.12 1 25.2\n19.275 4.025 1.67 23\n\
    40.77 3.275 1.699 23\n12.75 5.705 1 18\n0 4.5 0 17.1\n-14.495 1.18 1.603 17\n40.77 6.065 1.658 20\n-20.385 0.19 1 20\n\
    437.065 3.22 1.717 20\n-39.73 0 1 20\n";

fn read(text: &str, name: &str) -> Result<Prescription, Error> {
    decoded(text.as_bytes(), Path::new(name))
}

/// Two public transcriptions of US 2,673,491, for CamGen and for pbrt (scaled by one half), are the objective `double-gauss`.
#[test]
fn transcriptions_of_the_double_gauss_agree() {
    let preset = Objective::by_name("double-gauss").unwrap().prescription().unwrap();
    let camgen = read(CAMGEN, "lens.csv").unwrap().scaled_to(preset.paraxial().focal_length_m).unwrap();
    let pbrt = read(PBRT, "lens.dat").unwrap().scaled_to(preset.paraxial().focal_length_m).unwrap();
    for lens in [&camgen, &pbrt] {
        assert_eq!(lens.surfaces().len(), preset.surfaces().len());
        for (found, expected) in lens.surfaces().iter().zip(&preset.surfaces()[..10]) {
            assert!((found.radius_m - expected.radius_m).abs() < 1e-15, "{found:?} {expected:?}");
            assert!((found.thickness_m - expected.thickness_m).abs() < 1e-15, "{found:?} {expected:?}");
            assert_eq!(found.medium.index(587.5618), expected.medium.index(587.5618));
            assert_eq!(found.is_stop, expected.is_stop);
        }
    }
    assert!((camgen.paraxial().f_number - preset.paraxial().f_number).abs() < 1e-12);
}

/// What is written is read again, in a file of its own, in a camera file and beside one.
#[test]
fn written_prescriptions_are_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let mut surfaces = read(CAMGEN, "lens.csv").unwrap().surfaces().to_vec();
    surfaces[0].medium = glass("n-bk7").unwrap();
    surfaces[1].conic = -0.5;
    surfaces[1].aspheric = vec![0.0, 2e3];
    let lens = Prescription::new(surfaces).unwrap();
    let text = surface_lines(lens.surfaces(), "surface");
    std::fs::write(folder.path().join("lens.toml"), &text).unwrap();
    let again = read_prescription(folder.path().join("lens.toml").to_str().unwrap()).unwrap();
    assert_eq!(again, lens, "{text}");
    let camera = |main_lens: &str| {
        format!(
            "[sensor]\nsize_px = [90, 60]\npixel_um = 10.0\n[mla]\ngrid = \"square\"\npitch_um = 100.0\ngap_um = 400.0\n[main_lens]\nfocus_m = 2.0\n{main_lens}"
        )
    };
    let path = folder.path().join("camera.toml");
    std::fs::write(&path, camera("prescription = \"lens.toml\"\nscale_to_focal_mm = 40.0\nclose_to_f_number = 4.0\n"))
        .unwrap();
    let file = super::super::CameraFile::read(&path).unwrap();
    let found = file.camera.main_lens();
    assert!((found.focal_length_m - 0.04).abs() < 1e-15 && (found.f_number - 4.0).abs() < 1e-12);
    let text = file.to_toml();
    assert!(!text.contains("focal_mm") && text.contains("[[main_lens.surface]]"), "{text}");
    let again = super::super::CameraFile::parse(&text, "").unwrap();
    assert_eq!(again.to_toml(), text);
    // Lengths scaled by a quotient have all digits of an f64 in millimeters, not in meters.
    assert!((again.camera.mla_distance_m() - file.camera.mla_distance_m()).abs() < 1e-15);
    let open = Folder::open(folder.path()).unwrap();
    assert_eq!(super::super::CameraFile::read_in(&open, "camera.toml").unwrap().camera, file.camera);
    let closed = file.with_f_number(8.0).unwrap();
    assert!((closed.camera.main_lens().f_number - 8.0).abs() < 1e-12);
    assert!(closed.with_f_number(1.0).unwrap_err().to_string().contains("open lens"));
}

/// A group of surfaces focuses: the array stays as far from the front of the lens, in every way of focusing it.
#[test]
fn groups_of_surfaces_focus() {
    let of = |focus_m: f64| {
        let text = format!(
            "[sensor]\nsize_px = [90, 60]\npixel_um = 10.0\n[mla]\ngrid = \"square\"\npitch_um = 100.0\ngap_um = 400.0\n\
             [main_lens]\nprescription = \"telephoto\"\nfocus_group = [8, 11]\nfocus_m = {focus_m:?}\n"
        );
        super::super::CameraFile::parse(&text, "").unwrap()
    };
    let [near, far] = [of(4.0), of(f64::INFINITY)];
    let front_m = |file: &super::super::CameraFile| {
        let paraxial = *file.camera.main_lens().prescription.as_ref().unwrap().paraxial();
        file.camera.mla_distance_m() + paraxial.rear_principal_m + paraxial.length_m
    };
    assert!((front_m(&near) - front_m(&far)).abs() < 1e-12);
    assert!((near.camera.inverse_focus_per_m() - 0.25).abs() < 1e-9);
    assert!(near.camera.main_lens().focal_length_m < 0.97 * far.camera.main_lens().focal_length_m);
    assert_eq!(far.clone().with_focus_m(4.0).unwrap().camera, near.camera);
    assert_eq!(near.clone().with_focus_m(f64::INFINITY).unwrap().camera, far.camera);
    assert!(near.clone().with_focus_m(0.3).unwrap_err().to_string().contains("focus_group"));
    let text = near.to_toml();
    let again = super::super::CameraFile::parse(&text, "").unwrap();
    assert!(text.contains("focus_group = [8, 11]\n") && again.to_toml() == text, "{text}");
    let closed = near.with_f_number(8.0).unwrap();
    assert!((closed.camera.main_lens().f_number - 8.0).abs() < 1e-12);
    let wide = closed.with_focus_m(4.0).unwrap();
    assert!((wide.camera.main_lens().f_number - 8.0).abs() < 1e-12);
}

/// Files that a camera file of a stranger names lie beside it, and wrong ones are named.
#[test]
fn bad_prescriptions_name_the_place() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("sub")).unwrap();
    std::fs::write(folder.path().join("lens.csv"), CAMGEN).unwrap();
    let camera = |main_lens: &str| {
        let text = format!(
            "[sensor]\nsize_px = [90, 60]\npixel_um = 10.0\n[mla]\ngrid = \"square\"\npitch_um = 100.0\ngap_um = 400.0\n[main_lens]\nfocus_m = 2.0\n{main_lens}"
        );
        std::fs::write(folder.path().join("sub/camera.toml"), text).unwrap();
        super::super::CameraFile::read(folder.path().join("sub/camera.toml"))
    };
    for (lens, what) in [
        ("prescription = \"../lens.csv\"", "below it"),
        ("prescription = \"/etc/lens.csv\"", "below it"),
        ("prescription = \"missing.csv\"", "missing.csv"),
        ("prescription = \"double-gaus\"", "did you mean double-gauss"),
        ("prescription = \"camera.txt\"", "camera.txt"),
        ("prescription = \"tessar\"\nfocal_mm = 3.0", "focal_mm follows from the prescription"),
        ("prescription = \"tessar\"\nclose_to_f_number = 1.0", "close_to_f_number"),
        ("prescription = \"tessar\"\nscale_to_focal_mm = -1.0", "scale_to_focal_mm"),
        ("prescription = \"tessar\"\n[[main_lens.surface]]\nradius_mm = 1.0", "give one of them"),
        ("[[main_lens.surface]]\nradius_mm = 1.0", "surface 1: semi_aperture_mm"),
        ("[[main_lens.surface]]\nsemi_aperture_mm = 1.0\nmaterial = \"N-BK77\"", "did you mean N-BK7"),
        ("[[main_lens.surface]]\nsemi_aperture_mm = 1.0\nradius = 2.0", "radius_mm"),
        ("scale_to_focal_mm = 50.0\nfocal_mm = 3.0\nf_number = 2.0", "belongs to a prescription"),
        ("focus_group = [1, 2]\nfocal_mm = 3.0\nf_number = 2.0", "belongs to a prescription"),
        ("prescription = \"telephoto\"\nfocus_group = [0, 2]", "of 1 to 11"),
        ("prescription = \"telephoto\"\nfocus_group = [3, 30]", "of 1 to 11"),
        ("prescription = \"telephoto\"\nfocus_group = [9, 11]", "as a whole"),
    ] {
        let error = camera(lens).expect_err(lens).to_string();
        assert!(error.contains(what), "{lens}: {error}");
    }
    for (name, text, what) in [
        ("lens.csv", CAMGEN.replace("8.050", "8,050"), "line 4"),
        ("lens.csv", CAMGEN.replace(";38.0;", ";"), "line 8"),
        ("lens.dat", PBRT.replace("4.025", "x"), "line 6"),
        ("lens.txt", PBRT.to_owned(), "ends neither in"),
        (
            "lens.toml",
            "[[surface]]\nnd = 1.5\nmaterial = \"F2\"\nsemi_aperture_mm = 1.0".to_owned(),
            "give one of them",
        ),
        ("lens.json", "{\"surfaces\": [{\"type\": \"Cubic\", \"r\": 1, \"mat2\": \"air\"}]}".to_owned(), "Cubic"),
        ("lens.zmx", "MODE NSC".to_owned(), "line 1"),
        ("lens.zmx", String::new(), "no surfaces"),
    ] {
        let error = read(&text, name).expect_err(&text).to_string();
        assert!(error.contains(what), "{name}: {error}");
    }
}

const ZEMAX: &str = "VERS 1\nMODE SEQ\nUNIT MM X W X CM MR CPMM\nSURF 0\n  TYPE STANDARD\n  DISZ INFINITY\nSURF 1\n  STOP\n  TYPE EVENASPH\n  CURV 2.0E-2 0 0\n\
      PARM 1 0\n  PARM 2 1.0E-6\n  DISZ 5\n  GLAS N-BK7 0 0 1.5168 64.17 0\n  CONI -0.3\n  DIAM 10 1 0\nSURF 2\n  TYPE STANDARD\n  CURV -0.01\n  DISZ 60\n  DIAM 10 1\n\
    SURF 3\n  TYPE STANDARD\n  CURV 0\n  DISZ 0\n  DIAM 5\n";

const DEEPLENS: &str = r#"{"info": "x", "surfaces": [
    {"type": "Aspheric", "r": 10.0, "roc": 50.0, "d": 0.0, "k": -0.3, "ai": [0.0, 1e-6], "mat2": "1.5168/64.17", "d_next": 5.0},
    {"type": "Spheric", "r": 10.0, "c": -0.01, "d": 5.0, "mat2": "air"},
    {"type": "Aperture", "r": 10.0, "d": 5.0, "mat2": "air", "d_next": 40.0}]}"#;

#[test]
fn other_programs_prescriptions_are_read() {
    let utf16: Vec<u8> = [0xff, 0xfe].into_iter().chain(ZEMAX.encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let zemax = read(ZEMAX, "lens.zmx").unwrap();
    assert_eq!(decoded(&utf16, Path::new("lens.ZMX")).unwrap(), zemax);
    let inches = read(&ZEMAX.replace("UNIT MM", "UNIT IN"), "lens.zmx").unwrap();
    assert!((inches.paraxial().focal_length_m / zemax.paraxial().focal_length_m - 25.4).abs() < 1e-9);
    let deeplens = read(DEEPLENS, "lens.json").unwrap();
    for lens in [&zemax, &deeplens] {
        let front = &lens.surfaces()[0];
        assert!((front.radius_m - 0.05).abs() < 1e-15 && front.conic == -0.3 && front.thickness_m == 0.005);
        // 1e-6 / mm^3 is 1000 / m^3.
        assert!(front.aspheric.len() == 1 && (front.aspheric[0] - 1e3).abs() < 1e-9, "{front:?}");
        assert_eq!(front.semi_aperture_m, 0.01);
    }
    assert_eq!(zemax.surfaces()[0].medium, glass("N-BK7").unwrap());
    // A glass of no catalog is what its numbers say; without them it is named.
    let medium = |glass: &str| read(&ZEMAX.replace("GLAS N-BK7 0 0 1.5168 64.17", glass), "lens.zmx");
    let of_numbers = medium("GLAS NO-GLASS 0 0 1.62 36.4").unwrap().surfaces()[0].medium;
    assert_eq!(of_numbers, Medium::Abbe { nd: 1.62, vd: Some(36.4) });
    assert!(medium("GLAS NO-GLASS 0 0 0 0").unwrap_err().to_string().contains("NO-GLASS"));
    assert!((zemax.paraxial().focal_length_m - deeplens.paraxial().focal_length_m).abs() < 1e-6);
    assert!(zemax.surfaces()[0].is_stop && deeplens.surfaces()[2].is_stop);
}

/// Five hundred mutated files are lenses or errors.
#[test]
fn mutated_prescriptions_do_not_panic() {
    let toml = surface_lines(read(CAMGEN, "lens.csv").unwrap().surfaces(), "surface");
    let (mut lenses, mut errors, mut state) = (0, 0, 1u64);
    let mut next = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    for k in 0..500 {
        let (text, name) =
            [(CAMGEN, "a.csv"), (PBRT, "a.dat"), (ZEMAX, "a.zmx"), (DEEPLENS, "a.json"), (&toml, "a.toml")][k % 5];
        let mut bytes = text.as_bytes().to_vec();
        for _ in 0..1 + next(4) {
            let at = next(bytes.len());
            match next(4) {
                0 => bytes[at] = b"0123456789.-eE;, \n\xff"[next(19)],
                1 => bytes.truncate(at.max(1)),
                2 => bytes.insert(at, b"0123456789.-eE;"[next(15)]),
                _ => {
                    bytes.remove(at);
                }
            }
            if bytes.is_empty() {
                bytes.push(b'1');
            }
        }
        match decoded(&bytes, Path::new(name)) {
            Ok(lens) => {
                lenses += 1;
                // What was read can be written, and traced in a camera or is refused.
                let camera = format!(
                    "[sensor]\nsize_px = [900, 600]\npixel_um = 10.0\n[mla]\ngrid = \"square\"\npitch_um = 100.0\ngap_um = 400.0\n[main_lens]\nfocus_m = 2.0\n{}",
                    surface_lines(lens.surfaces(), "main_lens.surface")
                );
                if let Ok(file) = super::super::CameraFile::parse(&camera, "") {
                    let corner = file.camera.place_m([3.0, 5.0]);
                    let owner = file.camera.owner(corner);
                    let ray = file.camera.ray(corner, file.camera.lens_center_m(owner), owner);
                    assert!(ray.is_none_or(|ray| ray.origin_m.iter().chain(&ray.direction).all(|x| x.is_finite())));
                }
            }
            Err(error) => {
                errors += 1;
                assert!(error.to_string().len() > 20);
            }
        }
    }
    assert!(lenses > 50 && errors > 50, "{lenses} {errors}");
}
