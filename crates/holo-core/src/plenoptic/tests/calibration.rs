//! Cameras that are found by their white images.

use ndarray::Array2;

use crate::GridSize;
use crate::plenoptic::{
    ArrayFocus, ImageSensor, MainLens, MicrolensArray, MicrolensFocus, MicrolensGrid, PlenopticCamera, Stop,
};

const SIZE: [usize; 2] = [420, 640];

fn camera(array: MicrolensArray, f_number: f64) -> PlenopticCamera {
    let sensor = ImageSensor::new(GridSize::new(SIZE[0], SIZE[1]), 4.4e-6);
    let lens = MainLens { exit_pupil_m: Some(60e-3), ..MainLens::new(0.05, f_number, 2.0) };
    PlenopticCamera::new(sensor, array, lens).unwrap()
}

/// The largest distance of a micro-image of one camera from the nearest of another, px.
fn off_px(truth: &PlenopticCamera, found: &PlenopticCamera) -> f64 {
    let mut most = 0.0_f64;
    for y in (0..SIZE[0]).step_by(35) {
        for x in (0..SIZE[1]).step_by(35) {
            let [a, b] = [truth, found].map(|camera| {
                let [x, y] = [x as f64, y as f64];
                // The same micro-image: that which owns the center of the other's.
                let center = truth.micro_image_center_px(truth.owner(truth.place_m([x, y])));
                camera.micro_image_center_px(camera.owner(camera.place_m(center)))
            });
            most = most.max((a[0] - b[0]).hypot(a[1] - b[1]));
        }
    }
    most
}

/// Numbers from -1/2 to 1/2.
fn noise(seed: u32) -> impl FnMut() -> f32 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / 16_777_216.0 - 0.5
    }
}

fn with_noise(white: &Array2<f32>, amplitude: f32) -> Array2<f32> {
    let (mut random, top) = (noise(7), white.iter().copied().fold(0.0, f32::max));
    // The standard deviation of numbers in an interval is 0.29 of it.
    white.mapv(|x| x + amplitude * top / 0.29 * random())
}

/// Pitches of 9 to 34 px, all grids, rotations, scales: the camera that knows the lens finds the array.
#[test]
fn the_array_is_found() {
    let nominal = camera(MicrolensArray::new(MicrolensGrid::Square, 90e-6, 3e-4), 5.0);
    for (grid, pitch_um, turn_deg, scale_y) in [
        (MicrolensGrid::Square, 62.3, 0.35, 1.0),
        (MicrolensGrid::Square, 62.3, -12.0, 1.004),
        (MicrolensGrid::Square, 120.0, 40.0, 1.0),
        (MicrolensGrid::HexRows, 62.3, 0.35, 1.0003),
        (MicrolensGrid::HexRows, 39.9, -7.0, 1.0),
        (MicrolensGrid::HexColumns, 62.3, 0.35, 1.002),
        (MicrolensGrid::HexColumns, 150.0, 11.0, 1.0),
    ] {
        let mut array = MicrolensArray::new(grid, pitch_um * 1e-6, 3e-4);
        (array.rotation_rad, array.scale_y) = (f64::to_radians(turn_deg), scale_y);
        array.offset_m = [13e-6, -21e-6];
        let truth = camera(array, 5.0);
        let white = truth.white_image().unwrap();
        let noises: &[(f32, f64)] =
            if pitch_um == 62.3 && scale_y < 1.001 { &[(0.0, 0.05), (0.1, 0.1)] } else { &[(0.0, 0.05)] };
        for &(amplitude, most) in noises {
            let found = nominal.calibrated(with_noise(&white, amplitude).view()).unwrap();
            let found = found.unwrap_or_else(|| panic!("{grid:?} {pitch_um} {turn_deg} {amplitude}"));
            let of = found.camera.array();
            let away = off_px(&truth, &found.camera);
            assert!(of.grid == grid && away < most, "{grid:?} {pitch_um} {turn_deg} {amplitude}: {away} {found:?}");
            // A square turned by 40 degrees is one turned by -50.
            let fold = if grid == MicrolensGrid::Square { 90.0 } else { 60.0 };
            let turned = (of.rotation_rad - truth.array().rotation_rad).to_degrees();
            assert!((turned - fold * (turned / fold).round()).abs() < 0.02, "{turned}");
            assert_eq!(of.tilt_rad, [0.0; 2]);
            if pitch_um == 120.0 {
                // Any unit of light: a power of 2 changes no rounding.
                let counts = white.mapv(|light| 4096.0 * light);
                assert_eq!(nominal.calibrated(counts.view()).unwrap().as_ref(), Some(&found));
            }
            // Noise moves single centers, not their lattice.
            assert!(found.count > 20 && (amplitude > 0.0 || found.rms_px < most), "{found:?}");
        }
    }
}

