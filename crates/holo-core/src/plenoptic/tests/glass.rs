//! Cameras with a main lens of glass: rays, bounds of the light and white images.

use super::*;

/// A camera of microlenses of f/4 behind an objective, 24 mm wide.
fn behind(name: &str, f_number: Option<f64>) -> PlenopticCamera {
    tilted(name, f_number, 0.0)
}

/// The same with a tilted array.
fn tilted(name: &str, f_number: Option<f64>, tilt_rad: f64) -> PlenopticCamera {
    let mut lens = Objective::by_name(name).expect("an objective").prescription().expect("a lens");
    if let Some(f_number) = f_number {
        lens = lens.stopped_down(f_number).expect("a closed lens");
    }
    let focus = ArrayFocus::Depth { depth_m: 1.5, virtual_depth: 0.0 };
    let mut array = MicrolensArray::new(MicrolensGrid::HexRows, 100e-6, 300e-6);
    array.tilt_rad = [tilt_rad, -0.7 * tilt_rad];
    let sensor = ImageSensor::new(GridSize::new(1600, 2400), 10e-6);
    PlenopticCamera::new(sensor, array, MainLens::of_glass(lens, focus)).expect("a camera")
}

const NAMES: [&str; 8] = [
    "double-gauss",
    "double-gauss-baker",
    "double-gauss-fast",
    "petzval",
    "retrofocus",
    "telephoto",
    "tessar",
    "triplet",
];

/// Light passes nowhere outside of the discs that rays are sampled in, and where the table says so.
#[test]
fn the_table_holds_all_light() {
    let mut numbers = Numbers(5);
    for (name, tilt_rad) in NAMES.map(|name| (name, 0.0)).into_iter().chain([("double-gauss", 5e-3)]) {
        let camera = tilted(name, None, tilt_rad);
        let glass = camera.glass.as_ref().expect("a lens of glass");
        let (mut lit, mut sampled, mut wrong, mut count, mut astray) = (0, 0, 0, 0, 0f64);
        for _ in 0..20_000 {
            let x = camera.place_m([numbers.next() * 2400.0, numbers.next() * 1600.0]);
            let lens = camera.microlens(camera.owner(x));
            let reach = 2.0 * camera.exit_pupil_radius_m() * lens.gap_m / lens.exit_pupil_m();
            let on_sensor = [numbers.around(0.0, 2.0 * reach), numbers.around(0.0, 2.0 * reach)];
            let on_lens = [numbers.around(0.0, 70e-6), numbers.around(0.0, 70e-6)];
            let passes = camera.relative_ray(&lens, on_sensor, on_lens).is_some();
            let in_pupil = [0, 1].map(|k| {
                lens.exit_pupil_m() / lens.gap_m * on_sensor[k] - lens.alpha * on_lens[k] - lens.pupil.center_m[k]
            });
            let within = in_pupil[0].hypot(in_pupil[1]) <= lens.pupil.radius_m;
            assert!(within || !passes, "{name}: light outside of the disc, {lens:?} {on_sensor:?}");
            let inner = (in_pupil[0] + lens.pupil.center_m[0]).hypot(in_pupil[1] + lens.pupil.center_m[1]);
            assert!(passes || inner > lens.pupil.inner_m, "{name}: darkness within the inner disc, {lens:?}");
            count += 1;
            lit += usize::from(passes);
            sampled += usize::from(within);
            let [place, slope] = camera.to_glass(&lens, on_sensor, on_lens);
            let within_m = glass.table().within_m(place, slope);
            if (within_m >= 0.0) != passes {
                wrong += 1;
                astray = astray.max(within_m.abs() / camera.exit_pupil_radius_m());
            }
        }
        let (lost, wrong) = (1.0 - lit as f64 / sampled as f64, wrong as f64 / lit as f64);
        println!(
            "{name}: {:.1} % of sampled rays are stopped, {:.3} % of the table wrong, by {astray:.1e} of the pupil",
            100.0 * lost,
            100.0 * wrong
        );
        assert!(count > 0 && lit > 1000, "{name}: {lit}");
        assert!(wrong < 3e-3, "{name}: {wrong}");
        // The edge of the table is the edge of the light as nearly as its documentation says.
        assert!(astray < 5e-3, "{name}: {astray}");
    }
}

