//! Every layer (AOV) against a reference implementation in f64 without packets, ray tracing backends or camera
//! coordinates.

use std::num::NonZeroUsize;

use crate::common::{Random, cross, dot, engines, render_from, rig, square, sub};
use holo_core::{LightFieldOwned, Projection, Rig};
use holo_render::{Backend, GroundTruth, Integrator, Layer, LayerSet, Layers, Renderer, Request};
use holo_scene::{Instance, Material, Mesh, Scene, Texture, TextureInfo, TextureTransform, Transform, Wrap};

/// The layers of one ray by the reference implementation.
struct Found {
    distance: f64,
    layers: Layers<[f64; 3]>,
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    a.map(|x| x / dot(a, a).sqrt())
}

/// Normals transform by the inverse transpose: (c1 x c2, c2 x c0, c0 x c1) / det with the columns c of the map.
fn world_normal(transform: &Transform, n: [f32; 3]) -> [f64; 3] {
    let [a, b, c] = transform.columns;
    let cofactors = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = dot(a, cross(b, c));
    unit([0, 1, 2].map(|k| (0..3).map(|j| cofactors[j][k] * f64::from(n[j])).sum::<f64>() / determinant))
}

/// Bilinear, in linear light, by the formulas in the documentation of the scene.
fn texel(scene: &Scene, used: TextureInfo, [u, v]: [f64; 2]) -> [f64; 3] {
    let TextureTransform { offset, rotation_rad, scale } = used.transform;
    let (sin, cos) = f64::from(rotation_rad).sin_cos();
    let (w, h) = (f64::from(scale[0]), f64::from(scale[1]));
    let x = w * u * cos + h * v * sin + f64::from(offset[0]);
    let y = h * v * cos - w * u * sin + f64::from(offset[1]);
    let texture = &scene.textures[used.texture];
    let (x, y) = (x * texture.width as f64 - 0.5, y * texture.height as f64 - 0.5);
    let mut sum = [0.0; 3];
    for (column, row, weight) in [
        (x.floor(), y.floor(), (1.0 - x + x.floor()) * (1.0 - y + y.floor())),
        (x.floor() + 1.0, y.floor(), (x - x.floor()) * (1.0 - y + y.floor())),
        (x.floor(), y.floor() + 1.0, (1.0 - x + x.floor()) * (y - y.floor())),
        (x.floor() + 1.0, y.floor() + 1.0, (x - x.floor()) * (y - y.floor())),
    ] {
        // The texture repeats horizontally and is clamped vertically.
        let column = column.rem_euclid(texture.width as f64) as usize;
        let row = row.clamp(0.0, texture.height as f64 - 1.0) as usize;
        for c in 0..3 {
            let code = f64::from(texture.texels[row * texture.width + column][c]) / 255.0;
            let linear = if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) };
            sum[c] += weight * linear;
        }
    }
    sum
}

