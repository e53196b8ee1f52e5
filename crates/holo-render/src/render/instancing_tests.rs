//! Instanced scenes, compared with the same scenes flattened. These tests need Embree and are skipped without it.

use holo_core::{GridSize, LightFieldShape, Rig};

use super::*;
use crate::accel;
use crate::accel::refine;
use crate::accel::{Coherence, RayHits};
use crate::camera::tile::{Selection, Tiling};
use crate::geometry::Instancing;
use crate::geometry::{FLATTENED, Hit};
use crate::simd::LANES;
use holo_scene::{Instance, Light, LightKind, Material, Mesh, Texture, TextureInfo, Wrap};

/// A bumpy ball of radius about 1 around `center`: `2 * side * side` triangles with normals, texture coordinates and
/// colors.
fn ball(side: u32, center: f64) -> Mesh {
    let mut mesh = Mesh::default();
    for j in 0..=side {
        for i in 0..=side {
            let (s, t) = (f64::from(i) / f64::from(side), f64::from(j) / f64::from(side));
            let (around, down) = (s * std::f64::consts::TAU, (0.01 + 0.98 * t) * std::f64::consts::PI);
            let d = [down.sin() * around.cos(), down.cos(), -down.sin() * around.sin()];
            let radius = 1.0 + 0.1 * (5.0 * around).sin() * down.sin();
            mesh.positions.push(d.map(|x| (x * radius + center) as f32));
            mesh.normals.push(d.map(|x| x as f32));
            mesh.texture_coordinates.push([s as f32, t as f32]);
            mesh.colors.push([1.0 - 0.5 * s as f32, 1.0, 0.5 + 0.5 * t as f32, 1.0]);
        }
    }
    for j in 0..side {
        for i in 0..side {
            let [a, b] = [j, j + 1].map(|row| row * (side + 1) + i);
            mesh.triangles.extend([[a, b, b + 1], [a, b + 1, a + 1]]);
        }
    }
    mesh
}

/// Rotated, stretched, mirrored, sheared, small and large transforms.
fn transforms() -> Vec<Transform> {
    let parts =
        |x: f64, y: f64, z: f64, scale: [f64; 3]| Transform::from_parts([x, y, z], [0.3 + x, 0.4 - y, 0.2, 0.7], scale);
    let mut sheared = parts(0.5, 0.35, -2.6, [0.25; 3]);
    sheared.columns[1] = std::array::from_fn(|k| sheared.columns[1][k] + 0.9 * sheared.columns[0][k]);
    vec![
        parts(-0.6, -0.3, -2.2, [0.25; 3]),
        parts(0.1, -0.35, -2.4, [0.3, 0.1, 0.2]),
        parts(0.6, -0.3, -2.0, [-0.2, 0.2, 0.2]),
        parts(-0.5, 0.4, -2.5, [0.2, -0.3, 0.05]),
        sheared,
        // Overlapping the first ones.
        parts(-0.2, -0.1, -2.4, [0.3, 0.3, 0.3]),
        parts(0.2, 0.0, -9.0, [3.0, 3.0, 2.0]),
        parts(0.0, 0.2, -1.2, [0.02; 3]),
    ]
}

