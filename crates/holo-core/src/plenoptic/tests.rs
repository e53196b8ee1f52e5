//! The camera against thin lenses one after the other, the rig, and points traced forwards.

use std::f64::consts::PI;

use super::*;
use crate::{GridSize, LightFieldShape, Rig};

mod calibration;
mod focused;
mod glass;
mod real_lenses;
mod views;
mod white;

/// Numbers in 0..1, always the same.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn around(&mut self, center: f64, width: f64) -> f64 {
        center + (self.next() - 0.5) * width
    }
}

fn illum(size: GridSize) -> PlenopticCamera {
    let mut array = MicrolensArray::new(MicrolensGrid::HexRows, 20e-6, 37e-6);
    (array.rotation_rad, array.offset_m) = (5.426_123_971e-4, [8.42e-6, -9.5e-7]);
    let mut lens = MainLens::new(24.199_465_511e-3, 2.199_776, 0.5);
    lens.exit_pupil_m = Some(97.285_621_643e-3);
    PlenopticCamera::new(ImageSensor::new(size, 1.4e-6), array, lens).expect("a camera")
}

fn r12(size: GridSize) -> PlenopticCamera {
    let (mla, sensor) = (56.700_741_714_110_258e-3, 57.025_516_075_246_57e-3);
    let mut array = MicrolensArray::new(MicrolensGrid::HexRows, 127.455_294_296_207_78e-6, sensor - mla);
    array.focus = MicrolensFocus::Lengths(vec![578.182_088_509_875e-6, 505.42e-6, 552.08e-6]);
    let mut lens = MainLens::new(49.714_480_540_246_52e-3, 4.0, 1.0);
    lens.focus = ArrayFocus::Distance { mla_distance_m: mla };
    PlenopticCamera::new(ImageSensor::new(size, 5.5e-6), array, lens).expect("a camera")
}

/// The ray by thin lenses one after the other, and the point of the exit pupil that it crosses.
fn step_by_step(camera: &PlenopticCamera, x: [f64; 2], q: [f64; 2], lens: MicrolensIndex) -> (PlenopticRay, [f64; 2]) {
    refracted(camera, x, q, lens, camera.microlens_focal_lengths_m()[camera.array().type_of(lens)])
}

/// The same with any focal length; infinite for light that passes between the microlenses.
fn refracted(
    camera: &PlenopticCamera,
    x: [f64; 2],
    q: [f64; 2],
    lens: MicrolensIndex,
    focal_m: f64,
) -> (PlenopticRay, [f64; 2]) {
    let (center, array) = (camera.lens_center_m(lens), camera.array());
    // On a tilted array.
    let from_origin = [0, 1].map(|k| center[k] - camera.sensor().offset_m[k] - array.offset_m[k]);
    let raised = array.tilt_rad[0].tan() * from_origin[0] + array.tilt_rad[1].tan() * from_origin[1];
    let slope = [0, 1].map(|k| (q[k] - x[k]) / (array.gap_m + raised) - (q[k] - center[k]) / focal_m);
    let pupil = [0, 1].map(|k| -(q[k] + (camera.exit_pupil_m() - raised) * slope[k]));
    let height = [0, 1].map(|k| -(q[k] + (camera.mla_distance_m() - raised) * slope[k]));
    let direction = [0, 1].map(|k| -slope[k] - height[k] / camera.main_lens().focal_length_m);
    let origin_m = [0, 1].map(|k| height[k] + camera.entrance_pupil_offset_m() * direction[k]);
    (PlenopticRay { origin_m, direction }, pupil)
}

/// cos^4 of the light from a point of a microlens.
fn cos4(camera: &PlenopticCamera, x: [f64; 2], q: [f64; 2], lens: MicrolensIndex) -> f64 {
    let gap = camera.microlens(lens).gap_m;
    (1.0 + ((q[0] - x[0]).powi(2) + (q[1] - x[1]).powi(2)) / (gap * gap)).powi(-2)
}

