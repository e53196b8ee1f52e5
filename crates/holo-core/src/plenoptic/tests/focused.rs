//! Views of focused cameras, from raw images of scenes with a closed form: a textured wall, and a square before it.

use super::*;
use crate::Error;
use ndarray::{Array2, Array3, ArrayView2};

const SIZE: GridSize = GridSize::new(300, 340);

/// An array of three types of microlenses, focused near a virtual depth of 3, behind a thin lens; Galilean.
fn three_types() -> PlenopticCamera {
    let mut array = MicrolensArray::new(MicrolensGrid::HexRows, 100e-6, 300e-6);
    array.focus = MicrolensFocus::Lengths(vec![430e-6, 450e-6, 470e-6]);
    PlenopticCamera::new(ImageSensor::new(SIZE, 5e-6), array, MainLens::new(0.05, 3.2, 1.4)).expect("a camera")
}

/// One type of microlenses in squares, which look at an image in front of the array; Keplerian.
fn keplerian() -> PlenopticCamera {
    let mut array = MicrolensArray::new(MicrolensGrid::Square, 100e-6, 300e-6);
    array.focus = MicrolensFocus::Lengths(vec![240e-6]);
    PlenopticCamera::new(ImageSensor::new(SIZE, 5e-6), array, MainLens::new(0.05, 3.2, 0.45)).expect("a camera")
}

/// The depth of the wall and of the square, m, and how far the square reaches from the middle, as slopes.
struct Scene {
    wall_m: f64,
    square_m: f64,
}

const SQUARE: f64 = 0.004;

impl Scene {
    /// Color and depth along a ray through (x, y) of the pupil.
    fn seen(&self, origin: [f64; 2], direction: [f64; 2]) -> (f64, f64) {
        let at = |depth: f64| [0, 1].map(|k| origin[k] + depth * direction[k]);
        let near = at(self.square_m);
        if near.iter().all(|x| x.abs() < SQUARE * self.square_m) {
            return (texture(near.map(|x| x / self.square_m), 1.0), self.square_m);
        }
        (texture(at(self.wall_m).map(|x| x / self.wall_m), 0.0), self.wall_m)
    }
}

/// Waves in all directions, of some ten pixels of a view.
fn texture([x, y]: [f64; 2], phase: f64) -> f64 {
    let wave = |a: f64, b: f64, c: f64| (a * x + b * y + c + phase).sin();
    0.5 + 0.12 * (wave(1900.0, 300.0, 0.3) + wave(-400.0, 1700.0, 2.0) + wave(1300.0, 1400.0, 4.0))
}

/// The raw image, and the depth along the ray through the middle of each pixel and its microlens.
fn raw(camera: &PlenopticCamera, scene: &Scene, white: ArrayView2<'_, f32>) -> (Array3<f32>, Array2<f32>) {
    let mut image = Array3::zeros((SIZE.rows, SIZE.columns, 1));
    let mut depth = Array2::from_elem((SIZE.rows, SIZE.columns), f32::NAN);
    let at = |k: usize| (k as f64 + 0.5) / 5.0;
    for row in 0..SIZE.rows {
        for column in 0..SIZE.columns {
            let lens = camera.microlens(camera.owner(camera.place_m([column as f64 + 0.5, row as f64 + 0.5])));
            let (mut sum, mut count) = (0.0, 0.0);
            for part in 0..9 {
                let inside = |k: usize| (k as f64 + 0.5) / 3.0;
                let place = camera.place_m([column as f64 + inside(part % 3), row as f64 + inside(part / 3)]);
                let on_sensor = [0, 1].map(|k| place[k] - lens.image_center_m[k]);
                let region = camera.relative_lit_region(&lens, on_sensor);
                for point in (0..25).filter_map(|m| region.point([at(m % 5), at(m / 5)])) {
                    let ray = camera.relative_ray(&lens, on_sensor, point).expect("a thin lens");
                    (sum, count) = (sum + scene.seen(ray.origin_m, ray.direction).0, count + 1.0);
                }
            }
            if count > 0.0 {
                image[[row, column, 0]] = white[[row, column]] * (sum / count) as f32;
            }
            let middle = camera.place_m([column as f64 + 0.5, row as f64 + 0.5]);
            let chief = camera.ray(middle, lens.center_m, lens.index).expect("a thin lens");
            depth[[row, column]] = scene.seen(chief.origin_m, chief.direction).1 as f32;
        }
    }
    (image, depth)
}

