//! The white image against rays through random points, and closed forms of micro-images.

use super::*;

/// A point of a microlens for a point of the unit square: even points for even points.
pub(super) fn point_of_lens(aperture: LensAperture, [u, v]: [f64; 2]) -> [f64; 2] {
    match aperture {
        LensAperture::Round { radius_m } => {
            let (sin, cos) = (2.0 * PI * v).sin_cos();
            [cos, sin].map(|x| x * radius_m * u.sqrt())
        }
        LensAperture::Square { half_width_m } => [u, v].map(|x| (2.0 * x - 1.0) * half_width_m),
        LensAperture::Hexagon { .. } => {
            // Three rhombi between the center and every other corner.
            let first = (3.0 * u).floor();
            let [a, b] = [first, first + 1.0].map(|k| {
                let (sin, cos) = (k * 2.0 * PI / 3.0).sin_cos();
                [sin, cos].map(|x| x * aperture.outer_radius_m())
            });
            [0, 1].map(|k| (3.0 * u - first) * a[k] + v * b[k])
        }
    }
}

/// The mean of cos^4 over a microlens, which has a closed form, against that of many points.
#[test]
fn the_mean_of_cos4_is_that_of_many_points() {
    let (gap, side) = (37e-6f64, 1200usize);
    let at = |k: usize| (k as f64 + 0.5) / side as f64;
    for part in [0.094, 0.25, 0.5] {
        let half = part * gap;
        for aperture in [
            LensAperture::Round { radius_m: half },
            LensAperture::Square { half_width_m: half },
            LensAperture::Hexagon { half_width_m: half },
        ] {
            let sound = illum(GridSize::new(9, 9));
            let mut array = sound.array().clone();
            (array.pitch_m, array.aperture, array.rotation_rad) = (2.0 * half, aperture, 0.4);
            let camera = PlenopticCamera::new(*sound.sensor(), array, sound.main_lens().clone()).expect("a camera");
            let cos4 = |[x, y]: [f64; 2]| (1.0 + (x * x + y * y) / (gap * gap)).powi(-2);
            let points = (0..side * side).map(|k| point_of_lens(aperture, [at(k % side), at(k / side)]));
            let mean = points.map(cos4).sum::<f64>() / (side * side) as f64;
            let error = camera.central_cos4() / mean - 1.0;
            // The midpoints of 1200 (of 400 in each rhombus) steps leave 1e-7 to 3e-7.
            assert!(error.abs() < 1e-6, "{aperture:?}: {error:e}");
        }
    }
}

/// A round microlens of luminance L gives the point behind its center the illuminance pi L sin^2(angle of its edge).
#[test]
fn electrons_are_those_of_the_illuminance_behind_a_microlens() {
    let sound = illum(GridSize::new(9, 9));
    for (radius_m, fill) in [(1e-6f64, 1.0f64), (10e-6, 0.8)] {
        let (mut sensor, mut array) = (*sound.sensor(), sound.array().clone());
        (sensor.fill, array.aperture) = (fill, LensAperture::Round { radius_m });
        let gap = array.gap_m;
        let camera = PlenopticCamera::new(sensor, array, sound.main_lens().clone()).expect("a camera");
        let illuminance_lx = PI * 1000.0 * radius_m * radius_m / (radius_m * radius_m + gap * gap);
        // 4.09e15 photons a lumen and second, for 10 ms, half of which a square of fill x 1.4 um counts.
        let expected = 4.09e15 * illuminance_lx * 0.01 * 0.5 * (fill * 1.4e-6).powi(2);
        let found = camera.photometric_electrons(1000.0, 0.01, 0.5);
        // Rounding.
        assert!((found / expected - 1.0).abs() < 1e-12, "{radius_m}: {found} {expected}");
    }
}

