//! `holo extract`, `compose`, `rotate-elements`, `quilt`, `animate` and `optics`: light fields taken apart and put together.

use crate::common::{Bench, bench_display, ok, read_u8, small_split};
use holo_core::{GridSize, LightFieldOwned};
use ndarray::s;
use serde_json::Value;

fn rendered(bench: &Bench) -> LightFieldOwned<u8> {
    bench.render("out", "--baseline-m 0.05");
    LightFieldOwned::from_elemental_grid(read_u8(bench.path("out/scene_el.png")), small_split()).unwrap()
}

#[test]
fn views_taken_out_and_put_together_are_the_raw_image() {
    let bench = Bench::new();
    let field = rendered(&bench);
    std::fs::create_dir(bench.path("views")).unwrap();
    ok(bench.run("extract out --view all --out views/v.png"));
    assert_eq!(bench.list("views").len(), 20);
    assert_eq!(read_u8(bench.path("views/v_r01_c03.png")), field.view(1, 3).unwrap());
    // Their names are in reading order: the folder is enough.
    ok(bench.run("compose views --views 5x4 --out whole_el.png"));
    assert_eq!(read_u8(bench.path("whole_el.png")), read_u8(bench.path("out/scene_el.png")));
    let listed: Vec<_> = (0..4).flat_map(|t| (0..5).map(move |s| format!("views/v_r{t:02}_c{s:02}.png"))).collect();
    ok(bench.run(&format!("compose {} --views 5x4 --out again_el.png", listed.join(" "))));
    assert_eq!(read_u8(bench.path("again_el.png")), read_u8(bench.path("out/scene_el.png")));
    // A folder of numbered images, moved as a gantry moves.
    std::fs::create_dir(bench.path("gantry")).unwrap();
    for (index, name) in listed.iter().enumerate() {
        let (t, s) = (index / 5, index % 5);
        let place = t * 5 + if t % 2 == 1 { 4 - s } else { s };
        std::fs::copy(bench.path(name), bench.path(format!("gantry/{place}.png"))).unwrap();
    }
    ok(bench.run("compose gantry --views 5x4 --order serpentine --out again_vpi.png"));
    assert_eq!(read_u8(bench.path("again_vpi.png")), read_u8(bench.path("out/scene_vpi.png")));
}

#[test]
fn some_images_and_parts_of_them() {
    let bench = Bench::new();
    let field = rendered(&bench);
    std::fs::create_dir(bench.path("some")).unwrap();
    ok(bench.run("extract out --lens 1-11:5,7 --out some/lens.png"));
    assert_eq!(bench.list("some"), ["lens_r07_c01.png", "lens_r07_c06.png", "lens_r07_c11.png"]);
    assert_eq!(read_u8(bench.path("some/lens_r07_c06.png")), field.elemental_image(7, 6).unwrap());
    ok(bench.run("extract out --view 2,3 --crop 4,1,6x2 --out crop.png"));
    assert_eq!(read_u8(bench.path("crop.png")), field.view(3, 2).unwrap().slice(s![1..3, 4..10, ..]));
}

#[test]
fn a_display_gets_its_elements_turned() {
    let bench = Bench::new();
    let field = rendered(&bench);
    ok(bench.run("rotate-elements out display_el.png"));
    let turned = read_u8(bench.path("display_el.png"));
    assert_eq!(turned, field.as_light_field_ref().rotate_elemental_images().to_elemental_grid().unwrap());
    assert_ne!(turned, read_u8(bench.path("out/scene_el.png")));
    // A raw image without a rig keeps its layout.
    ok(bench.run("rotate-elements out/scene_vpi.png whole.png --whole"));
    assert_eq!(read_u8(bench.path("whole.png")), read_u8(bench.path("out/scene_vpi.png")).slice(s![..;-1, ..;-1, ..]));
}

#[test]
fn a_quilt_holds_a_row_of_views_from_the_bottom_left() {
    let bench = Bench::new();
    let field = rendered(&bench);
    ok(bench.run("quilt out --tiles 2x2 --row 1 --out quilt.png"));
    let quilt = read_u8(bench.path("quilt.png"));
    let GridSize { rows, columns } = small_split().lenses();
    assert_eq!(quilt.dim(), (2 * rows, 2 * columns, 3));
    // Four of five views at even distances: 0, 1, 3, 4.
    assert_eq!(quilt.slice(s![rows.., ..columns, ..]), field.view(1, 0).unwrap());
    assert_eq!(quilt.slice(s![..rows, columns.., ..]), field.view(1, 4).unwrap());
}

