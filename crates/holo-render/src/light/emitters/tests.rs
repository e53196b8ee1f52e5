//! Emissive triangles, compared with closed forms and with the definition of the pdf.

use super::*;
use crate::sampling::{Purpose, points, sequences};
use crate::simd::{Kernel, run_on_all};
use holo_scene::{Instance, Mesh, Scene, TextureInfo, Transform, Wrap};

fn emissive(emission: [f32; 3], double_sided: bool) -> Material {
    Material { emission, double_sided, ..Material::default() }
}

/// Corners and triangles.
type Shape = (Vec<[f32; 3]>, Vec<[u32; 3]>);

/// One instance per mesh, one mesh per material.
fn geometry(meshes: Vec<Shape>) -> Geometry {
    let count = meshes.len();
    let scene = Scene {
        meshes: meshes
            .into_iter()
            .enumerate()
            .map(|(material, (positions, triangles))| Mesh { positions, triangles, material, ..Mesh::default() })
            .collect(),
        instances: (0..count)
            .map(|mesh| Instance { name: String::new(), mesh, transform: Transform::IDENTITY })
            .collect(),
        materials: vec![Material::default(); count],
        ..Scene::default()
    };
    Geometry::build(&scene, &Transform::IDENTITY, crate::geometry::Instancing::Never).expect("a small scene")
}

/// The rectangle [-1, 2] x [-1, 1] at the height `z`; its front faces up (+z), or down.
fn rectangle(z: f32, up: bool) -> Shape {
    let corners = vec![[-1.0, -1.0, z], [2.0, -1.0, z], [2.0, 1.0, z], [-1.0, 1.0, z]];
    (corners, if up { vec![[0, 1, 2], [0, 2, 3]] } else { vec![[0, 2, 1], [0, 3, 2]] })
}

/// Independent random numbers for `16 * sets` samples.
fn independent_numbers(sets: u32) -> impl Iterator<Item = ([f32; LANES], Points)> {
    (0..sets).map(|k| {
        let sequences = sequences(5, &std::array::from_fn(|lane| k * 16 + lane as u32), &[0; LANES]);
        (
            points(&sequences, 0, Purpose::PIXEL)[0],
            points(&sequences, 0, Purpose::at_vertex(0, crate::sampling::Draw::Direction)),
        )
    })
}

/// The mean and standard error of the irradiance, for a radiance of 1, on a surface at `from` that faces +z.
fn irradiance(emitters: &Emitters, from: [f32; 3], sets: u32) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for (choice, point) in independent_numbers(sets) {
        let sample = emitters.sample(&from.map(|x| [x; LANES]), &choice, &point);
        for lane in 0..LANES {
            let w = Vec3::from(at(&sample.to_light, lane)).as_dvec3().normalize();
            let pdf = f64::from(sample.pdf[lane]);
            let value = if pdf > 0.0 { w.z.max(0.0) / pdf } else { 0.0 };
            sum += value;
            squares += value * value;
        }
    }
    let count = f64::from(sets) * LANES as f64;
    (sum / count, ((squares / count - (sum / count).powi(2)) / count).sqrt())
}

/// Lambert's formula: half the sum over the edges of (angle subtended by the edge) times the cosine between +z and the
/// normal of the triangle of the edge and `from`.
fn lambert(corners: &[[f32; 3]], from: [f32; 3]) -> f64 {
    let to = |k: usize| (Vec3::from(corners[k % corners.len()]) - Vec3::from(from)).as_dvec3().normalize();
    (0..corners.len()).map(|k| to(k).angle_between(to(k + 1)) * to(k).cross(to(k + 1)).normalize().z / 2.0).sum()
}

/// Within five standard errors, below 1 %, of Lambert's formula.
#[test]
fn a_rectangle_gives_the_irradiance_of_its_closed_form() {
    for (double_sided, up) in [(false, false), (true, false), (true, true)] {
        let (corners, triangles) = rectangle(1.5, up);
        let geometry = geometry(vec![(corners.clone(), triangles)]);
        let emitters = Emitters::build(&geometry, &[emissive([1.0; 3], double_sided)], &[]).expect("it emits");
        for from in [[0.0, 0.0, 0.0], [0.7, -0.3, 1.0], [4.0, 3.0, -2.0]] {
            let expected = lambert(&corners, from).abs();
            let (mean, error) = irradiance(&emitters, from, 2048);
            assert!(error < 0.01 * expected, "{error} of {expected}");
            assert!((mean - expected).abs() < 5.0 * error, "{from:?}: {mean} +- {error}, {expected}");
        }
    }
}

