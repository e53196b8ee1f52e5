//! What `holo render` writes: sizes, the two orders of one light field, ground truth, manifest.

use crate::common;
use crate::common::{Bench, DEFAULT_FILES, SCENE, read_u8, read_u16, small_split};
use holo_core::{GridSize, LightField};
use holo_io::{Limits, Manifest, read_pfm_gray};

#[test]
fn the_default_outputs_are_there_in_their_sizes() {
    let bench = Bench::new();
    bench.render("out", "");
    assert_eq!(bench.list("out"), DEFAULT_FILES);
    // 8 rows of lenses times 4 rows of views, 12 times 5 columns.
    let (elemental, viewpoint) = (read_u8(bench.path("out/scene_el.png")), read_u8(bench.path("out/scene_vpi.png")));
    assert_eq!(elemental.dim(), (32, 60, 3));
    assert_eq!(viewpoint.dim(), (32, 60, 3));
    assert!(elemental.iter().any(|&x| x > 100) && elemental.iter().any(|&x| x == 0), "an image with light and dark");
    let elemental = LightField::from_elemental_grid(elemental, small_split()).unwrap();
    let viewpoint = LightField::from_viewpoint_grid(viewpoint, small_split()).unwrap();
    assert_eq!(elemental.samples(), viewpoint.samples());
    let ((t, s), views) = (small_split().central_view(), small_split().views());
    assert_ne!(elemental.view(t, s).unwrap(), elemental.view(0, views.columns - 1).unwrap(), "views differ");
    assert_eq!(read_u8(bench.path("out/scene_disparity.png")).dim(), (8, 12, 1));
}

#[test]
fn depth_and_disparity_agree_by_equation_3() {
    let bench = Bench::new();
    bench.render("out", "--baseline-m 0.05");
    let manifest = Manifest::read(bench.path("out/manifest.json")).unwrap();
    let rig = manifest.rig.unwrap();
    let read = |name: &str| read_pfm_gray(bench.path("out").join(name), &Limits::default()).unwrap();
    let (depth_m, disparity_px) = (read("scene_depth.pfm"), read("scene_disparity.pfm"));
    assert_eq!((depth_m.dim(), disparity_px.dim()), ((8, 12), (8, 12)));
    assert!(depth_m.iter().any(|z| z.is_infinite()) && depth_m.iter().any(|z| z.is_finite()));
    for (&z, &d) in depth_m.iter().zip(&disparity_px) {
        let expected = rig.disparity().from_depth_m(f64::from(z));
        // Both were rounded to f32 from one depth in f64.
        let rounding = 1e-6 * rig.disparity().scale_m_px() / f64::from(z).min(1.0);
        assert!((f64::from(d) - expected).abs() <= rounding, "{z} m: {d} px, Eq. 3 says {expected}");
    }
    let finite = disparity_px.iter().map(|&d| f64::from(d)).filter(|d| d.is_finite());
    let range = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)));
    assert_eq!(manifest.disparity_px, Some(range));
    // The quads stand between 0.9 and 2.1 m.
    assert!(depth_m.iter().filter(|z| z.is_finite()).all(|z| (0.9..2.1).contains(z)));
}

#[test]
fn the_manifest_verifies_until_a_file_changes() {
    let bench = Bench::new();
    bench.render("out", "");
    let outcome = bench.run("verify out");
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
    let manifest = Manifest::read(bench.path("out/manifest.json")).unwrap();
    assert!(manifest.files.keys().map(String::as_str).eq(DEFAULT_FILES[1..].iter().copied()));

    let path = bench.path("out/scene_vpi.png");
    let mut bytes = std::fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&path, bytes).unwrap();
    std::fs::remove_file(bench.path("out/scene_depth.pfm")).unwrap();
    let outcome = bench.run("verify out");
    assert_eq!(outcome.code, Some(1), "{outcome:?}");
    assert!(outcome.stdout.contains("scene_vpi.png: changed") && outcome.stdout.contains("scene_depth.pfm: missing"));
    assert!(outcome.stderr.contains("2 of 8 files"), "{outcome:?}");
}

