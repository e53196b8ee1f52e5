//! Properties of all recipes, of what they draw, and of texts that are none.

use std::collections::HashMap;

use super::composition::{Composition, Rest, Space};
use super::objects::{self, Shape};
use super::*;
use crate::Mesh;
use crate::built::parts::noise::Random;
use crate::gltf::to_glb;

fn recipes() -> impl Iterator<Item = Recipe> {
    NAMES.iter().map(|name| Recipe::by_name(name).expect(name))
}

#[test]
fn every_recipe_has_its_name() {
    for (name, recipe) in NAMES.iter().zip(recipes()) {
        assert_eq!(recipe.name(), *name);
        assert!(!recipe.about().is_empty(), "{name}");
        assert!(recipe.files().is_empty(), "{name}");
        assert_eq!(Recipe::from_toml(recipe.text()).expect(name).text(), recipe.text());
    }
    assert!(Recipe::by_name("gallery").is_none());
}

/// A scene follows from seed, number and attempt, and every one of them makes another.
#[test]
fn scenes_are_valid_and_the_same_each_time() {
    for recipe in recipes() {
        let name = recipe.name();
        let first = recipe.scene(1, 0, 0);
        assert!(recipe.scene(1, 0, 0) == first, "{name}");
        for (seed, number, attempt) in [(1, 1, 0), (2, 0, 0), (1, 0, 1), (1, 2, 0), (1, 3, 0)] {
            let scene = recipe.scene(seed, number, attempt);
            scene.validate().unwrap_or_else(|why| panic!("{name} {seed} {number} {attempt}: {why}"));
            assert!(scene.has_light_sources() && scene.cameras.len() == 1, "{name}");
            assert!((2..2_000_000).contains(&scene.triangle_count()), "{name}: {}", scene.triangle_count());
            assert!(scene != first, "{name} {seed} {number} {attempt}");
        }
    }
}

#[test]
fn settings_are_in_their_ranges() {
    let recipe = Recipe::by_name("hci-like").unwrap();
    for number in 0..50 {
        let settings = recipe.settings(3, number);
        assert_eq!(settings, recipe.settings(3, number));
        let (_, disparity) = settings.iter().find(|(key, _)| key == "disparity").unwrap();
        let (low, high) = disparity.split_once(',').unwrap();
        assert!((-2.0..=-0.8).contains(&low.parse::<f64>().unwrap()), "{disparity}");
        assert!((0.8..=2.0).contains(&high.parse::<f64>().unwrap()), "{disparity}");
    }
    assert_ne!(recipe.settings(3, 0), recipe.settings(3, 1));
    assert_ne!(recipe.settings(3, 0), recipe.settings(4, 0));
}

/// In each quarter of the range of disparities are a quarter of the objects, within four standard errors.
#[test]
fn objects_are_placed_evenly_in_disparity() {
    // Its objects may overlap, so no place is drawn twice.
    let recipe = Recipe::by_name("thin-and-slanted").unwrap();
    let mut composition = Composition::new(&recipe.parts, &recipe.models, Random::new(7));
    let (view, space) = (composition.view, Space { near: 2.0, far: 5.0, rest: Rest::Nothing });
    let mut counts = [0_u32; 4];
    for _ in 0..4000 {
        let (center, _) = composition.place(&space).unwrap();
        let part = (1.0 / (center - view.eye).dot(view.ahead) - 0.2) / 0.3;
        assert!((-1e-9..1.0 + 1e-9).contains(&part), "{part}");
        counts[((4.0 * part) as usize).min(3)] += 1;
    }
    assert!(counts.iter().all(|count| count.abs_diff(1000) < 110), "{counts:?}");
}

/// The error says which key is wrong.
#[test]
fn texts_that_are_no_recipes_are_refused() {
    let text = Recipe::by_name("mixed").unwrap().text().to_owned();
    for (from, to, part) in [
        ("holo recipe 1", "holo recipe 9", "format"),
        ("name = \"mixed\"", "name = \"a/b\"", "name"),
        ("table = 4", "table = -4", "layouts"),
        ("table = 4", "tabel = 4", "tabel"),
        ("count = [6, 26]", "count = [26, 6]", "[26, 6]"),
        ("count = [6, 26]", "count = [6, 1e9]", "objects.count"),
        ("size = [0.08, 0.5]", "size = [0, 0.5]", "objects.size"),
        ("sky = 0.6", "sky = 1.6", "light.sky"),
        ("sheet = 1", "sheet = 1\nmodel = 1", "models"),
        ("letters = 1", "letters = 1\nimage = 1", "images"),
        ("apart = true", "apart = true\nmodels = \"own\"", "folders"),
        ("{0.3..2.5}", "{0.3}", "settings.disparity"),
    ] {
        let wrong = text.replace(from, to);
        assert_ne!(wrong, text, "{from}");
        let why = Recipe::from_toml(&wrong).unwrap_err().to_string();
        assert!(why.contains(part), "{to}: {why}");
    }
}

