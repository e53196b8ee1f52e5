//! Layers by name: which files come of `--layers` and `--write exr`, and what is in them.

use crate::common::{Bench, DEFAULT_FILES, SCENE, SMALL, read_u8, read_u16, small_split};
use crate::python;
use holo_io::{Limits, Manifest, ManifestValue, read_exr, read_pfm};
use ndarray::{Array3, Axis, s};

/// The files of one layer each, in alphabetical order.
const ALL_MAPS: [&str; 11] = [
    "scene_albedo.pfm",
    "scene_color.pfm",
    "scene_depth.pfm",
    "scene_disparity.pfm",
    "scene_geometric_normal.pfm",
    "scene_hit_mask.pfm",
    "scene_material_id.pfm",
    "scene_object_id.pfm",
    "scene_ray_length.pfm",
    "scene_reflective.pfm",
    "scene_shading_normal.pfm",
];

fn map(bench: &Bench, name: &str) -> Array3<f32> {
    read_pfm(bench.path(name), &Limits::default()).unwrap().values
}

fn layers_of(bench: &Bench, out: &str) -> Vec<String> {
    let manifest = Manifest::read(bench.path(out).join("manifest.json")).unwrap();
    let Some(ManifestValue::List(names)) = manifest.settings.get("layers") else { panic!("no list of layers") };
    names.iter().map(|name| name.as_text().unwrap().to_owned()).collect()
}

#[test]
fn layers_are_written_by_name() {
    let bench = Bench::new();
    bench.render("default", "");
    assert_eq!(layers_of(&bench, "default"), ["depth", "disparity"]);
    // Those that are named take the place of the two, twice named or not.
    bench.render("some", "--layers albedo,ray-length,albedo");
    let files =
        ["manifest.json", "parameters.cfg", "scene_5d.mat", "scene_albedo.pfm", "scene_el.png", "scene_ray_length.pfm"];
    assert_eq!(bench.list("some"), [&files[..], &["scene_vpi.png"]].concat());
    assert_eq!(layers_of(&bench, "some"), ["ray-length", "albedo"]);
    // Beside what --write names.
    bench.render("beside", "--layers hit-mask --write depth");
    let files = ["manifest.json", "parameters.cfg", "scene_depth.pfm", "scene_hit_mask.pfm", "scene_hit_mask.png"];
    assert_eq!(bench.list("beside"), files);
    bench.render("all", "--layers all");
    let mut expected = [
        &DEFAULT_FILES[..3],
        &ALL_MAPS,
        &["scene_disparity.png", "scene_el.png", "scene_hit_mask.png", "scene_vpi.png"],
    ]
    .concat();
    expected.sort_unstable();
    assert_eq!(bench.list("all"), expected);
    assert_eq!(bench.run("verify all").code, Some(0));
    // Without a image all means all that there are.
    bench.render("truth", "--layers all --integrator depth");
    expected.retain(|name| !["scene_5d.mat", "scene_color.pfm", "scene_el.png", "scene_vpi.png"].contains(name));
    assert_eq!(bench.list("truth"), expected);
    for name in expected.iter().filter(|name| name.starts_with("scene_")) {
        let read = |out: &str| std::fs::read(bench.path(out).join(name)).unwrap();
        assert!(read("truth") == read("all"), "{name}");
    }
}

