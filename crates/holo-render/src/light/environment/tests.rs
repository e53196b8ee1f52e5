//! The environment map, compared with its definition in f64.

use std::f64::consts::{PI, TAU};

use ndarray::Array3;

use super::*;
use crate::sampling::{Purpose, points, sequences};
use crate::simd::{Kernel, run_on_all};

const TURNED: fn() -> Transform = || Transform::look_at([3.0, -2.0, 5.0], [-1.0, 0.5, 1.0], [0.2, 1.0, -0.1]);

fn image(rows: usize, columns: usize, texel: impl Fn(usize, usize) -> [f32; 3]) -> Environment {
    Environment { radiance: Array3::from_shape_fn((rows, columns, 3), |(row, column, c)| texel(row, column)[c]) }
}

/// Uncorrelated texels, from 0 to 1.
fn noise(rows: usize, columns: usize) -> Environment {
    image(rows, columns, |row, column| {
        let x = (row as f32 * 12.9898 + column as f32 * 78.233).sin() * 43758.547;
        [0.0, 0.3, 0.6].map(|shift| (x + shift).rem_euclid(1.0))
    })
}

fn lanes(direction: [f64; 3]) -> [[f32; LANES]; 3] {
    direction.map(|x| [x as f32; LANES])
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| x / length)
}

fn direction_of(u: f64, v: f64) -> [f64; 3] {
    let (azimuth, polar) = (TAU * (u - 0.5), PI * v);
    [polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin()]
}

/// The bilinear image at (u, v): a reference implementation.
fn reference(environment: &Environment, u: f64, v: f64) -> [f64; 3] {
    let map = &environment.radiance;
    let (rows, columns, _) = map.dim();
    let (x, y) = (u * columns as f64 - 0.5, v * rows as f64 - 0.5);
    let (fx, fy) = (x - x.floor(), y - y.floor());
    let texel = |di: i64, dj: i64, c| {
        let column = (x.floor() as i64 + di).rem_euclid(columns as i64) as usize;
        let row = (y.floor() as i64 + dj).clamp(0, rows as i64 - 1) as usize;
        f64::from(map[[row, column, c]])
    };
    [0, 1, 2].map(|c| {
        let upper = texel(0, 0, c) * (1.0 - fx) + texel(1, 0, c) * fx;
        let lower = texel(0, 1, c) * (1.0 - fx) + texel(1, 1, c) * fx;
        upper * (1.0 - fy) + lower * fy
    })
}

/// Sets of sixteen independent points.
fn independent_points(sets: u32) -> impl Iterator<Item = Points> {
    (0..sets).map(|k| {
        points(
            &sequences(3, &std::array::from_fn(|lane| k * 16 + lane as u32), &[0; LANES]),
            0,
            Purpose::at_vertex(0, crate::sampling::Draw::Direction),
        )
    })
}

/// The mean and standard error of the irradiance (first channel) on a surface with a world normal, from `16 * sets`
/// samples.
fn irradiance(environment: &EnvironmentLight, pose: &Transform, normal: [f64; 3], sets: u32) -> (f64, f64) {
    let (mut sum, mut squares) = (0.0, 0.0);
    for numbers in independent_points(sets) {
        let sample = environment.sample(&numbers);
        for lane in 0..LANES {
            let world = pose.vector(at(&sample.direction, lane).map(f64::from));
            let cosine: f64 = (0..3).map(|k| world[k] * normal[k]).sum();
            let value = f64::from(sample.radiance[0][lane]) * cosine.max(0.0) / f64::from(sample.pdf[lane]);
            sum += value;
            squares += value * value;
        }
    }
    let count = f64::from(sets) * LANES as f64;
    let mean = sum / count;
    (mean, ((squares / count - mean * mean) / count).sqrt())
}