#[test]
fn sixteen_bits_are_the_same_image() {
    let bench = Bench::new();
    bench.render("fine", "--bit-depth 16 --exposure 1");
    bench.render("coarse", "--exposure 1");
    let (fine, coarse) = (read_u16(bench.path("fine/scene_el.png")), read_u8(bench.path("coarse/scene_el.png")));
    assert_eq!(fine.dim(), coarse.dim());
    for (&fine, &coarse) in fine.iter().zip(&coarse) {
        assert!((f64::from(fine) / 257.0 - f64::from(coarse)).abs() <= 0.51, "{fine} and {coarse}");
    }
}

/// What there is without a image.
fn without_picture() -> Vec<&'static str> {
    let shows = ["scene_5d.mat", "scene_el.png", "scene_vpi.png"];
    DEFAULT_FILES.into_iter().filter(|name| !shows.contains(name)).collect()
}

/// The array in the .mat holds the integers of the raw image, in either order, with the rig beside it.
#[test]
fn the_mat_file_is_the_raw_image() {
    let bench = Bench::new();
    for (out, more) in [("coarse", ""), ("fine", "--bit-depth 16"), ("toolbox", "--mat-order lftoolbox")] {
        bench.render(out, more);
        let mat = holo_io::read_mat_light_field(bench.path(out).join("scene_5d.mat"), &Default::default()).unwrap();
        let raw = bench.path(out).join("scene_el.png");
        match mat.light_field {
            holo_core::DynLightField::U8(field) => {
                assert_eq!(field.to_elemental_grid().unwrap(), read_u8(raw), "{out}")
            }
            holo_core::DynLightField::U16(field) => {
                assert_eq!(field.to_elemental_grid().unwrap(), read_u16(raw), "{out}")
            }
            other => panic!("{out}: {other:?}"),
        }
        let manifest = holo_io::Manifest::read(bench.path(out).join("manifest.json")).unwrap();
        assert_eq!(mat.rig, Some(manifest.rig.unwrap()), "{out}");
    }
}

/// The array in the .h5 is the linear image, and its maps are those of the PFMs.
#[cfg(feature = "hdf5")]
#[test]
fn the_hdf5_file_holds_radiance_and_ground_truth() {
    use holo_io::{Hdf5LightField, Hdf5Map, Limits, read_pfm, read_pfm_gray};
    let bench = Bench::new();
    for (out, more) in [("central", ""), ("all", "--ground-truth all")] {
        bench.render(out, &format!("--write h5,depth,disparity --layers color {more}"));
        let path = |name: &str| bench.path(out).join(name);
        let file = Hdf5LightField::open(path("scene_5d.h5"), &Limits::default()).unwrap();
        // Row 2 of 4, column 2 of 5.
        let picture = read_pfm(path("scene_color.pfm"), &Limits::default()).unwrap().values;
        assert_eq!(file.read_view(2, 2).unwrap(), picture.into(), "{out}");
        for (map, name) in [(Hdf5Map::Depth, "scene_depth.pfm"), (Hdf5Map::Disparity, "scene_disparity.pfm")] {
            let central = read_pfm_gray(path(name), &Limits::default()).unwrap();
            let stored = if out == "all" { file.read_map_of_view(map, 2, 2) } else { file.read_central_map(map) };
            assert_eq!(stored.unwrap(), central, "{out} {name}");
        }
        let manifest = holo_io::Manifest::read(path("manifest.json")).unwrap();
        assert_eq!(file.rig(), Some(&manifest.rig.unwrap()), "{out}");
    }
}

#[test]
fn only_what_is_asked_for_is_written() {
    let bench = Bench::new();
    for (write, files) in [
        ("el", &["scene_el.png"][..]),
        ("mat", &["scene_5d.mat"]),
        ("depth,vpi", &["scene_depth.pfm", "scene_hit_mask.png", "scene_vpi.png"]),
        ("disparity", &["scene_disparity.pfm", "scene_disparity.png", "scene_hit_mask.png"]),
    ] {
        bench.render(write, &format!("--write {write}"));
        let expected = [&["manifest.json", "parameters.cfg"], files].concat();
        assert_eq!(bench.list(write), expected);
        assert_eq!(bench.run(&format!("verify {write}")).code, Some(0));
    }
    bench.render("depth-only", "--integrator depth");
    assert_eq!(bench.list("depth-only"), without_picture());
}

