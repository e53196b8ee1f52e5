//! Failures: exit code 1, a message that names what failed, and nothing left behind.

use crate::common;
use std::path::Path;
use std::process::Command;

use crate::common::{Bench, Outcome, SCENE, SMALL};
use holo_io::Manifest;

fn failed(outcome: &Outcome, words: &[&str]) {
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(1), ""), "{outcome:?}");
    for word in words {
        assert!(outcome.stderr.contains(word), "no '{word}' in: {}", outcome.stderr);
    }
    assert!(!outcome.stderr.contains("panicked"), "{outcome:?}");
}

#[test]
fn scenes_that_cannot_be_read() {
    let bench = Bench::new();
    let whole = std::fs::read(bench.path(SCENE)).unwrap();
    std::fs::write(bench.path("cut.glb"), &whole[..whole.len() / 2]).unwrap();
    std::fs::write(bench.path("tail.glb"), &whole[..whole.len() - 1]).unwrap();
    std::fs::write(bench.path("text.glb"), "once upon a time").unwrap();
    std::fs::write(bench.path("empty.glb"), "").unwrap();
    std::fs::create_dir(bench.path("folder.glb")).unwrap();
    let before = bench.list("");
    for (scene, words) in [
        ("missing.glb", &["cannot read missing.glb"][..]),
        ("folder.glb", &["folder.glb", "not a file"]),
        ("cut.glb", &["cut.glb", "cut short"]),
        ("tail.glb", &["tail.glb", "cut short"]),
        ("text.glb", &["text.glb", "neither binary glTF (.glb) nor glTF JSON (.gltf)"]),
        ("empty.glb", &["empty.glb", "is empty"]),
    ] {
        let outcome = bench.run(&format!("render {scene} --out out/inner {SMALL}"));
        failed(&outcome, words);
        assert_eq!(outcome.stderr.matches(scene).count(), 1, "{outcome:?}");
        assert_eq!(bench.list(""), before, "{scene}");
    }
}

#[test]
fn a_scene_without_anything_to_look_at() {
    let bench = Bench::new();
    std::fs::write(bench.path("void.gltf"), "{\"asset\": {\"version\": \"2.0\"}}").unwrap();
    failed(&bench.run(&format!("render void.gltf --out out {SMALL}")), &["nothing to look at"]);
    assert_eq!(bench.list(""), [SCENE, "void.gltf"]);
}

#[test]
fn folders_that_cannot_be_made() {
    let bench = Bench::new();
    std::fs::write(bench.path("file"), "mine").unwrap();
    for out in ["file", "file/out", "file/a/b"] {
        failed(&bench.run(&format!("render {SCENE} --out {out} {SMALL}")), &["cannot create the folder file", "--out"]);
    }
    assert_eq!(bench.list(""), ["file", SCENE]);
    assert_eq!(std::fs::read(bench.path("file")).unwrap(), b"mine");
}

#[test]
fn a_failed_render_leaves_the_users_folder_as_it_was() {
    let bench = Bench::new();
    bench.render("out", "");
    std::fs::write(bench.path("out/mine.txt"), "keep").unwrap();
    std::fs::write(bench.path("out/.mine.part"), "keep this too").unwrap();
    let before = bench.bytes("out");
    std::fs::write(bench.path("text.glb"), "once upon a time").unwrap();
    for scene in ["text.glb", "missing.glb"] {
        failed(&bench.run(&format!("render {scene} --out out {SMALL} --overwrite")), &[scene]);
        assert!(bench.bytes("out") == before, "{scene}");
    }
}

#[test]
fn an_engine_that_is_not_there() {
    let bench = Bench::new();
    let run = |backend: &str, out: &str| {
        let mut command = bench.command(&format!("render {SCENE} --out {out} {SMALL} --spp 1 --backend {backend}"));
        command.env("HOLO_EMBREE_LIB", "/nonexistent/libembree4.so");
        common::outcome(command)
    };
    failed(&run("embree", "out"), &["Embree", "/nonexistent/libembree4.so", "HOLO_EMBREE_LIB"]);
    assert!(!run("embree", "out").stderr.contains(SCENE), "the scene is not to blame");
    assert_eq!(bench.list(""), [SCENE]);
    let outcome = run("auto", "out");
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("warning:") && outcome.stderr.contains("built-in BVH"), "{outcome:?}");
}

