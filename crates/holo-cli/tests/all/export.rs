//! `holo export`: what it writes has the values, names and orders that its readers' own code expects.

use crate::common::{Bench, SCENE, ok, read_u8};
use holo_core::LightFieldOwned;
use holo_io::{LightFieldReader, Limits, ReadOptions};

fn json(bench: &Bench, name: &str) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(bench.path(name)).unwrap()).unwrap()
}

/// The lines of `transforms.json` for cameras in a row.
fn cameras_in_a_row(count: usize) -> String {
    let frame = |k: usize| {
        let x = 0.1 * k as f64;
        format!(r#"{{"file_path":"images/v{k}.png","transform_matrix":[[1,0,0,{x}],[0,1,0,0],[0,0,1,2],[0,0,0,1]]}}"#)
    };
    let frames: Vec<String> = (0..count).map(frame).collect();
    format!(r#"{{"fl_x":20,"w":16,"h":12,"frames":[{}]}}"#, frames.join(","))
}

/// A folder of 9 x 9 views of 16 x 12 px, and its codes.
fn rendered(bench: &Bench) -> LightFieldOwned<u8> {
    ok(bench.run(&format!("render {SCENE} --out lf --views 9 --lenses 16x12 --disparity -1,1 --spp 1 --quiet")));
    match LightFieldReader::open(bench.path("lf"), &ReadOptions::default()).unwrap().read().unwrap().light_field {
        holo_core::DynLightField::U8(field) => field,
        other => panic!("{:?}", other.kind()),
    }
}

#[test]
fn hci_folders_have_views_truth_and_mask() {
    let bench = Bench::new();
    let field = rendered(&bench);
    let said = ok(bench.run("export lf --for hci --out out"));
    assert!(said.stderr.contains("512 x 512"), "{said:?}");
    // Nothing but the scene lies in the group.
    assert!(bench.list("out/training").iter().all(|name| name.starts_with("lf/")));
    for (k, (t, s)) in [(0, (0, 0)), (40, (4, 4)), (74, (8, 2))] {
        let view = read_u8(bench.path(format!("out/training/lf/input_Cam{k:03}.png")));
        assert_eq!(view, field.view(t, s).unwrap());
    }
    let truth = holo_io::read_pfm_gray(bench.path("lf/scene_disparity.pfm"), &Limits::default()).unwrap();
    let found = holo_io::read_pfm_gray(bench.path("out/training/lf/gt_disp_lowres.pfm"), &Limits::default()).unwrap();
    assert_eq!(found, truth);
    let (hits, mask) =
        (read_u8(bench.path("lf/scene_hit_mask.png")), read_u8(bench.path("out/training/lf/valid_mask.png")));
    assert_eq!(mask.dim(), (12, 16, 3));
    assert!(mask.indexed_iter().all(|((v, u, _), code)| *code == hits[[v, u, 0]]));
}

#[test]
fn arrays_have_views_first() {
    let bench = Bench::new();
    let field = rendered(&bench);
    ok(bench.run("export lf --for npy --out npy"));
    let bytes = std::fs::read(bench.path("npy/lf.npy")).unwrap();
    let length = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let header = std::str::from_utf8(&bytes[10..length]).unwrap();
    assert!(header.contains("'shape': (9, 9, 12, 16, 3,)") && header.ends_with('\n') && length % 64 == 0, "{header}");
    let expected: Vec<u8> = field.samples().permuted_axes([2, 3, 0, 1, 4]).iter().copied().collect();
    assert_eq!(bytes[length..], expected);

    ok(bench.run("export lf --for jpeg-pleno --out ppm"));
    let view = std::fs::read(bench.path("ppm/lf/002_007.ppm")).unwrap();
    let pixels = view.strip_prefix(b"P6\n16 12\n255\n").unwrap();
    assert_eq!(pixels, field.view(2, 7).unwrap().iter().copied().collect::<Vec<u8>>());
    assert_eq!(bench.list("ppm").iter().filter(|name| name.ends_with(".ppm")).count(), 81);
    // Names have three digits.
    ok(bench.run(&format!("render {SCENE} --out many --views 1001x1 --lenses 1x1 --spp 1 --write mat --quiet")));
    let refused = bench.run("export many --for jpeg-pleno --out none");
    assert!(refused.code == Some(2) && refused.stderr.contains("three digits"), "{refused:?}");

    ok(bench.run("export lf --for basiclfsr --out sr --group EPFL"));
    let path = bench.path("sr/datasets/EPFL/training/lf.mat");
    let info = holo_io::read_mat_info(&path).unwrap();
    let variable = info.iter().find(|variable| variable.name == "LF").unwrap();
    assert_eq!((&variable.size[..], variable.class.name()), (&[9, 9, 12, 16, 3][..], "single"));
    let read = LightFieldReader::open(&path, &ReadOptions::default()).unwrap().read().unwrap().light_field;
    let read = read.into_f32().unwrap();
    assert!(read.samples().iter().zip(field.samples()).all(|(value, code)| *value == f32::from(*code) / 255.0));
}

#[test]
fn views_of_other_readers_have_their_names() {
    let bench = Bench::new();
    let field = rendered(&bench);
    // Rows are counted from below; our own reader of these folders turns them.
    ok(bench.run("export lf --for stanford --out gantry"));
    let read = LightFieldReader::open(bench.path("gantry/lf"), &ReadOptions::default()).unwrap().read().unwrap();
    assert_eq!(read.light_field, field.clone().into());
    let rig = LightFieldReader::open(bench.path("lf"), &ReadOptions::default()).unwrap().rig().copied().unwrap();
    let name = format!("lf/out_08_02_{:.6}_{:.6}_.png", 1e3 * rig.view_y_m(0), 1e3 * rig.view_x_m(2));
    assert!(bench.list("gantry").contains(&name), "{name}: {:?}", bench.list("gantry"));

    let said = ok(bench.run("export lf --for urbanlf --out urban"));
    assert!(said.stderr.contains("640 x 480"), "{said:?}");
    assert_eq!(read_u8(bench.path("urban/UrbanLF_Syn/Image1/1_9.png")), field.view(0, 8).unwrap());
    let disparity = std::fs::read(bench.path("urban/UrbanLF_Syn/Image1/5_5_disparity.npy")).unwrap();
    let truth = holo_io::read_pfm_gray(bench.path("lf/scene_disparity.pfm"), &Limits::default()).unwrap();
    assert!(disparity.ends_with(&truth.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>()));

    ok(bench.run("export lf --for plenpy-lf --out plenpy"));
    let read = LightFieldReader::open(bench.path("plenpy/lf.mat"), &ReadOptions::default()).unwrap().read().unwrap();
    assert_eq!(read.light_field, field.into());
}

/// Two of three cameras are for training; points lie where their pixels see the scene.
#[test]
fn pinhole_cameras_are_exported_for_radiance_fields() {
    let bench = Bench::new();
    std::fs::write(bench.path("cameras.json"), cameras_in_a_row(3)).unwrap();
    let line = format!("render {SCENE} --transforms cameras.json --transforms-up y --out posed --spp 1 --quiet");
    ok(bench.run(&line));
    // The render also wrote a mask of what each camera hits.
    for k in 0..3 {
        let depth = holo_io::read_pfm_gray(bench.path(format!("posed/depth/v{k}.pfm")), &Limits::default()).unwrap();
        let mask = read_u8(bench.path(format!("posed/hit_mask/v{k}.png")));
        assert!(depth.indexed_iter().all(|((v, u), z)| (mask[[v, u, 0]] == 255) == z.is_finite()));
    }
    ok(bench.run("export posed --for nerf --out nerf"));
    let json = |name: &str| json(&bench, name);
    let (train, test) = (json("nerf/transforms_train.json"), json("nerf/transforms_test.json"));
    let angle = train["camera_angle_x"].as_f64().unwrap();
    assert!(
        (angle - 2.0 * (16.0_f64 / 40.0).atan()).abs() < 1e-12 && test["camera_angle_x"] == train["camera_angle_x"]
    );
    let names = |list: &serde_json::Value| -> Vec<String> {
        list["frames"].as_array().unwrap().iter().map(|frame| frame["file_path"].as_str().unwrap().into()).collect()
    };
    assert_eq!(
        (names(&train), names(&test)),
        (vec!["./images/v1".into(), "./images/v2".into()], vec!["./images/v0".into()])
    );
    assert_eq!(train["frames"][1]["transform_matrix"][0], serde_json::json!([1.0, 0.0, 0.0, 0.2]));
    assert_eq!(read_u8(bench.path("nerf/images/v2.png")), read_u8(bench.path("posed/images/v2.png")));
    // Every point is at the depth of its pixel: seen from the first camera along -Z, at the place of the pixel.
    let bytes = std::fs::read(bench.path("nerf/points3d.ply")).unwrap();
    let at = bytes.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let depth = holo_io::read_pfm_gray(bench.path("posed/depth/v0.pfm"), &Limits::default()).unwrap();
    let colors = read_u8(bench.path("posed/images/v0.png"));
    let hit = depth.indexed_iter().filter(|(_, z)| z.is_finite());
    let mut count = 0;
    for (((v, u), z), point) in hit.zip(bytes[at..].chunks_exact(27)) {
        let number = |k: usize| f32::from_le_bytes(point[4 * k..4 * k + 4].try_into().unwrap());
        let [x, y] = [(u as f32 + 0.5 - 8.0) / 20.0 * z, (6.0 - v as f32 - 0.5) / 20.0 * z];
        assert!((number(0) - x).abs() < 1e-5 && (number(1) - y).abs() < 1e-5 && (number(2) - (2.0 - z)).abs() < 1e-5);
        assert_eq!(point[24..27], [0, 1, 2].map(|c| colors[[v, u, c]]));
        count += 1;
    }
    assert!(count > 0);

    ok(bench.run("export posed --for nerfstudio --out studio"));
    let (list, own) = (json("studio/transforms.json"), json("posed/transforms.json"));
    assert_eq!((&list["frames"], &list["ply_file_path"]), (&own["frames"], &"points3d.ply".into()));
    for (arguments, code, words) in [
        ("export posed --for nerf --views 9 --out two", 2, "light fields"),
        ("export posed --for nerf --group training --out two", 2, "hci, hci-toolkit, basiclfsr"),
        ("export cameras.json --for nerf --out two", 1, "cameras.json"),
    ] {
        let refused = bench.run(arguments);
        assert!(refused.code == Some(code) && refused.stderr.contains(words), "{arguments}: {refused:?}");
    }
    assert!(!bench.path("two").exists());
}

/// Views are pinhole cameras whose principal points keep the focus plane in place; a focus at infinity leaves them in the middle.
#[test]
fn views_are_exported_for_radiance_fields() {
    let bench = Bench::new();
    let field = rendered(&bench);
    let refused = bench.run("export lf --for nerf --out nerf");
    assert!(refused.code == Some(2) && refused.stderr.contains("focus-m inf"), "{refused:?}");
    assert!(!bench.path("nerf").exists());
    ok(bench.run("export lf --for nerfstudio --out studio"));
    let json = |name: &str| json(&bench, name);
    let list = json("studio/transforms.json");
    let frames = list["frames"].as_array().unwrap();
    assert_eq!((frames.len(), &list["ply_file_path"]), (81, &"points3d.ply".into()));
    let rig = LightFieldReader::open(bench.path("lf"), &ReadOptions::default()).unwrap().rig().copied().unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    for (t, s) in [(0, 0), (2, 7), (4, 4), (8, 3)] {
        let frame = &frames[9 * t + s];
        let name = format!("images/{t:03}_{s:03}.png");
        assert_eq!(frame["file_path"], name.as_str());
        assert_eq!(read_u8(bench.path(format!("studio/{name}"))), field.view(t, s).unwrap());
        // As nerfstudio projects: the camera looks along its -Z, and rows run down.
        let position = [0, 1, 2].map(|row| number(&frame["transform_matrix"][row][3]));
        for point in [[0.1, -0.2, -2.0], [-0.4, 0.3, -7.0]] {
            let [x, y, z] = [0, 1, 2].map(|k| point[k] - position[k]);
            let column = number(&frame["cx"]) + number(&frame["fl_x"]) * x / -z;
            let row = number(&frame["cy"]) - number(&frame["fl_y"]) * y / -z;
            let (own_row, own_column) = rig.project(point, t, s).unwrap();
            assert!((row - own_row).abs() < 1e-9 && (column - own_column).abs() < 1e-9, "{t} {s}");
        }
    }
    // Points have the depth of pixels of the central view.
    let bytes = std::fs::read(bench.path("studio/points3d.ply")).unwrap();
    let at = bytes.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let depth = holo_io::read_pfm_gray(bench.path("lf/scene_depth.pfm"), &Limits::default()).unwrap();
    let hit: Vec<_> = depth.indexed_iter().filter(|(_, z)| z.is_finite()).collect();
    assert!(!hit.is_empty() && bytes.len() - at == 27 * hit.len());
    for (((v, u), z), point) in hit.into_iter().zip(bytes[at..].chunks_exact(27)) {
        let place = [0, 1, 2].map(|k| f64::from(f32::from_le_bytes(point[4 * k..4 * k + 4].try_into().unwrap())));
        let (row, column) = rig.project(place, 4, 4).unwrap();
        assert!((row - v as f64 - 0.5).abs() < 1e-4 && (column - u as f64 - 0.5).abs() < 1e-4);
        assert!((place[2] + f64::from(*z)).abs() < 1e-6 * place[2].abs());
    }

    ok(bench.run(&format!(
        "render {SCENE} --out far --views 3x2 --lenses 16x12 --focus-m inf --baseline-m 0.01 --spp 1 --quiet"
    )));
    ok(bench.run("export far --for nerf --out nerf"));
    let (train, test) = (json("nerf/transforms_train.json"), json("nerf/transforms_test.json"));
    assert_eq!((train["frames"].as_array().unwrap().len(), test["frames"].as_array().unwrap().len()), (5, 1));
    assert_eq!(train["frames"][0]["file_path"], "./images/000_001");
}

/// Every pose of a folder is a light field, and a scene of an export.
#[test]
fn light_fields_of_several_poses_are_exported_by_their_names() {
    let bench = Bench::new();
    std::fs::write(bench.path("cameras.json"), cameras_in_a_row(2)).unwrap();
    ok(bench.run(&format!(
        "render {SCENE} --transforms cameras.json --transforms-up y --views 3 --lenses 16x12 --disparity -1,1 --spp 1 --out poses \
         --quiet"
    )));
    ok(bench.run("export poses --for npy --out npy"));
    assert_eq!(bench.list("npy"), ["README.txt", "v0.npy", "v0_disparity.npy", "v1.npy", "v1_disparity.npy"]);
    ok(bench.run("export poses/v1 --for npy --out one"));
    let read = |name: &str| std::fs::read(bench.path(name)).unwrap();
    assert_eq!(read("npy/v1.npy"), read("one/v1.npy"));
    assert_ne!(read("npy/v1.npy"), read("npy/v0.npy"));
    ok(bench.run("export poses --for nerfstudio --out studio"));
    for pose in ["v0", "v1"] {
        assert_eq!(json(&bench, &format!("studio/{pose}/transforms.json"))["frames"].as_array().unwrap().len(), 9);
    }
}

/// The toolkit's truth of high resolution and masks, and truth of all views where it was rendered.
#[test]
fn the_toolkit_of_the_benchmark_gets_masks_and_truth_of_high_resolution() {
    let bench = Bench::new();
    let field = rendered(&bench);
    let refused = bench.run("export lf --for hci-toolkit --out out");
    assert!(refused.code == Some(2) && refused.stderr.contains("hci-highres"), "{refused:?}");
    ok(bench.run(&format!(
        "render {SCENE} --out all --views 9 --lenses 16x12 --disparity -1,1 --spp 1 --quiet --write hci-highres,masks,el \
         --ground-truth all"
    )));
    ok(bench.run("export all --for hci-toolkit --out out --group stratified --names all=boxes"));
    let scene = "out/data/stratified/boxes";
    let map = |name: &str| holo_io::read_pfm_gray(bench.path(name), &Limits::default()).unwrap();
    assert_eq!(map(&format!("{scene}/gt_disp_highres.pfm")), map("all/hci/gt_disp_highres.pfm"));
    assert_eq!(map(&format!("{scene}/gt_disp_highres.pfm")).dim(), (120, 160));
    for k in [0, 17, 80] {
        let name = format!("gt_disp_lowres_Cam{k:03}.pfm");
        assert_eq!(map(&format!("{scene}/{name}")), map(&format!("all/hci/{name}")));
    }
    assert_eq!(read_u8(bench.path(format!("{scene}/input_Cam013.png"))), field.view(1, 4).unwrap());
    let text = std::fs::read_to_string(bench.path(format!("{scene}/parameters.cfg"))).unwrap();
    for line in ["category = stratified", "scene = boxes", "depth_map_scale = 10"] {
        assert!(text.contains(line), "{text}");
    }
    for (ours, theirs) in [("discontinuity", "mask_discontinuities"), ("plane", "mask_planes"), ("fine", "mask_fine")] {
        let own = read_u8(bench.path(format!("all/masks/{ours}.png")));
        assert_eq!(read_u8(bench.path(format!("{scene}/{theirs}_lowres.png"))), own);
        let large = read_u8(bench.path(format!("{scene}/{theirs}_highres.png")));
        assert!(large.indexed_iter().all(|((v, u, c), &code)| code == own[[v / 10, u / 10, c]]), "{theirs}");
    }
    assert!(bench.path("out/algo_results/method/runtimes").is_dir());
    // EPINET leaves three scenes out where surfaces mirror light or let it pass.
    ok(bench.run("export all --for hci --out extra --group additional --names all=kitchen"));
    let area = read_u8(bench.path("extra/additional_invalid_area/kitchen/input_Cam040_invalid_ver2.png"));
    assert_eq!(area.dim(), (12, 16, 4));
    let [mirrors, passes] =
        ["reflective", "transparent"].map(|name| read_u8(bench.path(format!("all/masks/{name}.png"))));
    assert!(area.indexed_iter().all(|((v, u, _), &code)| code == mirrors[[v, u, 0]].max(passes[[v, u, 0]])));
    // An estimate is scored in either resolution.
    ok(bench.run(&format!("depth {scene} --out estimate.pfm --runtime seconds.txt --quiet")));
    let seconds: f64 = std::fs::read_to_string(bench.path("seconds.txt")).unwrap().trim().parse().unwrap();
    assert!(seconds >= 0.0);
    let scores = |truth: &str| -> serde_json::Value {
        let line = format!("eval estimate.pfm {scene}/{truth} --mask none --border 2 --json");
        serde_json::from_str(&ok(bench.run(&line)).stdout).unwrap()
    };
    let (low, high) = (scores("gt_disp_lowres.pfm"), scores("gt_disp_highres.pfm"));
    assert_eq!((&low["border_px"], &high["border_px"]), (&2.into(), &20.into()));
    for scores in [low, high] {
        assert!(scores["discontinuity_bad_pixels_0.07_percent"].is_number(), "{scores}");
        assert!(scores["plane_bumpiness"].is_number(), "{scores}");
    }
}

/// The truth has no fault, and an estimate that is too near has its share of them.
#[test]
fn stratified_scenes_have_scores_of_their_own() {
    let bench = Bench::new();
    ok(bench.run(
        "dataset --out four --scenes stratified --views 3 --lenses 128x128 --disparity -1.5,1.5 --write depth,disparity,masks --quiet",
    ));
    // By how many pixels the estimate is too near: the spikes are up to 2.5 px before the background.
    type Scores = &'static [(&'static str, f64)];
    let known: [(&str, f32, Scores); 4] = [
        ("backgammon", 3.0, &[("spikes_thinning_percent", 0.0), ("spikes_fattening_percent", 100.0)]),
        ("dots", 1.0, &[("boxes_mean_squared_error_x100", 100.0), ("missed_dots_percent", 100.0)]),
        ("pyramids", 1.0, &[("relief_bumpiness", 0.0), ("base_bumpiness", 0.0)]),
        (
            "stripes",
            1.0,
            &[("dark_stripes_bad_pixels_0.07_percent", 100.0), ("bright_stripes_bad_pixels_0.07_percent", 100.0)],
        ),
    ];
    for (scene, near_px, known) in known {
        let map = format!("four/{scene}/3x3/scene_disparity.pfm");
        let truth = holo_io::read_pfm_gray(bench.path(&map), &Limits::default()).unwrap();
        holo_io::write_pfm(bench.path("near.pfm"), truth.mapv(|d| d + near_px).view()).unwrap();
        let scores = |estimate: &str| -> serde_json::Value {
            serde_json::from_str(&ok(bench.run(&format!("eval {estimate} {map} --json"))).stdout).unwrap()
        };
        let (own, near) = (scores(&map), scores("near.pfm"));
        for (key, expected) in known {
            assert_eq!(own[key], 0.0, "{scene}: {own}");
            let found = near[key].as_f64().unwrap_or(f64::NAN);
            // Disparities are f32.
            assert!((found - expected).abs() < 1e-3, "{scene}: {key} is {found}");
        }
    }
}