#[test]
fn layers_agree_with_each_other() {
    let bench = Bench::new();
    bench.render("out", "--layers all");
    let map = |layer: &str| map(&bench, &format!("out/scene_{layer}.pfm"));
    let rig = Manifest::read(bench.path("out/manifest.json")).unwrap().rig.unwrap();
    let (t, s) = rig.shape().central_view();
    let (depth, length, mask) = (map("depth"), map("ray_length"), map("hit_mask"));
    let [geometric, shading] = ["geometric_normal", "shading_normal"].map(map);
    let [object, material] = ["object_id", "material_id"].map(map);
    let [color, albedo] = ["color", "albedo"].map(map);
    assert_eq!((depth.dim(), color.dim(), albedo.dim()), ((8, 12, 1), (8, 12, 3), (8, 12, 3)));
    let mut hits = 0;
    for ((v, u, _), &z) in depth.indexed_iter() {
        let at = |layer: &Array3<f32>| layer[[v, u, 0]];
        let triple = |layer: &Array3<f32>| [0, 1, 2].map(|c| layer[[v, u, c]]);
        if z.is_infinite() {
            assert_eq!((at(&length), at(&mask), at(&object), at(&material)), (f32::INFINITY, 0.0, 0.0, 0.0));
            assert_eq!([triple(&geometric), triple(&shading), triple(&albedo)], [[0.0; 3]; 3]);
            continue;
        }
        hits += 1;
        let [x, y, _] = rig.ray(v, u, t, s, 0.5, 0.5).direction;
        let expected = f64::from(z) * (x * x + y * y + 1.0).sqrt();
        // Depth and length are rounded to f32 on their own.
        assert!((f64::from(at(&length)) - expected).abs() <= 1.2e-7 * expected, "{} {expected}", at(&length));
        assert_eq!((at(&mask), at(&material)), (1.0, 1.0));
        assert!((1.0..=4.0).contains(&at(&object)));
        // The quads are flat and face the camera, which looks along -Z of the world.
        let (a, b) = (triple(&geometric), triple(&shading));
        assert!((0..3).all(|k| (a[k] - b[k]).abs() < 1e-6) && a[2] > 0.8, "{a:?} {b:?}");
    }
    assert!(hits > 20 && hits < 96, "{hits}");
    let seen: std::collections::BTreeSet<u32> = object.iter().map(|&x| x as u32).collect();
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), [0, 1, 2, 3, 4], "nothing, and all four instances");
    assert!(color.iter().any(|x| *x > 0.0));
}

#[test]
fn all_views_have_a_folder_for_every_layer() {
    let bench = Bench::new();
    bench.render(
        "out",
        "--ground-truth all --layers color,geometric-normal,object-id --write el --spp 2 --baseline-m 0.05",
    );
    let list = bench.list("out");
    let folders: Vec<&String> = list.iter().filter(|name| name.ends_with('/')).collect();
    assert_eq!(folders, ["color/", "geometric_normal/", "object_id/"]);
    for name in ["color", "geometric_normal", "object_id"] {
        let view = |k: usize| map(&bench, &format!("out/{name}/scene_{name}_Cam{k:03}.pfm"));
        assert_eq!(bench.list(&format!("out/{name}")).len(), 20);
        // Row 2 of 4, column 2 of 5.
        assert_eq!(view(2 * 5 + 2), map(&bench, &format!("out/scene_{name}.pfm")), "{name}");
        assert_ne!(view(0), view(19), "{name}");
    }
    // Nobody asked for disparity, but its range is known.
    let manifest = Manifest::read(bench.path("out/manifest.json")).unwrap();
    bench.render("default", "--baseline-m 0.05");
    let default = Manifest::read(bench.path("default/manifest.json")).unwrap();
    assert_eq!(manifest.disparity_px, default.disparity_px);
    assert_eq!(bench.run("verify out").code, Some(0));
}

/// The masks lie in a folder, follow from the layers, and are refused where there is no grid of views.
#[test]
fn masks_say_which_pixels_are_hard() {
    let bench = Bench::new();
    let render = format!("render {SCENE} --lenses 96x64 --views 5 --baseline-m 0.05 --quiet --write masks");
    assert_eq!(bench.run(&format!("{render} --out out --layers hit-mask,visibility")).code, Some(0));
    let expected = [
        "discontinuity",
        "fine",
        "fine_surrounding",
        "objects",
        "occluded",
        "plane",
        "reflective",
        "repetitive",
        "slanted",
        "smooth",
        "textureless",
        "transparent",
        "valid",
    ];
    assert_eq!(bench.list("out/masks"), expected.map(|name| format!("{name}.png")));
    let mask = |name: &str| read_u8(bench.path(format!("out/masks/{name}.png"))).index_axis_move(Axis(2), 0);
    let layer = |name: &str| map(&bench, &format!("out/scene_{name}.pfm")).index_axis_move(Axis(2), 0);
    let (valid, occluded) = (mask("valid"), mask("occluded"));
    let (hit, seen) = (layer("hit_mask"), layer("visibility"));
    for (place, &hit) in hit.indexed_iter() {
        assert_eq!(valid[place], if hit > 0.0 { 255 } else { 0 });
        assert_eq!(occluded[place] > 0, hit > 0.0 && seen[place] <= 0.75, "{place:?}");
        assert_eq!(mask("reflective")[place], 0, "all materials are diffuse");
    }
    for name in ["discontinuity", "plane", "occluded"] {
        assert!(mask(name).iter().any(|&code| code > 0) && mask(name).iter().any(|&code| code == 0), "{name}");
    }
    let objects = read_u16(bench.path("out/masks/objects.png")).index_axis_move(Axis(2), 0);
    let names = match &Manifest::read(bench.path("out/manifest.json")).unwrap().settings["objects"] {
        ManifestValue::List(names) => names.len(),
        other => panic!("{other:?}"),
    };
    for (place, &hit) in hit.indexed_iter() {
        assert_eq!(objects[place] > 0, hit > 0.0, "{place:?}");
        assert!(usize::from(objects[place]) <= names, "{place:?}");
    }
    assert_eq!(bench.run("verify out").code, Some(0));
    // Masks need visibility, and do not write it.
    assert_eq!(bench.run(&format!("{render} --out alone")).code, Some(0));
    assert!(!bench.list("alone").contains(&"scene_visibility.pfm".to_owned()));
    let read = |out: &str| std::fs::read(bench.path(out).join("masks/occluded.png")).unwrap();
    assert!(read("alone") == read("out"));
    let outcome = bench.run("render tiny.glb --out raw --camera-file lytro-illum --write masks");
    assert!(outcome.code == Some(2) && outcome.stderr.contains("--write masks"), "{outcome:?}");
}