/// Chief rays pass the middle of the stop, and points are seen where their rays come from.
#[test]
fn points_are_seen_through_glass() {
    let mut numbers = Numbers(6);
    for (name, tilt_rad) in NAMES.map(|name| (name, 0.0)).into_iter().chain([("double-gauss", 5e-3)]) {
        let camera = tilted(name, Some(8.0), tilt_rad);
        let glass = camera.glass.as_ref().expect("a lens of glass");
        let mut seen = 0;
        for round in 0..120 {
            let x = camera.place_m([numbers.next() * 2400.0, numbers.next() * 1600.0]);
            let lens = camera.owner(x);
            let center = camera.lens_center_m(lens);
            // The microlens that owns a place is the nearest one there.
            let owner = camera.micro_image_center_m(lens);
            let away = (owner[0] - x[0]).hypot(owner[1] - x[1]);
            assert!(away <= 0.6 * camera.micro_image_pitch_px() * camera.sensor().pixel_m, "{name}: {away}");
            let miss = if tilt_rad == 0.0 { glass.stop_miss_m(center) } else { 0.0 };
            assert!(miss.abs() < 1e-12, "{name}: {miss}");
            // Most places lie in the dark around the images of a pupil that is closed to f/8: this one lies in the light.
            let x = [0, 1].map(|k| owner[k] + 0.3 * (x[k] - owner[k]));
            let Some(ray) = camera.ray(x, center, lens) else { continue };
            for depth in [0.8, 4.0, 60.0] {
                let point = [0, 1].map(|k| ray.origin_m[k] + depth * ray.direction[k]);
                let found = camera
                    .project([point[0], point[1], -depth], lens)
                    .unwrap_or_else(|| panic!("{name} at {depth}: no image of {x:?}, {:?}", camera.microlens(lens)))
                    .position_px;
                let expected = camera.position_px(x);
                let away = (found[0] - expected[0]).hypot(found[1] - expected[1]);
                assert!(away < 1e-6, "{name} at {depth}: {found:?} {expected:?}");
                seen += 1;
                if round % 100 > 0 {
                    continue;
                }
                let all = camera.lenses_seeing([point[0], point[1], -depth], 6.0);
                let middle = camera.micro_image_center_px(lens);
                let on_sensor = (0.0..2400.0).contains(&middle[0]) && (0.0..1600.0).contains(&middle[1]);
                let near = on_sensor && (expected[0] - middle[0]).hypot(expected[1] - middle[1]) <= 6.0;
                assert!(!near || all.contains(&lens), "{name} at {depth}: {} lenses", all.len());
            }
        }
        assert!(seen > 150, "{name}: {seen}");
    }
}

/// Near the axis, a lens of glass is the thin lens of its focal length and pupils.
#[test]
fn glass_is_thin_near_the_axis() {
    for name in NAMES {
        let camera = behind(name, None);
        let thin = MainLens {
            prescription: None,
            focus_group: None,
            focus: ArrayFocus::Distance { mla_distance_m: camera.mla_distance_m() },
            ..camera.main_lens().clone()
        };
        let thin = PlenopticCamera::new(*camera.sensor(), camera.array().clone(), thin).expect("a thin lens");
        assert!((thin.entrance_pupil_radius_m() / camera.entrance_pupil_radius_m() - 1.0).abs() < 1e-12, "{name}");
        let lens = MicrolensIndex { row: 0, column: 0 };
        let mut last = f64::INFINITY;
        // What is left falls as the square of the distance from the axis.
        for step in [1e-2, 1e-3] {
            let x = [step * 300e-6, -0.5 * step * 300e-6];
            let q = [step * 30e-6, step * 20e-6];
            let [a, b] = [&camera, &thin].map(|camera| camera.ray(x, q, lens).expect("light near the axis"));
            let size = step * camera.exit_pupil_m();
            let away = (0..2)
                .map(|k| (a.origin_m[k] - b.origin_m[k]).abs().max((a.direction[k] - b.direction[k]).abs()))
                .fold(0.0, f64::max)
                / size;
            assert!(away.is_finite() && (away < 0.02 * last || away < 1e-9), "{name}: {away} {last}");
            last = away;
        }
    }
}