/// A main lens whose stops dim the corners: micro-images there are cat's eyes, whose centers of light are others.
#[test]
fn vignetting_is_that_of_the_camera() {
    let mut array = MicrolensArray::new(MicrolensGrid::HexRows, 62.3e-6, 3e-4);
    (array.rotation_rad, array.offset_m) = (0.004, [5e-6, 9e-6]);
    let sensor = ImageSensor::new(GridSize::new(SIZE[0], SIZE[1]), 4.4e-6);
    let of = |array: MicrolensArray| {
        let lens = MainLens {
            exit_pupil_m: Some(60e-3),
            stops: vec![Stop { distance_m: 30e-3, diameter_m: 9.5e-3 }],
            ..MainLens::new(0.05, 5.0, 2.0)
        };
        PlenopticCamera::new(sensor, array, lens).unwrap()
    };
    let truth = of(array);
    let white = truth.white_image().unwrap();
    let bare = camera(truth.array().clone(), 5.0).white_image().unwrap();
    let sums = [&white, &bare]
        .map(|image| image.indexed_iter().filter(|((v, u), _)| v.max(u) < &60).map(|(_, light)| light).sum::<f32>());
    assert!(sums[0] < 0.95 * sums[1], "nothing is dimmed: {sums:?}");
    let nominal = of(MicrolensArray::new(MicrolensGrid::HexRows, 64e-6, 3e-4));
    let found = nominal.calibrated(white.view()).unwrap().unwrap();
    assert!(off_px(&truth, &found.camera) < 0.06, "{} {found:?}", off_px(&truth, &found.camera));
}

/// An array that is tilted against the sensor: micro-images grow over it. A tilt of 2.2e-3 moves those at the sides, 1.4 mm from the
/// middle, by the 0.05 px that are promised, one of 4.5e-3 by the 0.1 px with noise.
#[test]
fn the_tilt_is_found() {
    let of = |grid: MicrolensGrid, tilt_rad: [f64; 2], offset_m: [f64; 2]| {
        let mut array = MicrolensArray::new(grid, 62.3e-6, 3e-4);
        (array.tilt_rad, array.offset_m) = (tilt_rad, offset_m);
        let sensor = ImageSensor::new(GridSize::new(SIZE[0], SIZE[1]), 4.4e-6);
        // A pupil so near that a tilt shows within 3 mm.
        let lens = MainLens { exit_pupil_m: Some(20e-3), ..MainLens::new(0.05, 15.0, 2.0) };
        PlenopticCamera::new(sensor, array, lens).unwrap()
    };
    for (grid, tilt_rad) in [
        (MicrolensGrid::Square, [0.03, -0.02]),
        (MicrolensGrid::HexRows, [-0.01, 0.04]),
        (MicrolensGrid::HexColumns, [0.0, 0.03]),
    ] {
        let truth = of(grid, tilt_rad, [13e-6, -21e-6]);
        let white = truth.white_image().unwrap();
        let noises: &[(f32, f64, f64)] = if grid == MicrolensGrid::HexRows {
            &[(0.0, 0.05, 1.5e-3), (0.1, 0.1, 4e-3)]
        } else {
            &[(0.0, 0.05, 1.5e-3)]
        };
        for &(amplitude, most_px, most_rad) in noises {
            let found = of(grid, [0.0; 2], [0.0; 2]).calibrated(with_noise(&white, amplitude).view()).unwrap().unwrap();
            let away = off_px(&truth, &found.camera);
            assert!(away < most_px, "{grid:?} {tilt_rad:?} {amplitude}: {away} {found:?}");
            for (found, expected) in found.camera.array().tilt_rad.into_iter().zip(tilt_rad) {
                assert!((found - expected).abs() < most_rad, "{grid:?} {tilt_rad:?} {amplitude}: {found} {expected}");
            }
        }
    }
}