/// What a camera lets through, by rays: the light of a pixel relative to the center of an unvignetted micro-image.
fn traced(camera: &PlenopticCamera, numbers: &mut Numbers, [column, row]: [usize; 2], side: usize) -> f64 {
    let (array, pixel) = (camera.array(), camera.sensor().pixel_m * camera.sensor().fill);
    let middle = camera.place_m([column as f64 + 0.5, row as f64 + 0.5]);
    let owner = camera.owner(middle);
    let outer = if array.has_clear_gaps { 0.6 * array.pitch_m } else { array.aperture.outer_radius_m() };
    let mut sum = 0.0;
    for (dr, dc) in (-2..=2).flat_map(|dr| (-2..=2).map(move |dc| (dr, dc))) {
        let lens = MicrolensIndex { row: owner.row + dr, column: owner.column + dc };
        let center = camera.lens_center_m(lens);
        for k in 0..side * side {
            let unit = [k % side, k / side].map(|k| (k as f64 + numbers.next()) / side as f64 * 2.0 - 1.0);
            let point = unit.map(|x| x * outer);
            let x = middle.map(|x| numbers.around(x, pixel));
            let q = [center[0] + point[0], center[1] + point[1]];
            let focal = match crate::plenoptic::lune::is_in_lens(array.aperture, array.rotation_rad, point) {
                true => camera.microlens_focal_lengths_m()[array.type_of(lens)],
                // Beside the microlens, and nearer to it than to its neighbors.
                false if array.has_clear_gaps => {
                    let away = |other: MicrolensIndex| {
                        let other = camera.lens_center_m(other);
                        (other[0] - q[0]).hypot(other[1] - q[1])
                    };
                    let near = (-1..=1).flat_map(|r| (-1..=1).map(move |c| (r, c)));
                    let neighbors = near.map(|(r, c)| MicrolensIndex { row: lens.row + r, column: lens.column + c });
                    if neighbors.clone().any(|other| away(other) < away(lens)) {
                        continue;
                    }
                    f64::INFINITY
                }
                false => continue,
            };
            let ray = refracted(camera, x, q, lens, focal).0;
            let undistorted = camera.main_lens().distortion.undistorted(q);
            let slope = camera.microlens(lens).pupils.slope_per_m;
            let direction = [0, 1].map(|k| ray.direction[k] + slope * (undistorted[k] - q[k]));
            let stops = camera.main_lens().stops.iter().all(|stop| {
                let depth = stop.distance_m - camera.entrance_pupil_offset_m();
                let at = [0, 1].map(|k| ray.origin_m[k] + depth * direction[k]);
                at[0].hypot(at[1]) <= stop.diameter_m / 2.0
            });
            let in_pupil = camera.main_lens().aperture.contains(ray.origin_m, camera.entrance_pupil_radius_m());
            sum += if in_pupil && stops { cos4(camera, x, q, lens) } else { 0.0 };
        }
    }
    sum / (side * side) as f64 * 4.0 * outer * outer / array.aperture.area_m2() / camera.central_cos4()
}

