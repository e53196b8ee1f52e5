//! `holo refocus`, `synthesize`, `depth`, `eval` and `epi`: what they write is what the libraries say.

use crate::common::{Bench, SCENE, ok, read_u8, read_u16, small_split};
use crate::python;
use holo_core::for_each_sample;
use holo_core::metrics::{NormalGeometry, Region, disparity_scores, median_angle_error_deg};
use holo_io::{ColorEncoding, Compression, Limits, read_pfm_gray, write_pfm, write_png};
use ndarray::{Array2, s};
use serde_json::Value;

#[test]
fn refocus_at_zero_is_the_mean_of_the_views_in_linear_light() {
    let bench = Bench::new();
    bench.render("out", "--bit-depth 16 --spp 4");
    ok(bench.run("refocus out --disparity 0 --out sharp.png"));
    let (views, lenses) = (small_split().views(), small_split().lenses());
    let raw = read_u16(bench.path("out/scene_el.png"));
    let curve = |code: u16| {
        let code = f64::from(code) / 65_535.0;
        if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
    };
    let refocused = read_u16(bench.path("sharp.png"));
    assert_eq!(refocused.dim(), (lenses.rows, lenses.columns, 3));
    for v in 0..lenses.rows {
        for u in 0..lenses.columns {
            for c in 0..3 {
                let block =
                    raw.slice(s![v * views.rows..(v + 1) * views.rows, u * views.columns..(u + 1) * views.columns, c]);
                let mean = block.iter().map(|&code| curve(code)).sum::<f64>() / views.count() as f64;
                let found = curve(refocused[[v, u, c]]);
                // f32 sums of 20 views, and the rounding of 16-bit codes where the curve is steepest.
                assert!((found - mean).abs() < 4e-5, "{v} {u} {c}: {found} {mean}");
            }
        }
    }
}

/// Half-way views are nearer to those that are rendered with the truth and with an estimate than views blended as they are.
#[test]
fn synthesized_views_are_those_that_are_rendered() {
    let bench = Bench::new();
    ok(bench.run("scene mountains --out mountains.glb"));
    let more = "--lenses 96x72 --write vpi,disparity,hci --ground-truth all --spp 16";
    ok(bench.run(&format!("render mountains.glb --out all --views 5x3 --disparity=-1,1 {more}")));
    let field = holo_io::read_light_field(bench.path("all"), &holo_io::ReadOptions::default()).unwrap();
    let rendered = field.light_field.into_linear(ColorEncoding::Srgb).unwrap();
    let reader =
        |folder: &str| holo_io::LightFieldReader::open(bench.path(folder), &holo_io::ReadOptions::default()).unwrap();
    // Every other view, whose neighbors move by twice as much.
    let maps = reader("all").disparity_px_of_views().unwrap().expect("maps of all views");
    assert_eq!(maps, reader("all/hci").disparity_px_of_views().unwrap().expect("maps of all views"));
    let central = reader("all").central_disparity_px().unwrap().expect("a map of the central view");
    assert_eq!(maps.slice(s![.., .., 1, 2]), central);
    let some = holo_core::LightField::new(rendered.samples().slice(s![.., .., ..;2, ..;2, ..]).to_owned()).unwrap();
    holo_io::write_png(
        bench.path("some_vpi.png"),
        some.to_viewpoint_grid().unwrap().mapv(encoded).view(),
        ColorEncoding::Srgb,
        Compression::Fast,
    )
    .unwrap();
    write_pfm(bench.path("map.pfm"), maps.slice(s![.., .., 2, 2]).mapv(|x| 2.0 * x).view()).unwrap();
    let error = |disparity: &str| {
        let out = ok(bench.run(&format!(
            "synthesize some_vpi.png --views 3x2 --at 1.5,0.5 --disparity {disparity} --out between.png"
        )));
        assert!(out.stderr.contains("pixels are in no view"), "{out:?}");
        assert_eq!(read_u8(bench.path("between_holes.png")).dim(), (72, 96, 1));
        let view = read_u8(bench.path("between.png"));
        let truth = rendered.view(1, 3).unwrap();
        view.iter().zip(truth).map(|(&a, &b)| (f64::from(a) - f64::from(encoded(b))).powi(2)).sum::<f64>().sqrt()
    };
    let (off, map, estimate) = (error("off"), error("map.pfm"), error("estimate"));
    println!("off {off:.1}, map {map:.1}, estimate {estimate:.1}");
    assert!(map < 0.8 * off && estimate < 0.9 * off, "{off} {map} {estimate}");
    // A view of the grid is itself, by truth of all views or of the central one.
    ok(bench.run("extract all --view 3,1 --out view.png"));
    ok(bench.run("synthesize all --at 3,1 --out same.png"));
    assert_eq!(read_u8(bench.path("view.png")), read_u8(bench.path("same.png")));
    let refused = bench.run("synthesize some_vpi.png --views 3x2 --at 1,1 --disparity truth --out x.png");
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.stderr.contains("--disparity estimate"), "{refused:?}");
    let refused = bench.run("synthesize some_vpi.png --views 3x2 --at 2.5,0 --out x.png");
    assert_eq!(refused.code, Some(2), "{refused:?}");
    assert!(refused.stderr.contains("3 x 2 views"), "{refused:?}");
}

