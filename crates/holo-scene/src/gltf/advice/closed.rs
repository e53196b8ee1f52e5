//! Whether a mesh is closed.

use crate::Mesh;

/// Whether a mesh encloses a volume: every edge is run through as often in one direction as in the other. Vertices at
/// the same place are one, because exporters split them where normals or texture coordinates differ.
pub(super) fn is_closed(mesh: &Mesh) -> bool {
    let numbers = places(&mesh.positions);
    // An edge as its lower and its higher vertex, and the direction.
    let mut edges: Vec<([u32; 2], bool)> = Vec::with_capacity(mesh.triangles.len() * 3);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| numbers[vertex as usize]);
        if a != b && b != c && c != a {
            edges.extend([[a, b], [b, c], [c, a]].map(|[from, to]| ([from.min(to), from.max(to)], from < to)));
        }
    }
    edges.sort_unstable();
    let balanced = |edges: &[([u32; 2], bool)]| edges.iter().filter(|(_, upward)| *upward).count() * 2 == edges.len();
    !edges.is_empty() && edges.chunk_by(|(one, _), (other, _)| one == other).all(balanced)
}

/// For each vertex the number of its place.
fn places(positions: &[[f32; 3]]) -> Vec<u32> {
    // -0 and 0 are the same place.
    let bits = |k: u32| positions[k as usize].map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&k| bits(k));
    let mut numbers = vec![0; positions.len()];
    let mut number = 0;
    for pair in order.windows(2) {
        number += u32::from(bits(pair[0]) != bits(pair[1]));
        numbers[pair[1] as usize] = number;
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tetrahedron with three vertices of its own a face.
    fn tetrahedron() -> Mesh {
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, -0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0_f32]];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2_usize]];
        Mesh {
            positions: faces.iter().flatten().map(|&k| corners[k]).collect(),
            triangles: (0..4).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
            ..Mesh::default()
        }
    }

    #[test]
    fn closed_and_open_meshes() {
        let whole = tetrahedron();
        assert!(is_closed(&whole));
        for missing in 0..4 {
            let mut open = whole.clone();
            open.triangles.remove(missing);
            assert!(!is_closed(&open));
            let mut turned = whole.clone();
            turned.triangles[missing].swap(0, 1);
            assert!(!is_closed(&turned), "a face looks inward");
        }
        assert!(!is_closed(&Mesh::default()));
        // A degenerate triangle encloses nothing, and opens nothing.
        let mut degenerate = whole;
        degenerate.triangles.push([0, 0, 1]);
        assert!(is_closed(&degenerate));
        degenerate.triangles = vec![[0, 0, 1]];
        assert!(!is_closed(&degenerate));
    }
}