/// What eyes see of a display agrees with the views of a rig twice as dense, rendered on their own: those at views and those
/// between them.
#[test]
fn an_eye_before_a_display_sees_the_rendered_views() {
    let bench = Bench::new();
    std::fs::write(bench.path("bench.toml"), bench_display("square", 36, 24, 5)).unwrap();
    let scene = "render plaster.glb --lenses 36x24 --spp 64 --denoise off --exposure 0 --write el --quiet";
    ok(bench.run("scene plaster --out plaster.glb"));
    ok(bench.run(&format!("{scene} --views 5 --baseline-m 0.04 --out out")));
    ok(bench.run(&format!("{scene} --views 9 --baseline-m 0.02 --out dense")));
    let shape = holo_core::LightFieldShape::new(GridSize::new(9, 9), GridSize::new(24, 36)).unwrap();
    let dense = LightFieldOwned::from_elemental_grid(read_u8(bench.path("dense/scene_el.png")), shape).unwrap();
    // The zone of a lens is a meter wide at 3 m, 20 cm for a view.
    let psnr = |eye: [f64; 2], view: (usize, usize)| {
        let arguments = format!("display out --display bench.toml --eye {},{},3 --out eye.png", eye[0], eye[1]);
        ok(bench.run(&arguments));
        let seen = read_u8(bench.path("eye.png"));
        holo_core::metrics::psnr_db(&seen, &dense.view(view.0, view.1).unwrap().to_owned(), 255.0).unwrap()
    };
    let pairs = [
        ("at a view", psnr([0.0, 0.0], (4, 4)), 34.0),
        ("at the corner", psnr([0.4, -0.4], (8, 8)), 34.0),
        ("between views", psnr([0.1, 0.1], (3, 5)), 28.0),
        ("elsewhere", -psnr([0.4, -0.4], (0, 0)), -25.0),
    ];
    println!("{pairs:?}");
    for (what, found, least) in pairs {
        assert!(found > least, "{what}: {found} dB, expected {least}");
    }
}

#[test]
fn an_animation_walks_through_the_views() {
    let bench = Bench::new();
    let field = rendered(&bench);
    ok(bench.run("animate out --path swing --row 2 --fps 10 --out moving.png"));
    assert_eq!(read_u8(bench.path("moving.png")), field.view(2, 0).unwrap(), "the first picture is the leftmost view");
    let bytes = std::fs::read(bench.path("moving.png")).unwrap();
    let at = bytes.windows(4).position(|chunk| chunk == b"acTL").expect("an animation");
    assert_eq!(bytes[at + 4..at + 8], 8_u32.to_be_bytes(), "there and back: five views and three");
    std::fs::create_dir(bench.path("frames")).unwrap();
    ok(bench.run("animate out --path sweep --frames --out frames/f.png"));
    assert_eq!(bench.list("frames"), ["f_000.png", "f_001.png", "f_002.png", "f_003.png", "f_004.png"]);
    assert_eq!(read_u8(bench.path("frames/f_004.png")), field.view(2, 4).unwrap());
}

#[test]
fn optics_tell_what_the_rig_tells_and_find_one() {
    let bench = Bench::new();
    let json = |arguments: &str| -> Value { serde_json::from_str(&ok(bench.run(arguments)).stdout).unwrap() };
    // "I need disparity within [-2, 2] px between 2 and 6 m": by hand, focus 3 m; k = 4/(1/2 - 1/6) = 12 m px and
    // baseline = k sens/(f N) = 12 * 0.035/(0.1 * 512).
    let found = json(
        "optics --views 9 --lenses 512x512 --focal-mm 100 --sensor-mm 35 --depths-m 2,6 --disparity -2,2 --json --limit-px 2.1",
    );
    assert_eq!(found["focus_distance_m"], 3.0);
    assert!((found["baseline_mm"].as_f64().unwrap() - 8.203125).abs() < 1e-12, "{found}");
    assert!((found["disparity_px"][1].as_f64().unwrap() - 2.0).abs() < 1e-12, "{found}");
    // The paper's camera by its lens pitch: 100 views.
    let paper = json("optics --lens-pitch-mm 0.45 --sensor-mm 35.784 --focus-m 1 --json");
    assert_eq!((&paper["views"]["columns"], &paper["lenses"]["columns"]), (&Value::from(100), &Value::from(79)));
    assert!((paper["baseline_mm"].as_f64().unwrap() - 10.0 / 99.0).abs() < 1e-12, "{paper}");
    // A rig that is there, and a warning about it.
    bench.render("out", "--baseline-m 0.2 --focus-m 2");
    let outcome = ok(bench.run("optics out --depths-m 1,inf --limit-px 0.5"));
    assert!(outcome.stdout.contains("5 x 4") && outcome.stdout.contains("200 mm"), "{outcome:?}");
    assert!(outcome.stderr.contains("warning: disparities from"), "{outcome:?}");
}