/// The displacement between two cameras is that of each of their micro-images, over all of the sensor: a tilted array has
/// one that grows with the square of the distance.
#[test]
fn a_displacement_is_that_of_every_micro_image() {
    let of = |tilt_rad: [f64; 2]| {
        let array = MicrolensArray { tilt_rad, ..MicrolensArray::new(MicrolensGrid::Square, 62.3e-6, 3e-4) };
        let sensor = ImageSensor::new(GridSize::new(SIZE[0], SIZE[1]), 4.4e-6);
        let lens = MainLens { exit_pupil_m: Some(20e-3), ..MainLens::new(0.05, 15.0, 2.0) };
        PlenopticCamera::new(sensor, array, lens).unwrap()
    };
    let (truth, known) = (of([0.03, -0.02]), of([0.0; 2]));
    let found = known.white_displacement(truth.white_image().unwrap().view(), true).unwrap().unwrap();
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for line in known.lens_lines(0..SIZE[0]) {
        for lens in known.lenses_on_line(line, 0..SIZE[0]) {
            let [from, to] = [&known, &truth].map(|camera| camera.micro_image_center_px(lens));
            let (expected, found) = ([to[0] - from[0], to[1] - from[1]], found.at(from));
            worst = worst.max((found[0] - expected[0]).hypot(found[1] - expected[1]));
            largest = largest.max(expected[0].hypot(expected[1]));
        }
    }
    println!("off by {worst:.4} of {largest:.3} px");
    // What `white_grid` promises: 0.03 px and a fiftieth of the displacement.
    assert!(largest > 1.0 && worst < 0.03 + largest / 50.0, "{worst} {largest}");
}

/// Behind a closed aperture a sixteenth of the sensor is lit.
#[test]
fn small_micro_images_are_found() {
    let mut array = MicrolensArray::new(MicrolensGrid::Square, 176e-6, 9e-4);
    array.offset_m = [13e-6, -21e-6];
    let truth = camera(array, 20.0);
    let nominal = camera(MicrolensArray::new(MicrolensGrid::Square, 180e-6, 9e-4), 20.0);
    let found = nominal.calibrated(truth.white_image().unwrap().view()).unwrap().expect("a lattice");
    assert!(off_px(&truth, &found.camera) < 0.05, "{} {found:?}", off_px(&truth, &found.camera));
    assert!(found.count > 100 && found.rms_px < 0.05, "{found:?}");
}

/// Nothing is known but the pixels: centers and radii are found all the same.
#[test]
fn an_unknown_camera_is_found() {
    let mut array = MicrolensArray::new(MicrolensGrid::HexRows, 62.3e-6, 3e-4);
    (array.rotation_rad, array.offset_m) = (0.35_f64.to_radians(), [5e-6, 9e-6]);
    let truth = camera(array, 6.0);
    let found = PlenopticCamera::of_white_image(truth.white_image().unwrap().view(), 4.4e-6).unwrap().unwrap();
    // Light leans towards the middle of micro-images of another lens.
    assert!(off_px(&truth, &found.camera) < 0.15, "{} {found:?}", off_px(&truth, &found.camera));
    let radius_px = truth.micro_image_radii_m(0)[1] / 4.4e-6;
    assert!((found.radii_px[0] / radius_px - 1.0).abs() < 0.05, "{radius_px} {found:?}");
    // In the mosaic of a color sensor too: blue and red have half of the light of green.
    let mut mosaic = truth.white_image().unwrap();
    for ((v, u), light) in mosaic.indexed_iter_mut() {
        *light *= if (v + u) % 2 == 0 { 1.0 } else { 0.5 };
    }
    let found = PlenopticCamera::of_white_image(mosaic.view(), 4.4e-6).unwrap().unwrap();
    assert!(off_px(&truth, &found.camera) < 0.15, "{} {found:?}", off_px(&truth, &found.camera));
}

