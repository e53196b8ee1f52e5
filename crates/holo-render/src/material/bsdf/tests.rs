//! Shared parts of the BSDF tests, and the tests without integrals.

mod fresnel;
mod furnace;
mod quadrature;
mod reference;

use super::*;
use crate::sampling::Points;
use crate::simd::{self, Kernel};

/// A random number generator that is independent of the renderer.
pub(super) struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// In [0, 1).
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((x ^ (x >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn lanes(&mut self) -> [f32; LANES] {
        std::array::from_fn(|_| (self.next() as f32).min(1.0 - f32::EPSILON))
    }

    pub fn points(&mut self) -> Points {
        [self.lanes(), self.lanes()]
    }

    /// Uniform over the sphere.
    pub fn direction(&mut self) -> [f64; 3] {
        let z = 2.0 * self.next() - 1.0;
        let (sin, cos) = (std::f64::consts::TAU * self.next()).sin_cos();
        let r = (1.0 - z * z).sqrt();
        [r * cos, r * sin, z]
    }

    pub fn choose<T: Copy>(&mut self, from: &[T]) -> T {
        from[(self.next() * from.len() as f64) as usize]
    }
}

/// The BSDF parameters of one lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct One {
    pub base_color: [f32; 3],
    pub metallic: f32,
    pub transmission: f32,
    pub roughness: f32,
    pub specular: f32,
    pub specular_color: [f32; 3],
    pub eta: f32,
    pub thin: bool,
}

pub(super) const WHITE_METAL: One = One { metallic: 1.0, ..WHITE_COATED };
pub(super) const CLEAR_GLASS: One = One { transmission: 1.0, ..WHITE_COATED };
pub(super) const WHITE_COATED: One = One {
    base_color: [1.0; 3],
    metallic: 0.0,
    transmission: 0.0,
    roughness: 0.0,
    specular: 1.0,
    specular_color: [1.0; 3],
    eta: 1.5,
    thin: false,
};

impl One {
    pub fn random(random: &mut Random) -> Self {
        let share = |random: &mut Random| random.choose(&[0.0, 1.0, 0.3, 0.8]);
        Self {
            base_color: std::array::from_fn(|_| random.next() as f32),
            metallic: share(random),
            transmission: share(random),
            roughness: random.choose(&[0.0, 0.0317, 0.05, 0.1, 0.3, 0.5, 0.7, 1.0]),
            specular: random.choose(&[0.0, 1.0, 1.0, 0.4]),
            specular_color: std::array::from_fn(|_| 1.2 * random.next() as f32),
            eta: random.choose(&[1.5, 1.0 / 1.5, 1.1, 2.4, 1.0 / 2.4, 1.0, 1.0003, 1.01]),
            thin: random.next() < 0.3,
        }
    }

    pub fn alpha(&self) -> f32 {
        self.roughness * self.roughness
    }

    pub fn f0(&self) -> [f32; 3] {
        let clear = super::fresnel::normal_incidence(self.eta);
        self.specular_color.map(|c| (c * clear).min(1.0) * self.specular)
    }
}

pub(super) fn bsdf(ones: &[One; LANES]) -> Bsdf {
    let color = |of: fn(&One) -> [f32; 3]| -> [[f32; LANES]; 3] {
        std::array::from_fn(|c| std::array::from_fn(|lane| of(&ones[lane])[c]))
    };
    let number = |of: fn(&One) -> f32| -> [f32; LANES] { std::array::from_fn(|lane| of(&ones[lane])) };
    Bsdf {
        base_color: color(|one| one.base_color),
        metallic: number(|one| one.metallic),
        transmission: number(|one| one.transmission),
        alpha: number(One::alpha),
        metal_f90: [[1.0; LANES]; 3],
        specular_f0: color(One::f0),
        specular_f90: number(|one| one.specular),
        eta: number(|one| one.eta),
        thin: std::array::from_fn(|lane| ones[lane].thin),
        multiple_scattering: true,
    }
}

pub(super) fn all(one: One) -> Bsdf {
    bsdf(&[one; LANES])
}

pub(super) fn lanes_of(directions: &[[f64; 3]; LANES]) -> Directions {
    std::array::from_fn(|axis| std::array::from_fn(|lane| directions[lane][axis] as f32))
}

pub(super) fn same_in_all_lanes(direction: [f64; 3]) -> Directions {
    lanes_of(&[direction; LANES])
}

/// The direction to a viewer at the cosine `mu`, at some azimuth.
pub(super) fn viewer(mu: f64) -> [f64; 3] {
    let r = (1.0 - mu * mu).sqrt();
    [0.6 * r, -0.8 * r, mu]
}

struct Both<'a> {
    bsdf: &'a Bsdf,
    out: &'a Directions,
    choice: &'a [f32; LANES],
    point: &'a Points,
    into: &'a Directions,
}