/// All light fields of a dataset lie in one array.
#[cfg(feature = "hdf5")]
#[test]
fn light_fields_are_joined_for_lfasr() {
    let bench = Bench::new();
    let line = "dataset --out set --scenes plaster,fence --views 3 --lenses 12x10 --spp 1 --write el --quiet";
    ok(bench.run(line));
    ok(bench.run("export set --for lfasr --out out"));
    let files = bench.list("out");
    assert_eq!(files, ["README.txt", "test.h5", "train.h5"]);
    let bytes = std::fs::read(bench.path("out/test.h5")).unwrap();
    // Without compression the values lie in the file as they are: those of both scenes, one after the other.
    let field = |scene: &str| {
        let path = bench.path(format!("set/{scene}/3x3"));
        LightFieldReader::open(path, &ReadOptions::default()).unwrap().read().unwrap().light_field
    };
    let mut expected: Vec<u8> = Vec::new();
    for scene in ["plaster", "fence"] {
        let holo_core::DynLightField::U8(field) = field(scene) else { panic!("codes") };
        let samples = field.samples().permuted_axes([2, 3, 0, 1, 4]);
        for rgb in samples.lanes(ndarray::Axis(4)) {
            for row in
                [[65.481, 128.553, 24.966, 16.0], [-37.797, -74.203, 112.0, 128.0], [112.0, -93.786, -18.214, 128.0]]
            {
                let sum: f64 = (0..3).map(|c| row[c] * f64::from(rgb[c])).sum();
                expected.push((sum / 255.0 + row[3]).round() as u8);
            }
        }
    }
    assert!(bytes.windows(expected.len()).any(|part| part == expected));
    assert_eq!(expected.len(), 2 * 9 * 120 * 3);
    for (arguments, words) in [
        ("export set --for lfasr --out two --names chess=boxes", "no scene chess"),
        ("export set --for lfasr --out two --names plaster=fence", "two scenes"),
        ("export set --for lfasr --out two --names plaster=a/b", "no name of a folder"),
        ("export set --for lfasr --out two --names plaster", "OURS=THEIRS"),
    ] {
        let refused = bench.run(arguments);
        assert!(refused.code == Some(2) && refused.stderr.contains(words), "{arguments}: {refused:?}");
    }
    assert!(!bench.path("two").exists());
}