/// The white image is the light that rays bring: of places and points of microlenses at random.
#[test]
fn white_images_are_those_of_glass() {
    let mut numbers = Numbers(7);
    for name in ["double-gauss", "retrofocus"] {
        let camera = behind(name, None);
        let relative = 1.0 / camera.central_cos4();
        for (row, column) in [(803, 1205), (40, 60), (300, 500), (1590, 1200), (810, 2380)] {
            let rows = camera.white_rows(row..row + 8).expect("rows");
            let white: f64 = (0..64).map(|k| f64::from(rows[[k / 8, column + k % 8]])).sum::<f64>() / 64.0;
            // The same by rays through all of the array that may light the pixels.
            let (mut sum, count) = (0.0, 40_000);
            for _ in 0..count {
                let x = camera.place_m([column as f64 + 8.0 * numbers.next(), row as f64 + 8.0 * numbers.next()]);
                let owner = camera.owner(x);
                for k in 0..25 {
                    let index = MicrolensIndex { row: owner.row + k / 5 - 2, column: owner.column + k % 5 - 2 };
                    let lens = camera.microlens(index);
                    let (radius, angle) = (50e-6 * numbers.next().sqrt(), 2.0 * PI * numbers.next());
                    let on_lens = [radius * angle.cos(), radius * angle.sin()];
                    let on_sensor = [0, 1].map(|k| x[k] - lens.image_center_m[k]);
                    if camera.relative_ray(&lens, on_sensor, on_lens).is_some() {
                        sum += camera.relative_cos4(&lens, on_sensor, on_lens) * relative;
                    }
                }
            }
            let traced = sum / f64::from(count);
            // The noise of 40,000 rays is 0.5 % at most where half of them pass; two of its standard deviations, and 0.1 % of the
            // light at edges for the table.
            assert!((white - traced).abs() < 0.012, "{name} at {row}, {column}: {white} {traced}");
        }
    }
}

/// Steps of evenly spread points in four dimensions.
const SPACE_STEPS: [f64; 4] =
    [0.856_674_883_854_502_9, 0.733_891_856_627_126, 0.628_706_721_037_806_4, 0.538_597_256_661_187];

/// So is each pixel of micro-images with wide edges: microlenses that do not image the pupil.
#[test]
fn pixels_of_focused_cameras_are_those_of_glass() {
    let preset = Preset::by_name("raytrix-r12-a").expect("a preset").camera().expect("a camera");
    let mut numbers = Numbers(11);
    for name in ["double-gauss", "telephoto"] {
        let lens = Objective::by_name(name).expect("an objective").prescription().expect("a lens");
        let lens = lens.stopped_down(4.0).unwrap_or(lens);
        let lens = MainLens::of_glass(lens, ArrayFocus::Depth { depth_m: 2.0, virtual_depth: 2.0 });
        for aperture in [LensAperture::Round { radius_m: 63e-6 }, LensAperture::Square { half_width_m: 50e-6 }] {
            let mut array = preset.array().clone();
            (array.aperture, array.rotation_rad) = (aperture, 0.3);
            let camera = PlenopticCamera::new(*preset.sensor(), array, lens.clone()).expect("a camera");
            let relative = 1.0 / camera.central_cos4();
            let (mut squares, mut sum, mut count) = (0.0, 0.0, 0);
            for _ in 0..30 {
                let [row, column] = [numbers.next() * 3000.0, numbers.next() * 4000.0].map(|x| x as usize);
                let white = f64::from(camera.white_rows(row..row + 1).expect("a row")[[0, column]]);
                let owner = camera.owner(camera.place_m([column as f64 + 0.5, row as f64 + 0.5]));
                let rays = 4000;
                let mut light = 0.0;
                for k in 0..25 {
                    let lens = camera
                        .microlens(MicrolensIndex { row: owner.row + k / 5 - 2, column: owner.column + k % 5 - 2 });
                    for ray in 0..rays {
                        let [a, b, c, d] =
                            SPACE_STEPS.map(|step| ((f64::from(ray) + 0.5) * step + 0.1 * f64::from(k)).fract());
                        let on_lens = super::white::point_of_lens(aperture, [a, b]);
                        let on_lens = crate::plenoptic::microlenses::rotate(on_lens, 0.3);
                        let x = camera.place_m([column as f64 + c, row as f64 + d]);
                        let on_sensor = [0, 1].map(|k| x[k] - lens.image_center_m[k]);
                        if camera.relative_ray(&lens, on_sensor, on_lens).is_some() {
                            light += camera.relative_cos4(&lens, on_sensor, on_lens) * relative / f64::from(rays);
                        }
                    }
                }
                (squares, sum, count) = (squares + (white - light).powi(2), sum + white - light, count + 1);
                assert!((white - light).abs() < 0.02, "{name} {aperture:?} at {row}, {column}: {white} {light}");
            }
            let (deviation, mean) = ((squares / f64::from(count)).sqrt(), sum / f64::from(count));
            println!("{name} {aperture:?}: {deviation:.4} a pixel, {mean:+.5} in the mean");
            assert!(deviation < 5e-3 && mean.abs() < 1e-3, "{name} {aperture:?}: {deviation} {mean}");
        }
    }
}