/// Seven curves; that of vignetting falls as the numbers of the table do.
#[test]
fn the_aberrations_of_glass_are_drawn() {
    let bench = Bench::new();
    let camera = "[sensor]\nsize_px = [600, 400]\npixel_um = 16.0\n[mla]\ngrid = \"hex-rows\"\npitch_um = 320.0\ngap_um = 900.0\n\
                  [main_lens]\nprescription = \"double-gauss\"\nfocus_m = 1.5\n";
    std::fs::write(bench.path("glass.toml"), camera).unwrap();
    let outcome = ok(bench.run("optics --camera-file glass.toml --json --plot curves.svg"));
    let table: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let svg = std::fs::read_to_string(bench.path("curves.svg")).unwrap();
    assert!(svg.starts_with("<svg ") && svg.ends_with("</svg>\n"), "{svg}");
    let curves: Vec<Vec<f64>> = svg
        .split("points=\"")
        .skip(1)
        .map(|rest| rest.split('"').next().unwrap().split([' ', ',']).map(|number| number.parse().unwrap()).collect())
        .collect();
    assert_eq!(curves.iter().map(Vec::len).collect::<Vec<_>>(), [98; 7]);
    // The light that is left falls from 100 % to what the table says: of one panel, heights are in proportion to the numbers.
    let light = &curves[1];
    let share = |k: usize| table["pupil_share"][k].as_f64().unwrap();
    let (first, last, middle) = (light[1], light[97], light[1 + 2 * 19]);
    let expected = (share(0) - share(2)) / (share(0) - share(5));
    // The second place of the table lies at 19.2 of the 48 steps, a fifth of a step beyond this point: 0.01 of the fall.
    assert!(((first - middle) / (first - last) - expected).abs() < 0.03, "{first} {middle} {last} {expected}");
}

#[test]
fn wrong_use_is_said() {
    let bench = Bench::new();
    bench.render("out", "");
    std::fs::write(bench.path("small.toml"), bench_display("lenticular", 12, 8, 4)).unwrap();
    std::fs::write(bench.path("fine.toml"), bench_display("square", 12, 8, 5)).unwrap();
    for (arguments, part) in [
        ("extract out --view 5,0 --out x.png", "view column"),
        ("extract out --view 0-7,0 --out x.png", "view column"),
        ("extract out --view 8-2,0 --out x.png", "2-8"),
        ("extract out --view 0,0 --crop 10,0,6x2 --out x.png", "leaves the image of 12x8"),
        ("extract out --lens 0,0 --crop 18446744073709551615,0,6x2 --out x.png", "leaves the image"),
        ("compose out --views 5x4 --out x_el.png", "need 20"),
        ("compose out --views 3 --out x.png", "neither --to nor the name"),
        ("quilt out --tiles 3x2 --out x.png", "views of a row"),
        ("quilt out --tiles 2x2 --row 4 --out x.png", "view row"),
        ("display out --display small.toml --row 4 --out x.png", "view row"),
        ("display out --display small.toml --disparity 1 --distance-m 2 --out x.png", "cannot be used with"),
        ("display out --display small.toml --eye 0,0,-1 --out x.png", "distance of the eye"),
        ("display out --display small.toml --eye 0,0 --out x.png", "X,Y,Z"),
        (
            "display out --display fine.toml --out x.png",
            "5.0 pixels behind a lens from top to bottom, and the light field 4.0 views",
        ),
        ("animate out --path circle --row 1 --out x.png", "sweep and ping-pong"),
        ("animate out --path sweep --row 4 --out x.png", "view row"),
        ("animate out --fps 0 --out x.png", "0.01 to 600"),
        ("rotate-elements out x.jpg", ".png"),
        ("optics", "--focus-m"),
        ("optics --focus-m 1 --baseline-m 0", "--baseline-m 0"),
        ("optics --focus-m 1 --views 1", "--views"),
        ("optics out --views 3", "cannot be used with"),
        ("optics --depths-m 6,2", "NEAR,FAR"),
        ("optics --disparity -2,2", "--depths-m"),
        ("optics --depths-m 1,2 --disparity 2,3 --focus-m 1", "cannot be used with"),
        ("optics tiny.glb", "camera parameters are unknown"),
        ("optics --camera-file lytro-illum --plot x.svg", "--plot: the main lens of lytro-illum is thin"),
        ("optics --camera-file lytro-illum --plot x.png", "end the name in .svg"),
        ("optics --focus-m 1 --plot x.svg", "--camera-file"),
    ] {
        let outcome = bench.run(arguments);
        assert_eq!(outcome.code, Some(2), "{arguments}: {outcome:?}");
        assert!(outcome.stderr.contains(part), "{arguments}: {outcome:?}");
    }
    assert!(!bench.list("").iter().any(|name| name.starts_with('x')), "nothing was written");
}
