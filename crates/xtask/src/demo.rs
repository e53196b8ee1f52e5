//! The demo: raw holoscopic images at 8K of the scene `garden` of the gallery.

use std::process::Command;

use crate::{Result, process, root, target};

/// What is rendered: views per axis, meters between them, and the view and microlens that are extracted. The baselines
/// are wider than those of an f/5 lens, so that the parallax is visible.
const LAYOUTS: &[(&str, &str, &str, &str)] =
    &[("100x100", "0.0002", "50,50", "40,26"), ("20x20", "0.001", "10,10", "200,130")];

/// Renders into `out/`. Further arguments go to `holo render`.
pub fn run(arguments: &[String]) -> Result {
    let holo = target().join("release").join("holo");
    let out = root().join("out").join("garden");
    std::fs::create_dir_all(&out).map_err(|why| format!("{}: {why}", out.display()))?;
    let scene = out.join("garden.glb");
    process::run(Command::new(&holo).args(["scene", "garden", "--out"]).arg(&scene))?;
    for (views, baseline_m, view, lens) in LAYOUTS {
        let folder = out.join(views);
        process::run(
            Command::new(&holo)
                .arg("render")
                .arg(&scene)
                .args(["--sensor", "8k", "--views", views, "--baseline-m", baseline_m])
                // Direct light alone: with indirect light the dense grass takes minutes.
                .args(["--sky", "0.35,0.45,0.6", "--spp", "2", "--no-indirect", "--denoise", "views", "--out"])
                .arg(&folder)
                .args(arguments),
        )?;
        for (which, place, file) in [("--view", view, "central_view.png"), ("--lens", lens, "one_lens.png")] {
            let raw = folder.join("scene_el.png");
            let cut = ["--out".into(), folder.join(file)];
            process::run(Command::new(&holo).arg("extract").arg(raw).args([which, place]).args(cut))?;
        }
    }
    println!("written to {}", out.display());
    println!("  */scene_el.png       the raw image behind the microlenses");
    println!("  */scene_vpi.png      all views side by side");
    println!("  */central_view.png   one view;  */one_lens.png  one elemental image");
    println!("  */scene_disparity.png, scene_depth.pfm   ground truth of the central view");
    Ok(())
}