/// Every triangle of the scene against a ray in camera coordinates.
fn look(scene: &Scene, pose: &Transform, rig: &Rig, [v, u, t, s]: [usize; 4]) -> Found {
    let ray = rig.ray(v, u, t, s, 0.5, 0.5);
    let (origin, direction) = (pose.point(ray.origin_m), pose.vector(ray.direction));
    let one = |x: f64| [x, 0.0, 0.0];
    let mut found = Found { distance: f64::INFINITY, layers: Layers::default() };
    let missed = [Layer::Depth, Layer::RayLength].map(|layer| (layer, one(f64::INFINITY)));
    found.layers.extend(LayerSet::ALL.iter().map(|layer| (layer, [0.0; 3])).chain(missed));
    found.layers.insert(Layer::Disparity, one(rig.disparity().at_infinity_px()));
    for (number, instance) in scene.instances.iter().enumerate() {
        let (mesh, transform) = (&scene.meshes[instance.mesh], &instance.transform);
        for triangle in &mesh.triangles {
            let corner = triangle.map(|k| transform.point(mesh.positions[k as usize].map(f64::from)));
            let (ab, ac) = (sub(corner[1], corner[0]), sub(corner[2], corner[0]));
            let normal = cross(ab, ac);
            let away = dot(normal, direction);
            let distance = dot(normal, sub(corner[0], origin)) / away;
            let point = [0, 1, 2].map(|k| origin[k] + distance * direction[k]);
            let from_a = sub(point, corner[0]);
            let share = |a, b| dot(cross(a, b), normal) / dot(normal, normal);
            let (second, third) = (share(from_a, ac), share(ab, from_a));
            let weights = [1.0 - second - third, second, third];
            if !(distance > 0.0 && distance < found.distance && weights.iter().all(|w| *w >= 0.0)) {
                continue;
            }
            found.distance = distance;
            // The back face: the corners are clockwise in the coordinates of the mesh.
            let mirrored = dot(transform.columns[0], cross(transform.columns[1], transform.columns[2])) < 0.0;
            let behind = if (away > 0.0) != mirrored { -1.0 } else { 1.0 };
            let towards_viewer = unit(normal.map(|n| -n * away.signum()));
            let mut shading = towards_viewer;
            if !mesh.normals.is_empty() {
                let corners = triangle.map(|k| world_normal(transform, mesh.normals[k as usize]));
                shading = unit([0, 1, 2].map(|k| behind * (0..3).map(|j| corners[j][k] * weights[j]).sum::<f64>()));
            }
            let material = &scene.materials[mesh.material];
            let mut albedo = [0, 1, 2].map(|c| f64::from(material.base_color[c]));
            if let Some(used) = material.base_color_texture {
                let at = triangle.map(|k| mesh.texture_coordinates[k as usize].map(f64::from));
                let at = [0, 1].map(|k| (0..3).map(|j| at[j][k] * weights[j]).sum::<f64>());
                let color = texel(scene, used, at);
                (0..3).for_each(|c| albedo[c] *= color[c]);
            }
            if !mesh.colors.is_empty() {
                for c in 0..3 {
                    let corner = |j: usize| f64::from(mesh.colors[triangle[j] as usize][c]);
                    albedo[c] *= (0..3).map(|j| corner(j) * weights[j]).sum::<f64>();
                }
            }
            found.layers = [
                (Layer::Depth, one(distance)),
                (Layer::RayLength, one(dot(sub(point, origin), sub(point, origin)).sqrt())),
                (Layer::Disparity, one(rig.disparity().from_depth_m(distance))),
                (Layer::GeometricNormal, towards_viewer),
                (Layer::ShadingNormal, shading),
                (Layer::Albedo, albedo),
                (Layer::ObjectId, one(number as f64 + 1.0)),
                (Layer::MaterialId, one(mesh.material as f64 + 1.0)),
                (Layer::HitMask, one(1.0)),
                // The materials of the scene differ in this alone.
                (Layer::Reflective, one(2.0 * f64::from(material.transmission))),
            ]
            .into_iter()
            .collect();
        }
    }
    found
}

/// A ball of radius 1 with smooth normals and a hole at either pole.
fn ball() -> Mesh {
    let (rings, spokes) = (9, 14);
    let mut mesh = Mesh::default();
    for ring in 0..=rings {
        for spoke in 0..spokes {
            let down = (0.15 + 0.7 * f64::from(ring) / f64::from(rings)) * std::f64::consts::PI;
            let around = f64::from(spoke) / f64::from(spokes) * std::f64::consts::TAU;
            let p = [down.sin() * around.sin(), down.cos(), down.sin() * around.cos()].map(|x| x as f32);
            mesh.positions.push(p);
            mesh.normals.push(p);
            if ring < rings {
                let (a, b) = (ring * spokes + spoke, ring * spokes + (spoke + 1) % spokes);
                mesh.triangles.extend([[a, a + spokes, b + spokes], [a, b + spokes, b]].map(|t| t.map(|k| k as u32)));
            }
        }
    }
    mesh
}

