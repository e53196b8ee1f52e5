//! Processes that are killed, or that write into one folder at once, again and again: `HOLO_ROUNDS` rounds, 20 by default.

#![cfg(unix)]

use std::collections::BTreeMap;
use std::process::Stdio;
use std::time::Duration;

use crate::common::{Bench, SCENE, SMALL};

/// An unfocused camera of few pixels.
const CAMERA: &str = r#"
name = "small"
[sensor]
size_px = [60, 45]
pixel_um = 5.0
[mla]
grid = "square"
pitch_um = 71.2
gap_um = 400.0
[main_lens]
focal_mm = 40.0
f_number = 5.8
focus_m = 0.8
"#;

fn rounds() -> u32 {
    std::env::var("HOLO_ROUNDS").map_or(20, |count| count.parse().expect("HOLO_ROUNDS is a number"))
}

/// A bench with the inputs of every command that writes.
fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::write(bench.path("small.toml"), CAMERA).unwrap();
    for line in [
        "scene pendulum",
        &format!("render {SCENE} --out field {SMALL} --spp 1 --quiet"),
        &format!("render {SCENE} --out part1 --lenses 12x96 --views 3 --spp 1 --shard 1/2 --quiet"),
        &format!("render {SCENE} --out part2 --lenses 12x96 --views 3 --spp 1 --shard 2/2 --quiet"),
        &format!("render {SCENE} --out raw --camera-file small.toml --spp 1 --write raw,raw-png --quiet"),
        &format!("dataset --out made --scenes none --glb {SCENE} --splits 2,3 --sensor 30x20 --spp 1 --quiet"),
    ] {
        let outcome = bench.run(line);
        assert_eq!(outcome.code, Some(0), "{line}: {outcome:?}");
    }
    bench
}

/// Every command that writes, and its output. The same line again must finish what was interrupted.
fn commands() -> Vec<(String, &'static str)> {
    let render = format!("render {SCENE} --spp 2 --quiet");
    let mut commands = vec![
        (format!("{render} {SMALL} --write el,vpi,mat,exr,hci --out killed --checkpoint 0"), "killed"),
        (format!("{render} --camera-file small.toml --out killed --checkpoint 0"), "killed"),
        ("render pendulum.glb --lenses 24x16 --views 3x2 --spp 1 --frame 3-5 --quiet --out killed".into(), "killed"),
        (
            format!("dataset --scenes none --glb {SCENE} --splits 2,3 --sensor 30x20 --spp 1 --quiet --out killed"),
            "killed",
        ),
    ];
    let others = [
        ("merge killed part1 part2 --quiet", "killed"),
        ("pack made --out killed", "killed"),
        ("animate field --out killed.png", "killed.png"),
        ("decode raw --out killed --overwrite", "killed"),
        ("target --camera-file small.toml --square-mm 20 --out killed --overwrite", "killed"),
        ("white --camera-file small.toml --out killed", "killed"),
        ("remap field/scene_vpi.png killed_el.png --from vpi --to el --views 5x4", "killed_el.png"),
        ("extract field --view 1,1 --out killed.png", "killed.png"),
        ("quilt field --tiles 5x1 --out killed.png", "killed.png"),
        ("refocus field --disparity 0.5 --out killed.png", "killed.png"),
        ("depth field --out killed.pfm", "killed.pfm"),
        ("view field --out killed.html", "killed.html"),
        ("scene plaster --out killed.glb", "killed.glb"),
    ];
    commands.extend(others.map(|(line, out)| (line.to_owned(), out)));
    commands
}

/// The bytes of an output, which is a file or a folder, and is removed.
fn taken(bench: &Bench, out: &str) -> BTreeMap<String, Vec<u8>> {
    let path = bench.path(out);
    if path.is_file() {
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        return BTreeMap::from([(out.to_owned(), bytes)]);
    }
    let bytes = bench.bytes(out);
    std::fs::remove_dir_all(path).unwrap();
    bytes
}

/// Numbers from 0 to 1 without pattern, the same in every run.
fn fraction(round: u32) -> f64 {
    (f64::from(round) * 0.618_033_988_749_895).fract()
}

/// After `kill -9` at any moment, the same command gives the files of an undisturbed run, and nothing else is left.
#[test]
fn killed_commands_are_repeated_to_the_same_files() {
    let bench = bench();
    let commands = commands();
    let before = bench.list("");
    let mut whole = BTreeMap::new();
    for round in 0..rounds() {
        let number = round as usize % commands.len();
        let (line, out) = &commands[number];
        let (expected, took) = whole.entry(number).or_insert_with(|| {
            let outcome = bench.run(line);
            assert_eq!(outcome.code, Some(0), "{line}: {outcome:?}");
            (taken(&bench, out), outcome.took)
        });
        let mut child = bench.command(line).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        std::thread::sleep(took.mul_f64(1.1 * fraction(round)));
        // It may have ended.
        let _ = child.kill();
        child.wait().unwrap();
        let outcome = bench.run(line);
        assert_eq!(outcome.code, Some(0), "round {round}: {line}: {outcome:?}");
        let found = taken(&bench, out);
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