#[test]
fn rays_equal_those_through_one_thin_lens_after_the_other() {
    let mut numbers = Numbers(1);
    let whole = GridSize::new(3000, 4000);
    let mut odd = MicrolensArray::new(MicrolensGrid::HexColumns, 20e-6, 40e-6);
    (odd.focus, odd.rotation_rad) = (MicrolensFocus::Lengths(vec![38e-6, 43e-6]), 0.7);
    let mut behind = MainLens::new(24e-3, 2.2, f64::INFINITY);
    behind.exit_pupil_m = Some(15e-3);
    let odd = PlenopticCamera::new(ImageSensor::new(whole, 1.4e-6), odd, behind).expect("a camera");
    let (mut array, lens) = (r12(whole).array().clone(), r12(whole).main_lens().clone());
    array.tilt_rad = [8.4e-4, -6.4e-3];
    let tilted = PlenopticCamera::new(*r12(whole).sensor(), array, lens).expect("a camera");
    for camera in [illum(whole), r12(whole), odd, tilted] {
        for _ in 0..2000 {
            let position = [numbers.next() * 4000.0, numbers.next() * 3000.0];
            let x = camera.place_m(position);
            let lens = camera.owner(x);
            let pitch = camera.array().pitch_m;
            let q = camera.lens_center_m(lens).map(|c| numbers.around(c, pitch));
            let (expected, pupil) = step_by_step(&camera, x, q, lens);
            let ray = camera.ray(x, q, lens).expect("a thin lens");
            for k in 0..2 {
                assert!((ray.origin_m[k] - expected.origin_m[k]).abs() < 1e-14, "{ray:?} {expected:?}");
                assert!((ray.direction[k] - expected.direction[k]).abs() < 1e-14, "{ray:?} {expected:?}");
            }
            // The exit pupil and the entrance pupil let the same rays pass.
            let radius = camera.exit_pupil_radius_m();
            let within = pupil[0].hypot(pupil[1]) / radius;
            assert!(camera.passes(&ray) == (within <= 1.0) || (within - 1.0).abs() < 1e-9, "{within}");
            let [px, py] = camera.position_px(camera.place_m(position));
            assert!((px - position[0]).abs() + (py - position[1]).abs() < 1e-9);
        }
    }
}

/// The lit region is where rays pass.
#[test]
fn lit_regions_hold_the_points_whose_rays_pass() {
    let mut numbers = Numbers(5);
    let whole = GridSize::new(3000, 4000);
    let mut square = r12(whole);
    for (aperture, pupil) in [
        (LensAperture::Square { half_width_m: 60e-6 }, PupilShape::Round),
        (LensAperture::Hexagon { half_width_m: 63e-6 }, PupilShape::Square),
        (LensAperture::Square { half_width_m: 60e-6 }, PupilShape::Square),
        (LensAperture::Round { radius_m: 60e-6 }, PupilShape::Round),
        (LensAperture::Round { radius_m: 60e-6 }, PupilShape::Polygon { blades: 5, rotation_rad: 0.3 }),
    ] {
        let (mut array, mut lens) = (square.array().clone(), square.main_lens().clone());
        (array.aperture, lens.aperture) = (aperture, pupil);
        square = PlenopticCamera::new(*square.sensor(), array, lens).expect("a camera");
        let mut lit = 0;
        for _ in 0..500 {
            let x = square.place_m([numbers.next() * 4000.0, numbers.next() * 3000.0]);
            let lens = square.owner(x);
            let region = square.lit_region(x, lens);
            let center = square.lens_center_m(lens);
            for _ in 0..8 {
                let Some([px, py]) = region.point([numbers.next(), numbers.next()]) else { continue };
                let ray = square.ray(x, [center[0] + px, center[1] + py], lens).expect("a thin lens");
                // A millionth of the pupil: the rounding of points at its edge.
                let inner = PlenopticRay { origin_m: ray.origin_m.map(|o| o * (1.0 - 1e-6)), ..ray };
                assert!(square.passes(&inner), "{aperture:?} {pupil:?}");
                lit += 1;
            }
            // As much of the microlens is lit as its points say.
            let outer = aperture.outer_radius_m();
            let at = |k: usize| ((k as f64 + 0.5) / 40.0 - 1.0) * outer;
            let passing = (0..80 * 80).filter(|k| {
                let point = [at(k % 80), at(k / 80)];
                let ray = square.ray(x, [center[0] + point[0], center[1] + point[1]], lens);
                let passes = square.passes(&ray.expect("a thin lens"));
                passes && super::lune::is_in_lens(aperture, 0.0, point)
            });
            let counted = passing.count() as f64 * (outer / 40.0).powi(2);
            assert!((region.area_m2() - counted).abs() < 0.03 * aperture.area_m2(), "{} {counted}", region.area_m2());
        }
        assert!(lit > 500, "{lit}");
    }
}