/// Options that make raw images far larger than the maps, which are written first.
const LARGE: &str = "--lenses 48x32 --views 8x8 --spp 1 --sky 1,1,1";

/// Runs `holo` where no file may grow beyond some 20 KB: an error while writing that needs no privilege.
#[cfg(unix)]
fn with_small_files(bench: &Bench, arguments: &str) -> Outcome {
    let mut command = Command::new("sh");
    // `bash` counts in KiB, others in blocks of 512 bytes. The signal is ignored, so that the write itself fails.
    command.args(["-c", "trap '' XFSZ; ulimit -f 24; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_holo")]);
    command.args(arguments.split_whitespace()).current_dir(bench.path(""));
    common::outcome(command)
}

#[cfg(unix)]
#[test]
fn a_write_that_fails_halfway_takes_everything_back() {
    let bench = Bench::new();
    let arguments = format!("render {SCENE} {LARGE} --ground-truth all");
    failed(&with_small_files(&bench, &format!("{arguments} --out new/inner")), &["cannot write new/inner/scene_"]);
    assert_eq!(bench.list(""), [SCENE], "a new folder goes");

    std::fs::create_dir(bench.path("old")).unwrap();
    std::fs::write(bench.path("old/mine.txt"), "keep").unwrap();
    failed(&with_small_files(&bench, &format!("{arguments} --out old")), &["cannot write old/scene_"]);
    assert_eq!(bench.list("old"), ["mine.txt"], "files that were made go, others stay");
    let outcome = with_small_files(&bench, &format!("render {SCENE} {LARGE} --out old --write depth"));
    assert_eq!(outcome.code, Some(0), "small files do fit: {outcome:?}");
}

#[cfg(unix)]
#[test]
fn a_write_that_fails_over_older_results_leaves_whole_files() {
    let bench = Bench::new();
    bench.render("out", "");
    let arguments = format!("render {SCENE} {LARGE} --out out --overwrite");
    failed(&with_small_files(&bench, &arguments), &["cannot write out/scene_"]);
    assert!(!bench.list("out").contains(&"manifest.json".into()), "no manifest vouches for a mixture");
    assert!(bench.list("out").iter().all(|name| !name.ends_with(".part")), "{:?}", bench.list("out"));
    assert_eq!(common::read_u8(bench.path("out/scene_el.png")).dim(), (32, 60, 3), "the older image, whole");
    let depth = holo_io::read_pfm_gray(bench.path("out/scene_depth.pfm"), &holo_io::Limits::default()).unwrap();
    assert_eq!(depth.dim(), (32, 48));
}

/// A file system of 64 KiB at a path, for as long as this lives.
struct TinyDisk<'a>(&'a Path);

impl TinyDisk<'_> {
    fn mount(at: &Path) -> Option<TinyDisk<'_>> {
        let mounted = Command::new("mount").args(["-t", "tmpfs", "-o", "size=64k", "none"]).arg(at).output();
        mounted.is_ok_and(|output| output.status.success()).then_some(TinyDisk(at))
    }
}

impl Drop for TinyDisk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).output();
    }
}

#[test]
fn a_full_disk() {
    let bench = Bench::new();
    let at = bench.path("disk");
    std::fs::create_dir(&at).unwrap();
    let Some(disk) = TinyDisk::mount(&at) else {
        eprintln!("not run: needs the right to mount a small file system (root)");
        return;
    };
    let outcome = bench.run(&format!("render {SCENE} --out disk/out {LARGE}"));
    failed(&outcome, &["cannot write disk/out/scene_", "space"]);
    assert_eq!(bench.list("disk"), Vec::<String>::new());
    // Room is there again: what fits succeeds.
    let outcome = bench.run(&format!("render {SCENE} --out disk/out {SMALL} --spp 1"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(Manifest::read(bench.path("disk/out/manifest.json")).unwrap().verify(bench.path("disk/out")).is_empty());
    drop(disk);
}
