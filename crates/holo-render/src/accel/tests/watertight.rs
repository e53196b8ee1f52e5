//! Closed meshes have no holes: rays from inside that are aimed exactly at edges and vertices.
//!
//! A ray through an edge meets both of its triangles within rounding; a triangle test that rounds one edge in two ways lets it
//! slip between them. The BVH has the watertight test of [`super::super::triangle`] (Woop, Benthin, Wald, 2013), and none leaks. With
//! Embree 4.4, ROBUST flag and all, one in a thousand of rays that are aimed *exactly* at a vertex or an edge of a sphere does: a
//! known limit, held to one in a hundred here.

use std::f64::consts::TAU;

use super::*;

/// A closed mesh and points inside.
struct Closed {
    name: &'static str,
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// A point inside that sees the vertex number `k`.
    inside: fn([f32; 3], &mut u64) -> [f32; 3],
}

/// Anywhere near the origin.
fn near_origin(_: [f32; 3], state: &mut u64) -> [f32; 3] {
    std::array::from_fn(|_| (random(state) * 0.4 - 0.2) as f32)
}

/// On the circle in the middle of the tube, at the vertex's place.
fn in_the_tube([x, _, z]: [f32; 3], state: &mut u64) -> [f32; 3] {
    let length = x.hypot(z);
    [x / length, (random(state) * 0.1 - 0.05) as f32, z / length]
}

/// A parametric surface, closed in its first coordinate and, if it is a torus, in the second.
fn torus(around: u32, across: u32) -> Closed {
    let mut positions = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let (a, b) = (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(across));
            let radius = 1.0 + 0.3 * b.cos();
            positions.push([radius * a.cos(), 0.3 * b.sin(), radius * a.sin()].map(|x| x as f32));
        }
    }
    let at = |i: u32, j: u32| (i % around) * across + j % across;
    let mut triangles = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Closed { name: "torus", positions, triangles, inside: in_the_tube }
}

/// A sphere from an octahedron whose triangles are split into four, `times` times over.
fn sphere(times: usize) -> Closed {
    let mut positions: Vec<[f64; 3]> =
        vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for x in [0, 1] {
        for y in [2, 3] {
            triangles.extend([4, 5].map(|z| [x, y, z]));
        }
    }
    for _ in 0..times {
        let mut middles = std::collections::BTreeMap::new();
        let mut finer = Vec::new();
        for [a, b, c] in triangles {
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    let sum: [f64; 3] = std::array::from_fn(|k| positions[a as usize][k] + positions[b as usize][k]);
                    let length = sum.iter().map(|x| x * x).sum::<f64>().sqrt();
                    positions.push(sum.map(|x| x / length));
                    positions.len() as u32 - 1
                })
            };
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let positions = positions.into_iter().map(|p| p.map(|x| x as f32)).collect();
    Closed { name: "sphere", positions, triangles, inside: near_origin }
}

/// A box whose six faces are grids with these lines: without T-junctions, for neighbours share their lines.
fn box_of_grids(name: &'static str, lines: &[f32]) -> Closed {
    let n = lines.len();
    let mut numbers = std::collections::BTreeMap::new();
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let mut vertex = |place: [usize; 3]| {
        *numbers.entry(place).or_insert_with(|| {
            positions.push(place.map(|k| lines[k]));
            positions.len() as u32 - 1
        })
    };
    for axis in 0..3 {
        for side in [0, n - 1] {
            for i in 0..n - 1 {
                for j in 0..n - 1 {
                    let corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|[i, j]| {
                        let mut place = [side; 3];
                        (place[(axis + 1) % 3], place[(axis + 2) % 3]) = (i, j);
                        vertex(place)
                    });
                    let [a, b, c, d] = corners;
                    triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    Closed { name, positions, triangles, inside: near_origin }
}

fn meshes() -> Vec<Closed> {
    let even: Vec<f32> = (0..=24).map(|k| k as f32 / 12.0 - 1.0).collect();
    // Every second strip is 1e-6 wide: the triangles in them are a million times longer than wide.
    let mut thin: Vec<f32> = (0..12).flat_map(|k| [k as f32 / 6.0 - 1.0, k as f32 / 6.0 - 1.0 + 1e-6]).collect();
    thin.push(1.0);
    vec![sphere(5), torus(96, 48), box_of_grids("grids", &even), box_of_grids("slivers", &thin)]
}

/// Rays of one mesh that leave it, of `packets` times 16; half the targets are vertices, half lie on edges.
fn leaks(mesh: &Closed, engine: &dyn Engine, packets: usize) -> usize {
    let mut state = 11;
    let mut leaks = 0;
    for round in 0..packets {
        let mut packet = RayHits::EMPTY;
        for lane in 0..LANES {
            let triangle = mesh.triangles[(random(&mut state) * mesh.triangles.len() as f64) as usize];
            let [a, b] = [0, 1].map(|corner| mesh.positions[triangle[corner] as usize]);
            // Halves and quarters of an edge are exact where its ends have few digits; others are an f32 off.
            let share = [0.0, 0.5, 0.25, random(&mut state) as f32][lane % 4];
            let from = (mesh.inside)(a, &mut state);
            for axis in 0..3 {
                let target = a[axis] + share * (b[axis] - a[axis]);
                packet.rays.origin[axis][lane] = from[axis];
                packet.rays.direction[axis][lane] = target - from[axis];
            }
        }
        let mut shadows = packet.rays;
        let coherence = if round % 2 == 0 { Coherence::Coherent } else { Coherence::Incoherent };
        engine.intersect(&Lanes([-1; LANES]), &mut packet, coherence);
        leaks += packet.hits.triangle.iter().filter(|&&triangle| triangle == NO_TRIANGLE).count();
        if round % 8 == 0 {
            engine.occluded(&Lanes([-1; LANES]), &mut shadows, coherence);
            leaks += shadows.far.iter().filter(|&&far| far != f32::NEG_INFINITY).count();
        }
    }
    leaks
}

#[test]
fn rays_at_edges_and_vertices_stay_inside_closed_meshes() {
    for mesh in meshes() {
        let geometry = Arc::new(geometry(mesh.positions.clone(), mesh.triangles.clone()));
        for engine in engines(&geometry) {
            // 2.6 million rays a mesh; the BVH, ten times slower in a test, gets a quarter.
            let packets = if engine.name() == "bvh" { 40_000 } else { 160_000 };
            let leaks = leaks(&mesh, engine.as_ref(), packets);
            println!("{} of {}: {leaks} leaks of {} rays", mesh.name, engine.name(), packets * LANES);
            let most = if engine.name() == "bvh" { 0 } else { packets * LANES / 100 };
            assert!(leaks <= most, "{} of {}: {leaks}", mesh.name, engine.name());
        }
    }
}
