//! What commands do with existing files, and formats for other programs.

use crate::common;
use crate::common::{Bench, SCENE, SMALL, ok};
#[cfg(feature = "hdf5")]
use crate::python;
use holo_io::{HciFolder, HciQuantity, HciResolution, Limits, Manifest, read_exr, read_pfm_gray};
use serde_json::Value;

/// Refused with exit code 2 and these words; the folder stays as it is.
fn refused(bench: &Bench, folder: &str, arguments: &str, words: &[&str]) {
    let before = bench.bytes(folder);
    let outcome = bench.run(arguments);
    assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:?}");
    assert!(words.iter().all(|word| outcome.stderr.contains(word)), "{arguments}: {outcome:?}");
    assert!(bench.bytes(folder) == before, "{arguments}");
}

#[test]
fn another_image_is_not_replaced_unasked() {
    let bench = Bench::new();
    let render = |more: &str| format!("render {SCENE} --out out {SMALL} {more}");
    ok(bench.run(&render("--spp 1")));
    let first = bench.bytes("out");
    ok(bench.run(&render("--spp 1")));
    assert!(bench.bytes("out") == first, "the same command again");
    ok(bench.run(&render("--spp 1 --threads 1")));
    refused(&bench, "out", &render("--spp 2"), &["--spp has changed", "--overwrite", "--out"]);
    refused(&bench, "out", &render("--spp 1 --write depth"), &["--write has changed"]);
    refused(&bench, "out", &render("--spp 1 --seed 3"), &["--seed=0", "--seed=3"]);
    refused(&bench, "out", &render("--spp 1 --shard 1/2"), &["another part"]);
    std::fs::copy(bench.path(SCENE), bench.path("other.glb")).unwrap();
    ok(bench.run(&format!("render other.glb --out out {SMALL} --spp 1")));
    let mut scene = common::tiny_scene();
    scene.instances.pop();
    std::fs::write(bench.path("other.glb"), holo_scene::gltf::to_glb(&scene).unwrap()).unwrap();
    refused(&bench, "out", &format!("render other.glb --out out {SMALL} --spp 1"), &["the scene has changed"]);
    ok(bench.run(&render("--spp 2 --overwrite")));
    assert!(bench.bytes("out") != first);
    // A folder of the user's own files holds no image.
    std::fs::create_dir(bench.path("own")).unwrap();
    std::fs::write(bench.path("own/mine.txt"), "keep").unwrap();
    ok(bench.run(&format!("render {SCENE} --out own {SMALL} --spp 1")));
    assert_eq!(std::fs::read(bench.path("own/mine.txt")).unwrap(), b"keep");
}

#[test]
fn extract_and_remap_create_their_folders() {
    let bench = Bench::new();
    bench.render("out", "");
    ok(bench.run("extract out --view all --out views/of/out.png"));
    assert_eq!(bench.list("views/of").len(), 20);
    ok(bench.run("remap out/scene_el.png grids/again_vpi.png"));
    assert_eq!(common::read_u8(bench.path("grids/again_vpi.png")), common::read_u8(bench.path("out/scene_vpi.png")));
    std::fs::write(bench.path("file"), "mine").unwrap();
    let outcome = bench.run("remap out/scene_el.png file/again_vpi.png");
    assert!(outcome.code == Some(1) && outcome.stderr.contains("cannot create the folder file"), "{outcome:?}");
}

#[test]
fn animations_are_png_gif_and_mp4() {
    let bench = Bench::new();
    bench.render("out", "");
    ok(bench.run("animate out --out circle.gif"));
    assert!(std::fs::read(bench.path("circle.gif")).unwrap().starts_with(b"GIF89a"));
    ok(bench.run("animate out --out circle.png"));
    ok(bench.run("animate out --frames --out frame.tif"));
    assert!(bench.path("frame_000.tif").is_file());
    let outcome = bench.run("animate out --out circle.tif");
    assert!(outcome.code == Some(2) && outcome.stderr.contains("--frames"), "{outcome:?}");
    let mut command = bench.command("animate out --out circle.mp4");
    command.env("PATH", "");
    let outcome = common::outcome(command);
    assert!(outcome.code == Some(1) && outcome.stderr.contains("ffmpeg on PATH"), "{outcome:?}");
    assert!(!bench.list("").iter().any(|name| name.contains("mp4")), "{:?}", bench.list(""));
}

