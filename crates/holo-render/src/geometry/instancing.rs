//! The instancing policy: which meshes are stored once as prototypes, and which are copied to all their instances
//! (flattened).

use super::placement::Placement;
use super::to_camera;
use holo_scene::{Mesh, Scene, Transform};

/// The instancing policy of a ray tracing engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Instancing {
    /// All meshes are flattened: for engines that support a single list of triangles.
    Never,
    /// Meshes that save enough memory are prototypes, see [`worth_keeping`].
    Automatic,
    /// All possible meshes are prototypes: for tests and measurements.
    #[cfg(any(test, feature = "bench"))]
    Always,
}

/// The smallest prototype. A placement takes about 0.9 KB, as much memory as six triangles.
const MIN_TRIANGLES: usize = 64;

/// The minimum number of triangles that a prototype must save ...
const MIN_SAVED_BY_MESH: usize = 100_000;

/// ... and the minimum number that all prototypes together must save, about 0.6 GB.
const MIN_SAVED_BY_SCENE: usize = 4_000_000;

/// Decides which meshes, given as (instances, triangles), become prototypes.
///
/// The criterion is memory. Flattened triangles take 150 to 170 bytes each, prototypes almost none; but rays are
/// slower, because they are transformed to the mesh coordinates of every placement whose bounding box they cross.
/// Scenes that fit into memory are therefore flattened. `cargo bench -p holo-bench --bench large` measures both.
fn worth_keeping(meshes: &[(usize, usize)]) -> Vec<bool> {
    let saved = |&(places, triangles): &(usize, usize)| match places.saturating_sub(1).saturating_mul(triangles) {
        saved if triangles >= MIN_TRIANGLES && saved >= MIN_SAVED_BY_MESH => saved,
        _ => 0,
    };
    let all = meshes.iter().map(saved).fold(0, usize::saturating_add);
    meshes.iter().map(|mesh| all >= MIN_SAVED_BY_SCENE && saved(mesh) > 0).collect()
}

/// The storage of the instances of a scene.
pub(super) struct Plan {
    /// Indices of the meshes that are prototypes.
    pub prototypes: Vec<usize>,
    /// For every instance of the scene its placement, or `None` if it is flattened.
    pub placements: Vec<Option<Placement>>,
}

/// Decides the storage of every instance of `scene` in front of a camera at `pose`.
///
/// Always flattened are emissive meshes (their triangles are sampled individually as lights), meshes without triangles,
/// and placements for which [`Placement::new`] returns `None`.
pub(super) fn plan(scene: &Scene, pose: &Transform, policy: Instancing) -> Plan {
    let mut plan = Plan { prototypes: Vec::new(), placements: vec![None; scene.instances.len()] };
    // Instances and triangles of every mesh that may be a prototype; (0, 0) for the others.
    let mut counts = vec![(0, 0); scene.meshes.len()];
    for instance in &scene.instances {
        let mesh = &scene.meshes[instance.mesh];
        if scene.materials[mesh.material].emission == [0.0; 3] && !mesh.triangles.is_empty() {
            counts[instance.mesh].0 += 1;
            counts[instance.mesh].1 = mesh.triangles.len();
        }
    }
    let kept = match policy {
        Instancing::Never => return plan,
        Instancing::Automatic => worth_keeping(&counts),
        #[cfg(any(test, feature = "bench"))]
        Instancing::Always => counts.iter().map(|(places, _)| *places > 0).collect(),
    };
    let bounds_of: Vec<_> = scene.meshes.iter().zip(kept).map(|(mesh, kept)| kept.then(|| bounds(mesh))).collect();
    // Numbered at the first placement: a mesh that is flattened everywhere is no prototype.
    let mut prototype_of = vec![None; scene.meshes.len()];
    for (instance, placement) in scene.instances.iter().zip(&mut plan.placements) {
        let Some(bounds) = bounds_of[instance.mesh] else { continue };
        let prototype = prototype_of[instance.mesh].unwrap_or(plan.prototypes.len());
        *placement = Placement::new(&to_camera(&instance.transform, pose), bounds, prototype as u32);
        if placement.is_some() && prototype_of[instance.mesh].is_none() {
            prototype_of[instance.mesh] = Some(prototype);
            plan.prototypes.push(instance.mesh);
        }
    }
    plan
}

/// The bounding box of all vertices.
fn bounds(mesh: &Mesh) -> [[f64; 3]; 2] {
    let mut out = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    for p in &mesh.positions {
        for axis in 0..3 {
            out[0][axis] = out[0][axis].min(f64::from(p[axis]));
            out[1][axis] = out[1][axis].max(f64::from(p[axis]));
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_pays_only_for_what_is_repeated_and_large() {
        let alone = |places, triangles| worth_keeping(&[(places, triangles)])[0];
        assert!(alone(1000, 10_000) && alone(100, 100_000) && alone(2, 5_000_000));
        assert!(!alone(1, 100_000_000), "not repeated");
        assert!(!alone(1700, 182), "the grass of the garden");
        assert!(!alone(1_000_000, 12), "crates: a place costs as much as they do");
        assert!(!alone(0, 1) && alone(usize::MAX, usize::MAX), "no overflow");
        // Together they save enough; a mesh that saves little stays flattened.
        assert_eq!(worth_keeping(&[(300, 10_000), (20, 100_000), (20, 182)]), [true, true, false]);
    }
}
