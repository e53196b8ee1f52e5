//! The disparity of views behind real microlenses and pixels.

use super::*;
use ndarray::{Array2, Array3};

/// The light of a pixel from a wave exp(i k x) on a plane, as a complex number: integrated over the pixel and the
/// microlens, with cos^4.
fn wave(camera: &PlenopticCamera, lens: &Microlens, place: [f64; 2], depth: f64, k: f64) -> [f64; 2] {
    let pixel = camera.sensor().pixel_m * camera.sensor().fill;
    let at = |n: usize, count: usize| (n as f64 + 0.5) / count as f64;
    let mut sum = [0.0; 2];
    for n in 0..16 {
        let offset = [n % 4, n / 4].map(|n| (at(n, 4) - 0.5) * pixel);
        let on_sensor = [0, 1].map(|axis| place[axis] + offset[axis] - lens.image_center_m[axis]);
        let region = camera.relative_lit_region(lens, on_sensor);
        for point in (0..256).filter_map(|m| region.point([at(m % 16, 16), at(m / 16, 16)])) {
            let ray = camera.relative_ray(lens, on_sensor, point).expect("a thin lens");
            let light = camera.relative_cos4(lens, on_sensor, point);
            let (sin, cos) = (k * (ray.origin_m[0] + depth * ray.direction[0])).sin_cos();
            sum = [sum[0] + light * cos, sum[1] + light * sin];
        }
    }
    sum
}

/// Views of a wave, sampled where they are defined: Eq. 3 and the lean of the cos^4 law.
#[test]
fn views_have_the_disparity_of_the_equivalent_rig() {
    let size = GridSize::new(1000, 1000);
    let (mut array, mut lens) = (illum(size).array().clone(), illum(size).main_lens().clone());
    (array.rotation_rad, array.offset_m) = (0.0, [0.0; 2]);
    let illum = PlenopticCamera::new(*illum(size).sensor(), array.clone(), lens.clone()).expect("a camera");
    // Microlenses that are focused far from the pupil, behind a square one.
    array.grid = MicrolensGrid::Square;
    array.aperture = LensAperture::Square { half_width_m: 9e-6 };
    lens.f_number = 2.0;
    let square = PlenopticCamera::new(*illum.sensor(), array, lens).expect("a camera");
    for (name, camera) in [("illum", illum), ("square", square)] {
        let views = camera.equivalent_views();
        for depth in [0.35, 0.45, 0.7, 2.0] {
            let period = 40.0 * views.slope_per_lens * depth;
            let k = 2.0 * PI / period;
            let phase = |view: f64, column: i32| {
                let lens = camera.microlens(MicrolensIndex { row: 0, column });
                let place = [lens.image_center_m[0] + view * camera.sensor().pixel_m, lens.image_center_m[1]];
                let [cos, sin] = wave(&camera, &lens, place, depth, k);
                sin.atan2(cos)
            };
            let turn = |angle: f64| (angle + PI).rem_euclid(2.0 * PI) - PI;
            let per_lens = turn(phase(0.0, 1) - phase(0.0, 0));
            let per_view = turn(phase(2.0, 0) - phase(-2.0, 0)) / 4.0;
            let expected = views.baseline_m / views.slope_per_lens * (1.0 / depth - views.inverse_focus_per_m);
            let found = per_view / per_lens;
            println!("{name} {depth} m: {found:.5} px, Eq. 3 {expected:.5}, lean {:.5}", views.cos4_disparity_px);
            assert!((found - expected - views.cos4_disparity_px).abs() < 1e-3, "{name} {depth}: {found} {expected}");
        }
    }
}

/// The same after decoding, from whole pixels of a rotated hexagonal array: within 1 %.
#[test]
fn decoded_views_have_the_disparity_of_their_rig() {
    let size = GridSize::new(300, 560);
    let sensor = ImageSensor::new(size, 1.4e-6);
    let whole = illum(size);
    let camera = PlenopticCamera::new(sensor, whole.array().clone(), whole.main_lens().clone()).expect("a camera");
    let views = camera.equivalent_views();
    let depth = 0.36;
    let k = 2.0 * PI / (9.0 * views.slope_per_lens * depth);
    let at = |n: usize| (n as f64 + 0.5) / 5.0;
    let raw = Array3::from_shape_fn((size.rows, size.columns, 1), |(row, column, _)| {
        let place = camera.place_m([column as f64 + 0.5, row as f64 + 0.5]);
        let lens = camera.microlens(camera.owner(place));
        let on_sensor = [0, 1].map(|axis| place[axis] - lens.image_center_m[axis]);
        let region = camera.relative_lit_region(&lens, on_sensor);
        let value = |point: [f64; 2]| {
            let ray = camera.relative_ray(&lens, on_sensor, point).expect("a thin lens");
            let x = ray.origin_m[0] + depth * ray.direction[0];
            camera.relative_cos4(&lens, on_sensor, point)
                * (1.0 + 0.5 * (k * x).cos() + 0.3 * (1.7 * k * x + 1.0).sin())
        };
        let points = (0..25).filter_map(|m| region.point([at(m % 5), at(m / 5)]));
        let scale = region.sampled_area_m2() / camera.array().aperture.area_m2() / camera.central_cos4();
        (points.map(value).sum::<f64>() / 25.0 * scale) as f32
    });
    let white = camera.white_image().expect("memory");
    let decoded = camera.decode(raw.view(), white.view(), 7).expect("views");
    assert_eq!(camera.decoded_rig(7), Ok(decoded.rig));
    let image =
        |s: usize| decoded.light_field.view(3, s).expect("a view").index_axis(ndarray::Axis(2), 0).mapv(f64::from);
    // By least squares, the views in the middle row against the central one.
    let mut found = 0.0;
    for _ in 0..6 {
        let (mut above, mut below) = (0.0, 0.0);
        let center = image(3);
        let sample = |row: usize, x: f64| {
            let left = x.floor() as usize;
            let cubic = |a: f64, b: f64, c: f64, d: f64, t: f64| {
                b + 0.5 * t * (c - a + t * (2.0 * a - 5.0 * b + 4.0 * c - d + t * (3.0 * (b - c) + d - a)))
            };
            let value = |k: usize| center[[row, left + k - 1]];
            cubic(value(0), value(1), value(2), value(3), x - x.floor())
        };
        for s in [0usize, 1, 2, 4, 5, 6] {
            let (view, steps): (Array2<f64>, f64) = (image(s), s as f64 - 3.0);
            for row in 1..view.nrows() - 1 {
                for column in 8..view.ncols() - 8 {
                    let x = column as f64 + found * steps;
                    let slope = (sample(row, x + 0.5) - sample(row, x - 0.5)) * steps;
                    above += slope * (view[[row, column]] - sample(row, x));
                    below += slope * slope;
                }
            }
        }
        // Not farther than the margin.
        found = f64::clamp(found + above / below, -1.5, 1.5);
    }
    let pitch = camera.array().pitch_m * super::microlenses::HEX_ROW;
    let lean = views.cos4_disparity_px * camera.array().pitch_m / pitch;
    let expected = decoded.rig.disparity().from_depth_m(depth) + lean;
    println!("decoded: {found:.5} px, Eq. 3 with the lean {expected:.5}");
    assert!((found / expected - 1.0).abs() < 0.01, "{found} {expected}");
}