/// Square microlenses that image the pupil onto whole pixels: the rig, ray by ray.
#[test]
fn the_limit_is_the_ideal_rig() {
    let mut numbers = Numbers(2);
    let (pixel, pixels, gap, lenses) = (5e-6, 9usize, 200e-6, GridSize::new(77, 99));
    let focused = 1.0 / (1.0 / 0.05 - 1.0 / 0.9);
    for (exit, focus) in [(None, 0.9), (Some(0.075), 0.9), (Some(0.031), 0.9), (None, f64::INFINITY)] {
        let distance = if focus == 0.9 { focused } else { 0.05 };
        let pitch = pixels as f64 * pixel / (1.0 + gap / exit.unwrap_or(distance));
        let mut array = MicrolensArray::new(MicrolensGrid::Square, pitch, gap);
        array.focus = MicrolensFocus::Pupil;
        array.aperture = LensAperture::Square { half_width_m: pitch / 2.0 };
        let mut lens = MainLens::new(0.05, 4.0, focus);
        (lens.exit_pupil_m, lens.focus) = (exit, ArrayFocus::Distance { mla_distance_m: distance });
        let sensor = ImageSensor::new(GridSize::new(77 * 9, 99 * 9), pixel);
        let camera = PlenopticCamera::new(sensor, array, lens).expect("a camera");
        assert_eq!(camera.alpha(0), 0.0);
        let rig = camera.equivalent_rig(GridSize::new(9, 9), lenses, pitch, 1.0).expect("a rig");
        for _ in 0..2000 {
            let [v, u, t, s] = [77, 99, 9, 9].map(|count| (numbers.next() * f64::from(count)) as usize);
            let (jx, jy) = (numbers.next(), numbers.next());
            let lens = MicrolensIndex { row: v as i32 - 38, column: u as i32 - 49 };
            let center = camera.lens_center_m(lens);
            let q = [center[0] + (jx - 0.5) * pitch, center[1] + (0.5 - jy) * pitch];
            let x = camera.place_m([(u * 9 + s) as f64 + 0.5, (v * 9 + t) as f64 + 0.5]);
            let ray = camera.ray(x, q, lens).expect("a thin lens");
            let expected = rig.ray(v, u, t, s, jx, jy);
            for k in 0..2 {
                assert!((ray.origin_m[k] - expected.origin_m[k]).abs() < 1e-14, "{exit:?} {ray:?} {expected:?}");
                assert!((ray.direction[k] - expected.direction[k]).abs() < 1e-14, "{exit:?} {ray:?} {expected:?}");
            }
        }
    }
}

/// The camera is focused where it is told to, also behind a pupil that is not in the lens, and in front of the array.
#[test]
fn the_focus_is_found() {
    for exit in [None, Some(97e-3), Some(15e-3), Some(1e6)] {
        for depth_m in [0.2, 0.5, 20.0, f64::INFINITY, -3.0] {
            for virtual_depth in [0.0, 2.0, -3.0] {
                let mut lens = MainLens::new(24.2e-3, 2.2, depth_m);
                (lens.exit_pupil_m, lens.focus) = (exit, ArrayFocus::Depth { depth_m, virtual_depth });
                let array = MicrolensArray::new(MicrolensGrid::Square, 20e-6, 37e-6);
                let sensor = ImageSensor::new(GridSize::new(10, 10), 1.4e-6);
                let camera = PlenopticCamera::new(sensor, array, lens).expect("a camera");
                let case = format!("{exit:?} {depth_m} {virtual_depth}");
                let found = camera.virtual_depth(depth_m);
                // A virtual depth is a difference of lengths a thousand times as long as the gap.
                assert!((found - virtual_depth).abs() < 1e-9 * (1.0 + depth_m.abs().min(100.0)), "{case}: {found}");
                if virtual_depth == 0.0 {
                    let inverse = camera.inverse_focus_per_m();
                    assert!((inverse - 1.0 / depth_m).abs() < 1e-10 * (1.0 + 1.0 / depth_m.abs()), "{case}: {inverse}");
                }
            }
        }
    }
}

