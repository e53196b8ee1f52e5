//! The three engines agree.

mod watertight;

use std::sync::Arc;

use super::*;
use crate::geometry::Instancing;
use crate::simd::{LANES, Lanes};
use holo_scene::{Instance, Material, Mesh, Scene, Transform};

/// A random number generator (SplitMix64), so that tests are the same on all machines.
pub(crate) fn random(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// `count` random triangles in front of the camera.
pub(crate) fn soup(count: usize, seed: u64) -> Geometry {
    let (positions, triangles) = soup_mesh(count, seed);
    geometry(positions, triangles)
}

/// The same triangles as a prototype with two placements.
pub(crate) fn instanced_soup(count: usize, seed: u64) -> Geometry {
    let (positions, triangles) = soup_mesh(count, seed);
    let mut scene = scene(positions, triangles);
    let aside = Transform::from_translation([0.5, 0.25, -1.0]);
    scene.instances.push(Instance { transform: aside, ..scene.instances[0].clone() });
    let geometry = Geometry::build(&scene, &Transform::IDENTITY, Instancing::Always).expect("a valid scene");
    assert_eq!(geometry.placements().len(), 2);
    geometry
}

fn soup_mesh(count: usize, seed: u64) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let mut state = seed;
    let mut positions = Vec::new();
    for _ in 0..count {
        let center = [random(&mut state) * 4.0 - 2.0, random(&mut state) * 4.0 - 2.0, -2.0 - 4.0 * random(&mut state)];
        for _ in 0..3 {
            positions.push(center.map(|c| (c + random(&mut state) * 0.8 - 0.4) as f32));
        }
    }
    (positions, (0..count as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect())
}

pub(crate) fn geometry(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Geometry {
    Geometry::build(&scene(positions, triangles), &Transform::IDENTITY, Instancing::Never).expect("a valid scene")
}

fn scene(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Scene {
    Scene {
        meshes: vec![Mesh { positions, triangles, ..Mesh::default() }],
        instances: vec![Instance { name: String::new(), mesh: 0, transform: Transform::IDENTITY }],
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

/// A closed box around the origin, 12 triangles.
pub(crate) fn cube(half: f32) -> Geometry {
    let positions: Vec<[f32; 3]> =
        (0..8).map(|k| [0, 1, 2].map(|axis| if k >> axis & 1 == 1 { half } else { -half })).collect();
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    geometry(positions, quads.iter().flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]).collect())
}

fn engines(geometry: &Arc<Geometry>) -> Vec<Box<dyn Engine>> {
    let mut list = vec![build(Backend::Bvh, geometry, 1).unwrap().0];
    match build(Backend::Embree, geometry, 1) {
        Ok((engine, _)) => list.push(engine),
        Err(why) => crate::peer::missing(&format!("Embree: {why}")),
    }
    list
}

fn random_packet(state: &mut u64) -> RayHits {
    let mut packet = RayHits::EMPTY;
    for lane in 0..LANES {
        for axis in 0..2 {
            packet.rays.origin[axis][lane] = (random(state) * 0.2 - 0.1) as f32;
            // Also rays along the axes, with zeros of both signs.
            let tilt = random(state) - 0.5;
            packet.rays.direction[axis][lane] =
                if tilt.abs() < 0.05 { 0.0f32.copysign(tilt as f32) } else { tilt as f32 };
        }
    }
    packet
}

/// On random triangles all engines agree: hit or miss, triangle, distance, barycentrics, occlusion. An f32 test may
/// decide a ray within rounding of an edge differently, so one lane in a thousand may differ.
#[test]
fn engines_agree_on_random_triangles() {
    let geometry = Arc::new(soup(400, 7));
    let reference = brute_force::BruteForce::build(&geometry);
    let valid = Lanes(std::array::from_fn(|lane| if lane == 5 { 0 } else { -1 }));
    for engine in engines(&geometry) {
        let mut state = 99;
        let (mut differ, mut hits) = (0, 0);
        for round in 0..500 {
            let coherence = if round % 2 == 0 { Coherence::Coherent } else { Coherence::Incoherent };
            let rays = random_packet(&mut state);
            let (mut expected, mut got) = (rays, rays);
            reference.intersect(&valid, &mut expected, Coherence::Coherent);
            engine.intersect(&valid, &mut got, Coherence::Coherent);
            let (mut dark, mut also_dark) = (rays.rays, rays.rays);
            reference.occluded(&valid, &mut dark, Coherence::Incoherent);
            engine.occluded(&valid, &mut also_dark, coherence);
            for lane in 0..LANES {
                if lane == 5 {
                    assert_eq!(got.rays.far[lane], f32::INFINITY, "an invalid lane was touched");
                    assert_eq!(also_dark.far[lane], f32::INFINITY);
                    continue;
                }
                let same =
                    got.hits.triangle[lane] == expected.hits.triangle[lane] && (dark.far[lane] == also_dark.far[lane]);
                if !same {
                    differ += 1;
                } else if expected.hits.triangle[lane] != NO_TRIANGLE {
                    hits += 1;
                    let (a, b) = (got.rays.far[lane], expected.rays.far[lane]);
                    // Distances of 2 to 10 from products of three f32: an error of at most some tens of ulp.
                    assert!((a - b).abs() <= 2e-5 * b, "{}: {a} against {b}", engine.name());
                    for (a, b) in [(&got.hits.u, &expected.hits.u), (&got.hits.v, &expected.hits.v)] {
                        // Slivers magnify rounding errors of barycentrics, which are only used to interpolate vertex
                        // attributes.
                        assert!((a[lane] - b[lane]).abs() < 2e-3, "{}: {} {}", engine.name(), a[lane], b[lane]);
                    }
                }
            }
        }
        assert!(hits > 3000, "the test must hit: {hits}");
        assert!(differ <= 8, "{} differs on {differ} of 7500 rays", engine.name());
    }
}

/// From inside a closed box every ray hits, including those aimed exactly at edges and corners.
#[test]
fn no_ray_leaves_a_closed_box() {
    let geometry = Arc::new(cube(1.0));
    for engine in engines(&geometry) {
        let mut state = 3;
        for round in 0..2000 {
            let mut packet = RayHits::EMPTY;
            for lane in 0..LANES {
                // Half of the targets lie on edges, a quarter are corners.
                let mut target: [f32; 3] = std::array::from_fn(|_| (random(&mut state) * 2.0 - 1.0) as f32);
                let snapped = [1, 2, 2, 3][(round + lane) % 4];
                for axis in target.iter_mut().take(snapped) {
                    *axis = if *axis < 0.0 { -1.0 } else { 1.0 };
                }
                for axis in 0..3 {
                    packet.rays.origin[axis][lane] = (random(&mut state) * 0.5 - 0.25) as f32;
                    packet.rays.direction[axis][lane] = target[axis] - packet.rays.origin[axis][lane];
                }
            }
            engine.intersect(&Lanes([-1; LANES]), &mut packet, Coherence::Coherent);
            assert!(!packet.hits.triangle.contains(&NO_TRIANGLE), "{} leaks in round {round}", engine.name());
        }
    }
}

#[test]
fn an_empty_scene_is_hit_by_nothing() {
    let geometry = Arc::new(geometry(vec![], vec![]));
    let reference: Box<dyn Engine> = Box::new(brute_force::BruteForce::build(&geometry));
    for engine in engines(&geometry).into_iter().chain([reference]) {
        let mut packet = RayHits::EMPTY;
        engine.intersect(&Lanes([-1; LANES]), &mut packet, Coherence::Coherent);
        assert_eq!(packet.hits.triangle, [NO_TRIANGLE; LANES]);
        engine.occluded(&Lanes([-1; LANES]), &mut packet.rays, Coherence::Coherent);
        assert_eq!(packet.rays.far, [f32::INFINITY; LANES]);
    }
}
