//! `--frame`: frames of an animated scene, their motion, sequences, parts of them, and what is wrong with them.

use crate::common;
use crate::common::{Bench, read_u8, run};
use holo_io::{Limits, Manifest, read_flo, read_pfm, read_pfm_gray};
use ndarray::{Array2, Axis};
use serde_json::Value;

/// The pendulum as a file, a small rig, light without noise.
fn bench() -> Bench {
    let bench = Bench::new();
    let outcome = bench.run("scene pendulum");
    assert!(outcome.code == Some(0) && outcome.stderr.contains("animated"), "{outcome:?}");
    bench
}

const SMALL: &str = "render pendulum.glb --lenses 48x32 --views 3x2 --integrator direct --spp 1";

#[test]
fn a_sequence_is_its_frames_in_any_parts_and_order() {
    let bench = bench();
    let write = if cfg!(feature = "hdf5") { "el,h5" } else { "el" };
    let layers = format!("--layers depth,optical-flow,scene-flow --write {write}");
    let outcome = run(&bench, &format!("{SMALL} {layers} --frame 3-6 --fps 12 --out whole --json"));
    let lines: Vec<Value> = outcome.stdout.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.iter().filter_map(|line| line["frame"].as_u64()).collect::<Vec<_>>(), [3, 4, 5, 6]);
    assert_eq!((lines[4]["made"].as_u64(), lines[4]["kept"].as_u64()), (Some(4), Some(0)));
    let is_file = |name: &String| !name.ends_with('/');
    assert_eq!(common::names(&lines[4]["files"]), bench.list("whole").into_iter().filter(is_file).collect::<Vec<_>>());
    let of_frame = common::names(&lines[1]["files"]);
    assert!(of_frame.contains(&"frame_0004/scene_el.png".to_owned()), "{of_frame:?}");
    let folders: Vec<String> = bench.list("whole").into_iter().filter(|name| name.ends_with('/')).collect();
    assert_eq!(folders, ["frame_0003/", "frame_0004/", "frame_0005/", "frame_0006/"]);
    let listed = run(&bench, "info whole").stdout;
    assert!(listed.starts_with("sequence of 4 frames\n") && listed.contains("frame_0006"), "{listed}");
    // Parts, one of them made again. The file of all frames is there when all of them are.
    for part in ["2/3", "1/3", "1/3", "3/3"] {
        assert!(!bench.path("parts/sequence_5d.h5").exists(), "before part {part}");
        run(&bench, &format!("{SMALL} {layers} --frame 3-6 --fps 12 --out parts --shard {part} --quiet"));
    }
    assert!(bench.bytes("whole") == bench.bytes("parts"), "parts differ from the whole");
    let again = run(&bench, &format!("{SMALL} {layers} --frame 3-6 --fps 12 --out whole --json --quiet"));
    assert!(again.stdout.contains("\"kept\":4"), "{again:?}");
    let again: Value = serde_json::from_str(&again.stdout).unwrap();
    assert_eq!(again["files"].as_array().map(Vec::len), lines[4]["files"].as_array().map(Vec::len));
    assert!(run(&bench, "verify whole").stdout.contains("4 folders"));
    // Focus and exposure are those of the first frame.
    let manifest = |frame: u32| Manifest::read(bench.path(format!("whole/frame_{frame:04}/manifest.json"))).unwrap();
    let first = manifest(3);
    for frame in 4..=6 {
        let other = manifest(frame);
        assert_eq!((other.rig, other.exposure_ev), (first.rig, first.exposure_ev));
        assert_eq!(other.settings["frame"], frame.into());
    }
    // A frame alone is the same but for what is chosen automatically.
    let rig = first.rig.unwrap();
    let (focus_m, ev) = (rig.focus_distance_m(), first.exposure_ev.unwrap());
    let chosen = format!("--focus-m {focus_m} --exposure {ev}");
    run(&bench, &format!("{SMALL} {layers} --frame 5 --fps 12 --out alone {chosen}"));
    let same = |file: &str| {
        let read = |folder: &str| std::fs::read(bench.path(format!("{folder}/{file}"))).unwrap();
        read("alone") == read("whole/frame_0005")
    };
    assert!(
        ["scene_el.png", "scene_depth.pfm", "scene_optical_flow.flo", "scene_scene_flow.pfm"].into_iter().all(same)
    );
    std::fs::write(bench.path("parts/frame_0004/parameters.cfg"), "other").unwrap();
    let outcome = bench.run("verify parts");
    assert!(outcome.code == Some(1) && outcome.stdout.contains("frame_0004: parameters.cfg"), "{outcome:?}");
    std::fs::remove_dir_all(bench.path("parts/frame_0005")).unwrap();
    let outcome = bench.run("verify parts");
    assert!(outcome.code == Some(1) && outcome.stdout.contains("frame_0005"), "{outcome:?}");
    // Other options in the same folder are refused, as for one image.
    let other = bench.run(&format!("{SMALL} --frame 3-6 --fps 24 --out whole"));
    assert!(other.code == Some(2) && other.stderr.contains("--overwrite"), "{other:?}");
}

