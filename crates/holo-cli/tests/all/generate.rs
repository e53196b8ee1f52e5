//! `holo generate`: scenes of recipes, wherever they are drawn.

use crate::common::{Bench, camera_bench, ok};
use holo_io::{Manifest, ManifestValue};

const LINE: &str =
    "generate --count 4 --seed 5 --recipe hci-like --views 3 --lenses 24x24 --spp 1 --integrator direct --quiet";

/// All files of a folder, with their bytes; lists of the whole set are left out.
fn files(bench: &Bench, folder: &str) -> Vec<(String, Vec<u8>)> {
    let scenes = (0..4).map(|number| format!("{number:06}/3x3"));
    let mut out = Vec::new();
    for inner in scenes.flat_map(|scene| [scene.clone(), format!("{scene}/masks")]) {
        for name in bench.list(&format!("{folder}/{inner}")) {
            let path = bench.path(format!("{folder}/{inner}/{name}"));
            if path.is_file() {
                out.push((format!("{inner}/{name}"), std::fs::read(path).unwrap()));
            }
        }
    }
    out
}

#[test]
fn shards_draw_the_scenes_of_the_whole() {
    let bench = Bench::new();
    ok(bench.run(&format!("{LINE} --out whole")));
    let whole = files(&bench, "whole");
    assert!(whole.len() > 4 * 15, "{}", whole.len());
    ok(bench.run(&format!("{LINE} --out parts --shard 2/2 --threads 1")));
    ok(bench.run(&format!("{LINE} --out parts --shard 1/2")));
    let parts = files(&bench, "parts");
    assert_eq!(parts.len(), whole.len());
    for (one, other) in parts.iter().zip(&whole) {
        assert!(one == other, "{} and {} differ", one.0, other.0);
    }
    // Nothing is rendered again, and a scene that is lost is drawn again as it was.
    std::fs::remove_dir_all(bench.path("whole/000002")).unwrap();
    let again = ok(bench.run(&format!("{LINE} --out whole --json")));
    let counts: serde_json::Value = serde_json::from_str(again.stdout.lines().last().unwrap()).unwrap();
    assert_eq!((&counts["made"], &counts["kept"]), (&1.into(), &3.into()));
    assert!(files(&bench, "whole") == whole);
    assert_eq!(bench.run("verify whole").code, Some(0));
    // The set has its recipe, and says how it was made.
    let recipe = holo_scene::recipe::Recipe::by_name("hci-like").unwrap();
    assert_eq!(std::fs::read_to_string(bench.path("whole/recipe.toml")).unwrap(), recipe.text());
    let text = std::fs::read_to_string(bench.path("whole/DATASET.md")).unwrap();
    for part in ["holo generate --out DIR", "--recipe recipe.toml --count 4 --seed 5", "drawn from the recipe hci-like"]
    {
        assert!(text.contains(part), "{part}: {text}");
    }
    let table = std::fs::read_to_string(bench.path("whole/light_fields.csv")).unwrap();
    assert!(table.lines().next().unwrap().contains(",textureless,repetitive,reflective,"), "{table}");
    // A copy of the recipe draws the same scenes.
    ok(bench.run(&format!("{} --out copy", LINE.replace("hci-like", "whole/recipe.toml"))));
    assert!(files(&bench, "copy") == whole);
    // Another recipe has another set.
    let other = bench.run(&format!("{} --out whole", LINE.replace("hci-like", "mixed")));
    assert!(other.code == Some(1) && other.stderr.contains("another recipe"), "{other:?}");
    assert!(files(&bench, "whole") == whole);
}