/// The mapping. Four columns of values 1, 10, 100, 1000 have their centers at u = 1/8, 3/8, 5/8, 7/8; five rows have
/// them at v = 0.1, 0.3, 0.5, 0.7, 0.9.
#[test]
fn the_axes_of_the_world_lie_where_the_mapping_says() {
    let map = image(5, 4, |row, column| match row {
        0 => [7.0; 3],
        4 => [9.0; 3],
        _ => [[1.0, 10.0, 100.0, 1000.0][column], 0.0, 0.0],
    });
    let environment = EnvironmentLight::new(&map, &Transform::IDENTITY);
    let cases = [
        ([1.0, 0.0, 0.0], 55.0),   // u = 1/2: between the second and the third
        ([0.0, 0.0, 1.0], 550.0),  // u = 3/4: between the third and the fourth
        ([-1.0, 0.0, 0.0], 500.5), // u = 0 or 1: between the fourth and the first
        ([0.0, 0.0, -1.0], 5.5),   // u = 1/4: between the first and the second
        ([0.0, 1.0, 0.0], 7.0),    // v = 0: the top row
        ([0.0, -1.0, 0.0], 9.0),   // v = 1: the bottom row
    ];
    for (direction, expected) in cases {
        for length in [1.0, 1e-6, 1e6] {
            let found = environment.radiance(&lanes(direction.map(|x| x * length)))[0];
            assert!(found.iter().all(|x| (x / expected - 1.0).abs() < 1e-5), "{direction:?}: {}", found[0]);
        }
        // A camera looks along -z; rotated to the direction it sees the same radiance straight ahead.
        let up = if direction[1] == 0.0 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] };
        let pose = Transform::look_at([0.0; 3], direction.map(f64::from), up);
        let ahead = EnvironmentLight::new(&map, &pose).radiance(&lanes([0.0, 0.0, -1.0]))[0][0];
        assert!((ahead / expected - 1.0).abs() < 1e-5, "ahead at {direction:?}: {ahead}");
    }
}

/// The error of the arc tangent, 2e-7 rad, is 6.4e-8 in v; its argument, 1 / pi and the product add at most 4e-8 each
/// by rounding: less than 2e-7. The identity rounds no coordinate.
#[test]
fn directions_have_their_texture_coordinates() {
    let environment = EnvironmentLight::new(&noise(1, 1), &Transform::IDENTITY);
    for k in 0..20_000 {
        let (u, v) = (f64::from(k) / 20_000.0, 0.309 + f64::from(k) * 0.618);
        for length in [1e-6, 1.0, 1e6] {
            let direction = lanes(direction_of(u, v.fract()).map(|x| x * length));
            let [x, y, z] = at(&direction, 0).map(f64::from);
            let expected = [0.5 + z.atan2(x) / TAU, x.hypot(z).atan2(y) / PI];
            let found = environment.uv(&direction).map(|lanes| f64::from(lanes[0]));
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 2e-7, "({x}, {y}, {z}): {found} {expected}");
            }
        }
    }
}

/// A single bright texel of 64 x 32 is visible at its own center and not at the centers of the others, from any camera.
#[test]
fn a_bright_texel_is_seen_at_its_own_direction() {
    for (row, column) in [(0, 0), (5, 63), (16, 31), (16, 32), (31, 17), (24, 0)] {
        let map = image(32, 64, |r, c| if (r, c) == (row, column) { [1.0, 2.0, 3.0] } else { [0.0; 3] });
        let pose = TURNED();
        let environment = EnvironmentLight::new(&map, &pose);
        for r in 0..32 {
            for c in 0..64 {
                let world = direction_of((c as f64 + 0.5) / 64.0, (r as f64 + 0.5) / 32.0);
                let camera = crate::geometry::world_to_camera_rotation(&pose).vector(world);
                let found = at(&environment.radiance(&lanes(camera)), 5);
                let expected = if (r, c) == (row, column) { [1.0, 2.0, 3.0] } else { [0.0; 3] };
                for k in 0..3 {
                    // Rounded directions have an error of up to 1e-7 rad, 20 times that in u on the rows next to the
                    // poles.
                    assert!((found[k] - expected[k]).abs() < 2e-4, "{r} {c}: {found:?}");
                }
            }
        }
    }
}