/// `holo animate` shows the frames of a sequence once each, at its speed: the central view, or views along a path.
#[test]
fn a_sequence_becomes_an_animation() {
    let bench = bench();
    run(&bench, &format!("{SMALL} --frame 3-6 --fps 12 --write el --exposure 0 --out s"));
    let view = |frame: u32, [column, row]: [usize; 2]| {
        run(&bench, &format!("extract s/frame_{frame:04} --view {column},{row} --out view.png"));
        read_u8(bench.path("view.png"))
    };
    let chunk = |name: &str, kind: &[u8]| {
        let bytes = std::fs::read(bench.path(name)).unwrap();
        let at = bytes.windows(4).position(|found| found == kind).expect("an animation") + 4;
        bytes[at..at + 26].to_vec()
    };
    run(&bench, "animate s --out central.png");
    assert_eq!(chunk("central.png", b"acTL")[..4], 4_u32.to_be_bytes());
    // The delay of the first frame as a fraction of two 16-bit numbers: a twelfth of a second.
    let delay = &chunk("central.png", b"fcTL")[20..24];
    let [numerator, denominator] = [0, 2].map(|k| f64::from(u16::from_be_bytes([delay[k], delay[k + 1]])));
    assert!((numerator / denominator - 1.0 / 12.0).abs() < 1e-4, "{numerator} / {denominator} s");
    // Of 3 x 2 views the central one is column 1, row 1.
    assert_eq!(read_u8(bench.path("central.png")), view(3, [1, 1]));
    for (line, views) in [
        ("", [[1, 1]; 4]),
        ("--path sweep --row 0", [[0, 0], [0, 0], [1, 0], [2, 0]]),
        ("--path ping-pong --row 1", [[0, 1], [1, 1], [2, 1], [1, 1]]),
    ] {
        run(&bench, &format!("animate s {line} --frames --out f.png"));
        for (number, at) in views.into_iter().enumerate() {
            assert_eq!(
                read_u8(bench.path(format!("f_{number:03}.png"))),
                view(number as u32 + 3, at),
                "{line} {number}"
            );
        }
    }
    // Other commands need one frame.
    for line in ["refocus s --distance-m 1 --out r.png", "animate s/frame_0003 --row 9 --path sweep --out a.png"] {
        let outcome = bench.run(line);
        assert!(matches!(outcome.code, Some(1 | 2)), "{line}: {outcome:?}");
    }
    assert!(bench.run("depth s --out d.pfm").stderr.contains("a sequence of 4 frames; choose one of them"));
}

