//! Motion, compared with points that are moved by hand.

use std::num::NonZeroUsize;

use crate::World;
use holo_core::{GridSize, LightFieldShape};
use holo_scene::{Instance, Material, Mesh};

use super::*;
use crate::accel::{Backend, embree};
use crate::film::layers::Layer;
use crate::geometry::Instancing;

/// A grid of quads over the unit square around the origin, bent out of its plane.
fn sheet(side: u32) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=side {
        for i in 0..=side {
            let [x, y] = [i, j].map(|k| f64::from(k) / f64::from(side) - 0.5);
            mesh.positions.push([x, y, 0.2 * (4.0 * x).sin() * y].map(|x| x as f32));
        }
    }
    for j in 0..side {
        for i in 0..side {
            let [a, b] = [j, j + 1].map(|row| row * (side + 1) + i);
            mesh.triangles.extend([[a, a + 1, b + 1], [a, b + 1, b]]);
        }
    }
    mesh
}

/// Sheets in these places, which may overlap, and nothing behind them.
fn scene(places: &[Transform]) -> Scene {
    let instance = |transform: &Transform| Instance { name: String::new(), mesh: 0, transform: *transform };
    Scene {
        meshes: vec![sheet(24)],
        instances: places.iter().map(instance).collect(),
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

/// Turned, scaled, mirrored; the last but one does not move.
fn places(is_next: bool) -> Vec<Transform> {
    let later = if is_next { 1.0 } else { 0.0 };
    let place = |x: f64, y: f64, z: f64, turn: f64, scale: [f64; 3]| {
        let (sin, cos) = (0.5 * turn).sin_cos();
        Transform::from_parts([x, y, z], [0.3 * sin, sin, 0.2 * sin, cos], scale)
    };
    vec![
        place(-0.4 + 0.05 * later, 0.1, -2.0, 0.3 + 0.2 * later, [0.8; 3]),
        place(0.4, -0.2 + 0.03 * later, -1.7 - 0.2 * later, -0.4, [0.5, 0.7, 0.4]),
        place(0.1, 0.4, -2.4, 0.1 - 0.4 * later, [-0.7, 0.6, 0.6]),
        place(0.5, 0.4, -2.2, 0.6, [0.5; 3]),
        place(-0.1 - 0.02 * later, -0.5, -1.5, 0.0, [0.6 + 0.1 * later, 0.4, 0.5]),
    ]
}

fn rig(projection: Projection) -> Rig {
    let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(48, 71)).expect("sizes");
    let focus_m = if projection == Projection::Perspective { f64::INFINITY } else { 2.0 };
    Rig::builder(shape)
        .focal_length_m(0.04)
        .sensor_size_m(0.036)
        .baseline_m(0.01)
        .focus_distance_m(focus_m)
        .projection(projection)
        .build()
        .expect("a rig")
}

/// The pose of a camera at a large distance from the origin of the world, turned a little.
fn pose(is_next: bool, far: [f64; 3]) -> Transform {
    let eye = if is_next { [0.03, -0.02, 0.06] } else { [0.0; 3] };
    let target = if is_next { [0.02, 0.03, -2.0] } else { [0.0, 0.0, -2.0] };
    Transform::look_at([0, 1, 2].map(|k| far[k] + eye[k]), [0, 1, 2].map(|k| far[k] + target[k]), [0.0, 1.0, 0.0])
}

fn moved(places: Vec<Transform>, far: [f64; 3]) -> Vec<Transform> {
    let by = |t: Transform| Transform { translation: [0, 1, 2].map(|k| t.translation[k] + far[k]), ..t };
    places.into_iter().map(by).collect()
}

/// All views, both projections, flattened and instanced, beside the origin and far from it: the same material point, found
/// by the inverse of the transform, in the next frame.
#[test]
fn points_move_with_their_instances_and_the_camera() {
    // Powers of two, so that places are exact.
    for (far, instancing, backend) in [
        ([0.0; 3], Instancing::Never, Backend::Bvh),
        ([4096.0, -2048.0, 8192.0], Instancing::Never, Backend::Bvh),
        ([4096.0, -2048.0, 8192.0], Instancing::Always, Backend::Embree),
    ] {
        if backend == Backend::Embree && embree::Embree::available().is_err() {
            crate::peer::missing("Embree 4");
            continue;
        }
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let rig = rig(projection);
            let scenes = [false, true].map(|is_next| scene(&moved(places(is_next), far)));
            let poses = [false, true].map(|is_next| pose(is_next, far));
            let renderer = World::with_instancing(&scenes[0], backend, NonZeroUsize::new(2), instancing)
                .and_then(|world| world.at(&poses[0]))
                .expect("a renderer");
            let frames = [0, 1].map(|k| Frame { scene: &scenes[k], pose: poses[k], rig: &rig });
            let view = ViewIndex::new(1, 2);
            assert_eq!(rig.shape().central_view(), (1, 2));
            let motion = renderer.motion([&frames[0], &frames[1]], &[view], false, &()).expect("motion").remove(0);
            let layers = renderer.central_layers(&rig, [Layer::Depth, Layer::ObjectId].into()).expect("layers");
            let (mut hits, mut misses) = (0, 0);
            for ((v, u, _), &object) in layers[Layer::ObjectId].indexed_iter() {
                let flows =
                    ([0, 1].map(|k| motion.optical_flow[[v, u, k]]), [0, 1, 2].map(|k| motion.scene_flow[[v, u, k]]));
                let ray = rig.ray(v, u, 1, 2, 0.5, 0.5);
                if object == 0.0 {
                    assert_eq!(flows.1, [0.0; 3]);
                    // A direction in the next camera.
                    let world = poses[0].vector(ray.direction);
                    let seen = poses[1].columns.map(|axis| (0..3).map(|k| axis[k] * world[k]).sum::<f64>());
                    match projection {
                        Projection::Perspective => {
                            let [column, row] = [rig.column(-seen[0] / seen[2]), rig.row(-seen[1] / seen[2])];
                            assert_near(flows.0, [column - u as f64 - 0.5, row - v as f64 - 0.5], 1e-5);
                        }
                        Projection::Orthographic => assert!(flows.0.iter().all(|x| x.is_nan())),
                    }
                    misses += 1;
                    continue;
                }
                let k = object as usize - 1;
                let depth_m = f64::from(layers[Layer::Depth][[v, u, 0]]);
                let world = poses[0].point(ray.at_depth_m(depth_m));
                let own = inverse_point(&scenes[0].instances[k].transform, world);
                let after = scenes[1].instances[k].transform.point(own);
                // Depth is read in f32: 2e-7 of two meters.
                assert_near(flows.1, [0, 1, 2].map(|k| after[k] - world[k]), 1e-6);
                if k == 3 {
                    assert_eq!(flows.1, [0.0; 3], "it does not move");
                }
                let from = [0, 1, 2].map(|k| after[k] - poses[1].translation[k]);
                let seen = poses[1].columns.map(|axis| (0..3).map(|k| axis[k] * from[k]).sum::<f64>());
                let (row, column) = rig.project(seen, 1, 2).expect("in front");
                assert_near(flows.0, [column - u as f64 - 0.5, row - v as f64 - 0.5], 2e-4);
                hits += 1;
            }
            assert!(hits > 1000 && misses > 300, "{hits} {misses}");
        }
    }
}

