//! Tilted arrays and distorting main lenses.

use super::*;

/// An R12 with a tilted array and a distorting lens.
fn camera(tilt_rad: [f64; 2], distortion: Distortion) -> PlenopticCamera {
    let sound = r12(GridSize::new(3068, 4080));
    let (mut array, mut lens) = (sound.array().clone(), sound.main_lens().clone());
    (array.tilt_rad, lens.distortion) = (tilt_rad, distortion);
    PlenopticCamera::new(*sound.sensor(), array, lens).expect("a camera")
}

const BARREL: Distortion = Distortion { radial: [-120.0, 8e4, 0.0], tangential: [0.02, -0.01] };

/// Points are projected to the places whose chief rays, and all others by kappa, go through them.
#[test]
fn projected_points_lie_on_their_rays() {
    let mut numbers = Numbers(11);
    for camera in [camera([0.0; 2], BARREL), camera([8.4e-4, -6.4e-3], Distortion::NONE), camera([8e-3, 6e-3], BARREL)]
    {
        for _ in 0..500 {
            let place = camera.place_m([numbers.next() * 4080.0, numbers.next() * 3068.0]);
            let lens = camera.owner(place);
            let depth = 0.3 + numbers.next();
            let at = |ray: PlenopticRay| [0, 1].map(|k| ray.origin_m[k] + depth * ray.direction[k]);
            let [x, y] = at(camera.ray(place, camera.lens_center_m(lens), lens).expect("a thin lens"));
            let found = camera.project([x, y, -depth], lens).expect("a point in front of the camera");
            let expected = camera.position_px(place);
            let away = (found.position_px[0] - expected[0]).hypot(found.position_px[1] - expected[1]);
            assert!(away < 1e-8, "{:?} {expected:?}", found.position_px);
            let step = [3e-6, -2e-6];
            let center = camera.lens_center_m(lens);
            let moved = [0, 1].map(|k| place[k] + found.kappa * step[k]);
            let [mx, my] =
                at(camera.ray(moved, [center[0] + step[0], center[1] + step[1]], lens).expect("a thin lens"));
            // kappa is that without distortion, whose slope differs by up to a tenth in the corners.
            let scale = depth * camera.pupils.slope_per_m * 4e-6;
            assert!((mx - x).hypot(my - y) < 0.1 * scale, "{} {}", (mx - x).hypot(my - y), scale);
        }
    }
}

/// The ray through the middle of the pupil arrives where the distortion says.
#[test]
fn chief_rays_are_distorted() {
    let camera = camera([0.0; 2], BARREL);
    for slope in [[0.0, 0.0], [0.1, 0.05], [-0.15, 0.1]] {
        let straight = slope.map(|x| x / camera.pupils.slope_per_m);
        let arrived = BARREL.distorted(straight);
        let lens = camera.owner(arrived.map(|x| x * camera.micro_image_scale()));
        // The pixel from which the middle of the pupil is seen through that point.
        let center = camera.lens_center_m(lens);
        let away = [0, 1].map(|k| arrived[k] - center[k]);
        let per_pupil = camera.array().gap_m / camera.exit_pupil_m();
        let image = camera.micro_image_center_m(lens);
        let place = [0, 1].map(|k| image[k] + per_pupil * camera.microlens(lens).alpha * away[k]);
        let ray = camera.ray(place, arrived, lens).expect("a thin lens");
        for k in 0..2 {
            assert!(ray.origin_m[k].abs() < 1e-14 && (ray.direction[k] - slope[k]).abs() < 1e-12, "{ray:?} {slope:?}");
        }
    }
}

/// The owner of a place is the microlens with the nearest micro-image, and all of them are listed, on a tilted array too.
#[test]
fn tilted_arrays_are_complete() {
    let camera = camera([0.01, -0.02], Distortion::NONE);
    let mut numbers = Numbers(3);
    let all: Vec<_> = camera
        .lens_lines(0..3068)
        .flat_map(|line| camera.lenses_on_line(line, 0..3068).collect::<Vec<_>>())
        .map(|lens| (lens, camera.micro_image_center_m(lens)))
        .collect();
    for _ in 0..200 {
        let place = camera.place_m([numbers.next() * 4080.0, numbers.next() * 3068.0]);
        let away = |center: [f64; 2]| (center[0] - place[0]).hypot(center[1] - place[1]);
        let nearest = all.iter().min_by(|(_, a), (_, b)| away(*a).total_cmp(&away(*b))).expect("a microlens");
        assert_eq!(camera.owner(place), nearest.0);
    }
}

/// The corners of a target are found in the same micro-images as by trying all of them.
#[test]
fn all_microlenses_that_see_a_point_are_found() {
    for camera in [r12(GridSize::new(300, 400)), illum(GridSize::new(300, 400)), camera_part([4e-3, 0.0], BARREL)] {
        for point in [[0.0, 0.0, -0.4], [0.004, -0.003, -0.6], [0.001, 0.002, -3.0]] {
            let found = camera.lenses_seeing(point, 5.0);
            let corners = [camera.place_m([0.0, 300.0]), camera.place_m([400.0, 0.0])];
            let sees = |lens: &MicrolensIndex| {
                let [x, y] = camera.project(point, *lens).expect("a point in front of the camera").position_px;
                let [cx, cy] = camera.micro_image_center_px(*lens);
                let [mx, my] = camera.micro_image_center_m(*lens);
                let is_on_sensor =
                    mx >= corners[0][0] && mx <= corners[1][0] && my >= corners[0][1] && my <= corners[1][1];
                is_on_sensor && (x - cx).hypot(y - cy) <= 5.0
            };
            let all =
                camera.lens_lines(0..300).flat_map(|line| camera.lenses_on_line(line, 0..300).collect::<Vec<_>>());
            assert_eq!(found, all.filter(sees).collect::<Vec<_>>(), "{point:?}");
            assert!(!found.is_empty(), "{point:?}");
        }
    }
}

fn camera_part(tilt_rad: [f64; 2], distortion: Distortion) -> PlenopticCamera {
    let whole = camera(tilt_rad, distortion);
    let sensor = ImageSensor { size: GridSize::new(300, 400), ..*whole.sensor() };
    PlenopticCamera::new(sensor, whole.array().clone(), whole.main_lens().clone()).expect("a camera")
}