fn encoded(linear: f32) -> u8 {
    let curve = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
    (255.0 * curve.clamp(0.0, 1.0)).round() as u8
}

#[test]
fn refocus_knows_distances_slopes_stacks_and_everything_in_focus() {
    let bench = Bench::new();
    bench.render("out", "--baseline-m 0.05 --spp 4");
    let out = ok(bench.run("info out")).stdout;
    assert!(!out.is_empty());
    let parameters = holo_io::ParametersCfg::read(bench.path("out/parameters.cfg")).unwrap().rig().unwrap();
    let disparity = parameters.disparity().from_depth_m(1.4);
    ok(bench.run("refocus out --distance-m 1.4 --out distance.png"));
    ok(bench.run(&format!("refocus out --disparity {disparity} --out disparity.png")));
    assert_eq!(read_u8(bench.path("distance.png")), read_u8(bench.path("disparity.png")));
    // The toolbox has a step of its own for each axis: 5/4 of the slope for 5 columns of views, 4/3 for 4 rows.
    ok(bench.run(&format!("refocus out --slope {} --out slope.pfm", -disparity * 0.8)));
    let file = holo_io::read_light_field(bench.path("out"), &holo_io::ReadOptions::default()).unwrap();
    let field = file.light_field.into_linear(ColorEncoding::Srgb).unwrap();
    let refocus = holo_core::refocus::Refocus::new(small_split().views()).unwrap();
    let ratio = holo_core::BaselineRatio::vertical_over_horizontal(0.8 * 4.0 / 3.0).unwrap();
    let expected = refocus.baseline_ratio(ratio).at_disparity(&field, disparity).unwrap();
    let found = holo_io::read_pfm(bench.path("slope.pfm"), &Limits::default()).unwrap().values;
    assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-5), "the same but for rounding");
    ok(bench.run(&format!("refocus out --stack {disparity},0,2 --out stack.png")));
    assert_eq!(read_u8(bench.path("stack_000.png")), read_u8(bench.path("disparity.png")));
    let map = Array2::from_elem((8, 12), disparity as f32);
    write_pfm(bench.path("map.pfm"), map.view()).unwrap();
    ok(bench.run("refocus out --all-in-focus map.pfm --out all.png"));
    let all = read_u8(bench.path("all.png"));
    let by_disparity = read_u8(bench.path("disparity.png"));
    assert!(all.iter().zip(&by_disparity).all(|(a, b)| a.abs_diff(*b) <= 1));
    // One view alone is that view.
    ok(bench.run("refocus out --disparity 0.3 --aperture disc:0.5 --out one.png"));
    ok(bench.run("extract out/scene_el.png --view 2,2 --out view.png"));
    assert_eq!(read_u8(bench.path("one.png")), read_u8(bench.path("view.png")));
}

/// One view of an HDF5 file is read without the others, and is the one among all.
#[cfg(feature = "hdf5")]
#[test]
fn one_view_of_an_hdf5_file_is_that_of_all() {
    let bench = Bench::new();
    bench.render("out", "--write h5");
    ok(bench.run("extract out/scene_5d.h5 --view all --out all.pfm"));
    ok(bench.run("extract out --view 3,1 --out one.pfm"));
    assert_eq!(bench.bytes("")["one.pfm"], bench.bytes("")["all_r01_c03.pfm"]);
    let outcome = bench.run("extract out --view 5,1 --out none.pfm");
    assert!(outcome.code == Some(2) && outcome.stderr.contains("5"), "{outcome:?}");
}

