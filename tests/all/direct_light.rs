//! The integrator `direct` against closed forms and against a reference implementation in f64.

use crate::common::{Random, add, cross, dot, engines, everything, render, rig, soup, square, sub};
use holo_core::Projection;
use holo_render::Backend;
use holo_scene::{Light, LightKind, Scene, Transform};

fn light(intensity: [f64; 3], kind: LightKind) -> Light {
    Light { name: String::new(), intensity, kind }
}

fn wall(albedo: f32) -> Scene {
    let mut scene = Scene::default();
    add(&mut scene, square(50.0), [albedo, albedo, albedo, 1.0], Transform::from_translation([0.0, 0.0, -2.0]));
    scene
}

/// An irradiance of 1 lux on white gives the radiance 1/pi, times cosine and albedo. f32 arithmetic: a few 1e-7.
#[test]
fn a_directional_light_obeys_lambert() {
    for (albedo, degrees) in [(1.0, 0.0f64), (0.5, 60.0), (0.25, 89.0)] {
        let mut scene = wall(albedo);
        let angle = degrees.to_radians();
        let direction = [angle.sin(), 0.0, -angle.cos()];
        scene.lights.push(light([1.0, 2.0, 4.0], LightKind::Directional { direction, angular_diameter_rad: 0.0 }));
        let rendered = render(
            &scene,
            &everything(rig([2, 2], [3, 3], 0.01, 2.0, Projection::Perspective), 1, [0.0; 3]),
            Backend::Bvh,
            1,
        );
        for (k, &x) in rendered.color.expect("lit").samples().iter().enumerate() {
            let expected = f64::from(albedo) / std::f64::consts::PI * angle.cos() * [1.0, 2.0, 4.0][k % 3];
            assert!((f64::from(x) - expected).abs() < 1e-6 * expected, "{x} {expected}");
        }
    }
}

/// Under an unoccluded sky a white wall has exactly the radiance of the sky, for every sample.
#[test]
fn an_open_sky_lights_white_to_its_own_radiance() {
    for backend in engines() {
        let request = everything(rig([4, 4], [5, 5], 0.01, 2.0, Projection::Perspective), 2, [0.3, 0.5, 0.7]);
        let color = render(&wall(1.0), &request, backend, 1).color.expect("lit");
        for (k, &x) in color.samples().iter().enumerate() {
            assert!((x - [0.3, 0.5, 0.7][k % 3]).abs() < 1e-6, "{backend:?} {x}");
        }
    }
}

/// A wide wall at a right angle occludes half of the sky at its base. With Owen-scrambled samples the error of the mean
/// over 16 x 25 pixels of 64 samples is far below 1 %.
#[test]
fn a_wall_hides_half_of_the_sky() {
    let mut scene = wall(1.0);
    // The plane x = 0.02, from the wall to far behind the camera.
    let edge =
        Transform { columns: [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]], translation: [0.12, 0.0, 45.0] };
    add(&mut scene, square(50.0), [0.0, 0.0, 0.0, 1.0], edge);
    // A long lens: it sees only the base of the wall, 2 to 10 cm from it.
    let rig = rig([4, 4], [5, 5], 1e-4, 2.0, Projection::Perspective).to_builder().focal_length_m(2.0).build();
    let request = everything(rig.expect("a rig"), 64, [1.0; 3]);
    let color = render(&scene, &request, Backend::Bvh, 2).color.expect("lit");
    let samples = color.samples();
    let lit: Vec<f64> = samples.iter().map(|&x| f64::from(x)).collect();
    let mean = lit.iter().sum::<f64>() / lit.len() as f64;
    assert!((mean - 0.5).abs() < 0.005, "{mean}");
}

/// The reference implementation: every ray against all triangles in f64.
struct Reference<'a> {
    scene: &'a Scene,
    triangles: Vec<([[f64; 3]; 3], usize)>,
}

impl<'a> Reference<'a> {
    fn new(scene: &'a Scene) -> Self {
        let mut triangles = Vec::new();
        for instance in &scene.instances {
            let mesh = &scene.meshes[instance.mesh];
            for t in &mesh.triangles {
                let corners = t.map(|k| instance.transform.point(mesh.positions[k as usize].map(f64::from)));
                triangles.push((corners, mesh.material));
            }
        }
        Self { scene, triangles }
    }