/// The root mean square of the deviation of a view from the scene, 4 pixels from the border, and where the view is empty.
fn deviation(decoded: &Decoded, scene: &Scene, (t, s): (usize, usize)) -> (f64, usize) {
    let image = decoded.light_field.view(t, s).expect("a view");
    let weight = decoded.weight.view(t, s).expect("a view");
    let (rows, columns, _) = image.dim();
    let (mut squares, mut count) = (0.0, 0.0);
    for v in 4..rows - 4 {
        for u in 4..columns - 4 {
            let ray = decoded.rig.ray(v, u, t, s, 0.5, 0.5);
            let origin = [ray.origin_m[0], ray.origin_m[1]];
            let expected = scene.seen(origin, [ray.direction[0], ray.direction[1]]).0;
            squares += (f64::from(image[[v, u, 0]]) - expected).powi(2);
            count += 1.0;
        }
    }
    ((squares / count).sqrt(), weight.iter().filter(|w| **w == 0.0).count())
}

/// The part of the central view whose depth is not that of the scene.
fn wrong_part(decoded: &Decoded, scene: &Scene) -> f64 {
    let (depth, (t, s)) = (decoded.depth_m.as_ref().expect("the depth"), decoded.rig.shape().central_view());
    let is_wrong = |((v, u), &found): ((usize, usize), &f32)| {
        let ray = decoded.rig.ray(v, u, t, s, 0.5, 0.5);
        let (_, expected) = scene.seen([ray.origin_m[0], ray.origin_m[1]], [ray.direction[0], ray.direction[1]]);
        (f64::from(found) / expected - 1.0).abs() > 1e-3
    };
    depth.indexed_iter().filter(|&sample| is_wrong(sample)).count() as f64 / depth.len() as f64
}