#[test]
fn options_win_over_the_recipe() {
    let bench = Bench::new();
    let line = LINE.replace("--count 4", "--count 2");
    let manifest = |folder: &str| Manifest::read(bench.path(format!("{folder}/000001/3x3/manifest.json"))).unwrap();
    ok(bench.run(&format!("{line} --out drawn")));
    let drawn = manifest("drawn");
    assert_eq!(drawn.settings["recipe"], ManifestValue::from("hci-like"));
    assert!(matches!(drawn.settings["attempt"], ManifestValue::Integer(0..16)), "{:?}", drawn.settings["attempt"]);
    assert_eq!(drawn.seed, 6, "noise of one scene is not that of another");
    ok(bench.run(&format!("{line} --out given --disparity=-0.5,0.25")));
    let given = manifest("given");
    let (low, high) = given.disparity_px.unwrap();
    assert!((low + 0.5).abs() < 1e-3 && (high - 0.25).abs() < 1e-3, "{low} {high}");
    assert_ne!(given.disparity_px, drawn.disparity_px);
    assert_eq!(given.settings["scene_sha256"], drawn.settings["scene_sha256"]);
    for (line, code, part) in [
        (line.replace("hci-like", "hci-lik"), 2, "mixed, hci-like"),
        (line.replace("--count 2", "--count 0"), 2, "--count"),
        (line.replace("--count 2", ""), 2, "--count"),
        (format!("{line} --scenes garden"), 2, "--scenes"),
    ] {
        let outcome = bench.run(&format!("{line} --out no"));
        assert!(outcome.code == Some(code) && outcome.stderr.contains(part), "{line}: {outcome:?}");
        assert!(!bench.path("no").exists(), "{line}");
    }
    std::fs::write(bench.path("own.toml"), "format = \"holo recipe 1\"\nname = \"own\"").unwrap();
    let broken = bench.run(&format!("{} --out no", line.replace("hci-like", "own.toml")));
    assert!(broken.code == Some(1) && broken.stderr.contains("own.toml"), "{broken:?}");
    let text = holo_scene::recipe::Recipe::by_name("hci-like").unwrap().text().replace("disparity =", "dispartiy =");
    std::fs::write(bench.path("own.toml"), text).unwrap();
    let broken = bench.run(&format!("{} --out no", line.replace("hci-like", "own.toml")));
    assert!(broken.code == Some(2) && broken.stderr.contains("did you mean"), "{broken:?}");
    assert!(!bench.path("no").exists());
}

/// The microlens array of every scene is turned and moved, and its focus too: as `camera.toml` says it.
#[test]
fn recipes_perturb_plenoptic_cameras() {
    let bench = camera_bench();
    let line = "generate --count 3 --seed 5 --recipe plenoptic-raw --camera-file small.toml --spp 1 --integrator direct --quiet";
    ok(bench.run(&format!("{line} --out set")));
    let camera =
        |k: u32| holo_io::CameraFile::read(bench.path(format!("set/{k:06}/small/camera.toml"))).unwrap().camera;
    let nominal = holo_io::CameraFile::read(bench.path("small.toml")).unwrap().camera;
    let pitch_m = nominal.array().pitch_m;
    for k in 0..3 {
        let own = camera(k);
        let turned = (own.array().rotation_rad - nominal.array().rotation_rad).to_degrees();
        assert!(turned != 0.0 && turned.abs() <= 0.2, "{turned}");
        let moved = [0, 1].map(|axis| (own.array().offset_m[axis] - nominal.array().offset_m[axis]) / pitch_m);
        assert!(moved[0] != moved[1] && moved.iter().all(|part| part.abs() <= 0.5), "{moved:?}");
        assert!((own.array().pitch_m / pitch_m - 1.0).abs() <= 0.005);
        assert_ne!(own.array(), camera((k + 1) % 3).array());
        assert!(own.main_lens() != nominal.main_lens(), "the focus is drawn");
    }
    let focus = bench.run(&format!("{line} --out other --focus-m 0.4"));
    assert!(focus.code == Some(2) && focus.stderr.contains("draws the focus"), "{focus:?}");
    // Settings of rigs do not concern it, others do.
    let text = holo_scene::recipe::Recipe::by_name("plenoptic-raw").unwrap().text().to_owned();
    std::fs::write(bench.path("own.toml"), text + "\n[settings]\nspp = [\"3\"]\nlenses = [\"20x20\"]\n").unwrap();
    let of_recipe = line.replace("plenoptic-raw", "own.toml").replace("--count 3", "--count 1").replace("--spp 1", "");
    ok(bench.run(&format!("{of_recipe} --out own")));
    let manifest = Manifest::read(bench.path("own/000000/small/manifest.json")).unwrap();
    assert_eq!(manifest.settings["spp"], ManifestValue::Integer(3));
    // Every scene has its own camera, which `dataset.json` knows; a resumed set has the same.
    assert_eq!(bench.run("verify set").code, Some(0));
    let table = std::fs::read_to_string(bench.path("set/light_fields.csv")).unwrap();
    assert_eq!(table.lines().count(), 4, "{table}");
    let again = ok(bench.run(&format!("{line} --out set --json")));
    let counts: serde_json::Value = serde_json::from_str(again.stdout.lines().last().unwrap()).unwrap();
    assert_eq!((&counts["made"], &counts["kept"]), (&0.into(), &3.into()));
    // The camera of one scene is not that of another.
    std::fs::remove_dir_all(bench.path("set/000001")).unwrap();
    std::process::Command::new("cp")
        .args(["-r", "set/000000", "set/000001"])
        .current_dir(bench.path(""))
        .status()
        .unwrap();
    let wrong = bench.run("verify set");
    assert!(wrong.code == Some(1) && wrong.stdout.contains("another camera"), "{wrong:?}");
}