/// So is all of the light far from the axis, where it ends within the sensor and pixels are as wide as it is.
#[test]
fn light_that_ends_is_that_of_glass() {
    let array = MicrolensArray::new(MicrolensGrid::Square, 280e-6, 800e-6);
    let mut sensor = ImageSensor::new(GridSize::new(72, 80), 50e-6);
    sensor.offset_m = [22e-3, 9e-3];
    let lens = Objective::by_name("double-gauss").expect("an objective").prescription().expect("a lens");
    let lens = MainLens::of_glass(lens, ArrayFocus::Depth { depth_m: 1.5, virtual_depth: 0.0 });
    let camera = PlenopticCamera::new(sensor, array, lens).expect("a camera");
    let white = camera.white_image().expect("memory");
    let relative = 1.0 / camera.central_cos4();
    let rays = 400;
    let (mut squares, mut light_of_all, mut white_of_all) = (0.0, 0.0, 0.0);
    let every_third = white.indexed_iter().filter(|((row, column), _)| row % 3 == 0 && column % 3 == 0);
    let count = every_third.clone().count();
    for ((row, column), &white) in every_third {
        let owner = camera.owner(camera.place_m([column as f64 + 0.5, row as f64 + 0.5]));
        let mut light = 0.0;
        for k in 0..25 {
            let lens =
                camera.microlens(MicrolensIndex { row: owner.row + k / 5 - 2, column: owner.column + k % 5 - 2 });
            for ray in 0..rays {
                let shift = [row, column, 1, 1].map(|x| x as f64);
                let [a, b, c, d] = [0, 1, 2, 3].map(|axis| {
                    ((f64::from(ray) + 0.5) * SPACE_STEPS[axis] + shift[axis] * SPACE_STEPS[3 - axis]).fract()
                });
                let on_lens = super::white::point_of_lens(camera.array().aperture, [a, b]);
                let x = camera.place_m([column as f64 + c, row as f64 + d]);
                let on_sensor = [0, 1].map(|k| x[k] - lens.image_center_m[k]);
                if camera.relative_ray(&lens, on_sensor, on_lens).is_some() {
                    light += camera.relative_cos4(&lens, on_sensor, on_lens) * relative / f64::from(rays);
                }
            }
        }
        let white = f64::from(white);
        squares += (white - light).powi(2);
        (light_of_all, white_of_all) = (light_of_all + light, white_of_all + white);
    }
    let deviation = (squares / count as f64).sqrt();
    println!("{:.6} of the light, {deviation:.4} a pixel", light_of_all / white_of_all);
    // The deviation is that of 400 rays.
    assert!(deviation < 4e-3 && (light_of_all / white_of_all - 1.0).abs() < 5e-4, "{light_of_all} {white_of_all}");
}