    fn nearest(&self, origin: [f64; 3], direction: [f64; 3], near: f64) -> Option<(f64, usize)> {
        let mut best: Option<(f64, usize)> = None;
        for (k, ([a, b, c], _)) in self.triangles.iter().enumerate() {
            let (e1, e2) = (sub(*b, *a), sub(*c, *a));
            let p = cross(direction, e2);
            let determinant = dot(e1, p);
            let s = sub(origin, *a);
            let q = cross(s, e1);
            let (u, v, t) = (dot(s, p) / determinant, dot(direction, q) / determinant, dot(e2, q) / determinant);
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > near && best.is_none_or(|(z, _)| t < z) {
                best = Some((t, k));
            }
        }
        best
    }

    fn radiance(&self, origin: [f64; 3], direction: [f64; 3]) -> [f64; 3] {
        let Some((t, k)) = self.nearest(origin, direction, 0.0) else { return [0.0; 3] };
        let (corners, material) = &self.triangles[k];
        let point: [f64; 3] = std::array::from_fn(|i| origin[i] + t * direction[i]);
        let mut normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
        let length = dot(normal, normal).sqrt();
        let side = if dot(normal, direction) > 0.0 { -1.0 } else { 1.0 };
        normal = normal.map(|x| x * side / length);
        let albedo = self.scene.materials[*material].base_color;
        let mut sum = [0.0; 3];
        for light in &self.scene.lights {
            let (to_light, distance, strength) = match light.kind {
                LightKind::Directional { direction, .. } => (direction.map(|x| -x), f64::INFINITY, 1.0),
                LightKind::Point { position, .. } => {
                    let way = sub(position, point);
                    let r = dot(way, way).sqrt();
                    (way.map(|x| x / r), r, 1.0 / (r * r))
                }
                LightKind::Spot { .. } => unreachable!("not used here"),
            };
            let cosine = dot(normal, to_light);
            let hidden = self.nearest(point, to_light, 1e-6).is_some_and(|(t, _)| t < distance);
            if cosine > 0.0 && !hidden {
                for c in 0..3 {
                    sum[c] += f64::from(albedo[c]) / std::f64::consts::PI * light.intensity[c] * strength * cosine;
                }
            }
        }
        sum
    }
}

/// Random triangles under a directional and a point light agree with the reference implementation in every pixel of
/// every view. Its shadow rays have other origins by rounding, so pixels at shadow edges may differ: at most two in a
/// thousand.
#[test]
fn the_renderer_agrees_with_the_reference_implementation() {
    let mut random = Random(12);
    let mut scene = soup(160, 21);
    let direction = [0.0, -0.6, -0.8];
    scene.lights.push(light([2.0, 1.5, 1.0], LightKind::Directional { direction, angular_diameter_rad: 0.0 }));
    let position = [random.between(-1.0, 1.0), random.between(0.5, 1.0), -1.0];
    scene.lights.push(light([0.5, 1.0, 1.5], LightKind::Point { position, range: None }));
    let naive = Reference::new(&scene);
    for projection in [Projection::Perspective, Projection::Orthographic] {
        let rig = rig([4, 5], [14, 18], 0.02, 3.5, projection);
        for backend in engines() {
            let color = render(&scene, &everything(rig, 1, [0.0; 3]), backend, 2).color.expect("lit");
            let (mut differ, mut lit, mut all) = (0, 0, 0);
            for v in 0..14 {
                for u in 0..18 {
                    for (t, s) in [(0, 0), (3, 4), (1, 2), (2, 0)] {
                        let ray = rig.ray(v, u, t, s, 0.5, 0.5);
                        let expected = naive.radiance(ray.origin_m, ray.direction);
                        let found = color.samples().slice(ndarray::s![v, u, t, s, ..]).to_vec();
                        all += 1;
                        lit += usize::from(expected[0] > 0.0);
                        // f32 shading, computed where secondary rays start, some 1e-6 of the distance off the
                        // surface: under grazing light that is a few 1e-5 of the value.
                        differ += usize::from(
                            (0..3).any(|c| (f64::from(found[c]) - expected[c]).abs() > 1e-4 * (expected[c] + 1e-3)),
                        );
                    }
                }
            }
            assert!(lit > all / 10, "the test must look at lit pixels: {lit} of {all}");
            assert!(differ * 500 <= all, "{backend:?} {projection:?}: {differ} of {all} pixels differ");
        }
    }
}