/// A point of the scene, traced forwards through a grid of points of the entrance pupil: every ray arrives where the
/// closed form says, and the spot has its radius.
#[test]
fn points_arrive_at_their_chief_pixels() {
    for (camera, point) in [
        (illum(GridSize::new(5368, 7728)), [0.011, -0.007, -0.62]),
        (r12(GridSize::new(3068, 4080)), [-0.012, 0.009, -0.3]),
    ] {
        let (depth, offset) = (-point[2], camera.entrance_pupil_offset_m());
        let (mut seen, mut widest) = (0, 0f64);
        for k in 0..160_000 {
            let unit = [k % 400, k / 400].map(|k| (f64::from(k) + 0.5) / 200.0 - 1.0);
            if unit[0].hypot(unit[1]) > 1.0 {
                continue;
            }
            let entrance = unit.map(|x| x * camera.entrance_pupil_radius_m());
            let slope = [0, 1].map(|k| (point[k] - entrance[k]) / depth);
            // Behind the lens, physical coordinates are the negative of upright ones.
            let height = [0, 1].map(|k| entrance[k] - slope[k] * offset);
            let behind = [0, 1].map(|k| slope[k] + height[k] / camera.main_lens().focal_length_m);
            let q = [0, 1].map(|k| -(height[k] - behind[k] * camera.mla_distance_m()));
            let lens = camera.owner(q.map(|x| x * camera.micro_image_scale()));
            let center = camera.lens_center_m(lens);
            if (q[0] - center[0]).hypot(q[1] - center[1]) > camera.array().aperture.half_width_m() {
                continue;
            }
            let focal = camera.microlens_focal_lengths_m()[camera.array().type_of(lens)];
            let gap = camera.array().gap_m;
            let x = [0, 1].map(|k| q[k] + (behind[k] - (q[k] - center[k]) / focal) * gap);
            let found = camera.project(point, lens).expect("in front of the camera");
            let blur = [0, 1].map(|k| (q[k] - center[k]) * found.kappa);
            let arrived = camera.position_px(x);
            let chief = camera.place_m(found.position_px);
            let expected = camera.position_px([chief[0] + blur[0], chief[1] + blur[1]]);
            for axis in 0..2 {
                assert!((arrived[axis] - expected[axis]).abs() < 1e-9, "{arrived:?} {expected:?}");
            }
            let from_chief = [0, 1].map(|k| arrived[k] - found.position_px[k]);
            widest = widest.max(from_chief[0].hypot(from_chief[1]) / found.blur_radius_px.abs());
            seen += 1;
            assert!((found.kappa - camera.kappa(depth, camera.array().type_of(lens))).abs() < 1e-12);
        }
        assert!(seen > 50_000 && (0.98..1.0 + 1e-9).contains(&widest), "{seen} {widest}");
    }
    // Published numbers of the same point of the R12: virtual depth and blur radius.
    let camera = r12(GridSize::new(3068, 4080));
    assert!((camera.virtual_depth(0.3) - 8.894).abs() < 1e-3);
    assert!((camera.blur_radius_px(0.3, 0) - 3.77557).abs() < 1e-4);
    assert_eq!([0, 1, 2].map(|k| camera.mode(k)), [PlenopticMode::Galilean; 3]);
    assert_eq!(illum(GridSize::new(10, 10)).mode(0), PlenopticMode::Unfocused);
    assert!(camera.project([0.0, 0.0, 0.1], MicrolensIndex { row: 0, column: 0 }).is_none());
}

