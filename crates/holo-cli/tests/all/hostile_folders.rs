//! Folders and scenes from somebody else: no file outside of them is touched, nothing in them grants a right, nothing waits
//! for ever. A test for each way that was found; that of HDF5 is in `holo-io` (`hdf5/storage.rs`).

#![cfg(unix)]

use crate::common;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Bench, CAMERA, Outcome, SCENE, SMALL, wait};
use holo_io::{Manifest, hash_file};

/// No command here has work for so long.
const LONG: Duration = Duration::from_secs(180);

/// Seconds of rendering, in many tiles.
const SLOW: &str = "--lenses 60x40 --views 20x20 --spp 16 --sky 1,1,1 --max-bounces 3";

/// A folder with the victim's files beside the scene, which must stay as they are.
fn bench() -> Bench {
    let bench = Bench::new();
    fs::create_dir(bench.path("victim")).unwrap();
    fs::write(bench.path("victim/keep.txt"), "keep").unwrap();
    bench
}

/// Runs a command, which must end by itself; the victim's files are as they were.
fn run(bench: &Bench, command: Command) -> Outcome {
    let outcome = wait(start(command), LONG).expect("it ends by itself");
    assert_eq!(bench.list("victim"), ["keep.txt"], "{outcome:?}");
    assert_eq!(fs::read(bench.path("victim/keep.txt")).unwrap(), b"keep", "{outcome:?}");
    outcome
}

fn holo(bench: &Bench, arguments: &str) -> Outcome {
    run(bench, bench.command(arguments))
}