/// A point that a view sees, moved by its flow, has in the next frame the depth that the scene flow gives it, wherever
/// nothing hides it there; and what rests has exactly 0.
#[test]
fn flow_leads_to_the_next_frame() {
    let bench = bench();
    for frame in [2, 3] {
        let line = "render pendulum.glb --lenses 480x320 --views 3x3 --integrator depth --focus-m 0.6 --sensor-mm 36";
        let layers = "--layers depth,object-id,optical-flow,scene-flow --ground-truth all";
        run(&bench, &format!("{line} {layers} --frame {frame} --out f{frame} --quiet"));
    }
    let pfm = |name: &str| read_pfm(bench.path(name), &Limits::default()).unwrap().values;
    let gray = |name: &str| read_pfm_gray(bench.path(name), &Limits::default()).unwrap();
    let [.., back] = holo_scene::gallery::scene("pendulum").unwrap().cameras[0].pose.columns;
    let (mut resting, mut moving, mut seen, mut near) = (0, 0, 0, 0);
    for view in [0, 4, 8] {
        let flow =
            read_flo(bench.path(format!("f2/optical_flow/scene_optical_flow_Cam{view:03}.flo")), &Limits::default());
        let flow = flow.unwrap();
        let moved = pfm(&format!("f2/scene_flow/scene_scene_flow_Cam{view:03}.pfm"));
        let here = gray(&format!("f2/depth/scene_depth_Cam{view:03}.pfm"));
        let [there, objects] = ["depth", "object_id"].map(|of| gray(&format!("f3/{of}/scene_{of}_Cam{view:03}.pfm")));
        let own = gray(&format!("f2/object_id/scene_object_id_Cam{view:03}.pfm"));
        for ((v, u), &depth_m) in here.indexed_iter() {
            let px = [flow[[v, u, 0]], flow[[v, u, 1]]];
            if px == [0.0; 2] {
                assert_eq!([0, 1, 2].map(|k| moved[[v, u, k]]), [0.0; 3]);
                resting += 1;
                continue;
            }
            moving += 1;
            // The camera of this scene does not move: its pose is the same in both frames.
            let (x, y) = (u as f64 + 0.5 + f64::from(px[0]), v as f64 + 0.5 + f64::from(px[1]));
            let (row, column) = (y.floor() as usize, x.floor() as usize);
            if row >= 320 || column >= 480 || objects[[row, column]] != own[[v, u]] {
                continue;
            }
            seen += 1;
            // The depth there is of the center of the pixel: within the slope of the surface over a pixel, which is steep at
            // the rims of the bob alone.
            let nearer: f64 = (0..3).map(|k| f64::from(moved[[v, u, k]]) * back[k]).sum();
            let error = (f64::from(there[[row, column]]) - f64::from(depth_m) + nearer).abs();
            assert!(error < 0.02, "view {view}, pixel {v} {u}: {error} m");
            near += usize::from(error < 0.001);
        }
    }
    assert!(resting > 300_000 && moving > 9_000 && seen * 10 > moving * 8, "{resting} {moving} {seen}");
    assert!(near * 100 > seen * 95, "{near} of {seen}");
    // The central view is one of them.
    let read = |name: &str| std::fs::read(bench.path(name)).unwrap();
    assert!(read("f2/scene_optical_flow.flo") == read("f2/optical_flow/scene_optical_flow_Cam004.flo"));
}