/// The white image against rays: unvignetted, vignetted, overlapping, of several shapes, tilted, with stops and gaps.
#[test]
fn the_white_image_is_the_light_that_rays_bring() {
    let mut numbers = Numbers(7);
    let size = GridSize::new(60, 60);
    let with = |camera: PlenopticCamera, change: &dyn Fn(&mut MicrolensArray, &mut MainLens)| {
        let (mut array, mut lens, mut sensor) = (camera.array().clone(), camera.main_lens().clone(), *camera.sensor());
        sensor.offset_m = [3e-3, 2e-3];
        change(&mut array, &mut lens);
        PlenopticCamera::new(sensor, array, lens).expect("a camera")
    };
    let square = |half_width_m| LensAperture::Square { half_width_m };
    let polygon = |blades| PupilShape::Polygon { blades, rotation_rad: 0.4 };
    let stop = Stop { distance_m: 0.03, diameter_m: 0.0125 };
    let mut sparse = r12(size).sensor().to_owned();
    sparse.fill = 0.6;
    let sparse = PlenopticCamera::new(sparse, r12(size).array().clone(), r12(size).main_lens().clone());
    for (name, camera) in [
        ("illum", with(illum(size), &|_, _| {})),
        ("r12", with(r12(size), &|_, _| {})),
        ("overlap", with(sparse.expect("a camera"), &|_, l| l.f_number = 2.0)),
        ("square", with(illum(size), &|a, l| (a.aperture, l.aperture) = (square(10e-6), PupilShape::Square))),
        ("square and disc", with(r12(size), &|a, _| a.aperture = square(50e-6))),
        (
            "hexagon",
            with(r12(size), &|a, l| {
                a.aperture = LensAperture::Hexagon { half_width_m: 60e-6 };
                (l.aperture, l.f_number) = (PupilShape::Square, 5.0);
            }),
        ),
        ("five blades", with(illum(size), &|_, l| l.aperture = polygon(5))),
        ("seven blades, focused", with(r12(size), &|_, l| l.aperture = polygon(7))),
        ("tilted", with(r12(size), &|a, _| a.tilt_rad = [0.02, -0.01])),
        ("stop", with(illum(size), &|_, l| l.stops = vec![stop])),
        (
            "stop and distortion",
            with(r12(size), &|_, l| {
                l.stops = vec![Stop { distance_m: 0.06, diameter_m: 0.0145 }];
                l.distortion.radial = [300.0, 0.0, 0.0];
            }),
        ),
        (
            "clear gaps",
            with(illum(size), &|a, _| {
                (a.aperture, a.has_clear_gaps) = (LensAperture::Round { radius_m: 7e-6 }, true);
            }),
        ),
    ] {
        let white = camera.white_image().expect("memory");
        let (mut total, mut expected_total, mut worst) = (0.0, 0.0, 0f64);
        // Gaps let little light through: more points.
        let side = if camera.array().has_clear_gaps { 40 } else { 36 };
        for (row, column) in (0..60).step_by(3).flat_map(|row| (0..60).step_by(4).map(move |column| (row, column))) {
            let traced = traced(&camera, &mut numbers, [column, row], side);
            let value = f64::from(white[[row, column]]);
            worst = worst.max((traced - value).abs());
            (total, expected_total) = (total + value, expected_total + traced);
        }
        println!("{name}: mean {:.5} of the light, worst pixel {worst:.4}, sum {total:.1}", total / expected_total);
        // 1296 points a pixel and microlens, stratified over the microlens and random over the pixel: their standard error
        // is some 0.015 at edges, where 0.1 are seven of them, and 5e-4 of the sum, where 2e-3 are four.
        assert!((total / expected_total - 1.0).abs() < 2e-3 && worst < 0.1, "{name}: {total} {expected_total} {worst}");
        // Nothing outside of the listed pixels.
        for line in camera.lens_lines(0..60) {
            for lens in camera.lenses_on_line(line, 0..60) {
                for (row, columns) in camera.lit_pixels(&camera.microlens(lens), 0..60) {
                    assert!(row < 60 && columns.end <= 60, "{name}: {row} {columns:?}");
                }
            }
        }
    }
}

/// The light of a pixel in which micro-images overlap, by many points of pixel and microlenses; else `None`.
fn overlapping(camera: &PlenopticCamera, numbers: &mut Numbers, [column, row]: [usize; 2]) -> Option<f64> {
    const ON_LENS: usize = 24;
    const ON_PIXEL: usize = 12;
    let (array, pixel) = (camera.array(), camera.sensor().pixel_m);
    let (gap, exit, radius) = (array.gap_m, camera.exit_pupil_m(), camera.exit_pupil_radius_m());
    let middle = camera.place_m([column as f64 + 0.5, row as f64 + 0.5]);
    let owner = camera.owner(middle);
    let around = (-1..=1).flat_map(|dr| (-1..=1).map(move |dc| (dr, dc)));
    let neighbors = around.map(|(dr, dc)| MicrolensIndex { row: owner.row + dr, column: owner.column + dc });
    let reaches = |lens: &MicrolensIndex| {
        let center = camera.micro_image_center_m(*lens);
        (center[0] - middle[0]).hypot(center[1] - middle[1]) < camera.micro_image_radii_m(0)[2] + pixel
    };
    let (mut light, mut lit) = (0.0, 0);
    for lens in neighbors.filter(reaches) {
        let (center, focal) = (camera.lens_center_m(lens), camera.microlens_focal_lengths_m()[array.type_of(lens)]);
        let mut sum = 0.0;
        for k in 0..ON_LENS * ON_LENS {
            let unit = [k % ON_LENS, k / ON_LENS].map(|k| (k as f64 + numbers.next()) / ON_LENS as f64);
            let from_center = point_of_lens(array.aperture, unit);
            let q = [0, 1].map(|axis| center[axis] + from_center[axis]);
            for n in 0..ON_PIXEL * ON_PIXEL {
                let unit = [n % ON_PIXEL, n / ON_PIXEL].map(|n| (n as f64 + numbers.next()) / ON_PIXEL as f64);
                let x = [0, 1].map(|axis| middle[axis] + (unit[axis] - 0.5) * pixel);
                let slope = [0, 1].map(|axis| (q[axis] - x[axis]) / gap - from_center[axis] / focal);
                let pupil = [0, 1].map(|axis| -(q[axis] + exit * slope[axis]));
                if camera.main_lens().aperture.contains(pupil, radius) {
                    sum += (1.0 + ((q[0] - x[0]).powi(2) + (q[1] - x[1]).powi(2)) / (gap * gap)).powi(-2);
                }
            }
        }
        light += sum / (ON_LENS * ON_LENS * ON_PIXEL * ON_PIXEL) as f64;
        lit += usize::from(sum > 0.0);
    }
    (lit > 1).then(|| light / camera.central_cos4())
}

