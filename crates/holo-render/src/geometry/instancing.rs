//! Which meshes are kept once and which are copied to every place where they stand.

use super::placed::Placed;
use super::to_camera;
use holo_scene::{Mesh, Scene, Transform};

/// What a ray engine is ready for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Instancing {
    /// Everything is flattened: engines that know one list of triangles.
    Never,
    /// Meshes for which it pays, see [`worth_keeping`].
    WhereItPays,
    /// Every mesh for which it is possible: for tests and measurements.
    #[cfg(any(test, feature = "bench"))]
    WherePossible,
}

/// A place costs about 0.9 KB, as much as six triangles: smaller meshes than this are not worth it.
const FEWEST_TRIANGLES: usize = 64;

/// Keeping a mesh once must save at least this many triangles ...
const FEWEST_SAVED_BY_MESH: usize = 100_000;

/// ... and all such meshes together at least this many, about 0.6 GB.
const FEWEST_SAVED_BY_SCENE: usize = 4_000_000;

/// Which meshes, given as (places, triangles), are kept once.
///
/// Measured with `cargo bench -p holo-bench --bench large` (10 million triangles, two cores, ratios within one run):
/// flattened triangles cost 150 to 170 bytes and about a microsecond each before the first ray; kept once, a scene of
/// 1000 x 10,000 or 100 x 100,000 triangles takes 10 to 20 MB and a tenth of a second. But rays that must be turned into
/// the coordinates of every place whose box they cross are slower: 0.5 to 0.7 of the speed for rocks side by side and for
/// tufts that grow through each other, 0.3 to 0.5 for the garden, whose meshes are small. A full render has far more rays
/// than triangles, so that memory is the reason to keep meshes once, and time is not: scenes that fit stay flattened.
fn worth_keeping(meshes: &[(usize, usize)]) -> Vec<bool> {
    let saved = |&(places, triangles): &(usize, usize)| match places.saturating_sub(1).saturating_mul(triangles) {
        saved if triangles >= FEWEST_TRIANGLES && saved >= FEWEST_SAVED_BY_MESH => saved,
        _ => 0,
    };
    let all = meshes.iter().map(saved).fold(0, usize::saturating_add);
    meshes.iter().map(|mesh| all >= FEWEST_SAVED_BY_SCENE && saved(mesh) > 0).collect()
}

/// What becomes of the instances of a scene.
pub(super) struct Plan {
    /// Indices of meshes that are kept once.
    pub prototypes: Vec<usize>,
    /// For every instance of the scene its placement, or `None` if it is flattened.
    pub placed: Vec<Option<Placed>>,
}

/// Decides for every instance of `scene` in front of a camera at `pose`.
///
/// Flattened whatever the policy says: meshes that glow (their triangles are drawn as lights, one by one), meshes
/// without triangles, and placements that [`Placed::new`] refuses.
pub(super) fn plan(scene: &Scene, pose: &Transform, policy: Instancing) -> Plan {
    let mut plan = Plan { prototypes: Vec::new(), placed: vec![None; scene.instances.len()] };
    // Places and triangles of every mesh that may be kept once; none for the others.
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
        Instancing::WhereItPays => worth_keeping(&counts),
        #[cfg(any(test, feature = "bench"))]
        Instancing::WherePossible => counts.iter().map(|(places, _)| *places > 0).collect(),
    };
    let bounds_of: Vec<_> = scene.meshes.iter().zip(kept).map(|(mesh, kept)| kept.then(|| bounds(mesh))).collect();
    // Numbered when the first place is found: a mesh that is flattened everywhere is not kept.
    let mut prototype_of = vec![None; scene.meshes.len()];
    for (instance, placed) in scene.instances.iter().zip(&mut plan.placed) {
        let Some(bounds) = bounds_of[instance.mesh] else { continue };
        let prototype = prototype_of[instance.mesh].unwrap_or(plan.prototypes.len());
        *placed = Placed::new(&to_camera(&instance.transform, pose), bounds, prototype as u32);
        if placed.is_some() && prototype_of[instance.mesh].is_none() {
            prototype_of[instance.mesh] = Some(prototype);
            plan.prototypes.push(instance.mesh);
        }
    }
    plan
}

/// The box around all vertices.
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
        // Together they are worth it, and what saves little stays flattened even then.
        assert_eq!(worth_keeping(&[(300, 10_000), (20, 100_000), (20, 182)]), [true, true, false]);
    }
}
