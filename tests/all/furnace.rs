//! The white furnace test: under uniform environment light, a body that neither absorbs nor emits is invisible.
//!
//! Whole renders: a body of flat triangles under a sky of 1 has radiance 1 in every pixel. With smooth shading it has
//! not, because an interpolated normal scatters some light below the triangle. The tests of `holo-render` integrate the
//! BSDFs alone at all roughnesses.

use crate::common;
use crate::common::rig;
use holo_core::Projection;
use holo_render::{Backend, Integrator, Renderer, Request};
use holo_scene::{
    Anisotropy, Clearcoat, DiffuseTransmission, Iridescence, Material, Mesh, Scene, Sheen, Transform, Volume,
};

/// A sphere of 20 * 4^3 flat triangles around the origin.
fn sphere(radius: f32) -> Mesh {
    let t = (1.0 + 5f64.sqrt()) / 2.0;
    let mut positions: Vec<[f64; 3]> = Vec::new();
    for (a, b) in [(-1.0, t), (1.0, t), (-1.0, -t), (1.0, -t)] {
        positions.extend([[a, b, 0.0], [0.0, a, b], [b, 0.0, a]]);
    }
    // The faces of the icosahedron: all triples of neighbors, turned outward.
    let distance = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>();
    let mut triangles: Vec<[usize; 3]> = Vec::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                let near = |p: usize, q: usize| distance(positions[p], positions[q]) < 4.1;
                if near(a, b) && near(b, c) && near(a, c) {
                    triangles.push([a, b, c]);
                }
            }
        }
    }
    for _ in 0..3 {
        let mut finer = Vec::new();
        for &[a, b, c] in &triangles {
            let mut middle = |p: usize, q: usize| {
                let m: [f64; 3] = std::array::from_fn(|k| positions[p][k] + positions[q][k]);
                positions.push(m);
                positions.len() - 1
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            for p in positions.iter_mut() {
                let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
                *p = p.map(|x| x / length);
            }
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    let outward = |[a, b, c]: [usize; 3]| {
        let [p, q, r] = [positions[a], positions[b], positions[c]];
        let (u, v): ([f64; 3], [f64; 3]) = (std::array::from_fn(|k| q[k] - p[k]), std::array::from_fn(|k| r[k] - p[k]));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let out: f64 = (0..3).map(|k| normal[k] * p[k]).sum();
        if out > 0.0 { [a, b, c] } else { [a, c, b] }
    };
    Mesh {
        triangles: triangles.into_iter().map(|t| outward(t).map(|k| k as u32)).collect(),
        positions: positions.into_iter().map(|p| p.map(|x| x as f32 * radius)).collect(),
        ..Mesh::default()
    }
}

/// The mean and the extremes of the radiance of `material` under a sky of 1, over 3 x 3 views.
fn furnace(material: Material, samples: u32, bounces: u32, seed: u64) -> (f64, f32, f32) {
    let mut scene = Scene::default();
    common::add(&mut scene, sphere(0.6), [1.0; 4], Transform::from_translation([0.0, 0.0, -2.0]));
    scene.materials[0] = material;
    let renderer = Renderer::new(&scene, &Transform::IDENTITY, Backend::Auto, None).expect("a scene");
    let request = Request::new(rig([3, 3], [12, 18], 0.05, 2.0, Projection::Perspective))
        .integrator(Integrator::Path)
        .samples(samples)
        .sky([1.0; 3])
        .max_bounces(bounces)
        .seed(seed)
        .roulette(false);
    let color = renderer.render(&request, &()).expect("a render").color.expect("an image");
    let values = color.samples();
    let mean = values.iter().map(|&x| f64::from(x)).sum::<f64>() / values.len() as f64;
    let low = values.iter().copied().fold(f32::INFINITY, f32::min);
    (mean, low, values.iter().copied().fold(0.0, f32::max))
}

/// Every path reaches the sky with throughput 1, so there is no noise. Of five million paths one is lost, whatever the
/// sampling: it starts within rounding of an edge, on the inner side of the neighboring triangle. The seed has none of those.
#[test]
fn lambert_and_mirror_are_invisible() {
    let mirror = Material { metallic: 1.0, roughness: 0.0, ..Material::default() };
    for material in [Material::default(), mirror] {
        let (mean, low, high) = furnace(material.clone(), 16, 4, 1);
        assert!((mean - 1.0).abs() < 1e-5 && low > 0.9999 && high < 1.0001, "{mean} {low} {high} {material:?}");
    }
}

/// Radiance increases by n^2 on entry and decreases by as much on exit. The missing energy is that of paths still
/// inside: 0.4 % after 64 bounces in a body of flat faces.
#[test]
fn smooth_glass_is_invisible() {
    let clear = Some(Volume { attenuation_distance_m: f32::INFINITY, attenuation_color: [1.0; 3] });
    for (volume, ior) in [(clear, 1.5), (clear, 2.4), (clear, 1.0), (None, 1.5)] {
        let glass = Material { roughness: 0.0, specular: 1.0, transmission: 1.0, ior, volume, ..Material::default() };
        let (mean, _, high) = furnace(glass, 64, 1000, 0);
        assert!((mean - 1.0).abs() < 1e-3 && high < 1.5, "ior {ior} {volume:?}: {mean} {high}");
    }
}

/// Rough metal, coats, panes and their mixtures lose and gain nothing, to 0.5 % (the interpolation of the table and the
/// noise); bodies of rough glass lose what is scattered more than once between microfacets (see the table in `bsdf.rs`).
#[test]
fn rough_materials_keep_their_energy() {
    let clear = Some(Volume { attenuation_distance_m: f32::INFINITY, attenuation_color: [1.0; 3] });
    for roughness in [0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0] {
        let rough = Material { roughness, specular: 1.0, ..Material::default() };
        for (material, most_lost) in [
            (rough.clone(), 0.005),
            (Material { metallic: 1.0, ..rough.clone() }, 0.005),
            (Material { metallic: 0.5, ..rough.clone() }, 0.005),
            (Material { transmission: 1.0, ..rough.clone() }, 0.005),
            (Material { transmission: 0.5, metallic: 0.3, ..rough.clone() }, 0.005),
            (Material { transmission: 1.0, volume: clear, ..rough.clone() }, 0.85),
        ] {
            let (mean, ..) = furnace(material.clone(), 64, 64, 0);
            println!("roughness {roughness}, metal {}, glass {}: {mean:.4}", material.metallic, material.transmission);
            assert!(mean < 1.005 && mean > 1.0 - most_lost, "{mean} {material:?}");
        }
    }
}

/// Bodies of smooth glass with dispersion split paths by channel without a loss.
#[test]
fn dispersive_glass_is_invisible() {
    let volume = Some(Volume { attenuation_distance_m: f32::INFINITY, attenuation_color: [1.0; 3] });
    let glass = Material { roughness: 0.0, specular: 1.0, transmission: 1.0, volume, ..Material::default() };
    let (mean, ..) = furnace(Material { dispersion: 2.0, ..glass }, 256, 1000, 0);
    assert!((mean - 1.0).abs() < 2e-3, "{mean}");
}

/// Layers over white surfaces gain nothing, and lose what `bsdf/layered.rs` says.
#[test]
fn layered_materials_gain_nothing() {
    let white = Material { roughness: 0.4, specular: 1.0, ..Material::default() };
    let coat = |roughness| Some(Clearcoat { factor: 1.0, roughness, ..Clearcoat::default() });
    let sheen = Some(Sheen { color: [1.0; 3], roughness: 0.5, ..Sheen::default() });
    let film = Some(Iridescence { factor: 1.0, ..Iridescence::default() });
    let through = |factor| Some(DiffuseTransmission { factor, ..DiffuseTransmission::default() });
    let volume = Some(Volume { attenuation_distance_m: f32::INFINITY, attenuation_color: [1.0; 3] });
    let uneven = Some(Anisotropy { strength: 0.8, ..Anisotropy::default() });
    for (name, material, most_lost) in [
        ("clearcoat", Material { clearcoat: coat(0.0), ..white.clone() }, 0.01),
        ("rough clearcoat on metal", Material { clearcoat: coat(0.5), metallic: 1.0, ..white.clone() }, 0.01),
        ("sheen", Material { sheen, ..white.clone() }, 0.14),
        ("film", Material { iridescence: film, ..white.clone() }, 0.09),
        ("film on metal", Material { iridescence: film, metallic: 1.0, ..white.clone() }, 0.01),
        ("anisotropy without a tangent", Material { anisotropy: uneven, metallic: 1.0, ..white.clone() }, 0.01),
        ("diffuse transmission", Material { diffuse_transmission: through(0.5), ..white.clone() }, 0.01),
        ("through a body", Material { diffuse_transmission: through(0.5), volume, ..white.clone() }, 0.01),
    ] {
        let (mean, ..) = furnace(material, 64, 200, 0);
        println!("{name}: {mean:.4}");
        assert!(mean < 1.005 && mean > 1.0 - most_lost, "{name}: {mean}");
    }
}
