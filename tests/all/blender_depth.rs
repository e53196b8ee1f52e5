//! Depth against Blender, if there are reference data: HOLO_REFERENCE is the folder with still_life.glb.

use crate::common;
use std::path::{Path, PathBuf};

use holo_core::{GridSize, LightFieldShape, ViewIndex};
use holo_render::{Baseline, Framing, Layer, Renderer, Views};

fn reference() -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join("shared").join("reference");
    let folder = std::env::var_os("HOLO_REFERENCE").map_or(beside, PathBuf::from);
    folder.join("still_life.glb").is_file().then_some(folder)
}

/// Median relative error at most 1e-6; at most 0.1 % of the pixels (silhouettes) off by more than 1e-3.
#[test]
fn five_views_have_the_depth_of_blender() {
    let Some(folder) = reference() else {
        eprintln!("not run: needs the reference scene (HOLO_REFERENCE)");
        return;
    };
    let loaded = holo_scene::gltf::load(&folder.join("still_life.glb"), &Default::default()).expect("a scene");
    let framing = Framing::new(LightFieldShape::new(GridSize::new(41, 41), GridSize::new(132, 198)).unwrap())
        .baseline(Baseline::Meters(0.01));
    let framed = framing.frame(&loaded.scene).unwrap();
    let rig = framed.rig(6.0).unwrap();
    let views = [(0, 0), (0, 40), (13, 29), (20, 20), (40, 40)];
    let list = views.map(|(row, column)| ViewIndex { row, column }).to_vec();
    let request = common::truth(rig).views(Views::List(list));
    for backend in common::engines() {
        let renderer = Renderer::new(&loaded.scene, &framed.pose, backend, None).unwrap();
        let all = renderer.render(&request, &()).unwrap().all.expect("requested");
        for (k, (t, s)) in views.into_iter().enumerate() {
            let file = folder.join(format!("still_life_depth_t{t}_s{s}.pfm"));
            let theirs = holo_io::read_pfm_gray(file, &holo_io::Limits::default()).unwrap();
            let ours = all[Layer::Depth].view(0, k).unwrap();
            let mut errors: Vec<f64> = theirs
                .indexed_iter()
                .map(|((v, u), &z)| (f64::from(ours[[v, u, 0]]) / f64::from(z) - 1.0).abs())
                .collect();
            errors.sort_by(f64::total_cmp);
            let median = errors[errors.len() / 2];
            let off = errors.iter().filter(|e| **e > 1e-3).count() as f64 / errors.len() as f64;
            assert!(median <= 1e-6, "{backend:?} view {t},{s}: median {median:e}");
            assert!(off <= 1e-3, "{backend:?} view {t},{s}: {off} of the pixels");
        }
    }
}