#[test]
fn between_texels_it_is_bilinear_in_every_frame() {
    let map = noise(19, 37);
    for pose in [Transform::IDENTITY, TURNED()] {
        let environment = EnvironmentLight::new(&map, &pose);
        for k in 0..20_000 {
            let (u, v) = (f64::from(k) / 20_000.0, 0.02 + 0.96 * (f64::from(k) * 0.618).rem_euclid(1.0));
            let camera = crate::geometry::world_to_camera_rotation(&pose).vector(direction_of(u, v));
            let found = at(&environment.radiance(&lanes(camera)), 0);
            let expected = reference(&map, u, v);
            for c in 0..3 {
                // Angles within 5e-7 rad, divided by a sine of 0.06 at the rows next to the poles, times 37 / (2 pi)
                // texels.
                assert!((f64::from(found[c]) - expected[c]).abs() < 5e-5, "{u} {v}");
            }
        }
    }
}

/// The midpoint rule over a grid that does not match the cells.
#[test]
fn the_density_integrates_to_one() {
    for (map, pose) in [(noise(8, 16), TURNED()), (noise(3, 5), Transform::IDENTITY), (noise(1, 1), TURNED())] {
        let environment = EnvironmentLight::new(&map, &pose);
        let (rows, columns) = (1501, 3001);
        let mut sum = 0.0;
        for row in 0..rows {
            // Rows of equal solid angle.
            let y: f64 = 1.0 - (2.0 * f64::from(row) + 1.0) / f64::from(rows);
            for first in (0..columns).step_by(LANES) {
                let mut direction = [[0.0; LANES]; 3];
                for lane in 0..LANES {
                    let azimuth = TAU * (f64::from(first) + lane as f64 + 0.5) / f64::from(columns);
                    let level = (1.0 - y * y).sqrt();
                    for (axis, x) in [level * azimuth.cos(), y, level * azimuth.sin()].into_iter().enumerate() {
                        direction[axis][lane] = x as f32;
                    }
                }
                let count = (columns as usize - first as usize).min(LANES);
                sum += environment.pdf(&direction)[..count].iter().map(|&p| f64::from(p)).sum::<f64>();
            }
        }
        let integral = sum * 4.0 * PI / f64::from(rows * columns);
        assert!((integral - 1.0).abs() < 1e-3, "{integral}");
    }
}

/// A constant image is sampled uniformly, up to half a step of 2^-24 of the probabilities of row and cell.
#[test]
fn a_constant_image_has_a_constant_density() {
    for (rows, columns, at_most) in [(1, 1, 1e-6), (32, 64, 1e-4), (1024, 2048, 5.5e-2)] {
        let environment = EnvironmentLight::new(&image(rows, columns, |_, _| [0.25; 3]), &TURNED());
        let (mut off, mut worst) = (0.0, 0.0f64);
        for numbers in independent_points(1000) {
            let sample = environment.sample(&numbers);
            for lane in 0..LANES {
                let error = (f64::from(sample.pdf[lane]) * 4.0 * PI - 1.0).abs();
                worst = worst.max(error);
                off += error / 16_000.0;
                assert_eq!(sample.radiance[1][lane], 0.25);
            }
        }
        assert!(worst < at_most, "{rows} x {columns}: {worst}");
        // The mean deviation is far smaller: rows next to the poles are small.
        assert!(off < 5e-4, "{rows} x {columns}: {off}");
        // The outermost row of 2048 has 9.9 steps, rounded to 10.
        let pole = environment.cells.pdf(&[[0.3; LANES], [0.0; LANES]])[0];
        assert!((f64::from(pole) * 4.0 * PI - 1.0).abs() < at_most);
    }
}