#[test]
fn a_one_sided_emitter_is_dark_from_behind_and_edge_on() {
    let geometry = geometry(vec![rectangle(1.5, true)]);
    let one = Emitters::build(&geometry, &[emissive([1.0; 3], false)], &[]).expect("it emits");
    let both = Emitters::build(&geometry, &[emissive([1.0; 3], true)], &[]).expect("it emits");
    for (choice, point) in independent_numbers(100) {
        let pdf = |emitters: &Emitters, z: f32| {
            emitters.sample(&[[9.0; LANES], [0.3; LANES], [z; LANES]], &choice, &point).pdf
        };
        assert!(pdf(&one, 2.0).iter().zip(&pdf(&both, 1.0)).all(|(a, b)| *a > 0.0 && *b > 0.0));
        assert_eq!(pdf(&one, 1.0), [0.0; LANES]);
        // From its own plane, and from a point of the triangle.
        assert_eq!((pdf(&one, 1.5), pdf(&both, 1.5)), ([0.0; LANES], [0.0; LANES]));
        let here = both.sample(&[[0.0; LANES]; 3], &choice, &point).to_light;
        assert_eq!(both.sample(&here, &choice, &point).pdf, [0.0; LANES]);
    }
    let pdf = |emitters: &Emitters, cosine: f32| emitters.pdf(&[0; LANES], &[4.0; LANES], &[cosine; LANES])[7];
    assert_eq!(pdf(&one, 0.5), 4.0 / 0.5 / 6.0, "one over the area, at the distance 2");
    assert_eq!(pdf(&one, -0.5), 0.0);
    assert_eq!(pdf(&both, 0.5), pdf(&both, -0.5));
    assert_eq!(pdf(&both, 0.5), 4.0 / 0.5 / 6.0);
    assert_eq!(one.pdf(&[u32::MAX; LANES], &[4.0; LANES], &[0.5; LANES]), [0.0; LANES], "no such instance");
}

/// Two emissive materials, three instances, one of them dark: `sample` returns the pdf of `pdf`, within the rounding of
/// the cosine for triangles seen at less than 89 degrees.
#[test]
fn samples_have_the_pdf_of_the_lookup() {
    let dark = rectangle(-3.0, true);
    let tilted = (vec![[0.0, 0.0, 3.0], [5.0, 1.0, 4.0], [-1.0, 6.0, 7.0]], vec![[0, 1, 2]]);
    let geometry = geometry(vec![rectangle(1.5, false), dark, tilted]);
    let materials = [emissive([1.0, 2.0, 3.0], false), emissive([0.0; 3], true), emissive([0.1, 5.0, 0.0], true)];
    let emitters = Emitters::build(&geometry, &materials, &[]).expect("two emit");
    let from = [0.2, -0.4, -1.0];
    let mut seen = [0; 3];
    for (choice, point) in independent_numbers(1000) {
        let sample = emitters.sample(&from.map(|x| [x; LANES]), &choice, &point);
        for lane in 0..LANES {
            let triangle = sample.triangle[lane] as usize;
            let instance = geometry.instance_index(Hit::flattened(triangle));
            seen[instance as usize] += 1;
            let [a, b, c] = geometry.corners(Hit::flattened(triangle)).map(Vec3::from);
            let (u, v) = (sample.u[lane], sample.v[lane]);
            assert!(u >= 0.0 && v >= 0.0 && u + v <= 1.0);
            let to_light = a * (1.0 - u - v) + b * u + c * v - Vec3::from(from);
            assert!((to_light - Vec3::from(at(&sample.to_light, lane))).length() < 2e-6);
            let cosine = -(b - a).cross(c - a).normalize().dot(to_light.normalize());
            if cosine.abs() > 0.02 {
                let pdf = emitters.pdf(&[instance; LANES], &[to_light.length_squared(); LANES], &[cosine; LANES])[lane];
                assert!((pdf / sample.pdf[lane] - 1.0).abs() < 1e-4, "{pdf} {}", sample.pdf[lane]);
            }
        }
    }
    // In proportion to area times luminance times sides, within five standard deviations of the binomial distribution.
    let luminance = |m: &Material| 0.2126 * m.emission[0] + 0.7152 * m.emission[1] + 0.0722 * m.emission[2];
    let [a, b, c] = geometry.corners(Hit::flattened(4)).map(Vec3::from);
    let weights = [6.0 * luminance(&materials[0]), (b - a).cross(c - a).length() * luminance(&materials[2])];
    let share = f64::from(weights[0] / (weights[0] + weights[1]));
    assert_eq!(seen[1], 0);
    assert!(
        (f64::from(seen[0]) - 16_000.0 * share).abs() < 5.0 * (16_000.0 * share * (1.0 - share)).sqrt(),
        "{seen:?}"
    );
}

