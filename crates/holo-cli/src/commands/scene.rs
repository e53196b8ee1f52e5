//! `holo scene`: the gallery as .glb files.

use holo_scene::gallery;

use crate::arguments::SceneOptions;
use crate::console::{out, say};
use crate::failure::Failure;

pub fn run(options: &SceneOptions) -> Result<(), Failure> {
    let known: Vec<&str> = gallery::all_names().collect();
    let Some(name) = &options.name else {
        for name in &known {
            out!("{name:18} {}", gallery::purpose(name).unwrap_or_default())?;
        }
        return Ok(());
    };
    let (scene, glb) = gallery::scene(name)
        .zip(gallery::to_glb(name))
        .ok_or_else(|| Failure::Usage(format!("the gallery has no scene '{name}'; it has: {}", known.join(", "))))?;
    let path = options.out.clone().unwrap_or_else(|| format!("{name}.glb").into());
    let written = holo_io::write_file(&path, &glb?)?;
    let moves = if gallery::animation(name).is_some() { ", animated: see --frame" } else { "" };
    say!("wrote {} ({} triangles, {} bytes{moves})", path.display(), scene.triangle_count(), written.bytes);
    Ok(())
}