#[test]
fn an_estimate_is_written_and_judged() {
    let bench = Bench::new();
    ok(bench.run(&format!(
        "render {SCENE} --out out --lenses 60x40 --views 7 --baseline-m 0.02 --spp 16 --sky 0.3,0.3,0.3 --quiet"
    )));
    let outcome = ok(bench.run("depth out --out estimate.pfm --confidence sure.pfm --effort draft"));
    assert!(outcome.stderr.contains("7 x 7 views"), "{outcome:?}");
    // The raw image alone, with the parameters beside it, says the same.
    ok(bench.run("depth out/scene_el.png --out raw.pfm --effort draft --quiet"));
    assert_eq!(std::fs::read(bench.path("raw.pfm")).unwrap(), std::fs::read(bench.path("estimate.pfm")).unwrap());
    let estimate = read_pfm_gray(bench.path("estimate.pfm"), &Limits::default()).unwrap();
    let truth = read_pfm_gray(bench.path("out/scene_disparity.pfm"), &Limits::default()).unwrap();
    let scores = disparity_scores(&estimate, &truth, &Region::with_border(5)).unwrap();
    let json =
        ok(bench.run("eval estimate.pfm out/scene_disparity.pfm --border 5 --mask none --json --error-map error.png"))
            .stdout;
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["bad_pixels_0.07_percent"], scores.bad_pixels_percent[2]);
    assert_eq!(json["mean_squared_error_x100"], scores.mean_squared_error_x100);
    assert_eq!(json["compared"], scores.counts.compared);
    assert!(json["best_plane_bad_pixels_percent"].as_f64() <= json["best_constant_bad_pixels_percent"].as_f64());
    assert_eq!(read_u8(bench.path("error.png")).dim(), (40, 60, 3));
    // The rig beside the truth makes depths of the maps, and of these normals.
    let parameters = holo_io::ParametersCfg::read(bench.path("out/parameters.cfg")).unwrap().rig().unwrap();
    let rig = parameters;
    let region = Region::with_border(5);
    let angle = median_angle_error_deg(&estimate, &truth, &rig, NormalGeometry::Pinhole, &region).unwrap();
    assert_eq!(json["median_angle_deg"], angle.value);
    let table = ok(bench.run("eval estimate.pfm out/scene_disparity.pfm --border 5 --mask none")).stdout;
    for name in [
        "BadPix(0.01)",
        "BadPix(0.07), best plane",
        "MSE x 100",
        "Q25 x 100",
        "bumpiness",
        "mean absolute error",
        "root mean squared error",
        "MedianAngleError",
        "without a finite truth",
    ] {
        assert!(table.contains(name), "no {name} in {table}");
    }
    // A mask that leaves the left half.
    let mask = ndarray::Array3::from_shape_fn((40, 60, 1), |(_, column, _)| if column < 30 { 255_u8 } else { 0 });
    write_png(bench.path("mask.png"), mask.view(), ColorEncoding::Linear, Compression::Fast).unwrap();
    let masked = ok(bench.run("eval estimate.pfm out/scene_disparity.pfm --border 5 --mask mask.png --json")).stdout;
    let masked: Value = serde_json::from_str(&masked).unwrap();
    assert!(masked["compared"].as_u64() < json["compared"].as_u64());
}

#[test]
fn pictures_are_compared_too() {
    let bench = Bench::new();
    bench.render("out", "");
    let table = ok(bench.run("eval out/scene_el.png out/scene_vpi.png")).stdout;
    assert!(table.contains("PSNR") && table.contains("SSIM"), "{table}");
    let same = ok(bench.run("eval out/scene_el.png out/scene_el.png --json")).stdout;
    let same: Value = serde_json::from_str(&same).unwrap();
    assert_eq!((&same["ssim"], &same["psnr_db"]), (&Value::from(1.0), &Value::from("inf")));
}

