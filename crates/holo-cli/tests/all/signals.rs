//! Ctrl-C, SIGTERM and SIGKILL: quick ends, no broken file.

#![cfg(unix)]

use crate::common;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Bench, DEFAULT_FILES, SCENE, read_u8};
use holo_io::{Limits, read_pfm_gray};

/// Many seconds of work for any machine.
const LONG: &str = "--lenses 200x150 --views 60x60 --spp 400 --sky 1,1,1";

/// Seconds of writing after little rendering: most pixels see nothing but a sky of one color.
const LARGE: &str = "--lenses 160x120 --views 16x16 --spp 1 --sky 1,1,1";

/// How soon a process must be gone; the requirement is a second, the rest is for debug builds on busy machines.
const AT_ONCE: Duration = Duration::from_millis(1500);

fn start(bench: &Bench, arguments: &str) -> Child {
    bench.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// Waits until one of the raw images is being written, or the process ends by itself.
fn wait_for_writing(child: &mut Child, folder: &Path) {
    let start = Instant::now();
    loop {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut names = entries.map(|entry| entry.file_name().into_string().unwrap());
        let raw = |name: &str| name.starts_with(".scene_el.png.") || name.starts_with(".scene_vpi.png.");
        let writing = names.any(|name| raw(&name));
        if writing || child.try_wait().unwrap().is_some() {
            return;
        }
        assert!(start.elapsed() < Duration::from_secs(60), "nothing is written");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_render_that_is_asked_to_stop_leaves_nothing() {
    for name in ["INT", "TERM"] {
        let bench = Bench::new();
        let child = start(&bench, &format!("render {SCENE} --out new/inner {LONG}"));
        std::thread::sleep(Duration::from_millis(500));
        assert_eq!(bench.list("new"), ["inner/", "inner/.holo.lock"], "it is at work");
        signal(&child, name);
        let outcome = common::wait(child, AT_ONCE).expect("it ends within a second");
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(1), ""), "{name}: {outcome:?}");
        assert_eq!(outcome.stderr.matches("holo: stopped").count(), 1, "{name}: {outcome:?}");
        assert!(!outcome.stderr.contains("panicked"), "{name}: {outcome:?}");
        assert_eq!(bench.list(""), [SCENE], "{name}");
    }
}

#[test]
fn a_long_render_names_a_short_one() {
    let bench = Bench::new();
    let (said, start) = (bench.path("said"), Instant::now());
    let stderr = std::fs::File::create(&said).unwrap();
    let mut child = bench.command(&format!("render {SCENE} --out new {LONG}")).stderr(stderr).spawn().unwrap();
    let text = loop {
        let text = std::fs::read_to_string(&said).unwrap();
        if text.contains("--preset") || start.elapsed() > Duration::from_secs(60) {
            break text;
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    child.kill().unwrap();
    child.wait().unwrap();
    let line = text.lines().find(|line| line.starts_with("note: about ")).expect(&text);
    assert!(line.ends_with("min are left; `--preset draft` renders a first image of the same in seconds"), "{line}");
}

#[test]
fn a_stopped_render_leaves_the_users_folder_as_it_was() {
    let bench = Bench::new();
    bench.render("out", "");
    std::fs::write(bench.path("out/mine.txt"), "keep").unwrap();
    let before = bench.bytes("out");
    let child = start(&bench, &format!("render {SCENE} --out out {LONG} --overwrite"));
    std::thread::sleep(Duration::from_millis(500));
    signal(&child, "INT");
    let outcome = common::wait(child, AT_ONCE).expect("it ends within a second");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(bench.bytes("out") == before);
}

#[test]
fn a_stop_while_files_are_written_takes_them_back() {
    let bench = Bench::new();
    let mut child = start(&bench, &format!("render {SCENE} --out new {LARGE}"));
    wait_for_writing(&mut child, &bench.path("new"));
    signal(&child, "INT");
    let outcome = common::wait(child, AT_ONCE).expect("it ends within a second");
    // A fast machine may be done before it is stopped: then everything is there.
    match outcome.code {
        Some(0) => {
            eprintln!("the render was done before it could be stopped");
            assert_eq!(bench.list("new"), DEFAULT_FILES);
        }
        Some(1) => assert_eq!(bench.list(""), [SCENE], "{outcome:?}"),
        _ => panic!("{outcome:?}"),
    }
    assert!(!outcome.stderr.contains("panicked"), "{outcome:?}");
}

#[test]
fn a_killed_render_leaves_only_whole_files_and_the_next_one_cleans_up() {
    let bench = Bench::new();
    let mut child = start(&bench, &format!("render {SCENE} --out out {LARGE}"));
    wait_for_writing(&mut child, &bench.path("out"));
    child.kill().unwrap();
    let killed = child.wait().unwrap().code().is_none();
    let left = bench.list("out");
    if !killed {
        eprintln!("the render was done before it could be killed");
    }
    assert!(!killed || left.iter().any(|name| name.ends_with(".part")), "it was killed while it wrote: {left:?}");
    assert!(!killed || !left.contains(&"manifest.json".into()), "{left:?}");
    for name in left.iter().filter(|name| !name.ends_with(".part")) {
        let path = bench.path("out").join(name);
        match name.rsplit_once('.').unwrap().1 {
            "lock" => {}
            "png" => assert!(read_u8(path).dim().0 > 0),
            "pfm" => assert_eq!(read_pfm_gray(path, &Limits::default()).unwrap().dim(), (120, 160)),
            _ => assert_eq!(bench.run(&format!("info out/{name}")).code, Some(0), "{name}"),
        }
    }
    bench.render("out", "");
    assert_eq!(bench.list("out"), DEFAULT_FILES, "the leftovers are gone");
    assert_eq!(bench.run("verify out").code, Some(0));
}

/// Seconds of rendering, in many tiles.
const SLOW: &str = "--lenses 60x40 --views 20x20 --spp 16 --sky 1,1,1 --max-bounces 3";

/// Waits until there are tiles in the checkpoint in `folder`.
fn wait_for_checkpoint(child: &mut Child, folder: &Path) {
    let start = Instant::now();
    let size = |name: &str| std::fs::metadata(folder.join(name)).map_or(0, |found| found.len());
    loop {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let mut names = entries.map(|entry| entry.file_name().into_string().unwrap());
        if names.any(|name| name.ends_with(".checkpoint") && size(&name) > 20_000) {
            return;
        }
        assert!(child.try_wait().unwrap().is_none(), "it is done before there is a checkpoint");
        assert!(start.elapsed() < Duration::from_secs(60), "there is no checkpoint");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn the_same_command_continues_after_a_stop_and_after_a_kill() {
    let bench = Bench::new();
    let command = |out: &str| format!("render {SCENE} --out {out} {SLOW} --checkpoint 0.05");
    let undisturbed = bench.run(&format!("render {SCENE} --out whole {SLOW} --checkpoint 0 --threads 1"));
    assert_eq!(undisturbed.code, Some(0), "{undisturbed:?}");
    for name in ["TERM", "KILL"] {
        let mut child = start(&bench, &command(name));
        wait_for_checkpoint(&mut child, &bench.path(name));
        signal(&child, name);
        let stopped = common::wait(child, AT_ONCE).expect("it ends within a second");
        assert_eq!(stopped.code, if name == "TERM" { Some(1) } else { None }, "{stopped:?}");
        assert_eq!(stopped.stderr.contains("the same command continues"), name == "TERM", "{stopped:?}");
        // A killed process leaves the file of its lock, which means nothing without the lock.
        let left = if name == "TERM" { 1 } else { 2 };
        assert_eq!(bench.list(name).len(), left, "the checkpoint alone: {:?}", bench.list(name));
        assert!(bench.run(&format!("verify {name}")).stderr.contains("unfinished render"));
        let finished = bench.run(&command(name));
        assert_eq!(finished.code, Some(0), "{finished:?}");
        assert!(finished.stderr.contains("note: continues with"), "{finished:?}");
        assert!(bench.bytes(name) == bench.bytes("whole"), "{name}");
    }
}

#[test]
fn a_checkpoint_of_another_command_is_not_used() {
    let bench = Bench::new();
    let mut child = start(&bench, &format!("render {SCENE} --out out {SLOW} --checkpoint 0.05"));
    wait_for_checkpoint(&mut child, &bench.path("out"));
    child.kill().unwrap();
    child.wait().unwrap();
    let other = bench.render("out", "");
    assert!(other.stderr.contains("is not used: --lenses has changed"), "{other:?}");
    assert_eq!(bench.list("out"), DEFAULT_FILES, "a finished render has no checkpoint");
}
