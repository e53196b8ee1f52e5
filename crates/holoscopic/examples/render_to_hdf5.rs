//! Renders a glTF scene into a folder with the raw image, linear light as HDF5, and the exact disparity.

use holoscopic::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rig = RigSettings::default().views(20).lenses([265, 397]); // rows, columns
    let files = [Output::El, Output::H5, Output::Disparity];
    let settings = RenderSettings::default().camera(rig).samples(64).write(files);
    RenderJob::new(SceneSource::file("scene.glb"), settings).run("out", &RunOptions::default())?;
    println!("out/scene_5d.h5 has the axes (v, u, t, s, c): lens row, lens column, view row, view column, channel");
    Ok(())
}