/// Three types of microlenses blur the pupil differently: their radii have the order of the camera's.
#[test]
fn three_types_are_found() {
    let of = |offset_m: [f64; 2]| {
        let mut array = MicrolensArray::new(MicrolensGrid::HexRows, 127e-6, 338e-6);
        array.focus = MicrolensFocus::Lengths(vec![578e-6, 505e-6, 430e-6]);
        array.offset_m = offset_m;
        let sensor = ImageSensor::new(GridSize::new(SIZE[0], SIZE[1]), 4.4e-6);
        let mut lens = MainLens::new(0.05, 5.0, 2.0);
        lens.focus = ArrayFocus::Distance { mla_distance_m: 0.0567 };
        PlenopticCamera::new(sensor, array, lens).unwrap()
    };
    // One microlens further right, and nearly one.
    for offset_m in [[0.0, 0.0], [127e-6, 0.0], [100e-6, 10e-6]] {
        let truth = of(offset_m);
        let found = of([0.0; 2]).calibrated(truth.white_image().unwrap().view()).unwrap().unwrap();
        assert!(found.radii_px.len() == 3 && off_px(&truth, &found.camera) < 0.1, "{found:?}");
        for x in [100.0, 350.0, 500.0] {
            let center = truth.micro_image_center_px(truth.owner(truth.place_m([x, 210.0])));
            let [a, b] =
                [&truth, &found.camera].map(|camera| camera.array().type_of(camera.owner(camera.place_m(center))));
            assert_eq!(a, b, "{offset_m:?} {x} {found:?}");
        }
    }
}

#[test]
fn what_is_no_white_image_is_none() {
    let nominal = camera(MicrolensArray::new(MicrolensGrid::Square, 62e-6, 3e-4), 5.0);
    let mut random = noise(1);
    let images = [
        Array2::from_elem((SIZE[0], SIZE[1]), 1.0),
        Array2::from_elem((SIZE[0], SIZE[1]), 0.0),
        Array2::from_elem((SIZE[0], SIZE[1]), f32::NAN),
        Array2::from_shape_fn((SIZE[0], SIZE[1]), |_| random() + 0.5),
        // Stripes, and rectangles.
        Array2::from_shape_fn((SIZE[0], SIZE[1]), |(_, u)| (u as f32 / 3.0).sin() + 1.0),
        Array2::from_shape_fn((SIZE[0], SIZE[1]), |(v, u)| (u as f32 / 3.0).sin() + (v as f32 / 2.0).sin() + 2.0),
    ];
    for (k, image) in images.iter().enumerate() {
        assert_eq!(nominal.calibrated(image.view()).unwrap(), None, "{k}");
        assert_eq!(PlenopticCamera::of_white_image(image.view(), 4.4e-6).unwrap(), None, "{k}");
    }
    for size in [[0, 0], [1, 1], [5, 400], [30, 30]] {
        let tiny = Array2::from_elem((size[0], size[1]), 1.0);
        assert_eq!(PlenopticCamera::of_white_image(tiny.view(), 4.4e-6).unwrap(), None, "{size:?}");
    }
    let cut = images[0].slice_axis(ndarray::Axis(0), (..100).into());
    assert!(nominal.calibrated(cut).is_err(), "another size");
}
