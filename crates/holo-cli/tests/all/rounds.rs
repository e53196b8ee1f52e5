//! Processes that are killed, or that write into one folder at once, again and again: 80 rounds, 200 with
//! `HOLO_THOROUGH=1`.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::process::Stdio;
use std::time::Duration;

use crate::common::{Bench, SCENE, SMALL, bench_display, camera_with_sensor, is_thorough};

fn rounds() -> u32 {
    if is_thorough() { 200 } else { 80 }
}

/// A bench with the inputs of every command that writes.
fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("bench.toml"), bench_display("square", 4, 4, 1)).unwrap();
    std::fs::write(bench.path("small.toml"), camera_with_sensor()).unwrap();
    let frame = |name: &str, x: f64| {
        let rows = [[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
        serde_json::json!({ "file_path": format!("{name}.png"), "transform_matrix": rows })
    };
    let frames = [frame("left", -0.1), frame("right", 0.1)];
    let poses = serde_json::json!({ "fl_x": 14.0, "w": 12, "h": 8, "frames": frames });
    std::fs::write(bench.path("poses.json"), poses.to_string()).unwrap();
    for line in [
        "scene pendulum",
        &format!("render {SCENE} --out field {SMALL} --spp 1 --quiet"),
        &format!("render {SCENE} --out part1 --lenses 12x96 --views 3 --spp 1 --shard 1/2 --quiet"),
        &format!("render {SCENE} --out part2 --lenses 12x96 --views 3 --spp 1 --shard 2/2 --quiet"),
        &format!("render {SCENE} --out raw --camera-file small.toml --spp 1 --write raw,raw-png --sky 1,1,1 --quiet"),
        "render pendulum.glb --lenses 12x8 --views 3x2 --spp 1 --frame 3-5 --quiet --out moving",
        &format!("dataset --out made --scenes none --glb {SCENE} --splits 2,3 --sensor 30x20 --spp 1 --quiet"),
        "develop raw/raw.exr --camera-file small.toml --out codes.png",
        &format!(
            "render {SCENE} --out cameras --transforms poses.json --transforms-up y --layers depth --spp 1 --quiet"
        ),
        "extract field --view all --out views/view.png",
        "depth field --out estimate.pfm",
    ] {
        let outcome = bench.run(line);
        assert_eq!(outcome.code, Some(0), "{line}: {outcome:?}");
    }
    bench
}

/// Every command that writes; all outputs have names that begin with `killed`. The same line again must finish what was
/// interrupted. Those that write most files come first.
fn commands() -> Vec<String> {
    let render = format!("render {SCENE} --spp 2 --quiet --out killed");
    let poses = "--transforms poses.json --transforms-up y";
    let folders = [
        format!("{render} {SMALL} --write el,vpi,mat,exr,hci --checkpoint 0"),
        format!("{render} --camera-file small.toml --checkpoint 0"),
        "render pendulum.glb --lenses 24x16 --views 3x2 --spp 1 --frame 3-5 --quiet --out killed".into(),
        format!("dataset --scenes none --glb {SCENE} --splits 2,3 --sensor 30x20 --spp 1 --quiet --out killed"),
        "merge killed part1 part2 --quiet".into(),
        "pack made --out killed".into(),
        format!("{render} {poses} --layers depth,color"),
        format!("{render} {poses} --views 3x2"),
        format!("{render} --lenses 12x96 --views 3 --shard 2/2"),
        format!("{render} --camera-file small.toml --sky 1,1,1 --for lftoolbox"),
        "decode raw --out killed --overwrite".into(),
        "target --camera-file small.toml --square-mm 20 --out killed --overwrite".into(),
        "white --camera-file small.toml --out killed".into(),
        "generate --count 2 --seed 5 --recipe hci-like --views 3 --lenses 24x24 --spp 1 --quiet --out killed".into(),
        "export made --for npy --views 3 --out killed --overwrite".into(),
        "export raw --for lftoolbox --out killed --overwrite".into(),
    ];
    let files = [
        "animate field --out killed.png",
        "animate moving --out killed.png",
        "remap field/scene_vpi.png killed_el.png --from vpi --to el --views 5x4",
        "extract field --view 1,1 --out killed.png",
        "quilt field --tiles 5x1 --out killed.png",
        "correspond cameras --from left --to right --out killed.npy",
        "depth cameras --depths-m 0.5,4 --out killed.pfm",
        "display field --display bench.toml --out killed.png",
        "refocus field --disparity 0.5 --out killed.png",
        "synthesize field --at 1.5,1 --out killed.png",
        "depth field --out killed.pfm --confidence killed_confidence.pfm",
        "view field --out killed.html",
        "scene plaster --out killed.glb",
        "develop raw/raw.exr --camera-file small.toml --iso 400 --seed 3 --out killed.png",
        "demosaic codes.png --method malvar --out killed.exr",
        "epi field --row 1,1 --out killed.png",
        "rotate-elements field killed_el.png",
        "compose views --views 5x4 --out killed_el.png",
        "array sphere --count 4 --radius-m 1.5 --elevation-deg 10,70 --size 8x6 --out killed.json",
        "camera lytro-illum --out killed.toml",
        "eval estimate.pfm field/scene_disparity.pfm --border 1 --error-map killed.png",
    ];
    let mut commands = Vec::from(folders);
    if cfg!(feature = "hdf5") {
        commands.push(format!("{render} {SMALL} --write h5 --checkpoint 0"));
        let frames =
            "render pendulum.glb --frame 3-5 --lenses 12x8 --views 3x2 --spp 1 --write h5 --quiet --out killed";
        commands.push(frames.into());
    }
    commands.extend(files.map(str::to_owned));
    commands
}

/// The files of an output, which is removed.
fn taken(bench: &Bench) -> BTreeMap<String, Vec<u8>> {
    let mut files = bench.bytes("");
    files.retain(|name, _| name.starts_with("killed"));
    for entry in std::fs::read_dir(bench.path("")).unwrap() {
        let path = entry.unwrap().path();
        match (path.file_name().unwrap().to_str().unwrap().starts_with("killed"), path.is_dir()) {
            (true, true) => std::fs::remove_dir_all(path).unwrap(),
            (true, false) => std::fs::remove_file(path).unwrap(),
            (false, _) => {}
        }
    }
    files
}

/// Puts the files of an earlier run where they were.
fn put(bench: &Bench, files: &BTreeMap<String, Vec<u8>>) {
    for (name, bytes) in files {
        std::fs::create_dir_all(bench.path(name).parent().unwrap()).unwrap();
        std::fs::write(bench.path(name), bytes).unwrap();
    }
}

/// Numbers from 0 to 1 without pattern, the same in every run.
fn fraction(round: u32) -> f64 {
    (f64::from(round) * 0.618_033_988_749_895).fract()
}

/// After `kill -9` at any moment, the same command gives the files of an undisturbed run, and nothing else is left; in
/// every second pass over the commands it replaces an older result.
#[test]
fn killed_commands_are_repeated_to_the_same_files() {
    let bench = bench();
    let commands = commands();
    let before = bench.list("");
    let mut whole = BTreeMap::new();
    for round in 0..rounds() {
        let number = round as usize % commands.len();
        let line = &commands[number];
        let (expected, took) = whole.entry(number).or_insert_with(|| {
            let outcome = bench.run(line);
            assert_eq!(outcome.code, Some(0), "{line}: {outcome:?}");
            (taken(&bench), outcome.took)
        });
        let mut line = line.clone();
        let is_over = round as usize / commands.len() % 2 == 1 && !line.starts_with("pack");
        if is_over {
            put(&bench, expected);
            if line.starts_with("render") {
                line.push_str(" --overwrite");
            }
        }
        let mut child = bench.command(&line).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(took.mul_f64(1.1 * fraction(round)));
        // It may have ended.
        let _ = child.kill();
        child.wait().unwrap();
        let outcome = bench.run(&line);
        assert_eq!(outcome.code, Some(0), "round {round}: {line}: {outcome:?}");
        let mut found = taken(&bench);
        // Nobody can know whose it is: it is reported, and stays.
        found.retain(|name, _| !is_over || !name.ends_with(".manifest.old.json"));
        let names = |files: &BTreeMap<String, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&found), names(expected), "round {round}: {line}");
        assert!(found == *expected, "round {round}: {line}: other bytes");
        assert_eq!(bench.list(""), before, "round {round}: {line}");
    }
}