/// A program in the place of ffmpeg: it keeps what it is told and given.
#[cfg(unix)]
#[test]
fn mp4_is_what_ffmpeg_makes_of_the_frames() {
    use std::os::unix::fs::PermissionsExt;

    let bench = Bench::new();
    bench.render("out", "");
    std::fs::create_dir(bench.path("bin")).unwrap();
    let script = |text: &str| {
        std::fs::write(bench.path("bin/ffmpeg"), format!("#!/bin/sh\n{text}\n")).unwrap();
        std::fs::set_permissions(bench.path("bin/ffmpeg"), std::fs::Permissions::from_mode(0o755)).unwrap();
    };
    let run = || {
        let mut command = bench.command("animate out --path sweep --fps 12 --out sweep.mp4");
        let path = std::env::var("PATH").unwrap_or_default();
        command.env("PATH", format!("{}:{path}", bench.path("bin").display()));
        common::outcome(command)
    };
    script("echo \"$@\" > said; for last; do :; done; cat > \"$last\"");
    ok(run());
    let said = std::fs::read_to_string(bench.path("said")).unwrap();
    for words in ["-f rawvideo -pix_fmt rgb24 -s 12x8 -r 12 -i -", "libx264", "yuv420p"] {
        assert!(said.contains(words), "{words} in {said}");
    }
    // Five views of one row, in order.
    let vpi = common::read_u8(bench.path("out/scene_vpi.png"));
    let row: Vec<u8> = (0..5)
        .flat_map(|s| vpi.slice(ndarray::s![16..24, s * 12..(s + 1) * 12, ..]).iter().copied().collect::<Vec<_>>())
        .collect();
    assert!(std::fs::read(bench.path("sweep.mp4")).unwrap() == row);
    std::fs::remove_file(bench.path("sweep.mp4")).unwrap();
    script("cat > /dev/null; echo 'no such encoder' >&2; exit 3");
    let outcome = run();
    assert!(outcome.code == Some(1) && outcome.stderr.contains("no such encoder"), "{outcome:?}");
    assert!(!bench.list("").iter().any(|name| name.contains("mp4")), "{:?}", bench.list(""));
}

#[test]
fn a_dataset_of_own_scenes_is_of_these_alone() {
    let bench = Bench::new();
    let arguments = "--sensor 30x20 --views 3 --spp 1 --write depth --quiet";
    ok(bench.run(&format!("dataset --out set --glb {SCENE} {arguments}")));
    let folders: Vec<String> =
        bench.list("set").into_iter().filter(|name| name.matches('/').count() == 1 && name.ends_with('/')).collect();
    assert_eq!(folders, ["tiny/"]);
    let outcome = bench.run(&format!("dataset --out set --gallery --scenes garden {arguments}"));
    assert!(outcome.code == Some(2) && outcome.stderr.contains("cannot be used with"), "{outcome:?}");
}

#[test]
fn high_resolution_truth_is_that_of_the_same_surfaces() {
    let bench = Bench::new();
    bench.render("out", "--write hci-highres --baseline-m 0.05");
    let hci = HciFolder::open(bench.path("out/hci")).unwrap();
    let parameters = hci.parameters();
    assert_eq!(parameters.depth_map_scale, Some(10.0));
    assert_eq!((parameters.frustum_disp_min, parameters.frustum_disp_max), (parameters.disp_min, parameters.disp_max));
    assert!(parameters.disp_min.is_some());
    let read = |quantity, resolution| hci.central_truth(quantity, resolution, &Limits::default()).unwrap().unwrap();
    let (depth, low) = (read(HciQuantity::Depth, HciResolution::High), read(HciQuantity::Depth, HciResolution::Low));
    let disparity = read(HciQuantity::Disparity, HciResolution::High);
    assert_eq!((depth.dim(), low.dim()), ((80, 120), (8, 12)));
    let rig = hci.rig().unwrap();
    // Disparity in pixels of the views, not of the finer grid.
    assert_eq!(disparity, rig.disparity().map_from_depth_m(&depth));
    // The center of a pixel lies between the middle four of its hundred values.
    let mut equal = 0;
    for ((v, u), &low) in low.indexed_iter() {
        let middle = [(4, 4), (4, 5), (5, 4), (5, 5)].map(|(i, j)| depth[[10 * v + i, 10 * u + j]]);
        let (least, most) = middle.iter().fold((f32::INFINITY, 0.0_f32), |(a, b), &z| (a.min(z), b.max(z)));
        equal += usize::from(low >= least * 0.999_999 && (low <= most * 1.000_001 || most.is_infinite()));
    }
    // All but pixels with a silhouette through their middle.
    assert!(equal >= 90, "{equal} of 96");
    assert_eq!(bench.run("verify out").code, Some(0));
    let outcome = bench.run(&format!("render {SCENE} --out part {SMALL} --write hci-highres --shard 1/2"));
    assert!(outcome.code == Some(2) && outcome.stderr.contains("without --shard"), "{outcome:?}");
    // The keys that HCI's own reader asks for.
    let text = std::fs::read_to_string(bench.path("out/hci/parameters.cfg")).unwrap();
    for key in [
        "fstop",
        "center_cam_rz_rad",
        "disp_min",
        "frustum_disp_min",
        "frustum_disp_max",
        "depth_map_scale",
        "category",
    ] {
        assert!(text.contains(&format!("\n{key} =")), "{key}");
    }
}