/// The balls in front of an emissive (and therefore flattened) wall, under a sun.
fn scene() -> Scene {
    let texels = (0..64u8).map(|k| [k.wrapping_mul(37), 255 - k, 128 + k, 255]).collect();
    let texture = Texture {
        name: String::new(),
        width: 8,
        height: 8,
        texels,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Clamp,
        filter: holo_scene::Filter::Linear,
    };
    let textured = Material { base_color_texture: Some(TextureInfo::new(0)), ..Material::default() };
    let emissive = Material { emission: [0.5; 3], ..Material::default() };
    let wall = Mesh {
        positions: vec![[-9.0, -9.0, -12.0], [9.0, -9.0, -12.0], [9.0, 9.0, -12.0], [-9.0, 9.0, -12.0]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material: 1,
        ..Mesh::default()
    };
    let place = |mesh, transform| Instance { name: String::new(), mesh, transform };
    let mut instances: Vec<Instance> = transforms().into_iter().map(|transform| place(0, transform)).collect();
    instances.insert(3, place(1, Transform::IDENTITY));
    let kind = LightKind::Directional { direction: [0.48, -0.6, -0.64], angular_diameter_rad: 0.0 };
    Scene {
        meshes: vec![ball(24, 0.0), wall],
        instances,
        materials: vec![textured, emissive],
        textures: vec![texture],
        lights: vec![Light { name: String::new(), intensity: [2.0; 3], kind }],
        ..Scene::default()
    }
}

fn rig() -> Rig {
    Rig::builder(LightFieldShape::new(GridSize::new(4, 4), GridSize::new(60, 90)).expect("sizes"))
        .focal_length_m(0.05)
        .sensor_size_m(0.036)
        .baseline_m(0.01)
        .focus_distance_m(2.0)
        .build()
        .expect("a rig")
}

/// Flattened and instanced, or `None` without Embree.
fn both(scene: &Scene) -> Option<[Renderer; 2]> {
    if let Err(why) = accel::embree::Embree::available() {
        crate::peer::missing(&format!("Embree 4: {why}"));
        return None;
    }
    Some([Instancing::Never, Instancing::Always].map(|instancing| {
        World::with_instancing(scene, Backend::Embree, NonZeroUsize::new(2), instancing)
            .and_then(|world| world.at(&Transform::IDENTITY))
            .expect("a renderer")
    }))
}

/// For every hit on an instanced geometry the index of the same triangle in the flattened one.
fn flattened_numbers(scene: &Scene, geometry: &Geometry) -> impl Fn(Hit) -> u32 {
    let mut firsts = Vec::new();
    let mut first = 0;
    for instance in &scene.instances {
        firsts.push((instance.mesh, first));
        first += scene.meshes[instance.mesh].triangles.len() as u32;
    }
    let of = |mesh: usize| firsts.iter().filter(move |(m, _)| *m == mesh).map(|(_, f)| *f).collect::<Vec<u32>>();
    let (placements, flat) = (of(0), of(1));
    let start = geometry.prototypes()[0].start as u32;
    move |hit| {
        if hit.placement == FLATTENED {
            flat[0] + hit.triangle
        } else {
            placements[hit.placement as usize] + hit.triangle - start
        }
    }
}

struct Found {
    hit: Hit,
    depth: f64,
    normal: [f64; 3],
    barycentrics: [f32; 2],
}

/// The hits of all rays of the rig.
fn trace(renderer: &Renderer) -> Vec<Found> {
    let selection = Selection::whole(rig().shape());
    let tiling = Tiling::new(selection.counts());
    let camera = RaySource::Rig(RigRays::new(&rig(), &tiling, &selection));
    let mut out = Vec::new();
    let mut packet = RayHits::EMPTY;
    for tile in tiling.tiles() {
        for pixels in camera.packets(&tile) {
            let rays = pixels.chief(&mut packet);
            renderer.engines[0][0].intersect(&pixels.valid, &mut packet, Coherence::Coherent);
            let refined = refine::refine(&renderer.geometry, &packet, &rays);
            for lane in (0..LANES).filter(|&lane| pixels.valid.0[lane] != 0) {
                out.push(Found {
                    hit: packet.hit(lane),
                    depth: refined.depth[lane],
                    normal: std::array::from_fn(|axis| refined.normal[axis][lane]),
                    barycentrics: [packet.hits.u[lane], packet.hits.v[lane]],
                });
            }
        }
    }
    out
}

/// Every triangle of every placement: corners, normals, plane, instance data.
#[test]
fn an_instanced_triangle_equals_its_flattened_copy() {
    let scene = scene();
    let pose = Transform::look_at([0.3, 0.2, 0.5], [0.0, 0.0, -3.0], [0.1, 1.0, 0.0]);
    let flat = Geometry::build(&scene, &pose, Instancing::Never).expect("a scene");
    let geometry = Geometry::build(&scene, &pose, Instancing::Always).expect("a scene");
    assert_eq!((geometry.placements().len(), geometry.flattened_count()), (transforms().len(), 2));
    let number = flattened_numbers(&scene, &geometry);
    let triangles = geometry.prototypes()[0].clone();
    for placement in 0..geometry.placements().len() as u32 {
        let mirrored = transforms()[placement as usize].determinant() < 0.0;
        // Flattening swaps two corners of mirrored triangles.
        let order = if mirrored { [0, 2, 1] } else { [0, 1, 2] };
        let in_flat = |triangle: usize| Hit::flattened(number(Hit { triangle: triangle as u32, placement }) as usize);
        let largest = triangles.clone().map(|triangle| flat.extent(in_flat(triangle))).fold(0.0, f32::max);
        for triangle in triangles.clone() {
            let hit = Hit { triangle: triangle as u32, placement };
            let same = Hit::flattened(number(hit) as usize);
            assert_eq!(geometry.corners(hit), order.map(|k| flat.corners(same)[k]), "the same f64 sums");
            let (a, b) = (geometry.normals_of(hit), order.map(|k| flat.normals_of(same)[k]));
            // A few f32 roundings of numbers up to 1, magnified up to the ratio of the scales (6) squared.
            assert!(a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 2e-5), "{a:?} {b:?}");
            let (a, b) = (geometry.plane(hit), flat.plane(same));
            let length = b.normal.iter().map(|x| x * x).sum::<f64>().sqrt();
            // f64 corners 10 m away have an error of 1e-15, edges are at least 1e-3 m: 1e-12 relative, here a hundred
            // times that.
            for (a, b) in a.normal.iter().chain([&a.offset]).zip(b.normal.iter().chain([&b.offset])) {
                assert!((a - b).abs() < 1e-10 * length, "{a} {b} of {length}");
            }
            assert_eq!(geometry.colors_of(hit), order.map(|k| flat.colors_of(same)[k]));
            assert_eq!(geometry.texture_coordinates_of(hit, 0), order.map(|k| flat.texture_coordinates_of(same, 0)[k]));
            let [a, b] = [geometry.instance(geometry.instance_index(hit)), flat.instance(flat.instance_index(same))];
            assert_eq!((a.material, a.smooth, a.textured, a.colored), (b.material, b.smooth, b.textured, b.colored));
            assert!(geometry.extent(hit) >= flat.extent(same) && geometry.extent(hit) < 16.1 * largest);
        }
    }
}