/// Light of other wavelengths is refracted otherwise, by glass only.
#[test]
fn glass_disperses() {
    let camera = behind("double-gauss", Some(4.0));
    let blue = camera.at_wavelength(450.0).expect("a camera");
    let lens = MicrolensIndex { row: 30, column: 60 };
    let center = camera.lens_center_m(lens);
    let x = camera.micro_image_center_m(lens);
    let [yellow, blue] = [&camera, &blue].map(|camera| camera.ray(x, center, lens).expect("light"));
    let away = (yellow.direction[0] - blue.direction[0]).abs();
    assert!(away > 1e-6 && away < 1e-3, "{away}");
    let thin = illum(GridSize::new(100, 100));
    assert_eq!(thin.at_wavelength(450.0).expect("a camera"), thin);
    assert!(camera.at_wavelength(f64::NAN).is_err());
}

/// A ray behind a tilted array is that of the same light without the tilt.
#[test]
fn tilt_moves_microlenses_along_the_light() {
    let mut numbers = Numbers(8);
    let (camera, flat) = (tilted("double-gauss", None, 8e-3), behind("double-gauss", None));
    let glass = flat.glass.as_ref().expect("a lens of glass");
    for _ in 0..300 {
        let x = camera.place_m([numbers.next() * 2400.0, numbers.next() * 1600.0]);
        let lens = camera.microlens(camera.owner(x));
        let raised = lens.gap_m - 300e-6;
        let q = [0, 1].map(|k| lens.center_m[k] + numbers.around(0.0, 60e-6));
        let Some(ray) = camera.ray(x, q, lens.index) else { continue };
        // Between microlens and main lens by the law of a thin lens.
        let slope = [0, 1].map(|k| (q[k] - x[k]) / lens.gap_m - (q[k] - lens.center_m[k]) / 300e-6);
        let on_flat = [0, 1].map(|k| [q[k] - raised * slope[k]]);
        let expected = glass.trace(on_flat, slope.map(|x| [x]));
        for k in 0..2 {
            assert!((ray.origin_m[k] - expected.origin_m[k][0]).abs() < 1e-12, "{ray:?} {expected:?}");
            assert!((ray.direction[k] - expected.direction[k][0]).abs() < 1e-12, "{ray:?} {expected:?}");
        }
    }
}

/// What is reported over the field, by ways of its own: third-order theory near the axis, and a lens of one surface.
#[test]
fn aberrations_are_those_of_the_glass() {
    // A hyperboloid with its stop at the plane collimates the light of its focus, so its spot on the axis is a point, and its field
    // is curved.
    let medium = Medium::Abbe { nd: 1.6, vd: Some(50.0) };
    let surfaces = vec![
        Surface { is_stop: true, ..Surface::sphere(0.0, 0.005, 0.01, medium) },
        Surface { conic: -1.6 * 1.6, ..Surface::sphere(-0.03, 0.0, 0.02, Medium::Air) },
    ];
    let focus = ArrayFocus::Depth { depth_m: f64::INFINITY, virtual_depth: 0.0 };
    let lens = MainLens::of_glass(Prescription::new(surfaces).expect("a lens"), focus);
    let sensor = ImageSensor::new(GridSize::new(800, 1200), 10e-6);
    let camera = PlenopticCamera::new(sensor, MicrolensArray::new(MicrolensGrid::Square, 100e-6, 300e-6), lens)
        .expect("a camera");
    let on_axis = camera.aberrations(0.0).expect("light");
    assert!(
        on_axis.spot_m < 1e-12 && on_axis.distortion == 0.0 && (on_axis.pupil_share - 1.0).abs() < 1e-12,
        "{on_axis:?}"
    );
    assert!(on_axis.sagittal_m.abs() < 1e-8 && on_axis.tangential_m.abs() < 1e-8, "{on_axis:?}");
    let outside = camera.aberrations(5e-3).expect("light");
    // The Petzval curvature 1 / (n f), half of its square of the height, between sagittal and tangential focus in third order:
    // Z_t - Z_p = 3 (Z_s - Z_p).
    let petzval_m = -(5e-3f64).powi(2) / (2.0 * 1.6 * 0.05);
    let found = (3.0 * outside.sagittal_m - outside.tangential_m) / 2.0;
    assert!((found / petzval_m - 1.0).abs() < 0.05, "{outside:?} {petzval_m}");
    // Of a thin lens f^2 / (V f) between F and C.
    let [blue, red] = [486.1327, 656.2725].map(|nm| camera.chromatic_shift_m(nm).expect("a lens of glass"));
    assert!(((red - blue) / (0.05 / 50.0) - 1.0).abs() < 0.02, "{blue} {red}");
    assert!(camera.chromatic_shift_m(587.5618).expect("a lens of glass").abs() < 1e-15);
    // A double Gauss vignettes; its foci are corrected.
    let camera = behind("double-gauss", None);
    let all: Vec<_> = (0..=7).map(|k| camera.aberrations(f64::from(k) * 2e-3).expect("light")).collect();
    println!("{all:#?}");
    assert!(all.windows(2).all(|pair| pair[1].pupil_share <= pair[0].pupil_share + 1e-3));
    assert!(all[7].pupil_share < 0.7 && all[7].distortion.abs() < 0.05 && all[7].spot_m < 200e-6);
    assert!(illum(GridSize::new(10, 10)).aberrations(0.0).is_none());
}

