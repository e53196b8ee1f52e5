//! What the recipes promise of their scenes, measured in the truth of a hundred of them.

use std::sync::Arc;

use holo_core::GridSize;
use holo_dataset::settings::Given;
use holo_dataset::{DatasetPlan, EngineSettings, RenderSettings, Rollback, RunOptions, SetProperties, drawn};
use holo_scene::recipe::{NAMES, Recipe};

/// Draws the first scenes of a recipe, and renders their truth.
fn properties(recipe: &Arc<Recipe>, count: u64) -> SetProperties {
    let folder = tempfile::tempdir().unwrap();
    let mut given = Given::default();
    for (key, text) in [("integrator", "depth"), ("write", "disparity,depth,masks"), ("lenses", "192x192")] {
        given.insert(key, text).unwrap();
    }
    let scenes = drawn(recipe, (7, count), &given, &RenderSettings::default()).unwrap();
    let plan = DatasetPlan::of_each(&scenes, &[GridSize::new(9, 9)], EngineSettings::default()).unwrap();
    plan.describe(folder.path(), &(), &Rollback::default()).unwrap();
    let mut run = plan.run();
    for job in plan.jobs() {
        run.job(job, folder.path(), &RunOptions::new()).unwrap();
    }
    SetProperties::read(folder.path()).unwrap()
}

/// By another seed than that which the shares were chosen with.
#[test]
#[ignore = "minutes: run by nightly"]
fn recipes_have_their_shares() {
    for recipe in NAMES.iter().map(|name| Arc::new(Recipe::by_name(name).unwrap())) {
        if recipe.camera_file().is_some() {
            // Masks are of views.
            assert_eq!(recipe.shares().count(), 0);
            continue;
        }
        assert_eq!(recipe.shares().count(), 8, "{}", recipe.name());
        let found = properties(&recipe, 100);
        println!("{}: {found}", recipe.name());
        assert_eq!((found.scenes, found.near_duplicates), (100, 0), "{}", recipe.name());
        assert_eq!(found.beyond(&recipe), [], "{}", recipe.name());
    }
}

#[test]
fn every_scene_of_a_set_counts() {
    let recipe = Arc::new(Recipe::by_name("thin-and-slanted").unwrap());
    let found = properties(&recipe, 3);
    assert_eq!((found.scenes, found.near_duplicates, found.shares.len()), (3, 0, 8));
    // Each is one of three.
    assert!(found.shares.iter().all(|(_, share)| (3.0 * share).fract() == 0.0), "{found}");
}