/// All rays of a rig: the same triangle, depth to 1e-10, the same normal and barycentrics.
#[test]
fn instanced_and_flattened_scenes_are_hit_alike() {
    let scene = scene();
    let Some([flat, instanced]) = both(&scene) else { return };
    assert!(!flat.geometry.is_instanced() && instanced.geometry.is_instanced());
    let number = flattened_numbers(&scene, &instanced.geometry);
    let (expected, found) = (trace(&flat), trace(&instanced));
    let mut differ = 0;
    let mut transforms = std::collections::BTreeSet::new();
    for (a, b) in expected.iter().zip(&found) {
        let same = number(b.hit);
        if same != a.hit.triangle {
            // An edge: the ray hits the neighbor, or what lies behind a silhouette.
            differ += 1;
            continue;
        }
        transforms.insert(b.hit.placement);
        assert!((a.depth - b.depth).abs() <= 1e-10 * a.depth, "{} {}", a.depth, b.depth);
        let length = a.normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((0..3).all(|k| (a.normal[k] - b.normal[k]).abs() < 1e-10 * length), "{:?} {:?}", a.normal, b.normal);
        let mirrored = b.hit.placement != FLATTENED && self::transforms()[b.hit.placement as usize].determinant() < 0.0;
        let barycentrics = if mirrored { [a.barycentrics[1], a.barycentrics[0]] } else { a.barycentrics };
        // f32 positions (1e-6 m) over edges of some millimeters, seen at a slant.
        assert!(
            (0..2).all(|k| (barycentrics[k] - b.barycentrics[k]).abs() < 2e-2),
            "{barycentrics:?} {:?}",
            b.barycentrics
        );
    }
    assert_eq!(transforms.len(), self::transforms().len() + 1, "every place and the wall must be seen: {transforms:?}");
    // f32 decides edges to about 1e-6 m, triangles are 1 to 10 mm wide: fewer than one ray in a thousand.
    assert!(differ * 1000 <= found.len(), "{differ} of {}", found.len());
}

/// The color of direct light and of paths.
#[test]
fn instanced_and_flattened_images_agree() {
    let scene = scene();
    let Some(renderers) = both(&scene) else { return };
    for integrator in [Integrator::Direct, Integrator::Path] {
        let request = Request::new(rig())
            .integrator(integrator)
            .sky([0.3, 0.4, 0.5])
            .max_bounces(3)
            .ground_truth(GroundTruth::All);
        let [flat, instanced] =
            renderers.each_ref().map(|renderer| renderer.render(&request, &()).expect("a render").color.expect("lit"));
        let (flat, instanced) = (flat.samples(), instanced.samples());
        let different = flat.iter().zip(instanced).filter(|(a, b)| (*a - *b).abs() > 1e-3 * a.abs().max(0.1)).count();
        // Silhouettes, edges of shadows, and paths that diverge there: 0.3 % of the values.
        assert!(different * 300 < flat.len(), "{integrator:?}: {different} of {}", flat.len());
        let mean = |x: &ndarray::ArrayView5<f32>| x.iter().map(|x| f64::from(*x)).sum::<f64>() / x.len() as f64;
        let (a, b) = (mean(&flat.view()), mean(&instanced.view()));
        assert!((a - b).abs() < 1e-3 * a, "{integrator:?}: {a} {b}");
    }
}

