//! The main job on a real scene: a garden of the gallery becomes an 8K raw holoscopic image of 10,000 views.

use std::process::Command;

use crate::{Result, process, root, target};

/// Renders into `out/`. Further arguments go to `holo render`.
pub fn run(arguments: &[String]) -> Result {
    let holo = target().join("release").join("holo");
    let out = root().join("out");
    std::fs::create_dir_all(&out).map_err(|why| format!("{}: {why}", out.display()))?;
    let scene = out.join("garden.glb");
    process::run(Command::new(&holo).args(["scene", "garden", "--out"]).arg(&scene))?;
    // 10,000 views: the raw image itself, as the paper has it. 0.4 mm between views makes the parallax visible.
    process::run(
        Command::new(&holo)
            .arg("render")
            .arg(&scene)
            .args(["--sensor", "8k", "--views", "100x100", "--baseline-m", "0.0004", "--sky", "0.35,0.45,0.6"])
            .args(["--spp", "2", "--out"])
            .arg(out.join("garden").join("100x100"))
            .args(arguments),
    )?;
    // 20 x 20 views: fewer, larger pictures.
    process::run(
        Command::new(&holo)
            .arg("render")
            .arg(&scene)
            .args(["--sensor", "8k", "--views", "20x20", "--baseline-m", "0.002", "--sky", "0.35,0.45,0.6"])
            .args(["--spp", "2", "--out"])
            .arg(out.join("garden").join("20x20"))
            .args(arguments),
    )?;
    for split in ["100x100", "20x20"] {
        let folder = out.join("garden").join(split);
        let (view, lens) = if split == "20x20" { ("10,10", "200,130") } else { ("50,50", "40,26") };
        for (which, place, file) in [("--view", view, "central_view.png"), ("--lens", lens, "one_lens.png")] {
            process::run(
                Command::new(&holo)
                    .arg("extract")
                    .arg(folder.join("scene_el.png"))
                    .args([which, place, "--out"])
                    .arg(folder.join(file)),
            )?;
        }
    }
    println!("look at {}", out.join("garden").display());
    println!("  */scene_el.png       the raw image behind the lenses");
    println!("  */scene_vpi.png      all views side by side");
    println!("  */central_view.png   one view;  */one_lens.png  what one lens sees");
    println!("  */scene_disparity.png, scene_depth.pfm   ground truth of the central view");
    Ok(())
}