/// Owners are nearest, lines hold every microlens once, and hexagonal neighbors have different types.
#[test]
fn lattices_are_complete() {
    let mut numbers = Numbers(3);
    for grid in [MicrolensGrid::Square, MicrolensGrid::HexRows, MicrolensGrid::HexColumns] {
        for rotation_rad in [0.0, 1e-3, 0.5, PI / 4.0, -2.0] {
            let mut array = MicrolensArray::new(grid, 37e-6, 100e-6);
            (array.rotation_rad, array.offset_m, array.scale_y) = (rotation_rad, [7e-6, -11e-6], 1.01);
            array.aperture = LensAperture::Round { radius_m: 18e-6 };
            array.focus = MicrolensFocus::Lengths(vec![100e-6, 90e-6, 110e-6]);
            let sensor = ImageSensor::new(GridSize::new(120, 200), 5e-6);
            let camera = PlenopticCamera::new(sensor, array, MainLens::new(0.05, 1.2, 1.0)).expect("a camera");
            let rows = 30..90;
            let listed: Vec<MicrolensIndex> = camera
                .lens_lines(rows.clone())
                .flat_map(|line| camera.lenses_on_line(line, rows.clone()).collect::<Vec<_>>())
                .collect();
            let unique: std::collections::BTreeSet<_> = listed.iter().copied().collect();
            assert_eq!(unique.len(), listed.len(), "{grid:?} {rotation_rad}");
            for _ in 0..300 {
                let place = camera.place_m([numbers.next() * 200.0, 30.0 + numbers.next() * 60.0]);
                let owner = camera.owner(place);
                let distance = |lens| {
                    let [x, y] = camera.micro_image_center_m(lens);
                    (x - place[0]).hypot(y - place[1])
                };
                let best = listed.iter().map(|&lens| distance(lens)).fold(f64::INFINITY, f64::min);
                assert!(unique.contains(&owner), "{grid:?} {rotation_rad} {owner:?}");
                assert!(distance(owner) <= best + 1e-12, "{grid:?} {rotation_rad} {owner:?}");
            }
            if grid != MicrolensGrid::Square {
                for &lens in &listed {
                    for other in listed.iter().filter(|&&other| other != lens) {
                        let [a, b] = [lens, *other].map(|lens| camera.lens_center_m(lens));
                        if (a[0] - b[0]).hypot(a[1] - b[1]) < 40e-6 {
                            let [a, b] = [lens, *other].map(|lens| camera.array().type_of(lens));
                            assert_ne!(a, b, "{grid:?} {lens:?} {other:?}");
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn equivalent_rigs_have_published_baselines() {
    let camera = illum(GridSize::new(5368, 7728));
    let equivalent = camera.equivalent_views();
    assert!((equivalent.baseline_m - 0.92695e-3).abs() < 1e-8, "{equivalent:?}");
    assert!((equivalent.slope_per_lens - 0.816_392e-3).abs() < 1e-9, "{equivalent:?}");
    assert!((equivalent.cos4_disparity_px - 0.0051).abs() < 1e-4, "{equivalent:?}");
    let rig = camera.equivalent_rig(GridSize::new(9, 9), GridSize::new(300, 400), 20e-6, 1.0).expect("a rig");
    let (k, focus) = (equivalent.baseline_m / equivalent.slope_per_lens, 1.0 / equivalent.inverse_focus_per_m);
    let expected = k * (1.0 / 0.7 - 1.0 / focus);
    assert!((rig.disparity().from_depth_m(0.7) - expected).abs() < 1e-12);
    let _: Rig = rig;
    assert!(LightFieldShape::new(GridSize::new(9, 9), GridSize::new(300, 400)).is_ok());
}

#[test]
fn impossible_cameras_are_errors() {
    type Change = fn(&mut ImageSensor, &mut MicrolensArray, &mut MainLens);
    let changes: [(&str, Change); 18] = [
        ("sensor rows", |s, _, _| s.size.rows = 0),
        ("sensor", |s, _, _| s.size.columns = usize::MAX),
        ("pixel width", |s, _, _| s.pixel_m = 0.0),
        ("fill", |s, _, _| s.fill = 1.5),
        ("offset of the sensor", |s, _, _| s.offset_m[1] = f64::NAN),
        ("pitch", |_, a, _| a.pitch_m = -1.0),
        ("vertical scale", |_, a, _| a.scale_y = 0.0),
        ("gap", |_, a, _| a.gap_m = f64::INFINITY),
        ("rotation", |_, a, _| a.rotation_rad = f64::NAN),
        ("offset of the microlens array", |_, a, _| a.offset_m[0] = f64::INFINITY),
        ("half width of a microlens", |_, a, _| a.aperture = LensAperture::Round { radius_m: 0.0 }),
        ("overlap", |_, a, _| a.aperture = LensAperture::Round { radius_m: 12e-6 }),
        ("number of focal lengths", |_, a, _| a.focus = MicrolensFocus::Lengths(vec![1e-5; 4])),
        ("focal length of a microlens", |_, a, _| a.focus = MicrolensFocus::Lengths(vec![-1e-5])),
        ("f-number", |_, _, l| l.f_number = 0.0),
        ("focus distance", |_, _, l| l.focus = ArrayFocus::Depth { depth_m: 0.0, virtual_depth: 0.0 }),
        ("main lens", |_, _, l| l.focus = ArrayFocus::Distance { mla_distance_m: -0.01 }),
        ("microlenses", |s, a, _| {
            (s.size, s.pixel_m) = (GridSize::new(1 << 24, 1 << 24), 1e-3);
            (a.pitch_m, a.aperture) = (1e-9, LensAperture::Round { radius_m: 1e-10 });
        }),
    ];
    for (name, change) in changes {
        let sound = illum(GridSize::new(50, 60));
        let (mut sensor, mut array, mut lens) = (*sound.sensor(), sound.array().clone(), sound.main_lens().clone());
        change(&mut sensor, &mut array, &mut lens);
        let error = PlenopticCamera::new(sensor, array, lens).expect_err(name).to_string();
        assert!(error.contains(name), "{name}: {error}");
    }
    // An exit pupil at the focal point is seen at infinity.
    let sound = illum(GridSize::new(50, 60));
    let mut lens = sound.main_lens().clone();
    (lens.focal_length_m, lens.exit_pupil_m) = (0.25, Some(0.25));
    lens.focus = ArrayFocus::Distance { mla_distance_m: 0.5 };
    let error = PlenopticCamera::new(*sound.sensor(), sound.array().clone(), lens).expect_err("a pupil").to_string();
    assert!(error.contains("infinity"), "{error}");
    // Nor can the equivalent rig focus behind itself.
    let mut lens = sound.main_lens().clone();
    lens.focus = ArrayFocus::Depth { depth_m: -2.0, virtual_depth: 0.0 };
    let behind = PlenopticCamera::new(*sound.sensor(), sound.array().clone(), lens).expect("a camera");
    assert!(behind.equivalent_rig(GridSize::new(3, 3), GridSize::new(3, 3), 20e-6, 1.0).is_err());
}

/// Views of a pattern on a plane, from rays through the centers of microlenses: those of the rig, rotated with the array.
#[test]
fn decoded_views_are_those_of_the_rotated_rig() {
    let size = GridSize::new(900, 1000);
    for (grid, rotation_rad, offset_m) in [
        (MicrolensGrid::Square, 0.0, [0.0; 2]),
        (MicrolensGrid::Square, 0.0, [17e-6, -9e-6]),
        (MicrolensGrid::Square, 0.3, [0.0; 2]),
        (MicrolensGrid::HexRows, -0.2, [5e-6, 0.0]),
        (MicrolensGrid::HexColumns, 0.1, [0.0; 2]),
    ] {
        let mut array = MicrolensArray::new(grid, 70e-6, 392e-6);
        (array.rotation_rad, array.offset_m) = (rotation_rad, offset_m);
        let camera = PlenopticCamera::new(ImageSensor::new(size, 5e-6), array, MainLens::new(0.05, 5.6, 0.5));
        let camera = camera.expect("a camera");
        let views = camera.equivalent_views();
        // A disparity of 1.5 px a view.
        let depth = 1.0 / (1.5 * views.slope_per_lens / views.baseline_m + views.inverse_focus_per_m);
        let period = 25.0 * views.slope_per_lens * depth;
        let pattern = |origin: [f64; 2], direction: [f64; 2]| {
            let [x, y] = [0, 1].map(|k| (origin[k] + depth * direction[k]) * 2.0 * PI / period);
            0.5 + 0.25 * (x.cos() + (y + 0.3 * x).sin())
        };
        let raw = ndarray::Array3::from_shape_fn((size.rows, size.columns, 1), |(row, column, _)| {
            let place = camera.place_m([column as f64 + 0.5, row as f64 + 0.5]);
            let lens = camera.owner(place);
            let ray = camera.ray(place, camera.lens_center_m(lens), lens).expect("a thin lens");
            pattern(ray.origin_m, ray.direction) as f32
        });
        let white = ndarray::Array2::from_elem((size.rows, size.columns), 1.0);
        let decoded = camera.decode(raw.view(), white.view(), 9).expect("views");
        assert_eq!(decoded.roll_rad, rotation_rad);
        let mut worst = 0f64;
        for ((v, u, t, s, _), &value) in decoded.light_field.samples().indexed_iter() {
            let ray = decoded.rig.ray(v, u, t, s, 0.5, 0.5);
            let turned = |[x, y, _]: [f64; 3]| super::microlenses::rotate([x, y], rotation_rad);
            let expected = pattern(turned(ray.origin_m), turned(ray.direction));
            worst = worst.max((expected - f64::from(value)).abs());
        }
        println!("{grid:?} {rotation_rad}: {:?}, off by {worst:.4}", decoded.rig.shape().lenses());
        // Linear interpolation of a period of 25: (2 pi / 25)^2 / 8 of each of its three waves, and of 19 along y.
        assert!(worst < 0.015, "{grid:?} {rotation_rad} {offset_m:?}: {worst}");
    }
}