/// Bumps of a normal map point the same way on mirrored placements as on mirrored, flattened copies.
#[test]
fn bumps_of_mirrored_placements_are_not_dents() {
    let mut scene = scene();
    // A slope along u and v: neither mirrored nor turned it is the same.
    scene.textures[0].texels = vec![[190, 90, 230, 255]; 64];
    let texture = TextureInfo::new(0);
    scene.materials[0].base_color_texture = None;
    scene.materials[0].normal_map = Some(holo_scene::NormalMap { texture, scale: 1.0 });
    let mut with_tangents = scene.clone();
    with_tangents.add_tangents().expect("a scene");
    assert!(!with_tangents.meshes[0].tangents.is_empty());
    let request = Request::new(rig()).integrator(Integrator::Direct);
    let mut images = Vec::new();
    for scene in [scene, with_tangents] {
        let Some(renderers) = both(&scene) else { return };
        let [flat, instanced] =
            renderers.each_ref().map(|renderer| renderer.render(&request, &()).expect("a render").color.expect("lit"));
        let (flat, instanced) = (flat.samples(), instanced.samples());
        let different = flat.iter().zip(instanced).filter(|(a, b)| (*a - *b).abs() > 1e-2).count();
        assert!(different * 300 < flat.len(), "{different} of {}", flat.len());
        images.push(flat.to_owned());
    }
    // The axes of triangles and those of vertices differ by the angle between neighboring triangles, 15 degrees of
    // 24 around; mirrored ones would differ by 0.1 and more on most of the balls.
    let far = images[0].iter().zip(&images[1]).filter(|(a, b)| (*a - *b).abs() > 0.05).count();
    assert!(far * 50 < images[0].len(), "{far} of {}", images[0].len());
}

/// The other engines get flattened geometry and agree with Embree.
#[test]
fn the_bvh_renders_what_is_instanced_elsewhere() {
    let scene = scene();
    let bvh = Renderer::new(&scene, &Transform::IDENTITY, Backend::Bvh, NonZeroUsize::new(2)).expect("a renderer");
    assert!(!bvh.geometry.is_instanced());
    let Some([_, instanced]) = both(&scene) else { return };
    let [a, b] = [&bvh, &instanced].map(|renderer| renderer.central_truth(&rig()).expect("a render"));
    let [a, b] = [&a, &b].map(|truth| truth.depth_m().expect("depth"));
    // If both hit the same triangle, depth is the same f64, rounded to f32.
    let different = a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 2e-7 * **a).count();
    assert!(different * 200 < a.len(), "{different} of {}", a.len());
}

/// Small scenes are flattened.
#[test]
fn small_scenes_stay_flattened() {
    for scene in [scene(), holo_scene::gallery::scene("garden").expect("a scene of the gallery")] {
        let geometry = Geometry::build(&scene, &Transform::IDENTITY, Instancing::Automatic).expect("a scene");
        assert!(!geometry.is_instanced());
    }
}

/// Instances that would lose precision in mesh coordinates are flattened: a mesh far from its own origin, a singular
/// transform, extreme shear, extreme units.
#[test]
fn instances_that_would_lose_precision_are_flattened() {
    let mut flat = Transform::from_translation([0.0, 0.0, -3.0]);
    flat.columns[2] = [0.0; 3];
    let mut sheared = Transform::from_translation([0.0, 0.0, -3.0]);
    (sheared.columns[0], sheared.columns[1]) = ([1.0, 1.0, 0.0], [1.0, 1.02, 0.0]);
    let microscopic = Transform::from_parts([0.0, 0.0, -3.0], [0.0, 0.0, 0.0, 1.0], [1e-7; 3]);
    let far = Transform::from_translation([-1000.0, -1000.0, -1003.0]);
    for (transform, center) in [(flat, 0.0), (sheared, 0.0), (microscopic, 0.0), (far, 1000.0)] {
        let scene = Scene {
            meshes: vec![ball(6, center)],
            instances: vec![Instance { name: String::new(), mesh: 0, transform }],
            materials: vec![Material::default()],
            ..Scene::default()
        };
        let geometry = Geometry::build(&scene, &Transform::IDENTITY, Instancing::Always).expect("a scene");
        assert!(!geometry.is_instanced() && geometry.prototypes().is_empty(), "{transform:?}");
        assert_eq!(geometry.triangles().len(), 72);
    }
}