/// A textured wall that does not fill the image, a ball, the same ball mirrored and stretched, a square that shows its
/// back face, and a pane of glass in front of some of them. Materials are in another order than instances.
fn scene() -> Scene {
    let mut random = Random(12);
    let mut scene = Scene::default();
    let texels = (0..35).map(|_| [0; 3].map(|_| (random.unit() * 256.0) as u8)).map(|[r, g, b]| [r, g, b, 255]);
    scene.textures.push(Texture {
        name: String::new(),
        width: 7,
        height: 5,
        texels: texels.collect(),
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Clamp,
        filter: holo_scene::Filter::Linear,
    });
    let transform = TextureTransform { offset: [0.1, -0.2], rotation_rad: 0.4, scale: [1.7, 0.8] };
    let base_color_texture = Some(TextureInfo { transform, ..TextureInfo::new(0) });
    let glass = Material { transmission: 1.0, base_color: [0.9, 0.95, 1.0, 1.0], ..Material::default() };
    let painted = |base_color| Material { base_color, ..Material::default() };
    scene.materials = vec![
        glass,
        painted([0.8, 0.3, 0.2, 1.0]),
        Material { base_color_texture, ..painted([0.9, 0.8, 0.7, 1.0]) },
        painted([1.0; 4]),
    ];
    let colors = vec![[1.0, 0.1, 0.2, 1.0], [0.3, 0.9, 0.1, 1.0], [0.0, 0.2, 1.0, 1.0], [0.6, 0.6, 0.0, 1.0]];
    let texture_coordinates = vec![[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    scene.meshes = vec![
        Mesh { material: 2, texture_coordinates, ..square(1.0) },
        Mesh { material: 1, ..ball() },
        Mesh { material: 3, colors, ..square(1.0) },
        Mesh { material: 0, ..square(1.0) },
    ];
    let mut place = |mesh, translation, rotation, scale| {
        let transform = Transform::from_parts(translation, rotation, scale);
        scene.instances.push(Instance { name: String::new(), mesh, transform });
    };
    place(0, [0.2, 0.0, -4.0], [0.1, 0.2, 0.0, 1.0], [1.1, 0.8, 1.0]);
    place(1, [-0.5, 0.1, -3.2], [0.3, 0.1, 0.2, 1.0], [0.4, 0.4, 0.4]);
    place(1, [0.5, -0.1, -3.0], [0.0, 0.3, 0.5, 1.0], [-0.3, 0.5, 0.2]);
    place(2, [0.0, 0.5, -2.8], [0.1, 1.0, 0.1, 0.2], [0.25, 0.2, 1.0]);
    place(3, [0.1, -0.1, -2.3], [0.0, 0.1, 0.0, 1.0], [0.3, 0.25, 1.0]);
    scene
}

fn moved(scene: &Scene) -> (Scene, Transform) {
    // Translated and rotated: world and camera coordinates differ.
    let pose = Transform::from_parts([3.0, -2.0, 5.0], [0.3, -0.5, 0.2, 0.7], [1.0; 3]);
    let mut scene = scene.clone();
    scene.instances.iter_mut().for_each(|instance| instance.transform = pose.after(&instance.transform));
    (scene, pose)
}

fn request(rig: Rig) -> Request {
    let ground_truth = GroundTruth::All;
    Request::new(rig).integrator(Integrator::Depth).layers(LayerSet::ALL).ground_truth(ground_truth)
}

/// The tolerance of a layer. Results in f64 are rounded to f32 once: 2^-24 = 6.0e-8, relative or of a unit vector.
/// Shading normal and albedo use the f32 barycentrics of the backend, which are off by about 1e-6, on a stretched ball
/// whose corners are 0.45 rad apart and on a texture that changes by 1 over a seventh of the wall.
fn tolerance(layer: Layer, exact: f64, rig: &Rig) -> f64 {
    match layer {
        Layer::Depth | Layer::RayLength => 6.0e-8 * exact,
        // Relative to the scale of disparities, because they pass through 0.
        Layer::Disparity => 1e-7 * (rig.disparity().scale_m_px() / rig.focus_distance_m()).max(exact.abs()),
        Layer::GeometricNormal => 6.0e-8,
        Layer::ShadingNormal => 8e-6,
        Layer::Albedo => 4e-6,
        Layer::ObjectId | Layer::MaterialId | Layer::HitMask | Layer::Reflective => 0.0,
    }
}

/// All layers of all pixels of all views. At most one pixel in a thousand may hit another triangle: backends in
/// f32 classify rays within rounding of an edge differently, and a ball has many edges.
#[test]
fn layers_agree_with_the_reference_implementation() {
    let (scene, pose) = moved(&scene());
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let rig = rig([3, 4], [17, 26], 0.06, 3.0, projection);
        let mut backends = engines();
        backends.push(Backend::BruteForce);
        for backend in backends {
            let all = render_from(&scene, &pose, &request(rig), backend, 2).all.expect("requested");
            assert_eq!(all.set(), LayerSet::ALL);
            let mut differ = 0;
            let mut seen = [0; 6];
            for (v, u, t, s) in ndarray::indices((17, 26, 3, 4)) {
                let exact = look(&scene, &pose, &rig, [v, u, t, s]);
                let found = |layer: Layer, c: usize| f64::from(all[layer].samples()[[v, u, t, s, c]]);
                let (z, object) = (exact.distance, exact.layers[Layer::ObjectId][0]);
                let depth = found(Layer::Depth, 0);
                if found(Layer::ObjectId, 0) != object || (depth != z && ((depth - z) / z).abs() > 1e-6) {
                    differ += 1;
                    continue;
                }
                seen[object as usize] += 1;
                for (layer, exact) in exact.layers.iter() {
                    for c in 0..layer.channels() {
                        let (found, exact) = (found(layer, c), exact[c]);
                        let close = found == exact || (found - exact).abs() <= tolerance(layer, exact, &rig);
                        assert!(close, "{backend:?} {projection:?} {layer}.{c} of {v} {u} {t} {s}: {found} {exact}");
                    }
                }
            }
            assert!(differ * 1000 <= 17 * 26 * 12, "{backend:?} {projection:?}: {differ}");
            // No instance (0), and every instance, the pane of glass included.
            assert!(seen.iter().all(|&n| n > 100), "{seen:?}");
        }
    }
}

/// The bits of the layers do not depend on the number of samples or the integrator, also for the central view alone.
#[test]
fn layers_do_not_depend_on_what_is_rendered_with_them() {
    let (scene, pose) = moved(&scene());
    let rig = rig([4, 5], [14, 19], 0.03, 3.0, Projection::Perspective);
    let alone = render_from(&scene, &pose, &request(rig), Backend::Bvh, 1);
    let (t, s) = rig.shape().central_view();
    let central = |all: &Layers<LightFieldOwned<f32>>| -> Layers<_> {
        all.iter().map(|(layer, field)| (layer, field.view(t, s).expect("a view").to_owned())).collect()
    };
    assert_eq!(alone.central, central(alone.all.as_ref().expect("requested")));
    for samples in [1, 3] {
        let request = request(rig).integrator(Integrator::Path).samples(samples).sky([1.0; 3]);
        let with_color = render_from(&scene, &pose, &request, Backend::Bvh, 2);
        assert_eq!(with_color.all, alone.all, "{samples}");
        assert!(with_color.color.is_some());
        let central = request.ground_truth(GroundTruth::Central);
        let rendered = render_from(&scene, &pose, &central, Backend::Bvh, 1);
        assert_eq!((rendered.central, rendered.all), (alone.central.clone(), None), "{samples}");
    }
}

/// Any subset of the layers: the requested ones, equal to those of all layers, and no others.
#[test]
fn any_subset_of_the_layers_can_be_requested() {
    let (scene, pose) = moved(&scene());
    let rig = rig([2, 2], [9, 12], 0.03, 3.0, Projection::Perspective);
    let all = render_from(&scene, &pose, &request(rig), Backend::Bvh, 1).all.expect("requested");
    let [first, second] = [[Layer::Albedo, Layer::HitMask], [Layer::Depth, Layer::GeometricNormal]].map(LayerSet::from);
    let single = Layer::ALL.map(|layer| LayerSet::from([layer]));
    for layers in single.into_iter().chain([first, second, first.union(second)]) {
        let rendered = render_from(&scene, &pose, &request(rig).layers(layers), Backend::Bvh, 1);
        let some = rendered.all.expect("requested");
        assert_eq!((some.set(), rendered.central.set()), (layers, layers));
        assert!(some.iter().all(|(layer, field)| *field == all[layer]), "{layers:?}");
    }
    let nothing = request(rig).layers(LayerSet::EMPTY);
    let rendered = render_from(&scene, &pose, &nothing, Backend::Bvh, 1);
    assert_eq!((rendered.central, rendered.all, rendered.rays.total()), (Layers::default(), None, 0));
    let renderer = Renderer::new(&scene, &pose, Backend::Bvh, NonZeroUsize::new(1)).expect("a renderer");
    let central = renderer.central_layers(&rig, first).expect("layers");
    assert_eq!(central.set(), first);
}