#[track_caller]
fn assert_near<const N: usize>(is: [f32; N], expected: [f64; N], tolerance: f64) {
    let worst = is.iter().zip(expected).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max);
    assert!(worst <= tolerance, "{is:?} instead of {expected:?}: {worst:e}");
}

fn inverse_point(transform: &Transform, point: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = transform.columns.map(glam::DVec3::from);
    let offset = glam::DVec3::from([0, 1, 2].map(|k| point[k] - transform.translation[k]));
    glam::DMat3::from_cols(a, b, c).inverse().mul_vec3(offset).to_array()
}

/// With the camera at rest, everything that rests has exactly 0, and what bends moves as its vertices do.
#[test]
fn rest_is_zero_and_bending_is_linear_on_a_triangle() {
    let rig = rig(Projection::Perspective);
    let mut scenes = [scene(&places(false)), scene(&places(false))];
    for mesh in scenes.iter_mut().map(|scene| &mut scene.meshes) {
        let own = mesh[0].clone();
        mesh.push(own);
    }
    scenes.iter_mut().for_each(|scene| scene.instances[0].mesh = 1);
    // A translation of the vertices of one mesh, rounded to f32.
    scenes[1].meshes[1].positions.iter_mut().for_each(|p| p[2] += 1.0 / 64.0);
    let pose = pose(false, [0.0; 3]);
    let renderer = Renderer::new(&scenes[0], &pose, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
    let frames = [0, 1].map(|k| Frame { scene: &scenes[k], pose, rig: &rig });
    let motion = renderer.motion([&frames[0], &frames[1]], &[ViewIndex::new(0, 0)], false, &());
    let motion = motion.expect("motion").remove(0);
    let expected = scenes[0].instances[0].transform.vector([0.0, 0.0, 1.0 / 64.0]);
    let mut count = 0;
    for v in 0..48 {
        for u in 0..71 {
            let flow = [0, 1, 2].map(|k| motion.scene_flow[[v, u, k]]);
            if flow == [0.0; 3] {
                assert_eq!([0, 1].map(|k| motion.optical_flow[[v, u, k]]), [0.0; 2]);
            } else {
                assert_near(flow, expected, 1e-8);
                count += 1;
            }
        }
    }
    assert!(count > 300, "{count}");
}

#[test]
fn frames_must_fit() {
    let (rig, pose) = (rig(Projection::Perspective), pose(false, [0.0; 3]));
    let here = scene(&places(false));
    let renderer = Renderer::new(&here, &pose, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
    let this = Frame { scene: &here, pose, rig: &rig };
    let error = |next: &Scene, rig: &Rig, view: ViewIndex| {
        let next = Frame { scene: next, pose, rig };
        renderer.motion([&this, &next], &[view], false, &()).expect_err("does not fit").to_string()
    };
    let first = ViewIndex::new(0, 0);
    assert!(error(&scene(&places(false)[..4]), &rig, first).contains("5 instances become 4"));
    let mut other = here.clone();
    other.meshes[0].triangles.pop();
    assert!(error(&other, &rig, first).contains("another number of triangles"));
    let coarse = rig.to_builder().shape(LightFieldShape::new(GridSize::new(3, 4), GridSize::new(4, 7)).expect("sizes"));
    assert!(error(&here, &coarse.build().expect("a rig"), first).contains("numbers of views or lenses"));
    assert!(error(&here, &rig, ViewIndex::new(3, 0)).contains("view row 3"));
}

/// With culling, what a back face hides is seen, as in the layers.
#[test]
fn culled_faces_have_no_motion() {
    let behind = Transform::from_translation([0.02, 0.0, -3.0]);
    // Turned by half a turn about y, it shows its back.
    let back = |x: f64| Transform::from_parts([x, 0.0, -2.0], [0.0, 1.0, 0.0, 0.0], [1.0; 3]);
    let mut scenes = [scene(&[back(0.0), behind]), scene(&[back(0.1), behind])];
    scenes.iter_mut().for_each(|scene| scene.materials[0].double_sided = false);
    let (rig, pose) = (rig(Projection::Perspective), Transform::IDENTITY);
    let renderer = Renderer::new(&scenes[0], &pose, Backend::BruteForce, NonZeroUsize::new(1)).expect("a renderer");
    let frames = [0, 1].map(|k| Frame { scene: &scenes[k], pose, rig: &rig });
    let center = |cull: bool| {
        let motion = renderer.motion([&frames[0], &frames[1]], &[ViewIndex::new(1, 2)], cull, &());
        motion.expect("motion").remove(0).scene_flow[[24, 35, 0]]
    };
    assert_eq!(center(true), 0.0);
    assert!((center(false) - 0.1).abs() < 1e-7);
}