/// A tilted wall of slivers under a slanting sun does not shadow itself: in meters, in millimeters, mirrored,
/// stretched, sheared, and around a point away from its own origin (close to the maximum loss).
#[test]
fn instanced_slivers_do_not_shade_themselves() {
    let tilt = |scale: [f64; 3]| Transform::from_parts([0.01, -0.02, -2.0], [0.21, 0.13, 0.08, 0.96], scale);
    let mut sheared = tilt([1.0; 3]);
    sheared.columns[1] = std::array::from_fn(|k| sheared.columns[1][k] + 0.8 * sheared.columns[0][k]);
    let away = 2.5;
    let mut shifted = tilt([1.0; 3]);
    shifted.translation = shifted.point([-away; 3]);
    for (what, transform, unit, center) in [
        ("meters", tilt([1.0; 3]), 1.0, 0.0),
        ("millimeters", tilt([1e-3; 3]), 1e3, 0.0),
        ("mirrored", tilt([1.0, -1.0, 1.0]), 1.0, 0.0),
        ("stretched", tilt([1.7, 1.1, 0.01]), 1.0, 0.0),
        ("sheared", sheared, 1.0, 0.0),
        ("shifted", shifted, 1.0, away),
    ] {
        let mut mesh = Mesh::default();
        for k in 0..1000u32 {
            let (y0, y1) = (-2.0 + 0.004 * f64::from(k), -2.0 + 0.004 * f64::from(k + 1));
            for [x, y] in [[-2.5, y0], [2.5, y0], [2.5, y1], [-2.5, y1]] {
                mesh.positions.push([x, y, 0.0].map(|x| ((x + center) * unit) as f32));
            }
            mesh.triangles.extend([[4 * k, 4 * k + 1, 4 * k + 2], [4 * k, 4 * k + 2, 4 * k + 3]]);
        }
        let kind = LightKind::Directional { direction: [0.48, -0.6, -0.64], angular_diameter_rad: 0.0 };
        let scene = Scene {
            meshes: vec![mesh],
            instances: vec![Instance { name: String::new(), mesh: 0, transform }],
            materials: vec![Material::default()],
            lights: vec![Light { name: String::new(), intensity: [1.0; 3], kind }],
            ..Scene::default()
        };
        let Some([_, instanced]) = both(&scene) else { return };
        assert!(instanced.geometry.is_instanced(), "{what}");
        let request = Request::new(rig()).integrator(Integrator::Direct);
        let color = instanced.render(&request, &()).expect("a render").color.expect("lit");
        let dark = color.samples().iter().filter(|x| **x == 0.0).count();
        assert_eq!(dark, 0, "{what}: of {}", color.samples().len());
    }
}

/// A camera that is moved sees what a camera sees that stands there, but for rounding at edges; and nothing else than color.
#[test]
fn moved_cameras_see_the_same() {
    let scene = scene();
    let world = World::new(&scene, Backend::Auto, NonZeroUsize::new(2)).expect("a world");
    let start = Transform::from_translation([0.5, 0.25, 1.0]);
    let still = world.at(&start).expect("a renderer");
    // Without what depends on the frame of random directions: the sun, and the wall that the camera sees.
    let request = Request::new(rig()).integrator(Integrator::Direct).samples(1).layers(LayerSet::EMPTY);
    for (place, turn) in [([0.0; 3], 0.0_f64), ([0.3, -0.2, 0.5], 0.4), ([-4.0, 1.0, -3.0], -1.2)] {
        let (sine, cosine) = turn.sin_cos();
        let columns = [[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]];
        let pose = Transform { columns, translation: place };
        let from_start = Transform { columns, translation: std::array::from_fn(|k| place[k] - start.translation[k]) };
        let color = |renderer: Renderer| renderer.render(&request, &()).expect("an image").color.expect("color");
        let there = color(world.at(&pose).expect("a renderer"));
        let moved = color(still.moved(&from_start).expect("a renderer"));
        let (there, moved) = (there.samples(), moved.samples());
        let differ = there.iter().zip(moved).filter(|(a, b)| (*a - *b).abs() > 1e-3 * (1.0 + a.abs())).count();
        assert!(differ * 100 < there.len(), "{turn}: {differ} of {} values differ", there.len());
        assert!(there.iter().any(|value| *value > 0.0));
    }
    let moved = still.moved(&Transform::IDENTITY).expect("a renderer");
    assert!(moved.render(&request.clone().layers([crate::film::layers::Layer::Depth].into()), &()).is_err());
    assert!(moved.render(&request.clone().denoise(Denoise::Views), &()).is_err());
    let skewed = Transform { columns: [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };
    assert!(still.moved(&skewed).is_err());
}