const SHAPES: [Shape; 14] = [
    Shape::Box,
    Shape::Ball,
    Shape::Stone,
    Shape::Lathe,
    Shape::Vessel,
    Shape::Ring,
    Shape::Knot,
    Shape::Spring,
    Shape::Gear,
    Shape::Frame,
    Shape::Text,
    Shape::Burr,
    Shape::Plant,
    Shape::Sheet,
];

/// Whether every edge has a triangle on both sides, with the same side outside.
fn is_closed(mesh: &Mesh) -> bool {
    let key = |k: u32| mesh.positions[k as usize].map(|x| (x * 1e5).round() as i64);
    let mut edges: HashMap<_, i32> = HashMap::new();
    for [a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let (from, to) = (key(*from), key(*to));
            if from != to {
                *edges.entry((from.min(to), from.max(to))).or_default() += if from < to { 1 } else { -1 };
            }
        }
    }
    edges.values().all(|sum| *sum == 0)
}

#[test]
fn bodies_are_in_the_unit_ball_and_closed_if_they_say_so() {
    for shape in SHAPES {
        for seed in 0..8 {
            let body = objects::body(shape, &mut Random::new(seed));
            let mesh = &body.mesh;
            let far = mesh.positions.iter().map(|p| p.map(|x| x * x).iter().sum::<f32>().sqrt()).fold(0.0, f32::max);
            assert!((far - 1.0).abs() < 1e-5, "{shape:?}: {far}");
            assert!(!mesh.triangles.is_empty(), "{shape:?}");
            for list in [mesh.normals.len(), mesh.texture_coordinates.len(), mesh.colors.len()] {
                assert!(list == 0 || list == mesh.positions.len(), "{shape:?}: {list} of {}", mesh.positions.len());
            }
            assert!(!body.is_closed || is_closed(mesh), "{shape:?} {seed} is open");
        }
    }
}

/// Models and images of folders, which lie beside the recipe.
#[test]
fn recipes_use_models_and_images_of_ones_own() {
    let folder = tempfile::tempdir().unwrap();
    for inner in ["models", "images"] {
        std::fs::create_dir(folder.path().join(inner)).unwrap();
    }
    let plaster = crate::gallery::scene("plaster").unwrap();
    std::fs::write(folder.path().join("models/plaster.glb"), to_glb(&plaster).unwrap()).unwrap();
    std::fs::write(folder.path().join("models/notes.txt"), "no model").unwrap();
    image::RgbImage::from_pixel(5, 3, image::Rgb([9, 90, 200])).save(folder.path().join("images/own.png")).unwrap();
    let text = Recipe::by_name("mixed").unwrap().text().to_owned();
    let text = text
        .replace("apart = true", "apart = true\nmodels = \"models\"")
        .replace("sheet = 1", "sheet = 1\nmodel = 1000")
        .replace("relief = 0.2", "relief = 0.2\nimages = \"images\"")
        .replace("letters = 1", "letters = 1\nimage = 1000");
    let path = folder.path().join("own.toml");
    std::fs::write(&path, &text).unwrap();
    let recipe = Recipe::open(&path).unwrap();
    assert_eq!(recipe.files().len(), 2);
    let scene = recipe.scene(5, 0, 0);
    scene.validate().unwrap();
    let of_model = |name: &str| plaster.instances.iter().any(|instance| instance.name == name);
    assert!(scene.instances.iter().any(|instance| of_model(&instance.name)));
    assert!(scene.textures.iter().any(|texture| (texture.width, texture.height) == (5, 3)));
    // On a table models stand: something reaches down to the floor, which is at 0, and nothing below.
    let (before, after) = text.split_once("[layouts]").unwrap();
    let after = after.split_once("[camera]").unwrap().1;
    let table = folder.path().join("table.toml");
    std::fs::write(&table, format!("{before}[layouts]\ntable = 1\n[camera]{after}")).unwrap();
    let mut scene = Recipe::open(&table).unwrap().scene(5, 1, 0);
    scene.instances.retain(|instance| of_model(&instance.name) && !["floor", "wall"].contains(&&*instance.name));
    let low = scene.bounds().unwrap().0[1];
    assert!((0.0..1e-3).contains(&low), "{low}");
    // What is broken is named.
    std::fs::write(folder.path().join("models/broken.glb"), "glTF").unwrap();
    assert!(Recipe::open(&path).is_err());
    std::fs::remove_dir_all(folder.path().join("models")).unwrap();
    let why = Recipe::open(&path).unwrap_err().to_string();
    assert!(why.contains("models"), "{why}");
}