/// A lens without thickness is the thin lens: for all rays through its middle, and for others but for its aberrations.
#[test]
fn a_lens_without_thickness_is_thin() {
    let medium = Medium::Abbe { nd: 1.5, vd: None };
    let surfaces = vec![
        Surface::sphere(0.05, 0.0, 0.004, medium),
        Surface::sphere(-0.05, 0.0, 0.004, Medium::Air),
        Surface::stop(0.0, 0.003),
    ];
    let lens = Prescription::new(surfaces).expect("a lens");
    assert!((lens.paraxial().focal_length_m - 0.05).abs() < 1e-15);
    let focus = ArrayFocus::Depth { depth_m: 1.5, virtual_depth: 0.0 };
    let array = MicrolensArray::new(MicrolensGrid::Square, 200e-6, 800e-6);
    let sensor = ImageSensor::new(GridSize::new(800, 1200), 20e-6);
    let camera = |lens: MainLens| {
        PlenopticCamera::new(sensor, array.clone(), lens).expect("a camera of a lens without thickness")
    };
    let thin = camera(MainLens::new(0.05, 0.05 / 0.006, 1.5));
    let glass = camera(MainLens::of_glass(lens, focus));
    let mut numbers = Numbers(9);
    for _ in 0..500 {
        let x = thin.place_m([numbers.next() * 1200.0, numbers.next() * 800.0]);
        let index = thin.owner(x);
        assert_eq!(glass.owner(x), index);
        // To the middle of the lens.
        let (center, image) = (thin.lens_center_m(index), thin.micro_image_center_m(index));
        let [a, b] = [&thin, &glass].map(|camera| camera.ray(image, center, index).expect("light"));
        for k in 0..2 {
            assert!((a.origin_m[k] - b.origin_m[k]).abs() < 1e-12, "{a:?} {b:?}");
            assert!((a.direction[k] - b.direction[k]).abs() < 1e-9, "{a:?} {b:?}");
        }
        // Near the middle the difference, coma and spherical aberration, vanishes with the distance from it.
        let near = [0, 1].map(|k| image[k] + 0.01 * (x[k] - image[k]));
        let [a, b] = [&thin, &glass].map(|camera| camera.ray(near, center, index).expect("light"));
        let away = (0..2).map(|k| (a.direction[k] - b.direction[k]).abs()).fold(0.0, f64::max);
        assert!(away < 3e-4, "{a:?} {b:?}");
    }
}

