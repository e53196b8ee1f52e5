//! A ground for scenes without one: it catches shadows.

use holo_scene::{Instance, Material, Mesh, Scene, Transform};

use crate::Error;

/// Neither black in the shadow nor white in the light.
const GRAY: [f32; 4] = [0.5, 0.5, 0.5, 1.0];

/// The ground reaches so many times as far as the scene from its middle.
const REACH: f64 = 20.0;

/// How far it is below the lowest point, relative to the size of the scene: what lies on it does not flicker, and the middle of
/// the scene hardly moves.
const BELOW: f64 = 1e-4;

/// Adds a square below the lowest point of the scene.
///
/// # Errors
/// [`Error::BadRequest`] if the scene has no triangles.
pub(super) fn add(scene: &mut Scene) -> Result<(), Error> {
    let Some((low, high)) = scene.bounds() else {
        return Err(Error::BadRequest("`ground` is below the triangles of a scene, and it has none".into()));
    };
    let size = (0..3).map(|k| (high[k] - low[k]).powi(2)).sum::<f64>().sqrt() / 2.0;
    let center = [f64::midpoint(low[0], high[0]), low[1] - BELOW * size, f64::midpoint(low[2], high[2])];
    let side = (REACH * size) as f32;
    let mesh = Mesh {
        name: "ground".into(),
        positions: vec![[-side, 0.0, -side], [-side, 0.0, side], [side, 0.0, side], [side, 0.0, -side]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: scene.materials.len(),
        ..Mesh::default()
    };
    scene.materials.push(Material { name: "ground".into(), base_color: GRAY, ..Material::default() });
    let transform = Transform::from_translation(center);
    scene.instances.push(Instance { name: "ground".into(), mesh: scene.meshes.len(), transform });
    scene.meshes.push(mesh);
    Ok(())
}