#[test]
fn ground_truth_of_all_views_holds_the_central_one() {
    let bench = Bench::new();
    for (out, more) in [("direct", ""), ("depth", "--integrator depth"), ("many", "--spp 3")] {
        bench.render(out, &format!("--ground-truth all {more}"));
        for name in ["depth", "disparity"] {
            let read = |file: String| std::fs::read(bench.path(out).join(file)).unwrap();
            let views: Vec<_> = (0..20).map(|k| read(format!("{name}/scene_{name}_Cam{k:03}.pfm"))).collect();
            assert_eq!(bench.list(&format!("{out}/{name}")).len(), 20);
            // Row 2 of 4, column 2 of 5.
            assert_eq!(views[2 * 5 + 2], read(format!("scene_{name}.pfm")), "{out}");
            assert_ne!(views[0], views[19], "{out}");
        }
        let manifest = Manifest::read(bench.path(out).join("manifest.json")).unwrap();
        assert_eq!(manifest.files.keys().filter(|name| name.starts_with("depth/")).count(), 20);
        assert_eq!(bench.run(&format!("verify {out}")).code, Some(0));
    }
}

#[test]
fn a_scene_without_light_under_a_black_sky_gives_ground_truth_and_a_hint() {
    let bench = Bench::new();
    let mut scene = common::tiny_scene();
    scene.lights.clear();
    std::fs::write(bench.path("dark.glb"), holo_scene::gltf::to_glb(&scene).unwrap()).unwrap();
    let outcome = bench.run("render dark.glb --out dark --lenses 12x8 --views 5x4 --sky 0");
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("--sky"), "{outcome:?}");
    assert_eq!(bench.list("dark"), without_picture());
    // Whoever asks for depth alone of a scene with light is not told that it has none.
    let outcome = bench.run(&format!("render {SCENE} --out depth --lenses 12x8 --views 5x4 --write depth"));
    assert!(outcome.code == Some(0) && !outcome.stderr.contains("--sky"), "{outcome:?}");
    let outcome = bench.run("render dark.glb --out lit --lenses 12x8 --views 5x4 --spp 1 --sky 1,1,1");
    assert_eq!((outcome.code, bench.list("lit").len()), (Some(0), DEFAULT_FILES.len()), "{outcome:?}");
}

#[test]
fn a_sensor_is_divided_and_its_rest_is_named() {
    let bench = Bench::new();
    let outcome = bench.run(&format!("render {SCENE} --out out --sensor 63x33 --views 5x4 --spp 1 --write el"));
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert!(outcome.stderr.contains("3 columns and 1 rows"), "{outcome:?}");
    assert_eq!(read_u8(bench.path("out/scene_el.png")).dim(), (32, 60, 3));
}

/// Lens array shifting: more microlenses on the same sensor, of which every N-th is one of the array at rest.
#[test]
fn a_shifted_lens_array_has_the_lenses_between_as_well() {
    let bench = Bench::new();
    let line = format!("render {SCENE} --lenses 24x16 --views 3x2 --focus-m 2 --write depth,el --spp 2 --sky 0.5");
    for (out, more) in [("rest", ""), ("shifted", "--lens-shifts 3")] {
        let outcome = bench.run(&format!("{line} --out {out} {more}"));
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
    }
    let manifest = |out: &str| Manifest::read(bench.path(format!("{out}/manifest.json"))).unwrap();
    let (rest, shifted) = (manifest("rest").rig.unwrap(), manifest("shifted").rig.unwrap());
    assert_eq!(shifted.shape().lenses(), GridSize::new(48, 72));
    assert_eq!((shifted.sensor_size_m(), shifted.baseline_x_m()), (rest.sensor_size_m(), rest.baseline_x_m()));
    let depth = |out: &str| read_pfm_gray(bench.path(format!("{out}/scene_depth.pfm")), &Limits::default()).unwrap();
    let (rest, shifted) = (depth("rest"), depth("shifted"));
    for ((v, u), &depth_m) in rest.indexed_iter() {
        let same = shifted[[3 * v + 1, 3 * u + 1]];
        assert!(same == depth_m || (same / depth_m - 1.0).abs() < 1e-6, "{v} {u}: {same} m instead of {depth_m} m");
    }
    for more in ["--lens-shifts 0", "--lens-shifts 2 --camera-file home-made", "--lens-shifts 2 --transforms t.json"] {
        let outcome = bench.run(&format!("render {SCENE} --out x {more}"));
        assert!(outcome.code == Some(2) && outcome.stderr.contains("--lens-shifts"), "{outcome:?}");
    }
}