#[test]
fn samples_have_the_pdf_of_the_lookup() {
    for (map, pose) in [(noise(128, 256), TURNED()), (noise(7, 3), Transform::IDENTITY)] {
        let environment = EnvironmentLight::new(&map, &pose);
        let mut elsewhere = 0;
        for numbers in independent_points(10_000) {
            let sample = environment.sample(&numbers);
            let (pdf, radiance) = (environment.pdf(&sample.direction), environment.radiance(&sample.direction));
            for lane in 0..LANES {
                let length: f32 = at(&sample.direction, lane).iter().map(|x| x * x).sum();
                assert!((length - 1.0).abs() < 1e-6);
                // Next to a pole u changes fast.
                let level = pose.vector(at(&sample.direction, lane).map(f64::from))[1].abs();
                let bound = if level < 0.9999 { 5e-3 } else { 5e-2 };
                assert!((radiance[0][lane] - sample.radiance[0][lane]).abs() < bound);
                elsewhere += u32::from((pdf[lane] / sample.pdf[lane] - 1.0).abs() > 1e-5);
            }
        }
        // Two borders per cell of 2 pi / 512 rad, 3e-7 rad wide: on average 1e-4 of the samples, doubled.
        assert!(elsewhere < 32, "{elsewhere} of 160000 in a neighboring cell");
    }
}

/// Pearson's test over the 12 x 8 cells of a 6 x 4 image: chi squared with 95 degrees of freedom is 95 +- 14, and
/// beyond five standard deviations once in a million.
#[test]
fn directions_are_drawn_with_the_density() {
    let pose = TURNED();
    let environment = EnvironmentLight::new(&noise(4, 6), &pose);
    let (rows, columns) = (8, 12);
    let mut counts = vec![0.0; rows * columns];
    let sets = 20_000;
    for numbers in independent_points(sets) {
        let sample = environment.sample(&numbers);
        for lane in 0..LANES {
            let [x, y, z] = pose.vector(at(&sample.direction, lane).map(f64::from));
            let u = (0.5 + z.atan2(x) / TAU).rem_euclid(1.0);
            let v = (x.hypot(z)).atan2(y) / PI;
            counts[(v * rows as f64) as usize * columns + (u * columns as f64) as usize] += 1.0;
        }
    }
    let (mut chi_squared, mut total) = (0.0, 0.0);
    for row in 0..rows {
        let edge = |k: usize| (PI * k as f64 / rows as f64).cos();
        let solid_angle = TAU / columns as f64 * (edge(row) - edge(row + 1));
        for column in 0..columns {
            let world = direction_of((column as f64 + 0.5) / columns as f64, (row as f64 + 0.5) / rows as f64);
            let camera = crate::geometry::world_to_camera_rotation(&pose).vector(world);
            let probability = f64::from(environment.pdf(&lanes(camera))[9]) * solid_angle;
            let expected = probability * f64::from(sets) * LANES as f64;
            chi_squared += (counts[row * columns + column] - expected).powi(2) / expected;
            total += probability;
        }
    }
    assert!((total - 1.0).abs() < 1e-5, "{total}");
    assert!(chi_squared < 95.0 + 5.0 * (2.0 * 95.0f64).sqrt(), "{chi_squared}");
}

/// Within five standard errors, below 0.5 %, of the sum in f64 over 6 x 6 points per texel, which has an error of 1e-3
/// where the horizon of the surface crosses texels.
#[test]
fn the_irradiance_is_that_of_all_texels() {
    let map = noise(12, 24);
    let pose = TURNED();
    let environment = EnvironmentLight::new(&map, &pose);
    for normal in [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0], unit([1.0, 0.3, -0.5]), unit([-0.4, 0.1, 0.9])] {
        let (rows, columns) = (72, 144);
        let mut expected = 0.0;
        for row in 0..rows {
            let v = (f64::from(row) + 0.5) / f64::from(rows);
            let edge = |k: i32| (PI * f64::from(k) / f64::from(rows)).cos();
            let solid_angle = TAU / f64::from(columns) * (edge(row) - edge(row + 1));
            for column in 0..columns {
                let u = (f64::from(column) + 0.5) / f64::from(columns);
                let cosine: f64 = direction_of(u, v).iter().zip(normal).map(|(a, b)| a * b).sum();
                expected += reference(&map, u, v)[0] * cosine.max(0.0) * solid_angle;
            }
        }
        let (mean, error) = irradiance(&environment, &pose, normal, 8192);
        assert!(error < 5e-3 * mean, "{error} of {mean}");
        assert!((mean - expected).abs() < 5.0 * error + 1e-3 * expected, "{mean} +- {error}, {expected}");
    }
}