/// A million triangles with 1 to 64 times a small area: every one has its share of the steps, and bins of 10,000
/// triangles are selected in proportion (chi squared with 99 degrees of freedom: 99 +- 14; five standard deviations).
#[test]
fn a_million_triangles_are_chosen_in_proportion() {
    let count = 1_000_000u32;
    let side = |k: u32| 1e-3 * (1.0 + ((k.wrapping_mul(2_654_435_761) >> 8) % 8) as f32);
    let mut positions = Vec::with_capacity(3 * count as usize);
    for k in 0..count {
        let (x, y) = ((k % 1000) as f32 * 0.01, (k / 1000) as f32 * 0.01);
        positions.extend([[x, y, 1.0], [x + side(k), y, 1.0], [x, y + side(k), 1.0]]);
    }
    let triangles = (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
    let geometry = geometry(vec![(positions, triangles)]);
    let emitters = Emitters::build(&geometry, &[emissive([2.0; 3], true)], &[]).expect("it emits");
    let areas: Vec<f64> = (0..count as usize)
        .map(|k| {
            let [a, b, c] = geometry.corners(Hit::flattened(k)).map(|p| Vec3::from(p).as_dvec3());
            (b - a).cross(c - a).length() / 2.0
        })
        .collect();
    let total: f64 = areas.iter().sum();
    for (k, area) in areas.iter().enumerate() {
        let end = emitters.starts.get(k + 1).copied().unwrap_or(STEPS);
        let share = (end - emitters.starts[k]) as f64 / STEPS as f64;
        // Two roundings to a step of 2^-40, of shares from 4e-8 on.
        assert!((share / (area / total) - 1.0).abs() < 6e-5, "triangle {k}");
    }
    let mut bins = [0.0; 100];
    let sets = 20_000;
    for (choice, point) in independent_numbers(sets) {
        for triangle in emitters.sample(&[[0.0; LANES]; 3], &choice, &point).triangle {
            bins[triangle as usize / 10_000] += 1.0;
        }
    }
    let chi_squared: f64 = bins
        .iter()
        .zip(areas.chunks(10_000))
        .map(|(count, areas)| {
            let expected = areas.iter().sum::<f64>() / total * f64::from(sets) * LANES as f64;
            (count - expected) * (count - expected) / expected
        })
        .sum();
    assert!(chi_squared < 99.0 + 5.0 * (2.0 * 99.0f64).sqrt(), "{chi_squared}");
}

/// The map to the triangle is uniform: of 2^16 points of a net, each of 64 subtriangles of equal area has 1/64, up to
/// the boxes of the net that its sides cross.
#[test]
fn points_are_uniform_on_the_triangle() {
    let triangle = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let geometry = geometry(vec![(triangle, vec![[0, 1, 2]])]);
    let emitters = Emitters::build(&geometry, &[emissive([1.0; 3], true)], &[]).expect("it emits");
    let mut counts = [[0; 15]; 8];
    let sets = 1 << 16;
    let sequences = sequences(1, &[9; LANES], &[4; LANES]);
    for index in 0..sets {
        let sample = emitters.sample(
            &[[0.0; LANES]; 3],
            &[0.5; LANES],
            &points(&sequences, index, Purpose::at_vertex(0, crate::sampling::Draw::Direction)),
        );
        let (u, v) = (8.0 * sample.u[0], 8.0 * sample.v[0]);
        // Rows along v, each of upright and inverted subtriangles.
        let hanging = usize::from(u.fract() + v.fract() > 1.0);
        counts[v as usize][2 * u as usize + hanging] += 1;
    }
    for (row, counts) in counts.iter().enumerate() {
        for (k, &count) in counts.iter().enumerate() {
            let expected = if k < 15 - 2 * row { f64::from(sets) / 64.0 } else { 0.0 };
            // Rounding may move a point on a side to the neighboring subtriangle.
            assert!((f64::from(count) - expected).abs() < 0.03 * 1024.0, "{row} {k}: {count}");
        }
    }
}

#[test]
fn textures_count_with_their_mean_in_linear_light() {
    let texture = |texels: Vec<[u8; 4]>| Texture {
        name: String::new(),
        width: texels.len(),
        height: 1,
        texels,
        wrap_u: Wrap::Repeat,
        wrap_v: Wrap::Repeat,
        filter: holo_scene::Filter::Linear,
    };
    let textures = [texture(vec![[255, 255, 255, 0], [0, 0, 0, 255]]), texture(vec![[0, 0, 0, 255]])];
    let lit = |k| Material { emission_texture: Some(TextureInfo::new(k)), ..emissive([4.0; 3], false) };
    let geometry = geometry(vec![rectangle(1.0, false), rectangle(2.0, false), rectangle(3.0, false)]);
    let materials = [lit(0), lit(1), emissive([2.0; 3], false)];
    let emitters = Emitters::build(&geometry, &materials, &textures).expect("two emit");
    // Half of 4 is 2: the first and the third are equal, the second is black.
    let pdf: Vec<f32> =
        (0..3).map(|instance| emitters.pdf(&[instance; LANES], &[1.0; LANES], &[1.0; LANES])[0]).collect();
    assert!((pdf[0] * 12.0 - 1.0).abs() < 1e-6 && (pdf[2] * 12.0 - 1.0).abs() < 1e-6 && pdf[1] == 0.0, "{pdf:?}");
}

#[test]
fn surfaces_without_emission_are_no_emitters() {
    let triangle = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [2.0, 0.0, 1.0]];
    let flat = geometry(vec![(triangle, vec![[0, 1, 2]]), rectangle(1.0, true)]);
    let dark = emissive([0.0; 3], true);
    assert!(Emitters::build(&flat, &[emissive([1.0; 3], true), dark.clone()], &[]).is_none(), "no area");
    assert!(Emitters::build(&flat, &[dark.clone(), dark], &[]).is_none(), "no emission");
}