#[test]
fn one_exr_holds_all_of_the_central_view() {
    let bench = Bench::new();
    bench.render("maps", "--layers all");
    for (out, more) in [("central", ""), ("views", "--ground-truth all --layers depth")] {
        bench.render(out, &format!("--write exr {more}"));
        assert!(bench.list(out).contains(&"scene_central.exr".to_owned()));
        assert!(!bench.list(out).contains(&"scene_el.png".to_owned()));
        let image = read_exr(bench.path(out).join("scene_central.exr"), &Limits::default()).unwrap();
        assert_eq!(image.channels.len(), 22);
        for (pass, components, file) in [
            ("Combined", "RGB", "color"),
            ("Depth", "Z", "depth"),
            ("RayLength", "Z", "ray_length"),
            ("Disparity", "X", "disparity"),
            ("GeometricNormal", "XYZ", "geometric_normal"),
            ("Normal", "XYZ", "shading_normal"),
            ("DiffCol", "RGB", "albedo"),
            ("IndexOB", "X", "object_id"),
            ("IndexMA", "X", "material_id"),
            ("HitMask", "X", "hit_mask"),
            ("Reflective", "X", "reflective"),
        ] {
            let expected = map(&bench, &format!("maps/scene_{file}.pfm"));
            for (c, component) in components.chars().enumerate() {
                let name = format!("ViewLayer.{pass}.{component}");
                let plane = image.channel(&name).unwrap_or_else(|| panic!("no {name}"));
                assert_eq!(*plane, expected.slice(s![.., .., c]), "{name}");
            }
        }
        // The color once more, for programs that know no layers.
        for name in ["R", "G", "B"] {
            assert_eq!(image.channel(name), image.channel(&format!("ViewLayer.Combined.{name}")), "{name}");
        }
        assert_eq!(bench.run(&format!("verify {out}")).code, Some(0));
    }
    bench.render("truth", "--write exr --integrator depth");
    let image = read_exr(bench.path("truth/scene_central.exr"), &Limits::default()).unwrap();
    assert_eq!(image.channels.len(), 16, "no color, no Combined");
    let outcome = bench.run("info truth/scene_central.exr");
    assert!(outcome.code == Some(0) && outcome.stdout.contains("ViewLayer.Depth.Z"), "{outcome:?}");
    assert_eq!(small_split().lenses().columns, image.channels[0].1.dim().1);
}