impl Kernel for Both<'_> {
    type Output = (Sampled, Evaluated);

    #[inline(always)]
    fn run(self) -> Self::Output {
        (self.bsdf.sample(self.out, self.choice, self.point), self.bsdf.evaluate(self.out, self.into))
    }
}

fn bits(result: &(Sampled, Evaluated)) -> Vec<[u32; LANES]> {
    let (sampled, evaluated) = result;
    let mut all: Vec<[f32; LANES]> = Vec::new();
    all.extend(sampled.into.iter().chain(&sampled.weight).chain(&evaluated.value));
    all.extend([sampled.pdf, evaluated.pdf, sampled.transmitted.map(|t| f32::from(u8::from(t)))]);
    all.iter().map(|lanes| lanes.map(f32::to_bits)).collect()
}

fn viewers(random: &mut Random) -> [[f64; 3]; LANES] {
    std::array::from_fn(|_| {
        let mu = random.next().powi(random.choose(&[1, 4])).max(1e-4);
        viewer(mu)
    })
}

/// Bitwise identical without vector instructions, with AVX2 and with AVX-512, for random mixtures.
#[test]
fn every_instruction_set_gives_the_same_bits() {
    let mut random = Random::new(1);
    for _ in 0..500 {
        let bsdf = bsdf(&std::array::from_fn(|_| One::random(&mut random)));
        let out = lanes_of(&viewers(&mut random));
        let into = lanes_of(&std::array::from_fn(|_| random.direction()));
        let (choice, point) = (random.lanes(), random.points());
        let results = simd::run_on_all(|| Both { bsdf: &bsdf, out: &out, choice: &choice, point: &point, into: &into });
        for result in &results[1..] {
            assert_eq!(bits(result), bits(&results[0]));
        }
    }
}

/// The result of a lane does not depend on the other lanes: lobes that a packet skips would add nothing.
#[test]
fn lanes_do_not_see_each_other() {
    let mut random = Random::new(2);
    for _ in 0..300 {
        let ones: [One; LANES] = std::array::from_fn(|_| One::random(&mut random));
        let out = lanes_of(&viewers(&mut random));
        let into = lanes_of(&std::array::from_fn(|_| random.direction()));
        let (choice, point) = (random.lanes(), random.points());
        let run = |bsdf: &Bsdf| bits(&Both { bsdf, out: &out, choice: &choice, point: &point, into: &into }.run());
        let together = run(&bsdf(&ones));
        for lane in 0..LANES {
            let alone = run(&all(ones[lane]));
            for (a, b) in together.iter().zip(&alone) {
                assert_eq!(a[lane], b[lane], "{:?}", ones[lane]);
            }
        }
    }
}

/// For all inputs within their ranges the results are finite (except the infinite pdf of delta lobes), weights are not
/// negative, and directions are unit vectors on the reported side.
#[test]
fn everything_is_finite() {
    let mut random = Random::new(3);
    let mut drawn = 0;
    for _ in 0..4000 {
        let ones: [One; LANES] = std::array::from_fn(|_| One {
            eta: random.choose(&[1e-3, 1e3, 1.0, 1.001, 0.999, 1.5, 0.4, 1.0 + 1e-6]),
            roughness: random.choose(&[0.0, 1e-3f32.sqrt(), 0.0317, 0.2, 1.0]),
            base_color: std::array::from_fn(|_| random.choose(&[0.0, 1.0, 1e-6, 0.5])),
            ..One::random(&mut random)
        });
        let bsdf = bsdf(&ones);
        let out = lanes_of(&std::array::from_fn(|_| viewer(random.choose(&[1e-6, 1e-5, 1e-3, 0.1, 0.5, 1.0]))));
        let mut random_into = || {
            let [x, y, z] = random.direction();
            let z = z * random.choose(&[1.0, 1e-3, 1e-6, 1e-30, 0.0]);
            let length = (x * x + y * y + z * z).sqrt();
            [x / length, y / length, z / length]
        };
        let mut into = lanes_of(&std::array::from_fn(|_| random_into()));
        // Straight through, where half vectors vanish, and straight back.
        for axis in 0..3 {
            into[axis][0] = -out[axis][0];
            into[axis][1] = out[axis][1];
        }
        let point = random.points();
        for choice in [[0.0; LANES], random.lanes(), [1.0 - f32::EPSILON / 2.0; LANES]] {
            let sampled = bsdf.sample(&out, &choice, &point);
            for evaluated in [bsdf.evaluate(&out, &into), bsdf.evaluate(&out, &sampled.into)] {
                for x in evaluated.value.iter().chain([&evaluated.pdf]).flatten() {
                    assert!(x.is_finite() && *x >= 0.0, "{evaluated:?}");
                }
            }
            for lane in 0..LANES {
                let weight = sampled.weight.map(|w| w[lane]);
                assert!(weight.iter().all(|w| w.is_finite() && *w >= 0.0), "{weight:?} {:?}", ones[lane]);
                assert!(sampled.pdf[lane] >= 0.0, "{:?}", ones[lane]);
                if weight.iter().any(|w| *w > 0.0) {
                    let length: f32 = sampled.into.iter().map(|x| x[lane] * x[lane]).sum();
                    assert!((length - 1.0).abs() < 2e-6, "{length} {:?}", ones[lane]);
                    assert_eq!(sampled.into[2][lane] < 0.0, sampled.transmitted[lane], "{:?}", ones[lane]);
                    drawn += 1;
                }
            }
        }
    }
    assert!(drawn > 100_000, "most draws find a direction: {drawn}");
}