#[test]
fn truth_alone_is_written_without_images() {
    let bench = Bench::new();
    let outputs = if cfg!(feature = "hdf5") { "h5,exr,hci" } else { "exr,hci" };
    bench.render("all", "--write el,depth --layers disparity");
    ok(bench.run(&format!("render {SCENE} --out truth {SMALL} --integrator depth --write {outputs}")));
    let files = bench.list("truth");
    // The mask is truth too.
    let images: Vec<_> = files.iter().filter(|name| name.ends_with(".png")).collect();
    assert_eq!(images, ["scene_hit_mask.png"]);
    let depth = read_pfm_gray(bench.path("all/scene_depth.pfm"), &Limits::default()).unwrap();
    let hci = read_pfm_gray(bench.path("truth/hci/gt_depth_lowres.pfm"), &Limits::default()).unwrap();
    assert_eq!(hci, depth);
    let exr = read_exr(bench.path("truth/scene_central.exr"), &Limits::default()).unwrap();
    assert_eq!(exr.channel("ViewLayer.Depth.Z"), Some(&depth));
    assert!(bench.path("truth/hci/parameters.cfg").is_file());
    assert_eq!(bench.run("verify truth").code, Some(0));
    #[cfg(feature = "hdf5")]
    if let Some(text) = python::run(
        &["h5py", "numpy"],
        "f = h5py.File(sys.argv[1])\nprint(sorted(f), sorted(f['central']), f['central/depth_m'].dims[1][0].name)\n\
         numpy.save(sys.argv[2], f['central/depth_m'][...])",
        &[bench.path("truth/scene_5d.h5").to_str().unwrap(), bench.path("depth.npy").to_str().unwrap()],
    ) {
        let expected = "['central', 's', 't', 'u', 'v'] ['depth_m', 'disparity_px', 'ray_length_m'] /u";
        assert_eq!(text.trim(), expected);
        let bytes = std::fs::read(bench.path("depth.npy")).unwrap();
        let values: Vec<f32> = bytes[bytes.len() - depth.len() * 4..]
            .chunks_exact(4)
            .map(|four| f32::from_le_bytes(four.try_into().unwrap()))
            .collect();
        assert_eq!(values, depth.iter().copied().collect::<Vec<_>>());
    }
}

#[cfg(feature = "hdf5")]
#[test]
fn info_knows_the_hdf5_file_that_render_made() {
    let bench = Bench::new();
    bench.render("out", "--write h5,depth");
    let text = ok(bench.run("info out/scene_5d.h5")).stdout;
    for part in ["5 x 4 views of 12 x 8 px", "rig: baseline", "disparity"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("unknown"), "{text}");
}

#[test]
fn eval_gives_the_angle_of_the_toolkit_beside_ours() {
    let bench = Bench::new();
    ok(bench.run(&format!(
        "render {SCENE} --out out --write disparity --baseline-m 0.05 --lenses 48x48 --views 3 --spp 1"
    )));
    let truth = bench.path("out/scene_disparity.pfm");
    let estimate = read_pfm_gray(&truth, &Limits::default()).unwrap();
    let estimate = ndarray::Array2::from_shape_fn(estimate.dim(), |(v, u)| {
        estimate[[v, u]] + 0.02 * ((v * 7 + u * 5) % 11) as f32
    });
    holo_io::write_pfm(bench.path("estimate.pfm"), estimate.view()).unwrap();
    let eval = |more: &str| ok(bench.run(&format!("eval estimate.pfm out/scene_disparity.pfm {more}"))).stdout;
    let json: Value = serde_json::from_str(&eval("--normals toolkit --json")).unwrap();
    let truth = read_pfm_gray(&truth, &Limits::default()).unwrap();
    let rig = Manifest::read(bench.path("out/manifest.json")).unwrap().rig.unwrap();
    let region = holo_core::metrics::Region { border_px: 15, mask: None };
    for (key, geometry) in [
        ("median_angle_deg", holo_core::metrics::NormalGeometry::Pinhole),
        ("median_angle_toolkit_deg", holo_core::metrics::NormalGeometry::Toolkit),
    ] {
        let angle = holo_core::metrics::median_angle_error_deg(&estimate, &truth, &rig, geometry, &region).unwrap();
        assert_eq!(json[key].as_f64(), Some(angle.value), "{key}");
    }
    assert_ne!(json["median_angle_deg"], json["median_angle_toolkit_deg"]);
    let table = eval("");
    assert!(table.contains("MedianAngleError") && !table.contains("toolkit"), "{table}");
    assert!(table.contains("mean absolute error") && !table.contains("MAE"), "{table}");
    std::fs::remove_file(bench.path("out/parameters.cfg")).unwrap();
    std::fs::remove_file(bench.path("out/manifest.json")).unwrap();
    let outcome = bench.run("eval estimate.pfm out/scene_disparity.pfm --normals toolkit");
    assert!(outcome.code == Some(1) && outcome.stderr.contains("parameters.cfg"), "{outcome:?}");
}

/// A camera that is designed for its disparities does not leave them.
#[test]
fn optics_compares_within_rounding() {
    let bench = Bench::new();
    for depths in ["2,6", "0.4,1.2", "0.333,7.7", "1.7,311"] {
        let outcome = ok(bench.run(&format!("optics --depths-m {depths} --disparity -2,2 --views 9 --lenses 512x512")));
        assert!(!outcome.stderr.contains("leave"), "{depths}: {outcome:?}");
    }
}