/// Where micro-images overlap, edges cross every pixel. A point of a microlens that is nearer to the pixel gives it
/// more light, and lights more of it.
#[test]
fn overlapping_micro_images_have_their_light() {
    let mut numbers = Numbers(23);
    let size = GridSize::new(16, 16);
    let pleno = Preset::by_name("pleno-upcs").expect("a preset").camera().expect("a camera");
    let with = |camera: &PlenopticCamera, change: &dyn Fn(&mut ImageSensor, &mut MicrolensArray, &mut MainLens)| {
        let (mut sensor, mut array, mut lens) = (*camera.sensor(), camera.array().clone(), camera.main_lens().clone());
        sensor.size = size;
        change(&mut sensor, &mut array, &mut lens);
        PlenopticCamera::new(sensor, array, lens).expect("a camera")
    };
    let half_width_m = 10e-6;
    for (name, camera) in [
        ("pleno-upcs", with(&pleno, &|_, _, _| {})),
        ("pleno-upcs, aside", with(&pleno, &|s, _, _| s.offset_m = [3e-3, -2e-3])),
        (
            "square",
            with(&pleno, &|_, a, l| {
                (a.aperture, l.aperture) = (LensAperture::Square { half_width_m }, PupilShape::Square);
            }),
        ),
        ("hexagon", with(&pleno, &|_, a, _| a.aperture = LensAperture::Hexagon { half_width_m })),
        ("illum, f/1.7", with(&illum(size), &|_, _, l| l.f_number = 1.7)),
    ] {
        let white = camera.white_image().expect("memory");
        let (mut total, mut expected_total, mut worst, mut count) = (0.0, 0.0, 0f64, 0);
        for (row, column) in (0..16).flat_map(|row| (0..16).map(move |column| (row, column))) {
            let Some(expected) = overlapping(&camera, &mut numbers, [column, row]) else { continue };
            let value = f64::from(white[[row, column]]);
            worst = worst.max((value - expected).abs());
            (total, expected_total, count) = (total + value, expected_total + expected, count + 1);
        }
        let error = total / expected_total - 1.0;
        println!("{name}: {count} pixels, {error:.1e} of their light, worst pixel {worst:.1e}");
        // The points have a standard error of 5e-4 in a pixel and of up to 1.5e-4 in the sum; the white image is within
        // 1e-3 and 2e-4. Without the variation of cos^4 over the microlens, 3e-3 of the light of pleno-upcs is missing.
        assert!(count > 20 && error.abs() < 7e-4 && worst < 3e-3, "{name}: {count} {error} {worst}");
    }
}

/// A camera that equals its mirror images has a white image that does. Points of a pixel and a microlens that lean to one
/// side show here and not in sums.
#[test]
fn symmetric_cameras_have_symmetric_white_images() {
    let pleno = Preset::by_name("pleno-upcs").expect("a preset").camera().expect("a camera");
    let of = |camera: PlenopticCamera, f_number: f64| {
        let sensor = ImageSensor { size: GridSize::new(40, 40), ..*camera.sensor() };
        let mut array = camera.array().clone();
        (array.rotation_rad, array.offset_m) = (0.0, [0.0; 2]);
        array.focus = MicrolensFocus::Lengths(vec![camera.microlens_focal_lengths_m()[0]]);
        PlenopticCamera::new(sensor, array, MainLens { f_number, ..camera.main_lens().clone() }).expect("a camera")
    };
    let size = GridSize::new(40, 40);
    for (name, camera) in [
        ("wide edges", of(pleno.clone(), pleno.main_lens().f_number)),
        ("wide edges, f/6", of(pleno, 6.0)),
        ("illum", of(illum(size), 2.0)),
        ("r12", of(r12(size), 8.0)),
    ] {
        let white = camera.white_image().expect("memory");
        let mut worst = [0f32; 2];
        for ((row, column), value) in white.indexed_iter() {
            let mirrored = [white[[39 - row, column]], white[[row, 39 - column]]];
            worst = [0, 1].map(|axis| worst[axis].max((value - mirrored[axis]).abs()));
        }
        let mean = white.mean().unwrap_or(0.0);
        println!("{name}: off by {worst:?} of {mean}");
        // A rounding of f32.
        assert!(mean > 0.01 && worst.iter().all(|&worst| worst < 2e-7), "{name}: {worst:?} of {mean}");
    }
}