/// `sample` returns the pdf of `evaluate`, bitwise.
#[test]
fn densities_agree() {
    let mut random = Random::new(4);
    for _ in 0..500 {
        let bsdf = bsdf(&std::array::from_fn(|_| One::random(&mut random)));
        let out = lanes_of(&viewers(&mut random));
        let sampled = bsdf.sample(&out, &random.lanes(), &random.points());
        let evaluated = bsdf.evaluate(&out, &sampled.into);
        for lane in 0..LANES {
            assert!(sampled.pdf[lane] == f32::INFINITY || sampled.pdf[lane] == evaluated.pdf[lane]);
        }
    }
}

/// Without specular reflection: base color / pi times the cosine, cosine-distributed samples, weighted by the base
/// color; bitwise, for any roughness.
#[test]
fn a_surface_without_specular_reflection_is_lamberts() {
    let mut random = Random::new(5);
    for _ in 0..100 {
        let base_color: [[f32; LANES]; 3] = std::array::from_fn(|_| random.lanes());
        let mut bsdf = Bsdf::lambertian(base_color);
        bsdf.alpha = random.lanes();
        bsdf.alpha[0] = 0.0;
        // Other lanes with lobes that are not skipped.
        bsdf.metallic[LANES - 1] = 0.5;
        bsdf.transmission[LANES - 2] = 0.5;
        bsdf.specular_f90[LANES - 3] = 1.0;
        let out = lanes_of(&viewers(&mut random));
        let into = lanes_of(&std::array::from_fn(|_| random.direction()));
        let evaluated = bsdf.evaluate(&out, &into);
        let (point, choice) = (random.points(), random.lanes());
        let sampled = bsdf.sample(&out, &choice, &point);
        let expected = crate::sampling::cosine_hemisphere(&point);
        for lane in 0..LANES - 3 {
            for c in 0..3 {
                let lambert = into[2][lane].max(0.0) * std::f32::consts::FRAC_1_PI;
                assert_eq!(evaluated.value[c][lane], base_color[c][lane] * lambert);
                assert_eq!(sampled.into[c][lane], expected[c][lane]);
                assert_eq!(sampled.weight[c][lane], base_color[c][lane]);
            }
        }
    }
}

/// Smooth white metal reflects everything in one direction, exactly; a smooth colored metal with `metal_f90` equal to
/// its base color has that reflectance at all angles.
#[test]
fn smooth_metal_is_a_mirror() {
    for mu in [1e-4, 0.02, 0.5, 1.0] {
        let out = same_in_all_lanes(viewer(mu));
        let mut bsdf = all(WHITE_METAL);
        let sampled = bsdf.sample(&out, &[0.7; LANES], &[[0.3; LANES]; 2]);
        for axis in 0..3 {
            assert_eq!(sampled.weight[axis], [1.0; LANES]);
            let sign = if axis == 2 { 1.0 } else { -1.0 };
            assert_eq!(sampled.into[axis][0], sign * out[axis][0]);
        }
        assert_eq!(sampled.pdf, [f32::INFINITY; LANES]);
        bsdf.base_color = [[0.9; LANES], [0.6; LANES], [0.2; LANES]];
        bsdf.metal_f90 = bsdf.base_color;
        assert_eq!(bsdf.sample(&out, &[0.7; LANES], &[[0.3; LANES]; 2]).weight, bsdf.base_color);
    }
}