/// Discs hold all light up to where the lens lets none pass.
#[test]
fn discs_hold_the_last_light() {
    let mut numbers = Numbers(10);
    for name in NAMES {
        let near = behind(name, None);
        // 120 mm wide.
        let sensor = ImageSensor { pixel_m: 50e-6, ..*near.sensor() };
        let array = MicrolensArray::new(MicrolensGrid::HexRows, 500e-6, 1500e-6);
        let camera = PlenopticCamera::new(sensor, array, near.main_lens().clone()).expect("a camera");
        let (mut lit, mut dark) = (0, 0);
        for _ in 0..30_000 {
            let x = camera.place_m([numbers.next() * 2400.0, numbers.next() * 1600.0]);
            let lens = camera.microlens(camera.owner(x));
            dark += usize::from(lens.pupil.radius_m == 0.0);
            let in_pupil = [0, 1].map(|_| numbers.around(0.0, 4.0 * camera.exit_pupil_radius_m()));
            let on_sensor = in_pupil.map(|x| x * lens.gap_m / lens.exit_pupil_m());
            if camera.relative_ray(&lens, on_sensor, [0.0; 2]).is_some() {
                let away = [0, 1].map(|k| in_pupil[k] - lens.pupil.center_m[k]);
                assert!(away[0].hypot(away[1]) <= lens.pupil.radius_m, "{name}: {lens:?} {in_pupil:?}");
                lit += 1;
            }
        }
        assert!(lit > 300 && dark > 100, "{name}: {lit} {dark}");
    }
}

/// The microlenses that see a point are found in a window, and are those of the whole array.
#[test]
fn windows_hold_all_microlenses_that_see_a_point() {
    use crate::plenoptic::{MicrolensIndex, Objective, Preset};

    let preset = Preset::by_name("raytrix-r12-a").expect("a preset").camera().expect("a camera");
    let mut sensor = *preset.sensor();
    sensor.size = GridSize::new(700, 900);
    let tilted = |scale: f64| {
        let mut array = preset.array().clone();
        array.tilt_rad = array.tilt_rad.map(|tilt| scale * tilt);
        array
    };
    let glass = Objective::by_name("double-gauss").expect("an objective").prescription().expect("a lens");
    let behind_glass = MainLens::of_glass(glass, ArrayFocus::Depth { depth_m: 0.45, virtual_depth: 2.0 });
    for (tilt, lens) in [(1.0, preset.main_lens().clone()), (20.0, preset.main_lens().clone()), (5.0, behind_glass)] {
        let camera = PlenopticCamera::new(sensor, tilted(tilt), lens).expect("a camera");
        let radius_px = camera.micro_image_radii_m(0)[1] / sensor.pixel_m;
        let mut count = 0;
        for k in 0..20 {
            let depth_m = 0.25 + 0.02 * f64::from(k % 7);
            let point_m = [0.01 * (f64::from(k % 5) - 2.0), 0.008 * (f64::from(k % 3) - 1.0), -depth_m];
            let is_near = |lens: &MicrolensIndex| {
                let middle = camera.micro_image_center_px(*lens);
                let found = camera.project(point_m, *lens);
                found.is_some_and(|found| {
                    let [x, y] = found.position_px;
                    (x - middle[0]).hypot(y - middle[1]) <= radius_px
                })
            };
            let lines = camera.lens_lines(0..sensor.size.rows);
            let all = lines.flat_map(|line| camera.lenses_on_line(line, 0..sensor.size.rows).collect::<Vec<_>>());
            let is_on_sensor = |lens: &MicrolensIndex| {
                let [x, y] = camera.micro_image_center_px(*lens);
                (0.0..900.0).contains(&x) && (0.0..700.0).contains(&y)
            };
            let mut expected: Vec<MicrolensIndex> = all.filter(|lens| is_on_sensor(lens) && is_near(lens)).collect();
            let mut found = camera.lenses_seeing(point_m, radius_px);
            found.retain(is_on_sensor);
            expected.sort();
            found.sort();
            count += found.len();
            assert_eq!(found, expected, "{tilt} {point_m:?}");
        }
        assert!(count > 100, "{count}");
    }
}
