//! Every command reads every folder that holds a light field, whatever it holds it in; and says what it reads.

use crate::common::{Bench, SCENE, bench_display, camera_bench, read_u8, run, shifted_camera};

fn refused(bench: &Bench, arguments: &str, code: i32, words: &[&str]) {
    let outcome = bench.run(arguments);
    assert_eq!(outcome.code, Some(code), "{arguments}: {outcome:?}");
    assert!(words.iter().all(|word| outcome.stderr.contains(word)), "{arguments}: {outcome:?}");
}

/// A bench with the raw image of a plenoptic camera in `raw`.
fn plenoptic() -> Bench {
    let bench = camera_bench();
    run(&bench, &format!("render {SCENE} --camera-file small.toml --spp 2 --sky 1,1,1 --out raw"));
    bench
}

/// Runs every command that takes a light field; each must say that it reads `what`. Views of floats become PFMs.
fn every_command_reads(bench: &Bench, folder: &str, what: &str, ending: &str) {
    std::fs::write(bench.path("bench.toml"), bench_display("square", 4, 4, 1)).unwrap();
    for command in [
        format!("depth {folder} --range -2,2 --effort draft --out estimate.pfm"),
        format!("refocus {folder} --disparity 0 --out sharp.png"),
        format!("synthesize {folder} --at 0.5,0.5 --disparity off --out between.{ending}"),
        format!("view {folder} --out page.html"),
        format!("extract {folder} --view 1,1 --out view.{ending}"),
        format!("epi {folder} --row 1,1 --out epi.{ending}"),
        format!("quilt {folder} --tiles 2x1 --out quilt.{ending}"),
        format!("display {folder} --display bench.toml --out panel.{ending}"),
        format!("animate {folder} --frames --out frame.{ending}"),
        format!("remap {folder} own_vpi.{ending}"),
        format!("rotate-elements {folder} own_el.{ending}"),
    ] {
        let outcome = run(bench, &command);
        assert!(outcome.stderr.contains(&format!("note: reads {what}\n")), "{command}: {outcome:?}");
    }
}

#[test]
fn every_representation_of_a_render_is_read_by_every_command() {
    let bench = Bench::new();
    bench.render("whole", "--write vpi");
    run(&bench, "extract whole --view 1,1 --out expected.png");
    for (write, removed, what, ending) in [
        ("mat", None, "scene_5d.mat", "png"),
        ("hci", None, "hci", "png"),
        ("exr,el", Some("scene_el.png"), "scene_el.exr", "pfm"),
        ("exr,vpi", Some("scene_vpi.png"), "scene_vpi.exr", "pfm"),
        #[cfg(feature = "hdf5")]
        ("h5", None, "scene_5d.h5", "pfm"),
    ] {
        bench.render("out", &format!("--write {write} --overwrite"));
        if let Some(removed) = removed {
            std::fs::remove_file(bench.path("out").join(removed)).unwrap();
        }
        every_command_reads(&bench, "out", what, ending);
        if ending == "png" {
            assert_eq!(read_u8(bench.path("view.png")), read_u8(bench.path("expected.png")), "{write}");
        }
        let info = run(&bench, "info out").stdout;
        assert!(info.starts_with("dataset folder, 5 x 4 views of 12 x 8 pixels\n"), "{info}");
    }
}

#[test]
fn the_note_is_about_choices_alone() {
    let bench = Bench::new();
    bench.render("one", "--write el");
    assert_eq!(run(&bench, "extract one --view 1,1 --out view.png").stderr, "");
    bench.render("several", "--write el,vpi,mat");
    let note = "note: reads scene_el.png\n";
    assert_eq!(run(&bench, "extract several --view 1,1 --out view.png").stderr, note);
    assert!(run(&bench, "view several --out page.html").stderr.starts_with(note));
    // Of a file there is no choice.
    assert_eq!(run(&bench, "extract several/scene_5d.mat --view 1,1 --out view.png").stderr, "");
    assert!(!run(&bench, "view several/scene_el.png --out page.html").stderr.contains("note:"));
    assert_eq!(run(&bench, "depth several --range -2,2 --out estimate.pfm --quiet").stderr, "");
}