fn start(mut command: Command) -> Child {
    command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn failed(outcome: &Outcome, words: &[&str]) {
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(words.iter().all(|word| outcome.stderr.contains(word)), "{words:?}: {outcome:?}");
}

fn pipe(path: &Path) {
    assert!(Command::new("mkfifo").arg(path).status().unwrap().success());
}

/// What is planted where: a manifest of either format under either name, and what replaces it.
const PLANTED: [(&str, u32, &str, &str); 4] = [
    ("a1", 1, ".manifest.old.json", ""),
    ("a2", 2, ".manifest.old.json", ""),
    ("b1", 1, "manifest.json", "--overwrite"),
    ("b2", 2, "manifest.json", "--overwrite"),
];

/// A manifest of a format that lists files with their true sizes and digests.
fn plant(bench: &Bench, name: &str, format: u32, folder: &str, files: &[&str]) {
    let mut manifest = Manifest::default();
    for file in files {
        manifest.files.insert((*file).to_owned(), hash_file(bench.path(folder).join(file)).unwrap());
    }
    let text = manifest.to_json().unwrap();
    assert!(text.contains("holo manifest 2"), "{text}");
    fs::write(bench.path(folder).join(name), text.replace("holo manifest 2", &format!("holo manifest {format}")))
        .unwrap();
}

/// Waits until a file of a folder has a name, and returns it.
fn wait_for(child: &mut Child, folder: &Path, is_it: impl Fn(&str) -> bool) -> String {
    let start = Instant::now();
    loop {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        let mut names = entries.map(|entry| entry.file_name().into_string().unwrap());
        if let Some(name) = names.find(|name| is_it(name)) {
            return name;
        }
        assert!(child.try_wait().unwrap().is_none(), "it is done already");
        assert!(start.elapsed() < LONG, "there is no such file");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Row 1.
#[test]
fn a_planted_manifest_deletes_nothing_through_a_link() {
    let bench = bench();
    for (out, format, name, more) in PLANTED {
        fs::create_dir(bench.path(out)).unwrap();
        symlink("../victim", bench.path(out).join("x")).unwrap();
        symlink("../victim", bench.path(out).join("depth")).unwrap();
        plant(&bench, name, format, out, &["x/keep.txt", "depth/keep.txt"]);
        let outcome = holo(&bench, &format!("render {SCENE} --out {out} {SMALL} --spp 1 {more}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        assert_eq!(outcome.stderr.contains("is not used"), name == ".manifest.old.json", "{outcome:?}");
    }
}

/// Row 2.
#[test]
fn a_planted_manifest_deletes_no_file_that_no_job_writes_or_that_has_changed() {
    let bench = bench();
    for (out, format, name, more) in PLANTED {
        fs::create_dir_all(bench.path(out).join(".git")).unwrap();
        let own = ["thesis.tex", ".git/config", "scene_notes.png"];
        own.iter().for_each(|file| fs::write(bench.path(out).join(file), *file).unwrap());
        plant(&bench, name, format, out, &own);
        fs::write(bench.path(out).join("scene_notes.png"), "scene_nOtes.png").unwrap();
        let outcome = holo(&bench, &format!("render {SCENE} --out {out} {SMALL} --spp 1 {more}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        assert!(own.iter().all(|file| bench.path(out).join(file).is_file()), "{:?}", bench.list(out));
    }
    // What is of an older result of this program, and as it was, goes.
    bench.render("c", "--write el,depth");
    holo(&bench, &format!("render {SCENE} --out c {SMALL} --spp 1 --write el --overwrite"));
    assert!(!bench.path("c/scene_depth.pfm").exists());
}

/// Row 2: files in the root of a dataset that only have the names of its own.
#[test]
fn a_dataset_replaces_no_file_that_only_has_a_name_of_its_own() {
    let bench = bench();
    let arguments = format!("dataset --glb {SCENE} --scenes none --views 3x3 --spp 1 --out set");
    let poses = r#"{"frames": [{"file_path": "a", "fl_x": 9, "w": 8, "h": 6, "note": "mine",
        "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,1],[0,0,0,1]]}]}"#;
    fs::write(bench.path("mine.json"), poses).unwrap();
    // What a stranger says of a folder grants no right.
    let complete = format!("{} --sensor 36x24", arguments.replace("--out set", "--out whole"));
    assert_eq!(holo(&bench, &complete).code, Some(0));
    let planted = fs::read(bench.path("whole/dataset.json")).unwrap();
    let names = ["train.txt", "test.txt", "light_fields.csv", "croissant.json", "contact_sheet_3x3.png", "DATASET.md"];
    for (name, text) in
        names.map(|name| (name, "mine\n")).into_iter().chain([("dataset.json", "{}"), ("transforms.json", poses)])
    {
        fs::create_dir(bench.path("set")).unwrap();
        if name != "dataset.json" {
            fs::write(bench.path("set/dataset.json"), &planted).unwrap();
        }
        fs::write(bench.path("set").join(name), text).unwrap();
        let before = bench.list("set");
        let pixels = if name == "transforms.json" { "--transforms mine.json --focus-m 1" } else { "--sensor 36x24" };
        failed(&holo(&bench, &format!("{arguments} {pixels}")), &[name, "did not write this one"]);
        assert_eq!(bench.list("set"), before);
        assert_eq!(fs::read_to_string(bench.path("set").join(name)).unwrap(), text);
        assert!(name == "dataset.json" || fs::read(bench.path("set/dataset.json")).unwrap() == planted);
        fs::remove_dir_all(bench.path("set")).unwrap();
    }
    // Other sheets than those of the dataset are no concern of it, and its own give way to another dataset.
    fs::write(bench.path("whole/contact_sheet_9x9.png"), "mine").unwrap();
    let other = complete.replace("3x3", "2x2");
    assert_eq!(holo(&bench, &other).code, Some(0));
    let list = bench.list("whole");
    let has = |name: &str| list.iter().any(|entry| entry == name);
    assert!(has("contact_sheet_9x9.png") && has("contact_sheet_2x2.png") && !has("contact_sheet_3x3.png"), "{list:?}");
    // Poses that are read from the folder where those of the images would be written.
    fs::create_dir(bench.path("poses")).unwrap();
    fs::write(bench.path("poses/transforms.json"), poses).unwrap();
    let render =
        format!("render {SCENE} --transforms poses/transforms.json --views 3x3 --spp 1 --focus-m 1 --out poses");
    let outcome = holo(&bench, &render);
    assert!(outcome.code == Some(2) && outcome.stderr.contains("came from elsewhere"), "{outcome:?}");
    assert_eq!(bench.list("poses"), ["transforms.json"]);
}

/// Row 2: the array of all frames.
#[test]
fn a_sequence_replaces_no_array_of_another() {
    let bench = bench();
    assert_eq!(holo(&bench, "scene pendulum").code, Some(0));
    let render = "render pendulum.glb --frame 3-4 --lenses 12x8 --views 3x2 --spp 1 --quiet --overwrite";
    for target in [None, Some("../victim/keep.txt")] {
        fs::create_dir(bench.path("out")).unwrap();
        let file = bench.path("out/sequence_5d.h5");
        match target {
            Some(target) => symlink(target, &file).unwrap(),
            None => fs::write(&file, "mine").unwrap(),
        }
        if cfg!(feature = "hdf5") {
            let outcome = holo(&bench, &format!("{render} --out out --write h5"));
            assert!(outcome.code == Some(2) && outcome.stderr.contains("came from elsewhere"), "{outcome:?}");
            assert_eq!(bench.list("out"), ["sequence_5d.h5"]);
        }
        let outcome = holo(&bench, &format!("{render} --out out --write el"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        assert_eq!(fs::read(&file).unwrap(), if target.is_some() { "keep" } else { "mine" }.as_bytes());
        fs::remove_dir_all(bench.path("out")).unwrap();
    }
    if cfg!(feature = "hdf5") {
        // Its own goes, because the frames get another shape.
        assert_eq!(holo(&bench, &format!("{render} --out out --write h5")).code, Some(0));
        assert!(bench.path("out/sequence_5d.h5").is_file());
        assert_eq!(holo(&bench, &format!("{render} --out out --write el")).code, Some(0));
        assert!(!bench.path("out/sequence_5d.h5").exists());
    }
}

/// Row 3.
#[test]
fn a_link_of_the_name_of_a_checkpoint_is_not_followed() {
    let bench = bench();
    let command = format!("render {SCENE} --out out {SLOW} --checkpoint 0.05");
    let mut child = start(bench.command(&command));
    let name = wait_for(&mut child, &bench.path("out"), |name| name.ends_with(".checkpoint"));
    child.kill().unwrap();
    child.wait().unwrap();
    let path = bench.path("out").join(name);
    for is_link in [true, false] {
        fs::remove_file(&path).unwrap();
        match is_link {
            true => symlink("../victim/keep.txt", &path).unwrap(),
            false => fs::hard_link(bench.path("victim/keep.txt"), &path).unwrap(),
        }
        let outcome = holo(&bench, &format!("{command} --overwrite"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        assert!(outcome.stderr.contains("checkpoint"), "{outcome:?}");
        assert!(path.symlink_metadata().is_ok(), "it is not removed either");
    }
}

/// Row 5.
#[test]
fn pack_archives_no_device_and_nothing_behind_a_link() {
    let bench = bench();
    let made = holo(
        &bench,
        &format!("dataset --out set --glb {SCENE} --sensor 30x20 --views 3 --spp 1 --write depth --quiet"),
    );
    assert_eq!(made.code, Some(0), "{made:?}");
    let (file, manifest) = (bench.path("set/tiny/3x3/scene_depth.pfm"), bench.path("set/tiny/3x3/manifest.json"));
    for target in ["/dev/zero", "../../../victim/keep.txt"] {
        // As text, so that the format stays that of the program.
        let mut listed: serde_json::Value = serde_json::from_slice(&fs::read(&manifest).unwrap()).unwrap();
        listed["files"]["scene_depth.pfm"]["bytes"] = if target == "/dev/zero" { 0.into() } else { 4.into() };
        fs::write(&manifest, listed.to_string()).unwrap();
        fs::remove_file(&file).unwrap();
        symlink(target, &file).unwrap();
        // A larger archive would be one without an end.
        let mut command = Command::new("sh");
        command.args(["-c", "trap '' XFSZ; ulimit -f 20000; exec \"$0\" \"$@\""]).arg(common::program());
        command.args(["pack", "set", "--out", "packed"]).current_dir(bench.path(""));
        failed(&run(&bench, command), &["symbolic link"]);
        assert!(!bench.path("packed").exists());
    }
}

/// Row 6.
#[test]
fn no_library_of_the_working_folder_is_loaded() {
    let bench = bench();
    for folder in ["holo/embree", ".cache/holo/embree", "bin"] {
        fs::create_dir_all(bench.path(folder)).unwrap();
        fs::write(bench.path(folder).join("libembree4.so.4"), "no library").unwrap();
    }
    // The copy has no folder `embree` next to it.
    fs::copy(common::program(), bench.path("bin/holo")).unwrap();
    for value in ["", ".", "holo/.."] {
        let mut command = Command::new(bench.path("bin/holo"));
        command.current_dir(bench.path("")).args(format!("render {SCENE} --out out {SMALL} --spp 1").split(' '));
        command.args(["--backend", "embree", "--overwrite"]).env_remove("HOLO_EMBREE_LIB");
        command.env("HOME", value).env("XDG_CACHE_HOME", value).stdin(Stdio::null());
        let outcome = run(&bench, command);
        // Unless the system has one.
        assert!(outcome.code == Some(0) || outcome.stderr.contains("no Embree 4 found"), "{outcome:?}");
        assert!(!outcome.stderr.contains("holo/embree"), "{outcome:?}");
    }
}

/// Row 7.
#[test]
fn a_second_render_into_one_folder_is_refused() {
    let bench = bench();
    let mut child = start(bench.command(&format!("render {SCENE} --out out {SLOW}")));
    wait_for(&mut child, &bench.path("out"), |name| name == ".holo.lock");
    // The lock is taken before it names its holder.
    std::thread::sleep(Duration::from_millis(100));
    for more in ["", "--overwrite"] {
        let outcome = holo(&bench, &format!("render {SCENE} --out out {SMALL} --spp 1 {more}"));
        failed(&outcome, &["is writing in it", &format!("process {} on ", child.id())]);
    }
    child.kill().unwrap();
    child.wait().unwrap();
    // The lock goes with its process, whatever is left of its file.
    bench.render("out", "");
    assert_eq!(holo(&bench, "verify out").code, Some(0));
    assert!(!bench.list("out").contains(&".holo.lock".to_owned()));
}

/// Row 8.
#[test]
fn nothing_is_written_through_a_link() {
    let bench = bench();
    for (out, name, target) in [("a", "scene_el.png", "../victim/keep.txt"), ("b", "hci", "../victim")] {
        fs::create_dir(bench.path(out)).unwrap();
        symlink(target, bench.path(out).join(name)).unwrap();
        for more in ["", "--overwrite"] {
            let outcome = holo(&bench, &format!("render {SCENE} --out {out} {SMALL} --spp 1 --write el,hci {more}"));
            failed(&outcome, &["symbolic link", name]);
            assert_eq!(bench.list(out), [name], "what was made goes, and the link stays");
        }
    }
    // The folder itself is the user's own choice, and so is a single file.
    symlink("real", bench.path("link")).unwrap();
    fs::create_dir(bench.path("real")).unwrap();
    bench.render("link", "");
    assert!(bench.path("real/manifest.json").is_file());
    symlink("real.png", bench.path("link.png")).unwrap();
    fs::write(bench.path("real.png"), "").unwrap();
    let outcome = holo(&bench, "remap link/scene_el.png link.png --from el --to vpi --views 5x4");
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(bench.path("link.png").is_symlink() && bench.path("real.png").metadata().unwrap().len() > 0);
}

/// Row 9.
#[test]
fn a_pipe_makes_nobody_wait() {
    let bench = bench();
    for name in ["manifest.json", "scene_el.png", ".holo.lock", ".scene_el.png.1-1.part"] {
        let out = format!("of{name}");
        fs::create_dir(bench.path(&out)).unwrap();
        pipe(&bench.path(&out).join(name));
        let outcome = holo(&bench, &format!("render {SCENE} --out {out} {SMALL} --spp 1 --overwrite"));
        // One of a name that nobody needs is left alone.
        let expected = if name.ends_with(".part") { Some(0) } else { Some(1) };
        assert_eq!(outcome.code, expected, "{name}: {outcome:?}");
        holo(&bench, &format!("verify {out}"));
        holo(&bench, &format!("info {out}"));
    }
    bench.render("out", "--write el,depth");
    fs::remove_file(bench.path("out/scene_el.png")).unwrap();
    pipe(&bench.path("out/scene_el.png"));
    pipe(&bench.path("out/.holo-0123456789abcdef.checkpoint"));
    assert_eq!(holo(&bench, "verify out").code, Some(1));
    assert_eq!(holo(&bench, "extract out --view 0,0 --out view.png").code, Some(1));
    fs::remove_file(bench.path("out/scene_el.png")).unwrap();
    assert_eq!(holo(&bench, &format!("render {SCENE} --out out {SMALL} --spp 1 --overwrite")).code, Some(0));
}

/// The images of views are files of their folder: in those of HCI, of the gantry, and of images.
#[test]
fn views_are_read_through_no_link_and_no_pipe() {
    let bench = bench();
    bench.render("out", "--write el,hci");
    let images = |folder: &str, names: [&str; 2]| {
        fs::create_dir(bench.path(folder)).unwrap();
        for name in names {
            fs::copy(bench.path("out/scene_el.png"), bench.path(folder).join(name)).unwrap();
        }
    };
    images("gantry", ["out_00_00_-1.5_2.5.png", "out_00_01_-2.5_2.5.png"]);
    images("images", ["a1.png", "a2.png"]);
    for (folder, name, views) in [
        ("out/hci", "input_Cam003.png", ""),
        ("gantry", "out_00_01_-2.5_2.5.png", ""),
        ("images", "a2.png", "--views 2x1"),
    ] {
        let arguments = format!("extract {folder} --view 0,0 --out view.png {views}");
        let path = bench.path(folder).join(name);
        let own = fs::read(&path).unwrap();
        fs::remove_file(&path).unwrap();
        symlink(bench.path("victim/keep.txt"), &path).unwrap();
        failed(&holo(&bench, &arguments), &["symbolic link", name]);
        fs::remove_file(&path).unwrap();
        pipe(&path);
        failed(&holo(&bench, &arguments), &["pipe", name]);
        holo(&bench, &format!("info {folder}"));
        fs::remove_file(&path).unwrap();
        fs::write(&path, own).unwrap();
        assert!(!bench.path("view.png").exists());
    }
    // The numbers beside the images are not read, and the images alone have no grid.
    fs::remove_file(bench.path("out/hci/parameters.cfg")).unwrap();
    pipe(&bench.path("out/hci/parameters.cfg"));
    let outcome = holo(&bench, "extract out/hci --view 0,0 --out view.png");
    assert!(outcome.code == Some(2) && outcome.stderr.contains("grid"), "{outcome:?}");
    fs::create_dir(bench.path("poses")).unwrap();
    let link = |path: &Path| symlink("../victim/keep.txt", path).unwrap();
    for make in [&pipe as &dyn Fn(&Path), &link] {
        let path = bench.path("poses/transforms.json");
        make(&path);
        failed(&holo(&bench, "verify poses"), &["transforms.json"]);
        fs::remove_file(&path).unwrap();
    }
}

/// What belongs to a file that is named lies beside it: the camera of a raw image and its lens, masks of a map.
#[test]
fn files_beside_a_named_one_are_read_through_no_link_and_no_pipe() {
    let bench = bench();
    fs::write(bench.path("small.toml"), CAMERA).unwrap();
    let made = holo(&bench, &format!("render {SCENE} --out raw --camera-file small.toml --spp 1 --sky 1,1,1"));
    assert_eq!(made.code, Some(0), "{made:?}");
    let (camera, lens) = (bench.path("raw/camera.toml"), bench.path("raw/lens.csv"));
    let commands = ["decode raw --out views", "depth raw/raw.exr --out map.pfm", "view raw/raw.exr -o page.html"];
    let text = fs::read_to_string(&camera).unwrap().replace("[main_lens]", "[main_lens]\nprescription = \"lens.csv\"");
    fs::write(&camera, text).unwrap();
    let link = |path: &Path| symlink("../victim/keep.txt", path).unwrap();
    for (make, word) in [(&pipe as &dyn Fn(&Path), "pipe"), (&link, "symbolic link")] {
        make(&lens);
        commands.iter().for_each(|command| failed(&holo(&bench, command), &["lens.csv", word]));
        fs::remove_file(&lens).unwrap();
    }
    fs::remove_file(&camera).unwrap();
    symlink("../small.toml", &camera).unwrap();
    failed(&holo(&bench, "decode raw --out views"), &["camera.toml", "symbolic link"]);
    assert!(!bench.path("views").exists() && !bench.path("map.pfm").exists());

    let size = "--lenses 96x64 --views 5 --baseline-m 0.05 --spp 1";
    let made = holo(&bench, &format!("render {SCENE} --out out {size} --write el,disparity,masks"));
    assert_eq!(made.code, Some(0), "{made:?}");
    let map = "out/scene_disparity.pfm";
    let scores = || {
        let outcome = holo(&bench, &format!("eval {map} {map} --border 0"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        outcome.stdout + &outcome.stderr
    };
    let own = ["occluded", "scene_hit_mask.png"];
    let of_regions = scores();
    assert!(own.iter().all(|name| of_regions.contains(name)), "{of_regions}");
    fs::create_dir(bench.path("away")).unwrap();
    for name in ["masks", "scene_hit_mask.png"] {
        fs::rename(bench.path("out").join(name), bench.path("away").join(name)).unwrap();
        symlink(format!("../away/{name}"), bench.path("out").join(name)).unwrap();
    }
    let without = scores();
    assert!(!own.iter().any(|name| without.contains(name)), "{without}");
}

/// Row 11.
#[test]
fn names_reach_the_terminal_and_other_files_escaped() {
    let bench = bench();
    let mut scene = common::tiny_scene();
    scene.cameras[0].name = "\u{1b}[2J\u{202e}\nname".into();
    fs::write(bench.path("names.glb"), holo_scene::gltf::to_glb(&scene).unwrap()).unwrap();
    for arguments in [format!("render names.glb --out out {SMALL} --camera none"), "info names.glb".into()] {
        let outcome = holo(&bench, &arguments);
        let shown = format!("{}{}", outcome.stdout, outcome.stderr);
        assert!(shown.contains("\\u{1b}[2J"), "{outcome:?}");
        assert!(!shown.contains(['\u{1b}', '\u{202e}']), "{outcome:?}");
    }
    // A line break in the name of a scene.
    fs::copy(bench.path(SCENE), bench.path("a\nb.glb")).unwrap();
    let mut command = bench.command("dataset --out set --sensor 30x20 --views 3 --spp 1 --quiet");
    command.args(["--glb", "a\nb.glb"]);
    failed(&run(&bench, command), &["a\\nb", "rename"]);
    let mut command = bench.command(&format!("render --out out {SMALL} --spp 1"));
    command.arg("a\nb.glb");
    let outcome = run(&bench, command);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let text = fs::read_to_string(bench.path("out/parameters.cfg")).unwrap();
    assert!(text.contains("scene = a\\nb\n"), "{text}");
}

/// Row 12.
#[test]
fn long_texts_are_shortened_and_links_beside_a_scene_stay_inside() {
    let bench = bench();
    let mut scene = common::tiny_scene();
    scene.cameras[0].name = "x".repeat(60_000);
    fs::write(bench.path("long.glb"), holo_scene::gltf::to_glb(&scene).unwrap()).unwrap();
    let outcome = holo(&bench, &format!("render long.glb --out out {SMALL} --camera none"));
    assert!(outcome.stderr.len() < 1_000, "{}", outcome.stderr.len());
    fs::create_dir(bench.path("scene")).unwrap();
    let text = r#"{"asset": {"version": "2.0"}, "buffers": [{"uri": "keep.bin", "byteLength": 4}]}"#;
    fs::write(bench.path("scene/scene.gltf"), text).unwrap();
    symlink("../victim/keep.txt", bench.path("scene/keep.bin")).unwrap();
    failed(&holo(&bench, &format!("render scene/scene.gltf --out out {SMALL}")), &["leads out of the folder"]);
    // Inside the folder a link is as good as a file.
    fs::remove_file(bench.path("scene/keep.bin")).unwrap();
    fs::write(bench.path("scene/real.bin"), "keep").unwrap();
    symlink("real.bin", bench.path("scene/keep.bin")).unwrap();
    failed(&holo(&bench, &format!("render scene/scene.gltf --out out {SMALL}")), &["nothing to look at"]);
}