/// Of two renders into one folder at once, one is refused or both finish, and the folder is whole.
#[test]
fn two_renders_at_once_leave_a_whole_folder() {
    let bench = Bench::new();
    for round in 0..rounds() {
        let out = format!("out{round}");
        let start = |more: &str| {
            let line = format!("render {SCENE} --out {out} {SMALL} --spp 1 --quiet {more}");
            bench.command(&line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap()
        };
        let [first, second] =
            [["", ""], ["--overwrite", "--seed 2 --overwrite"], ["--overwrite", "--write el --overwrite"]]
                [round as usize % 3]
                .map(|more| {
                    let child = start(more);
                    std::thread::sleep(Duration::from_secs_f64(0.02 * fraction(round)));
                    child
                });
        let ended = [first, second].map(|child| child.wait_with_output().unwrap());
        assert!(ended.iter().any(|one| one.status.success()), "round {round}: {ended:?}");
        for one in ended.iter().filter(|one| !one.status.success()) {
            let text = String::from_utf8_lossy(&one.stderr);
            assert_eq!(one.status.code(), Some(1), "round {round}: {text}");
            assert!(text.contains("is writing in it"), "round {round}: {text}");
        }
        let verified = bench.run(&format!("verify {out}"));
        assert_eq!(verified.code, Some(0), "round {round}: {verified:?}");
        assert!(bench.list(&out).iter().all(|name| !name.starts_with('.')), "{:?}", bench.list(&out));
    }
}