/// The strongest emission on the largest and on a tiny triangle: no infinity, no NaN.
#[test]
fn extremes_stay_finite() {
    for size in [1e17f32, 1e-15] {
        let triangle = vec![[0.0, 0.0, size], [size, 0.0, size], [0.0, size, size]];
        let geometry = geometry(vec![(triangle, vec![[0, 1, 2]])]);
        let emitters = Emitters::build(&geometry, &[emissive([1e30; 3], true)], &[]).expect("it emits");
        for (choice, point) in independent_numbers(10) {
            let sample = emitters.sample(&[[0.1 * size; LANES]; 3], &choice, &point);
            assert!(sample.pdf.iter().all(|pdf| *pdf > 0.0 && pdf.is_finite()), "{size}: {:?}", sample.pdf);
        }
    }
}

struct Everything<'a>(&'a Emitters, [f32; LANES], Points);

impl Kernel for Everything<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run(self) -> Vec<u32> {
        let sample = self.0.sample(&[[0.3; LANES], self.1, [-1.0; LANES]], &self.1, &self.2);
        let pdf = self.0.pdf(&sample.triangle, &sample.u, &sample.v);
        let mut out = sample.triangle.to_vec();
        for field in [[sample.u, sample.v, sample.pdf], sample.to_light, [pdf; 3]] {
            out.extend(field.iter().flatten().map(|x| x.to_bits()));
        }
        out
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let geometry = geometry(vec![rectangle(1.0, false), rectangle(2.0, true), rectangle(3.0, false)]);
    let emitters = Emitters::build(
        &geometry,
        &[emissive([1.0; 3], true), emissive([2.0; 3], false), emissive([0.1; 3], true)],
        &[],
    );
    let emitters = emitters.expect("all emit");
    for (choice, point) in independent_numbers(2000) {
        let results = run_on_all(|| Everything(&emitters, choice, point));
        assert!(results.iter().all(|r| *r == results[0]));
    }
}

/// The guide leads to the same triangle as a search among all, for powers over fourteen orders of magnitude, a single
/// triangle, and numbers at the borders of intervals.
#[test]
fn the_guide_finds_the_triangle_of_every_step() {
    for count in [1usize, 2, 3, 100, 5000] {
        let side = |k: usize| 10f32.powf((k * 37 % 71) as f32 / 10.0 - 3.5);
        let positions =
            (0..count).flat_map(|k| [[0.0, 0.0, 1.0], [side(k), 0.0, 1.0], [0.0, side(k), 1.0]]).collect::<Vec<_>>();
        let triangles = (0..count as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect();
        let geometry = geometry(vec![(positions, triangles)]);
        let emitters = Emitters::build(&geometry, &[emissive([1.0; 3], false)], &[]).expect("it emits");
        let near_starts = emitters.starts.iter().flat_map(|&start| [start, start.saturating_sub(1), start + 1]);
        let near_intervals = (0..emitters.guide.first.len() as u64).map(|k| k << emitters.guide.shift);
        let random = (0..10_000u32).map(|k| u64::from(crate::sampling::hash(k)) << 8 | u64::from(k & 0xFF));
        let steps: Vec<u64> =
            near_starts.chain(near_intervals).chain(random).chain([STEPS - 1]).filter(|&step| step < STEPS).collect();
        for sixteen in steps.chunks(LANES) {
            let step = |lane: usize| sixteen[lane.min(sixteen.len() - 1)];
            let choice = std::array::from_fn(|lane| (step(lane) >> 16) as f32 / 16_777_216.0);
            let low = |shift: u32| std::array::from_fn(|lane| (step(lane) >> shift & 0xFF) as f32 / 16_777_216.0);
            let found = emitters.search(&choice, &[low(8), low(0)]);
            for lane in 0..LANES {
                let expected = emitters.starts.partition_point(|&start| start <= step(lane)) - 1;
                assert_eq!(found[lane] as usize, expected, "step {} of {count} triangles", step(lane));
            }
        }
    }
}
