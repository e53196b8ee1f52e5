//! Triangles that lie on each other.

use rayon::prelude::*;

use crate::Scene;

impl Scene {
    /// The number of pairs of triangles of the world that have the same three vertices, in any order: copies of an
    /// object at its own place, or faces modeled twice. Which of the two a ray hits is not defined, and glass between
    /// them has no thickness. Three triangles on each other are three pairs; triangles without an area do not count.
    ///
    /// # Accuracy
    /// Vertices are compared in single precision in world coordinates, and by a hash of 64 bits.
    #[must_use]
    pub fn coincident_triangle_pairs(&self) -> u64 {
        let keys = self.instances.par_iter().flat_map_iter(|instance| {
            let mesh = self.meshes.get(instance.mesh);
            let (positions, triangles) = mesh.map_or((&[][..], &[][..]), |mesh| (&mesh.positions, &mesh.triangles));
            let world = |k: u32| {
                let p = positions.get(k as usize)?.map(f64::from);
                // Adding 0 makes 0 of -0.
                Some(instance.transform.point(p).map(|x| (x as f32 + 0.0).to_bits()))
            };
            triangles.iter().filter_map(move |&[a, b, c]| key([world(a)?, world(b)?, world(c)?]))
        });
        let mut keys: Vec<u64> = keys.collect();
        keys.par_sort_unstable();
        keys.chunk_by(|a, b| a == b).map(|same| same.len() as u64 * (same.len() as u64 - 1) / 2).sum()
    }
}

/// A hash that does not depend on the order of the vertices; `None` if two of them are the same.
fn key(mut vertices: [[u32; 3]; 3]) -> Option<u64> {
    vertices.sort_unstable();
    let [a, b, c] = vertices;
    (a != b && b != c).then(|| vertices.as_flattened().iter().fold(0, |hash, &word| mix(hash ^ u64::from(word))))
}

/// A bijection in which every bit depends on every bit. Source: SplitMix64 (Steele, Lea and Flood, 2014).
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use crate::{Instance, Mesh, Scene, Transform};

    #[test]
    fn pairs_in_the_world() {
        let square = Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, -0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        let at =
            |x: f64| Instance { name: String::new(), mesh: 0, transform: Transform::from_translation([x, 0.0, 0.0]) };
        let pairs = |mesh: &Mesh, instances: Vec<Instance>| {
            Scene { meshes: vec![mesh.clone()], instances, ..Scene::default() }.coincident_triangle_pairs()
        };
        assert_eq!(pairs(&square, vec![]), 0);
        assert_eq!(pairs(&square, vec![at(0.0), at(1.0)]), 0);
        assert_eq!(pairs(&square, vec![at(0.1), at(0.1)]), 2);
        assert_eq!(pairs(&square, vec![at(3.0); 3]), 6);
        // The other side of a face, from another vertex on; and one without an area, twice.
        let mut twice = square.clone();
        twice.triangles.extend([[2, 1, 0], [1, 1, 2], [1, 1, 2]]);
        assert_eq!(pairs(&twice, vec![at(0.0)]), 1);
        // Turned by half a turn about its center, the same square with the other vertices.
        let half =
            Transform { columns: [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]], translation: [1.0, 1.0, 0.0] };
        assert_eq!(pairs(&square, vec![at(0.0), Instance { transform: half, ..at(0.0) }]), 2);
        // Vertices out of range are for `validate` to report.
        let broken = Mesh { triangles: vec![[7, 8, 9]; 2], ..square };
        assert_eq!(pairs(&broken, vec![at(0.0)]), 0);
    }
}