#[test]
fn grids_in_linear_light_hold_the_same_radiance() {
    let bench = Bench::new();
    bench.render("out", "--write exr,el,vpi --layers color --ground-truth all");
    let read = |name: &str| read_exr(bench.path("out").join(name), &Limits::default()).unwrap();
    let (elemental, viewpoint) = (read("scene_el.exr"), read("scene_vpi.exr"));
    let shape = small_split();
    let (views, lenses) = (shape.views(), shape.lenses());
    for (channel, name) in ["R", "G", "B"].into_iter().enumerate() {
        let (elemental, viewpoint) = (elemental.channel(name).unwrap(), viewpoint.channel(name).unwrap());
        for t in 0..views.rows {
            for s in 0..views.columns {
                let view = map(&bench, &format!("out/color/scene_color_Cam{:03}.pfm", t * views.columns + s));
                let expected = view.slice(s![.., .., channel]);
                let from_elemental = elemental.slice(s![t..;views.rows, s..;views.columns]);
                let (row, column) = (t * lenses.rows, s * lenses.columns);
                let from_viewpoint = viewpoint.slice(s![row..row + lenses.rows, column..column + lenses.columns]);
                // Rounded to 11 bits.
                let near = |a: &f32, b: &f32| (a - b).abs() <= b.abs() / 2048.0 + 3e-8;
                assert!(expected.iter().zip(from_elemental).all(|(b, a)| near(a, b)), "{t} {s} {name}");
                assert_eq!(from_elemental, from_viewpoint, "{t} {s} {name}");
            }
        }
    }
    assert_eq!(bench.run("verify out").code, Some(0));
}

/// Programs that know no layers, such as OpenCV, need R, G and B. OpenEXR's own library reads them, because the wheels of
/// OpenCV 5 have no codec for the format.
#[test]
fn openexr_finds_plain_color_in_every_file() {
    const SCRIPT: &str = r#"
for path in sys.argv[1:]:
    channels = OpenEXR.File(path, separate_channels=True).channels()
    image = numpy.stack([channels[name].pixels for name in "RGB"], axis=2)
    print(" ".join(f"{value:.5f}" for value in image[::-1].astype(numpy.float32).ravel()))
"#;
    let bench = Bench::new();
    bench.render("out", "--write exr,el,vpi --layers color");
    let files = ["scene_central.exr", "scene_el.exr", "scene_vpi.exr"];
    let paths = files.map(|name| bench.path("out").join(name).to_str().unwrap().to_owned());
    let arguments = paths.each_ref().map(String::as_str);
    let Some(text) = python::run(&["numpy", "OpenEXR"], SCRIPT, &arguments) else { return };
    for (line, path) in text.lines().zip(&paths) {
        let rgb = holo_io::read_exr_rgb(path, &Limits::default()).unwrap();
        let found: Vec<f32> = line.split(' ').map(|word| word.parse().unwrap()).collect();
        let expected: Vec<f32> = rgb.slice(s![..;-1, .., ..]).iter().copied().collect();
        assert_eq!(found.len(), expected.len(), "{path}");
        // Five digits are printed.
        assert!(found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-5 * (1.0 + b.abs())), "{path}");
    }
}

#[test]
fn a_sky_can_be_a_file() {
    let bench = Bench::new();
    // Two texels: orange and half of it.
    std::fs::write(
        bench.path("sky.hdr"),
        b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x40\x20\x81\x80\x40\x20\x80",
    )
    .unwrap();
    bench.render("out", "--sky sky.hdr");
    let manifest = Manifest::read(bench.path("out/manifest.json")).unwrap();
    let digest = holo_io::hash_file(bench.path("sky.hdr")).unwrap().sha256.to_string();
    assert_eq!(manifest.settings["sky_sha256"].as_text(), Some(digest.as_str()));
    assert_eq!(manifest.settings["sky"], ManifestValue::List(vec![ManifestValue::Float(0.0); 3]));
    bench.render("plain", "");
    let manifest = Manifest::read(bench.path("plain/manifest.json")).unwrap();
    assert!(!manifest.settings.contains_key("sky_sha256"));

    let negative = ndarray::array![[-1.0f32]];
    let channels = ["R", "G", "B"].map(|name| holo_io::ExrChannel::float(name, negative.view()));
    holo_io::write_exr(bench.path("dark.exr"), &channels).unwrap();
    std::fs::write(bench.path("none.hdr"), "hello").unwrap();
    for (file, words) in [
        ("missing.exr", "cannot read missing.exr"),
        ("none.hdr", "none.hdr: not an environment map"),
        ("dark.exr", "dark.exr: environment.radiance[0, 0, 0]: is -1"),
    ] {
        let outcome = bench.run(&format!("render {SCENE} --out refused {SMALL} --sky {file}"));
        assert_eq!(outcome.code, Some(1), "{outcome:?}");
        assert!(outcome.stderr.contains(words), "{outcome:?}");
        assert!(!bench.path("refused").exists(), "{file}");
    }
}