#[test]
fn datasets_are_exported_whole_and_wrong_use_is_refused() {
    let bench = Bench::new();
    let line = format!("dataset --out set --scenes plaster --glb {SCENE} --views 9,2 --sensor 144x108 --spp 1 --quiet");
    ok(bench.run(&line));
    let refused = bench.run("export set --for hci --out out");
    assert!(refused.code == Some(2) && refused.stderr.contains("9x9, 2x2"), "{refused:?}");
    assert!(!bench.path("out").exists());
    let said = ok(bench.run("export set --for hci --views 9 --out out --group test"));
    assert!(said.stderr.contains("2 light fields"), "{said:?}");
    for scene in ["plaster", "tiny"] {
        assert!(bench.path(format!("out/test/{scene}/input_Cam080.png")).is_file(), "{scene}");
    }
    for (arguments, code, words) in [
        ("export set --for hci --views 9 --out out", 2, "has files already"),
        ("export set --for npy --views 9 --out set --overwrite", 2, "choose another --out"),
        ("export set/tiny/9x9 --for npy --out set/tiny --overwrite", 2, "choose another --out"),
        ("export set --for npy --views 9 --out set/tiny/9x9 --overwrite", 2, "choose another --out"),
        ("export set --for hci --views 2 --out two", 2, "9 x 9 views"),
        ("export set --for epinet --out two", 2, "jpeg-pleno"),
        ("export set --for basiclfsr --views 9 --group ../up --out two", 2, "no name of a folder"),
        ("export missing --for npy --out two", 1, "missing"),
    ] {
        let refused = bench.run(arguments);
        assert!(refused.code == Some(code) && refused.stderr.contains(words), "{arguments}: {refused:?}");
        let left = bench.path("two");
        assert!(!left.exists(), "{arguments} left {:?}", bench.list("two"));
    }
}
