//! `holo scene`: the gallery as .glb files.

use holo_scene::{gallery, gltf};

use crate::arguments::SceneOptions;
use crate::console::{out, say};
use crate::failure::Failure;

pub fn run(options: &SceneOptions) -> Result<(), Failure> {
    let known = gallery::NAMES.join(", ");
    let Some(name) = &options.name else {
        out!("{}", gallery::NAMES.join("\n"))?;
        return Ok(());
    };
    let scene = gallery::scene(name)
        .ok_or_else(|| Failure::Usage(format!("the gallery has no scene '{name}'; it has: {known}")))?;
    let path = options.out.clone().unwrap_or_else(|| format!("{name}.glb").into());
    let written = holo_io::write_file(&path, &gltf::to_glb(&scene)?)?;
    say!("wrote {} ({} triangles, {} bytes)", path.display(), scene.triangle_count(), written.bytes);
    Ok(())
}
