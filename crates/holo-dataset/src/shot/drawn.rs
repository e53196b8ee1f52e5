//! Scenes of recipes: drawn again until one is of use.

use holo_core::{GridSize, LightFieldShape};
use holo_render::{Framing, Integrator, Layer, Request, World};
use holo_scene::Scene;
use holo_scene::recipe::Recipe;

use crate::Error;
use crate::settings::EngineSettings;

/// How often a scene is drawn. Of a recipe whose scenes are hardly ever of use, the last one is taken.
const ATTEMPTS: u64 = 16;

/// The pixels of the image that tells whether a scene is of use.
const SIDE: usize = 48;

/// At least this share of the pixels hits something.
const HITS: f64 = 0.5;

/// What is nearest, one pixel of a hundred, is not nearer than this part of the median depth: nothing stands before the lens.
const NEAR: f64 = 0.12;

/// The inverse depths, from the 5th to the 95th of a hundred, differ by at least this part of their median.
const RANGE: f64 = 0.05;

/// At most this share of the pixels has less than a hundredth of the light of the brightest fiftieth: exposure would leave them
/// black.
const DARK: f64 = 0.6;

/// Draws a scene: the first that is of use, and the number of its attempt.
pub(super) fn draw(recipe: &Recipe, seed: u64, number: u64, engine: &EngineSettings) -> Result<(Scene, u64), Error> {
    let mut attempt = 0;
    loop {
        let scene = recipe.scene(seed, number, attempt);
        if attempt + 1 == ATTEMPTS || is_of_use(&scene, engine)? {
            return Ok((scene, attempt));
        }
        attempt += 1;
    }
}

/// Whether a scene is seen, neither flat nor hidden nor dark.
fn is_of_use(scene: &Scene, engine: &EngineSettings) -> Result<bool, Error> {
    let world = World::new(scene, engine.backend, engine.threads)?;
    let shape = LightFieldShape::new(GridSize::new(1, 1), GridSize::new(SIDE, SIDE))?;
    let framed = Framing::new(shape).frame(scene)?;
    let renderer = world.at(&framed.pose)?;
    let rig = framed.rig(f64::INFINITY)?;
    let mut request = Request::new(rig).integrator(Integrator::Direct).layers([Layer::Depth].into());
    request.transport.samples = 4.into();
    let rendered = renderer.render(&request, &())?;
    let mut depths: Vec<f32> =
        rendered.central[Layer::Depth].iter().copied().filter(|depth| depth.is_finite()).collect();
    let pixels = (SIDE * SIDE) as f64;
    if (depths.len() as f64) < HITS * pixels {
        return Ok(false);
    }
    depths.sort_by(f32::total_cmp);
    let depth = |share: f64| f64::from(ordered(&depths, share));
    let (median, range) = (depth(0.5), 1.0 / depth(0.05) - 1.0 / depth(0.95));
    if depth(0.01) < NEAR * median || range * median < RANGE {
        return Ok(false);
    }
    let Some(color) = &rendered.color else { return Ok(false) };
    let samples = color.samples();
    let mut lights: Vec<f32> = samples.lanes(ndarray::Axis(4)).into_iter().map(|rgb| rgb.sum()).collect();
    lights.sort_by(f32::total_cmp);
    let bright = ordered(&lights, 0.98);
    let dark = lights.iter().filter(|light| **light < 0.01 * bright).count() as f64;
    Ok(bright > 0.0 && bright.is_finite() && dark <= DARK * pixels)
}

/// The value below which a share of the sorted values lies.
fn ordered(values: &[f32], share: f64) -> f32 {
    values[((values.len() - 1) as f64 * share).round() as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_scene::{Camera, Instance, Material, Mesh, Transform};

    /// A wall across all that a camera sees.
    fn wall_before(camera: &Camera) -> Scene {
        let positions =
            [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]].map(|[x, y]: [f32; 2]| [x, y, -1.0]).to_vec();
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [0, 2, 3]], ..Mesh::default() };
        Scene {
            meshes: vec![mesh],
            instances: vec![Instance { name: "wall".into(), mesh: 0, transform: camera.pose }],
            materials: vec![Material { unlit: true, ..Material::default() }],
            cameras: vec![camera.clone()],
            ..Scene::default()
        }
    }

    /// Every scene that is taken is of use, most at the first or second attempt. A wall is flat, and what is a kilometer away is
    /// hardly seen.
    #[test]
    fn scenes_that_are_taken_are_of_use() {
        let engine = EngineSettings::default();
        let recipe = Recipe::by_name("hci-like").unwrap();
        let mut early = 0;
        for number in 0..4 {
            let (scene, attempt) = draw(&recipe, 5, number, &engine).unwrap();
            assert!(is_of_use(&scene, &engine).unwrap(), "{number}, attempt {attempt}");
            early += usize::from(attempt < 2);
            assert!(!is_of_use(&wall_before(&scene.cameras[0]), &engine).unwrap(), "a flat wall");
            let mut far = scene.clone();
            let back = Transform::from_translation([0.0, 0.0, 1000.0]);
            far.cameras.iter_mut().for_each(|camera| camera.pose = camera.pose.after(&back));
            assert!(!is_of_use(&far, &engine).unwrap(), "a scene far away");
        }
        assert!(early >= 2, "{early} of 4");
    }
}