/// `holo eval` beside scikit-image, on noise of 8 and of 16 bits, gray and colored. The Gaussian of SSIM is summed in another
/// order there: 1e-9.
#[test]
fn psnr_and_ssim_are_those_of_scikit_image() {
    let bench = Bench::new();
    bench.render("out", "");
    bench.render("other", "--spp 3 --seed 7");
    let noise = |seed: usize, (row, column, c): (usize, usize, usize)| {
        ((row * 7919 + column * 104_729 + c * 31 + seed * (row * column + 17)) % 65_521) as u16
    };
    for (name, seed) in [("a.png", 1), ("b.png", 3)] {
        let deep = ndarray::Array3::from_shape_fn((37, 41, 1), |at| noise(seed, at));
        holo_io::write_png(bench.path(name), deep.view(), ColorEncoding::Srgb, Compression::Fast).unwrap();
    }
    for (one, other) in [("out/scene_el.png", "other/scene_el.png"), ("a.png", "b.png")] {
        let own: Value = serde_json::from_str(&ok(bench.run(&format!("eval {one} {other} --json"))).stdout).unwrap();
        let paths = [one, other].map(|name| bench.path(name).to_str().unwrap().to_owned());
        let arguments = [paths[0].as_str(), paths[1].as_str()];
        let modules = ["numpy", "skimage", "PIL"];
        let Some(theirs) = python::run(&modules, include_str!("scikit_image.py"), &arguments) else { return };
        let theirs: Value = serde_json::from_str(&theirs).unwrap();
        for key in ["psnr_db", "ssim"] {
            let (own, theirs) = (own[key].as_f64().unwrap(), theirs[key].as_f64().unwrap());
            assert!((own - theirs).abs() <= 1e-9 * theirs.abs(), "{key} of {one}: {own} and {theirs}");
        }
    }
}

#[test]
fn an_epi_is_a_row_of_pixels_as_a_row_of_views_sees_it() {
    let bench = Bench::new();
    bench.render("out", "");
    ok(bench.run("epi out --row 3,1 --out row.png"));
    ok(bench.run("epi out --column 7,2 --out column.png"));
    // 8 rows of lenses, 4 of views.
    ok(bench.run("epi out --row 4,2 --out given.png"));
    ok(bench.run("epi out --out central.png"));
    assert!(std::fs::read(bench.path("given.png")).unwrap() == std::fs::read(bench.path("central.png")).unwrap());
    let raw = read_u8(bench.path("out/scene_vpi.png"));
    let (views, lenses) = (small_split().views(), small_split().lenses());
    let (row, column) = (read_u8(bench.path("row.png")), read_u8(bench.path("column.png")));
    assert_eq!((row.dim(), column.dim()), ((views.columns, lenses.columns, 3), (views.rows, lenses.rows, 3)));
    for s in 0..views.columns {
        for u in 0..lenses.columns {
            assert_eq!(row[[s, u, 0]], raw[[lenses.rows + 3, s * lenses.columns + u, 0]]);
        }
    }
    for t in 0..views.rows {
        for v in 0..lenses.rows {
            assert_eq!(column[[t, v, 1]], raw[[t * lenses.rows + v, 2 * lenses.columns + 7, 1]]);
        }
    }
}

#[test]
fn wrong_use_is_said() {
    let bench = Bench::new();
    bench.render("out", "");
    std::fs::create_dir(bench.path("alone")).unwrap();
    std::fs::copy(bench.path("out/scene_el.png"), bench.path("alone/scene_el.png")).unwrap();
    for (arguments, part) in [
        ("refocus out --out x.png", "--disparity"),
        ("refocus out --disparity 0 --distance-m 1 --out x.png", "cannot be used with"),
        ("refocus out --disparity 0 --aperture round --out x.png", "disc:D"),
        ("refocus out --stack 1,2 --out x.png", "A,B,N"),
        ("synthesize out --at 1 --out x.png", "S,T"),
        ("synthesize out --at 1,-0.5 --out x.png", "outside of the grid of 5 x 4 views"),
        ("synthesize out --at 1,1 --disparity none --out x.png", "truth, estimate, off"),
        ("refocus out --distance-m -1 --out x.png", "above 0"),
        ("refocus alone/scene_el.png --views 5x4 --distance-m 1 --out x.png", "camera parameters are unknown"),
        ("depth out --out x.pfm --range 2,1", "MIN,MAX"),
        ("eval out/scene_el.png out/scene_el.png --mask out/scene_el.png", "are for disparity maps"),
        ("epi out --row 8,0 --out x.png", "lens row"),
        ("epi out --row 0,0 --out x.pfm", ".png"),
        ("refocus out --disparity 0 --aperture disc:-1 --out x.png", "disc:D"),
        ("depth out --out x.pfm --range -100000,100000", "at most 4096"),
    ] {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains(part), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains("--help"), "{arguments}: {outcome:?}");
    }
    assert!(!bench.list("").iter().any(|name| name.starts_with("x.")), "nothing was written");
}