/// The texture of a frame is that of the next one where the flow leads, to within what lies between its pixels: the error of
/// linear interpolation halves with twice the resolution.
#[test]
fn textures_move_with_the_flow() {
    let bench = bench();
    run(&bench, "scene garden_walk");
    for frame in [10, 11] {
        let line = "render garden_walk.glb --lenses 960x640 --views 1 --integrator depth --quiet";
        let layers = "--layers albedo,object-id,material-id,depth,optical-flow";
        run(&bench, &format!("{line} {layers} --frame {frame} --out f{frame}"));
    }
    let gray = |name: &str| read_pfm_gray(bench.path(name), &Limits::default()).unwrap();
    let albedo = |frame: u32| {
        let path = bench.path(format!("f{frame}/scene_albedo.pfm"));
        let values = read_pfm(path, &Limits::default()).unwrap().values;
        values.mean_axis(Axis(2)).unwrap()
    };
    let flow = read_flo(bench.path("f10/scene_optical_flow.flo"), &Limits::default()).unwrap();
    let [here, there] = [10, 11].map(albedo);
    let [ids, depths] = [["object_id", "material_id"], ["depth", "depth"]]
        .map(|names| names.map(|name| [10, 11].map(|frame| gray(&format!("f{frame}/scene_{name}.pfm")))));
    let (mut warped, mut resting) = (Vec::new(), Vec::new());
    for ((v, u), &own) in here.indexed_iter() {
        let (x, y) = (u as f32 + flow[[v, u, 0]], v as f32 + flow[[v, u, 1]]);
        if !(x >= 0.0 && y >= 0.0 && x < 959.0 && y < 639.0) {
            continue;
        }
        let (column, row) = (x as usize, y as usize);
        let corners = [[row, column], [row, column + 1], [row + 1, column], [row + 1, column + 1]];
        // What the four pixels around show is the same surface, not what hides it.
        let is_same = |of: &[Array2<f32>; 2]| corners.iter().all(|&at| of[1][at] == of[0][[v, u]]);
        let is_near = |at: &[usize; 2]| (depths[0][1][*at] / depths[0][0][[v, u]] - 1.0).abs() < 0.1;
        // Constant albedo shows nothing.
        if !ids.iter().all(is_same) || !corners.iter().all(is_near) || here[[v, u]] == here[[v, (u + 1) % 960]] {
            continue;
        }
        let (a, b) = (x.fract(), y.fract());
        let found: f32 = [(1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b]
            .iter()
            .zip(corners)
            .map(|(weight, at)| weight * there[at])
            .sum();
        warped.push((found / own - 1.0).abs());
        resting.push((there[[v, u]] / own - 1.0).abs());
    }
    let count = warped.len();
    let [warped, resting] = [warped, resting].map(|mut errors| {
        errors.sort_by(f32::total_cmp);
        errors[errors.len() / 2]
    });
    println!("{count} pixels, median error {:.3} %, without flow {:.1} %", 100.0 * warped, 100.0 * resting);
    // Interpolation leaves 0.5 % at this resolution; without flow it is 4.1 %.
    assert!(count > 200_000 && warped < 0.01 && resting > 0.03, "{count} {warped} {resting}");
}

#[test]
fn frames_of_a_dataset_are_scenes_of_the_same_split() {
    let bench = bench();
    let line = "dataset --scenes pendulum --views 2,3 --sensor 96x64 --spp 1 --integrator direct --frame 0-2 --out set";
    let outcome = run(&bench, &format!("{line} --json --quiet"));
    assert!(outcome.stdout.contains("\"made\":6"), "{outcome:?}");
    let folders: Vec<String> =
        bench.list("set").into_iter().filter(|name| name.matches('/').count() == 1 && name.ends_with('/')).collect();
    assert_eq!(folders, ["pendulum_0000/", "pendulum_0001/", "pendulum_0002/"]);
    let focus = |folder: &str| Manifest::read(bench.path(format!("set/{folder}/2x2/manifest.json"))).unwrap();
    assert_eq!(focus("pendulum_0000").rig, focus("pendulum_0002").rig);
    let train = std::fs::read_to_string(bench.path("set/train.txt")).unwrap();
    assert_eq!(train.lines().count(), 6);
    assert!(run(&bench, &format!("{line} --json --quiet")).stdout.contains("\"kept\":6"));
    run(&bench, "verify set");
}

#[test]
fn wrong_use_is_said() {
    let bench = bench();
    run(&bench, "array plane --count 2 --spacing-m 0.1 --target-m 0,0,0 --size 6x4");
    for (line, part) in [
        ("render tiny.glb --out o --frame 5-2", "A-B"),
        ("render tiny.glb --out o --fps 12", "--frame"),
        ("render tiny.glb --out o --layers optical-flow", "--frame"),
        ("render pendulum.glb --out o --frame 1 --animation run", "'swing'"),
        ("render pendulum.glb --out o --frame 1 --shard 1/2 --layers scene-flow", "scene-flow"),
    ] {
        let outcome = bench.run(line);
        assert!(matches!(outcome.code, Some(1 | 2)) && outcome.stderr.contains(part), "{line}: {outcome:?}");
        assert!(!bench.path("o").exists(), "{line}");
    }
    let outcome = bench.render("still", "--frame 7");
    assert!(outcome.stderr.contains("no animations"), "{outcome:?}");
    let outcome = run(&bench, "info pendulum.glb");
    assert!(outcome.stdout.contains("animations:          0 'swing' (2 s)"), "{outcome:?}");
}
