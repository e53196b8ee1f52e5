//! Whether a mesh is closed.

use crate::Mesh;

/// The volume below which a body is flat, as a share of the cube of its largest extent. A pane of 1 m x 1 m x 1 mm has
/// 0.001 of it.
const FLAT: f64 = 1e-9;

/// Whether a mesh encloses a volume: every edge is run through as often in one direction as in the other, and the body
/// is not flat, such as a pane of two faces that lie on each other. Vertices at the same place are one, because
/// exporters split them where normals or texture coordinates differ.
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
    edges.chunk_by(|(one, _), (other, _)| one == other).all(balanced) && !is_flat(mesh)
}

fn is_flat(mesh: &Mesh) -> bool {
    let Some(origin) = mesh.positions.first().map(|p| p.map(f64::from)) else { return true };
    let mut extent = 0.0_f64;
    let mut volume = 0.0_f64;
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|k| {
            let p = mesh.positions[k as usize];
            let p: [f64; 3] = std::array::from_fn(|axis| f64::from(p[axis]) - origin[axis]);
            extent = p.iter().fold(extent, |extent, x| extent.max(x.abs()));
            p
        });
        let normal = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        volume += (a[0] * normal[0] + a[1] * normal[1] + a[2] * normal[2]) / 6.0;
    }
    // Also for NaN, where the sums overflow.
    let thick = volume.abs() > FLAT * extent.powi(3);
    !thick
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
        // A pane of two faces that lie on each other has no inside.
        let pane = Mesh { triangles: vec![[0, 1, 2], [2, 1, 0]], ..whole.clone() };
        assert!(!is_closed(&pane));
        // A degenerate triangle encloses nothing, and opens nothing.
        let mut degenerate = whole;
        degenerate.triangles.push([0, 0, 1]);
        assert!(is_closed(&degenerate));
        degenerate.triangles = vec![[0, 0, 1]];
        assert!(!is_closed(&degenerate));
    }
}