#[test]
fn a_plenoptic_folder_is_read_as_views() {
    let bench = plenoptic();
    every_command_reads(&bench, "raw", "raw.exr", "pfm");
    run(&bench, "optics raw");
    let info = run(&bench, "info raw").stdout;
    for part in ["folder of the plenoptic camera 'small', 120 x 90 pixels", "micro-images", "holo ", "raw_linear.png"] {
        assert!(info.contains(part), "no '{part}' in {info}");
    }
    std::fs::remove_file(bench.path("raw/raw.exr")).unwrap();
    every_command_reads(&bench, "raw", "raw_linear.png", "pfm");

    // From the raw image of a focused camera views are rendered.
    let focused = shifted_camera().replace("gap_um = 400.0", "gap_um = 400.0\nfocal_um = [500.0]");
    std::fs::write(bench.path("focused.toml"), focused).unwrap();
    run(&bench, &format!("render {SCENE} --camera-file focused.toml --spp 1 --sky 1,1,1 --layers depth --out focused"));
    run(&bench, "info focused");
    run(&bench, "depth focused --out focused.pfm");
    run(&bench, "refocus focused --disparity 0 --out focused.png");
    run(&bench, "decode focused --depth focused/raw_depth.pfm --out along");
    run(&bench, "verify along");
    refused(
        &bench,
        "decode raw --depth focused/raw_depth.pfm --out x",
        2,
        &["views of an unfocused camera need no depth"],
    );
    // White images alone are none.
    run(&bench, "target --camera-file small.toml --checkerboard 5x3 --square-mm 10 --spp 1 --out target");
    assert!(run(&bench, "info target").stdout.contains("no raw image"));
    refused(&bench, "depth target --out x.pfm", 1, &["none of raw.exr, raw_linear.png"]);
}

#[test]
fn decode_finds_the_camera_beside_the_raw_image() {
    let bench = plenoptic();
    run(&bench, "decode raw/raw.exr --camera-file raw/camera.toml --out named");
    run(&bench, "decode raw/raw.exr --out beside");
    run(&bench, "decode raw --out folder");
    assert!(bench.bytes("beside") == bench.bytes("named") && bench.bytes("folder") == bench.bytes("named"));
    std::fs::create_dir(bench.path("alone")).unwrap();
    std::fs::copy(bench.path("raw/raw.exr"), bench.path("alone/raw.exr")).unwrap();
    refused(&bench, "decode alone/raw.exr --out x", 2, &["has no camera.toml", "--camera-file"]);
    refused(&bench, "decode alone --out x", 2, &["has no camera.toml", "--camera-file"]);
    run(&bench, "decode alone --camera-file small.toml --out again");
    std::fs::remove_file(bench.path("alone/raw.exr")).unwrap();
    refused(&bench, "decode alone --out x", 1, &["alone", "neither raw.exr nor raw_linear.png"]);
    refused(&bench, "decode alone/raw.exr --out x", 1, &["cannot read alone/raw.exr"]);
    assert!(!bench.path("x").exists());
}

/// Copies of the files of a render: its PNGs are never views.
#[test]
fn files_without_a_manifest_are_read() {
    let bench = Bench::new();
    bench.render("out", "");
    run(&bench, "extract out --view 3,1 --out expected.png");
    std::fs::create_dir(bench.path("copy")).unwrap();
    let copy = |name: &str| std::fs::copy(bench.path("out").join(name), bench.path("copy").join(name)).unwrap();
    for name in ["scene_el.png", "scene_vpi.png", "scene_disparity.png"] {
        copy(name);
    }
    refused(&bench, "depth copy --views 7x1 --out x.pfm", 2, &["do not divide", "--views"]);
    refused(&bench, "depth copy --out x.pfm", 2, &["parameters.cfg does not specify", "--views"]);
    refused(&bench, "compose copy --views 3x1 --out x_el.png", 2, &["has 0 images"]);
    assert_eq!(bench.run("info copy").code, Some(1));
    copy("parameters.cfg");
    run(&bench, "extract copy --view 3,1 --out view.png");
    assert_eq!(read_u8(bench.path("view.png")), read_u8(bench.path("expected.png")));
    let info = run(&bench, "info copy").stdout;
    assert!(info.contains("light field in scene_el.png") && info.contains("5 x 4 views of 12 x 8 px"), "{info}");
    copy("scene_5d.mat");
    for name in ["scene_el.png", "scene_vpi.png", "parameters.cfg"] {
        std::fs::remove_file(bench.path("copy").join(name)).unwrap();
    }
    let outcome = run(&bench, "extract copy --view 3,1 --out view.png");
    assert_eq!(outcome.stderr, "note: reads scene_5d.mat\n");
    assert_eq!(read_u8(bench.path("view.png")), read_u8(bench.path("expected.png")));
}

#[test]
fn a_dng_is_described() {
    let bench = plenoptic();
    run(&bench, "develop raw/raw.exr --sensor-model imx250 --out codes.png");
    let info = run(&bench, "info codes.dng").stdout;
    assert_eq!(info, "DNG raw image, 120 x 90 pixels, 16 bits, largest code 4095, color filter RGGB\n");
    let bytes = std::fs::read(bench.path("codes.dng")).unwrap();
    // The directory is behind the codes.
    std::fs::write(bench.path("cut.dng"), &bytes[..bytes.len() / 2]).unwrap();
    refused(&bench, "info cut.dng", 1, &["cut.dng"]);
    refused(&bench, "depth codes.dng --out x.pfm", 1, &["codes.dng", "color filter"]);
}