/// Closed forms of micro-images: their pitch, centers, and energy, whatever alpha is.
#[test]
fn micro_images_have_their_energy_and_pitch() {
    for (camera, name) in [(illum(GridSize::new(150, 150)), "illum"), (r12(GridSize::new(240, 240)), "r12")] {
        let white = camera.white_image().expect("memory");
        let (pixel, side) = (camera.sensor().pixel_m, camera.sensor().size.rows);
        let pitch = camera.micro_image_pitch_px();
        let scale = camera.array().gap_m / camera.exit_pupil_m();
        let energy = PI * (scale * camera.exit_pupil_radius_m() / pixel).powi(2);
        let mut seen = 0;
        for line in camera.lens_lines(0..side) {
            for lens in camera.lenses_on_line(line, 0..side) {
                let [x, y] = camera.micro_image_center_px(lens);
                let reach = pitch / 2.0 + 1.5;
                let inside = |z: f64| z > reach && z < side as f64 - reach;
                if !(inside(x) && inside(y)) {
                    continue;
                }
                let mut moments = [0.0; 3];
                for (row, columns) in camera.lit_pixels(&camera.microlens(lens), 0..side) {
                    for column in columns {
                        let at = [column as f64 + 0.5, row as f64 + 0.5];
                        if camera.owner(camera.place_m(at)) == lens {
                            // Without cos^4, whose mean is over the lit part of the microlens.
                            let (place, center) = (camera.place_m(at), camera.lens_center_m(lens));
                            let region = camera.lit_region(place, lens);
                            let unit = |k: usize| [k % 6, k / 6].map(|k| (k as f64 + 0.5) / 6.0);
                            let points: Vec<_> = (0..36).filter_map(|k| region.point(unit(k))).collect();
                            let cos4 = |[x, y]: &[f64; 2]| cos4(&camera, place, [center[0] + x, center[1] + y], lens);
                            let mean = points.iter().map(cos4).sum::<f64>() / points.len().max(1) as f64;
                            let mean = if points.is_empty() { camera.central_cos4() } else { mean };
                            let value = f64::from(white[[row, column]]) * camera.central_cos4() / mean;
                            [1.0, at[0], at[1]].iter().zip(&mut moments).for_each(|(z, sum)| *sum += value * z);
                        }
                    }
                }
                let [sum, mx, my] = moments;
                // The mean of cos^4 over a microlens is not that of its center.
                assert!(
                    (mx / sum - x).abs() < 0.02 && (my / sum - y).abs() < 0.02,
                    "{name}: {} {} at {x} {y}",
                    mx / sum,
                    my / sum
                );
                // The mean of cos^4 is that of the pixel's center, half a percent off where an edge crosses it.
                assert!((sum / energy - 1.0).abs() < 0.01, "{name}: {sum} {energy}");
                seen += 1;
            }
        }
        assert!(seen > 50, "{name}: {seen}");
    }
    assert!((illum(GridSize::new(9, 9)).micro_image_pitch_px() - 14.291_147).abs() < 1e-6);
    assert!((r12(GridSize::new(9, 9)).micro_image_pitch_px() - 23.306_426).abs() < 1e-6);
    let radii = r12(GridSize::new(9, 9)).micro_image_radii_m(0).map(|radius| radius / 5.5e-6);
    for (found, published) in radii.into_iter().zip([1.3271, 6.4718, 11.6165]) {
        assert!((found - published).abs() < 1e-4, "{radii:?}");
    }
}