/// What is wrong with files is no wrong use, whichever file is named.
#[test]
fn errors_of_data_fail_without_advice_on_the_command_line() {
    let bench = Bench::new();
    bench.render("out", "");
    std::fs::create_dir(bench.path("empty")).unwrap();
    std::fs::write(bench.path("text.png"), "no image").unwrap();
    std::fs::write(bench.path("small.pfm"), "Pf\n1 1\n-1\n\0\0\0\0").unwrap();
    for (arguments, part) in [
        ("refocus empty --disparity 1 --out x.png", "no light field"),
        ("depth missing --out x.pfm", "missing"),
        ("extract text.png --view 0,0 --out x.png --views 2", "text.png"),
        ("eval out/scene_el.png out/scene_depth.pfm", "two disparity maps"),
        ("eval small.pfm out/scene_disparity.pfm --border 0", "shape"),
        ("eval small.pfm small.pfm", "narrower border"),
        ("refocus out --all-in-focus small.pfm --out x.png", "disparity map"),
        ("info text.png", "text.png"),
        ("verify empty", "empty"),
    ] {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(1), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains(part), "{arguments}: {outcome:?}");
        assert!(!outcome.stderr.contains("--help"), "{arguments}: {outcome:?}");
    }
}

/// The rig of a folder gets another vertical baseline on paper: what was rendered does not change, what is computed does.
fn with_vertical_baseline(bench: &Bench, factor: f64) -> holo_core::Rig {
    let light_field = holo_io::read_light_field(bench.path("out"), &holo_io::ReadOptions::default()).unwrap();
    let rig = light_field.rig.unwrap();
    let rig = rig.to_builder().baseline_y_m(rig.baseline_x_m() * factor).build().unwrap();
    for_each_sample!(DynLightField, light_field.light_field, field => {
        let options = holo_io::MatOptions::new();
        let path = bench.path("own.mat");
        holo_io::write_mat_light_field(path, &field, Some(&rig), holo_io::MatOrder::Lenses, &options).unwrap();
    });
    rig
}

#[test]
fn refocus_and_depth_follow_both_baselines() {
    let bench = Bench::new();
    bench.render("out", "--baseline-m 0.05 --spp 4");
    for factor in [0.5, 0.0] {
        let rig = with_vertical_baseline(&bench, factor);
        let file = holo_io::read_light_field(bench.path("own.mat"), &holo_io::ReadOptions::default()).unwrap();
        let field = file.light_field.into_linear(ColorEncoding::Srgb).unwrap();
        let expected = |disparity_px: f64| {
            let refocus = holo_core::refocus::Refocus::new(rig.shape().views()).unwrap();
            refocus.baseline_ratio(rig.baseline_ratio()).at_disparity(&field, disparity_px).unwrap()
        };
        let read = |name: &str| holo_io::read_pfm(bench.path(name), &Limits::default()).unwrap().values;
        ok(bench.run("refocus own.mat --disparity 0.7 --out disparity.pfm"));
        assert_eq!(read("disparity.pfm"), expected(0.7), "{factor}");
        ok(bench.run("refocus own.mat --distance-m 1.4 --out distance.pfm"));
        assert_eq!(read("distance.pfm"), expected(rig.disparity().from_depth_m(1.4)), "{factor}");
        ok(bench.run("refocus own.mat --stack 0.7,0.9,2 --out stack.pfm"));
        assert_eq!(read("stack_000.pfm"), expected(0.7), "{factor}");

        ok(bench.run("depth own.mat --range -3,3 --out estimate.pfm"));
        let found = read_pfm_gray(bench.path("estimate.pfm"), &Limits::default()).unwrap();
        let file = holo_io::read_light_field(bench.path("own.mat"), &holo_io::ReadOptions::default()).unwrap();
        let options = holo_core::PlaneSweepOptions::default().range_px(-3.0, 3.0).baseline_ratio(rig.baseline_ratio());
        let estimate = for_each_sample!(DynLightField, &file.light_field, field => {
            holo_core::plane_sweep(field, &options).unwrap()
        });
        assert_eq!(found, estimate.disparity_px, "{factor}");
    }
}