/// Views of all parts of the pupil are those of pinholes there: along the depth of the raw image, and along its estimate. With one
/// depth for all they are not.
#[test]
fn views_are_those_of_pinholes() {
    for (name, camera, gaps) in [("three types", three_types(), [2.6, 4.2]), ("keplerian", keplerian(), [3.2, 5.5])] {
        assert!(camera.has_rendered_views());
        // The depth whose image lies so many gaps behind the array, or before it.
        let side = if camera.mode(0) == PlenopticMode::Keplerian { -1.0 } else { 1.0 };
        let depth_m = |gaps: f64| {
            let image_m = camera.mla_distance_m() + side * gaps * camera.array().gap_m;
            1.0 / (1.0 / camera.main_lens().focal_length_m - 1.0 / image_m)
        };
        let (mut near, mut far) = (depth_m(gaps[1]), depth_m(gaps[0]));
        if near > far {
            (near, far) = (far, near);
        }
        let scene = Scene { wall_m: far, square_m: near };
        let white = camera.white_image().expect("a white image");
        let (raw, depth) = raw(&camera, &scene, white.view());
        let along = camera.decode_along(raw.view(), white.view(), 3, depth.view()).expect("views");
        let estimate = camera.decode(raw.view(), white.view(), 3).expect("views");
        let flat = Array2::from_elem(depth.dim(), ((near + far) / 2.0) as f32);
        let flat = camera.decode_along(raw.view(), white.view(), 3, flat.view()).expect("views");
        for view in [(1, 1), (0, 0), (1, 2)] {
            let [one, two, three] = [&along, &estimate, &flat].map(|decoded| deviation(decoded, &scene, view));
            println!("{name} {view:?}: {:.4} {:.4} {:.4}, empty {} {}", one.0, two.0, three.0, one.1, two.1);
            assert!((one.1, two.1) == (0, 0), "{name} {view:?}: no pixel is empty");
            // The estimate errs along edges, where fewer microlenses see what is behind.
            assert!(one.0 < 0.04 && two.0 < 0.06, "{name} {view:?}: {one:?} {two:?}");
            let worse = if view == (1, 1) { 1.0 } else { 1.15 };
            assert!(three.0 > worse * one.0, "{name} {view:?}: {one:?} {two:?} {three:?}");
        }
        // The depth of the central view, away from edges.
        let (found, rig) = (estimate.depth_m.expect("an estimate"), estimate.rig);
        let mut errors: Vec<f64> = Vec::new();
        for ((v, u), &found) in found.indexed_iter() {
            let ray = rig.ray(v, u, 1, 1, 0.5, 0.5);
            let (_, expected) = scene.seen([ray.origin_m[0], ray.origin_m[1]], [ray.direction[0], ray.direction[1]]);
            errors.push((f64::from(found) / expected - 1.0).abs());
        }
        errors.sort_by(f64::total_cmp);
        let (median, most) = (errors[errors.len() / 2], errors[errors.len() * 8 / 10]);
        println!("{name}: depth off by {median:.4} (median), {most:.4} (80 %)");
        assert!(median < 0.015 && most < 0.05, "{name}: {median} {most}");
        // The middle of the pupil has a view of an odd number, and none of an even one.
        let even = camera.decode_along(raw.view(), white.view(), 2, depth.view()).expect("views");
        let wrong = [&along, &even].map(|decoded| wrong_part(decoded, &scene));
        println!("{name}: depth wrong in {wrong:.4?} of the central view");
        // Along edges, where no sample comes from quite the same point of the pupil; twice as much if it came from another.
        assert!(wrong[0] < 0.032 && wrong[1] < 0.022, "{name}: {wrong:?}");
        let exact = along.depth_m.expect("the depth");
        let close =
            exact.iter().filter(|x| [near, far].iter().any(|z| (f64::from(**x) / z - 1.0).abs() < 1e-5)).count();
        assert_eq!(close, exact.len());
    }
}

#[test]
fn cameras_without_views_are_refused() {
    let camera = three_types();
    let white = Array2::<f32>::ones((SIZE.rows, SIZE.columns));
    let raw = Array3::<f32>::ones((SIZE.rows, SIZE.columns, 1));
    let depth = Array2::<f32>::ones((SIZE.rows, SIZE.columns));
    assert!(matches!(camera.decode(raw.view(), white.view(), 0), Err(Error::ZeroCount { .. })));
    let small = Array2::<f32>::ones((SIZE.rows, SIZE.columns - 1));
    assert!(matches!(camera.decode(raw.view(), small.view(), 3), Err(Error::Shape { .. })));
    assert!(matches!(camera.decode_along(raw.view(), white.view(), 3, small.view()), Err(Error::Shape { .. })));
    let unknown = depth.mapv(|_| f32::NAN);
    assert!(matches!(camera.decode_along(raw.view(), white.view(), 3, unknown.view()), Err(Error::BadNumber { .. })));
    // Dark images, and one of a single light, are no failure.
    let dark = white.mapv(|_| 0.0);
    let views = camera.decode(raw.view(), dark.view(), 3).expect("views without light");
    assert!(views.weight.samples().iter().all(|w| *w == 0.0));
    let unfocused = illum(GridSize::new(300, 300));
    let (raw, white) = (Array3::<f32>::ones((300, 300, 1)), Array2::<f32>::ones((300, 300)));
    let error = unfocused.decode_along(raw.view(), white.view(), 3, white.view()).expect_err("unfocused");
    assert!(error.to_string().contains("need no depth"), "{error}");
    // Micro-images of two pixels.
    let wide = ImageSensor::new(GridSize::new(40, 40), 40e-6);
    let coarse = PlenopticCamera::new(wide, camera.array().clone(), camera.main_lens().clone()).expect("a camera");
    let error = coarse.decoded_rig(3).expect_err("too few pixels");
    assert!(error.to_string().contains("at least 4"), "{error}");
    assert_eq!(camera.decodable_views(), Ok(5));
}
