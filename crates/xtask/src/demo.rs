//! The demo: the raw holoscopic image at 8K of the scene `garden` of the gallery.

use std::process::Command;

use crate::setup::{cargo, process};
use crate::{Result, root, target};

/// The program as soon as it can be had: without link-time optimization and HDF5, and for this processor alone, so that
/// the kernels of the renderer are compiled once instead of for three instruction sets.
fn build() -> Result<std::path::PathBuf> {
    crate::setup_embree()?;
    let environment = vec![("RUSTFLAGS", "-C target-cpu=native".into())];
    cargo::run_with(&["build", "--profile", "quick", "-p", "holo-cli"], environment)?;
    Ok(target().join("quick").join(format!("holo{}", std::env::consts::EXE_SUFFIX)))
}

/// Builds and renders into `out/`. Further arguments go to `holo render`.
pub fn run(arguments: &[String]) -> Result {
    let holo = build()?;
    let out = root().join("out").join("garden");
    std::fs::create_dir_all(&out).map_err(|why| format!("{}: {why}", out.display()))?;
    let scene = out.join("garden.glb");
    process::run(Command::new(&holo).args(["scene", "garden", "--out"]).arg(&scene))?;
    process::run(
        Command::new(&holo)
            .arg("render")
            .arg(&scene)
            // A baseline wider than that of an f/5 lens, so that the parallax is visible.
            .args(["--sensor", "8k", "--views", "100x100", "--baseline-m", "0.0002"])
            // Direct light alone: with indirect light the dense grass takes minutes.
            .args(["--sky", "0.35,0.45,0.6", "--spp", "1", "--no-indirect", "--denoise", "views", "--out"])
            .arg(&out)
            .args(arguments),
    )?;
    for (which, place, file) in [("--view", "50,50", "central_view.png"), ("--lens", "40,26", "one_lens.png")] {
        let cut = ["--out".into(), out.join(file)];
        process::run(Command::new(&holo).arg("extract").arg(out.join("scene_el.png")).args([which, place]).args(cut))?;
    }
    println!("written to {}", out.display());
    println!("  scene_el.png       the raw image behind the microlenses");
    println!("  scene_vpi.png      all views side by side");
    println!("  central_view.png   one view;  one_lens.png  one elemental image");
    println!("  scene_disparity.png, scene_depth.pfm   ground truth of the central view");
    Ok(())
}