/// One bright texel of 4096 x 2048 in a faint sky. A constant sky of radiance 0.01 gives 0.01 pi; the texel gives its
/// radiance times the integral of its tent filter, the solid angle of one texel, times the cosine with the normal.
#[test]
fn the_sun_in_one_texel_is_found() {
    let (row, column) = (700, 1000);
    let map = image(2048, 4096, |r, c| if (r, c) == (row, column) { [1e5; 3] } else { [0.01; 3] });
    let pose = TURNED();
    let environment = EnvironmentLight::new(&map, &pose);
    let polar = PI * (row as f64 + 0.5) / 2048.0;
    let solid_angle = (PI / 2048.0).powi(2) * polar.sin();
    let expected = 0.01 * PI + (1e5 - 0.01) * solid_angle * polar.cos();
    let (mean, error) = irradiance(&environment, &pose, [0.0, 1.0, 0.0], 1024);
    // A constant pdf per cell matches the tent within a relative standard deviation of about one: 1 % for 16384
    // samples.
    assert!(error < 0.015 * mean, "{error} of {mean}");
    assert!((mean - expected).abs() < 5.0 * error, "{mean} +- {error}, {expected}");
    // The faint sky is sampled, too.
    for k in 0..10_000u32 {
        let (u, v) = ((f64::from(k) * 0.618).rem_euclid(1.0), f64::from(k) / 1e4);
        assert!(environment.pdf(&lanes(direction_of(u, v)))[0] > 0.0);
    }
}

#[test]
fn a_black_environment_has_no_pdf() {
    let black = EnvironmentLight::new(&image(5, 9, |_, _| [0.0; 3]), &TURNED());
    assert!(black.is_black());
    for numbers in independent_points(20) {
        let sample = black.sample(&numbers);
        assert_eq!((sample.pdf, sample.radiance), ([0.0; LANES], [[0.0; LANES]; 3]));
        assert!(sample.direction.iter().flatten().all(|x| x.is_finite()));
        assert_eq!(black.pdf(&sample.direction), [0.0; LANES]);
    }
    // Half black: no samples where the bilinear image is 0.
    let half = image(6, 8, |row, column| if row < 3 && column < 4 { [0.0, 0.0, 1.0] } else { [0.0; 3] });
    let half = EnvironmentLight::new(&half, &TURNED());
    assert!(!half.is_black());
    for numbers in independent_points(500) {
        let sample = half.sample(&numbers);
        for lane in 0..LANES {
            assert!(sample.radiance[2][lane] > 0.0 && sample.pdf[lane] > 0.0);
        }
    }
}

struct Everything<'a>(&'a EnvironmentLight, Points);

impl Kernel for Everything<'_> {
    type Output = Vec<u32>;

    #[inline(always)]
    fn run(self) -> Vec<u32> {
        let sample = self.0.sample(&self.1);
        let (radiance, pdf) = (self.0.radiance(&sample.direction), self.0.pdf(&sample.direction));
        let mut out = Vec::new();
        for field in [sample.direction, sample.radiance, radiance, [sample.pdf, pdf, pdf]] {
            out.extend(field.iter().flatten().map(|x| x.to_bits()));
        }
        out
    }
}

#[test]
fn every_instruction_set_gives_the_same_bits() {
    let environment = EnvironmentLight::new(&noise(33, 70), &TURNED());
    for numbers in independent_points(2000) {
        let results = run_on_all(|| Everything(&environment, numbers));
        assert!(results.iter().all(|r| *r == results[0]));
    }
}
