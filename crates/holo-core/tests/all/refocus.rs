//! Refocusing against its reference implementation, the shifts of LFToolbox, and planes of known disparity.

mod naive;
mod sharpness;

use holo_core::refocus::{
    Aperture, FocalPlane, Kernel, Refocus, SyntheticAperture, disparity_from_slope, slope_from_disparity,
};
use holo_core::{BaselineRatio, Error, GridSize, LightField, LightFieldOwned, LightFieldShape, Pinhole, Rig, Sample};
use ndarray::{Array2, Array3, Array5, ArrayView3};

/// Pseudo-random numbers from 0 to 255.
fn byte(index: usize) -> u8 {
    let mut hash = (index as u64).wrapping_add(0x9e37_79b9_7f4a_7c15).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    hash = (hash ^ (hash >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (hash >> 56) as u8
}

fn noise<T>(shape: LightFieldShape, channels: usize, sample: impl Fn(u8) -> T) -> LightFieldOwned<T> {
    let raw = shape.raw_size();
    let size = (raw.rows, raw.columns, channels);
    let image =
        Array3::from_shape_fn(size, |(row, column, c)| sample(byte((row * raw.columns + column) * channels + c)));
    LightField::from_elemental_grid(image, shape).unwrap()
}

/// Compares with the sum in f64, pixel by pixel and NaN by NaN.
fn assert_close(found: ArrayView3<'_, f32>, expected: ArrayView3<'_, f64>, bound: f64, what: &str) {
    assert_eq!(found.dim(), expected.dim(), "{what}");
    for ((index, &found), &expected) in found.indexed_iter().zip(&expected) {
        let same = (found.is_nan() && expected.is_nan()) || (f64::from(found) - expected).abs() <= bound;
        assert!(same, "{what} {index:?}: {found} for {expected}, bound {bound:e}");
    }
}

fn ratio(vertical_over_horizontal: f64) -> BaselineRatio {
    BaselineRatio::vertical_over_horizontal(vertical_over_horizontal).unwrap()
}

/// The documented bound.
fn bound(shape: LightFieldShape, largest: f64) -> f64 {
    let views = shape.views();
    (views.columns + 4 * views.rows + 16) as f64 * 2.0_f64.powi(-23) * largest
}

/// Compares both refocusing methods with their reference implementation at many disparities.
fn check<T: Sample>(light_field: &LightFieldOwned<T>, largest: f64) {
    let shape = light_field.shape();
    let views = shape.views();
    let middle = ((views.rows - 1) as f64 / 2.0, (views.columns - 1) as f64 / 2.0);
    let apertures = [
        Aperture::all(views).unwrap(),
        Aperture::disc(views, middle, views.larger() as f64 * 0.8).unwrap(),
        Aperture::gaussian(views, (0.0, middle.1), 1.5).unwrap(),
    ];
    for aperture in apertures {
        for kernel in [Kernel::Bilinear, Kernel::CatmullRom] {
            let refocus = Refocus::with_aperture(aperture.clone()).kernel(kernel).baseline_ratio(ratio(0.75));
            let central = shape.central_view();
            let central = (central.0 as f64, central.1 as f64);
            for (refocus, reference) in
                [(refocus.clone(), central), (refocus.reference(middle.0, -0.25).unwrap(), (middle.0, -0.25))]
            {
                for disparity in [0.0, 1.0, -2.0, 0.3, -1.7, 4.1, 1000.0] {
                    let expected_for = |disparity: &dyn Fn(usize, usize) -> f64| {
                        naive::refocused(light_field, &aperture, kernel, reference, 0.75, disparity)
                    };
                    let what = format!("{shape:?} {kernel:?} {disparity}");
                    let found = refocus.at_disparity(light_field, disparity).unwrap();
                    assert_close(found.view(), expected_for(&|_, _| disparity).view(), bound(shape, largest), &what);
                    let lenses = shape.lenses();
                    let map = Array2::from_shape_fn((lenses.rows, lenses.columns), |(v, u)| {
                        disparity + 0.1 * v as f64 - 0.05 * u as f64
                    });
                    let found = refocus.all_in_focus(light_field, &map).unwrap();
                    let expected = expected_for(&|v, u| map[[v, u]]);
                    assert_close(found.view(), expected.view(), bound(shape, largest), &what);
                }
            }
        }
    }
}

#[test]
fn sums_agree_with_the_reference_implementation() {
    for (views, lenses, channels) in
        [((3, 3), (6, 7), 3), ((2, 4), (5, 9), 1), ((1, 5), (1, 8), 2), ((4, 1), (7, 1), 4), ((5, 2), (3, 2), 5)]
    {
        let shape = LightFieldShape::new(GridSize::new(views.0, views.1), GridSize::new(lenses.0, lenses.1)).unwrap();
        check(&noise(shape, channels, |byte| byte), 255.0);
        check(&noise(shape, channels, |byte| u16::from(byte) * 257), 65535.0);
        check(&noise(shape, channels, |byte| f32::from(byte) / 128.0 - 1.0), 1.0);
    }
}

#[test]
fn order_in_memory_changes_no_bit() {
    let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(8, 9)).unwrap();
    let elemental = noise(shape, 3, |byte| byte);
    let viewpoint = LightField::from_viewpoint_grid(elemental.to_viewpoint_grid().unwrap(), shape).unwrap();
    // Neither: turned by 180 degrees, stored, and seen turned back.
    let turned = elemental.clone().rotate_raw().to_owned().unwrap().to_elemental_grid().unwrap();
    let turned = LightField::from_elemental_grid(turned, shape).unwrap().rotate_raw();
    let refocus = Refocus::new(shape.views()).unwrap();
    let bits = |image: Array3<f32>| image.mapv(f32::to_bits);
    let expected = bits(refocus.at_disparity(&elemental, 0.6).unwrap());
    assert_eq!(bits(refocus.at_disparity(&viewpoint, 0.6).unwrap()), expected);
    assert_eq!(bits(refocus.at_disparity(&turned, 0.6).unwrap()), expected);
    let part = elemental.clip_lenses(1..6, 2..8).unwrap();
    let copy = LightField::from_elemental_grid(part.to_elemental_grid().unwrap(), part.shape()).unwrap();
    let part = refocus.at_disparity(&part, 0.6).unwrap();
    assert_eq!(bits(part), bits(refocus.at_disparity(&copy, 0.6).unwrap()));
}

#[test]
fn threads_change_no_bit() {
    let shape = LightFieldShape::new(GridSize::new(4, 5), GridSize::new(31, 17)).unwrap();
    let light_field = noise(shape, 3, |byte| byte);
    let refocus = Refocus::new(shape.views()).unwrap();
    let map = Array2::from_elem((31, 17), 0.37_f32);
    let in_pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let plane = refocus.at_disparity(&light_field, 0.37).unwrap().mapv(f32::to_bits);
            (plane, refocus.all_in_focus(&light_field, &map).unwrap().mapv(f32::to_bits))
        })
    };
    assert_eq!(in_pool(1), in_pool(3));
}

#[test]
fn edges_are_as_bright_as_the_middle() {
    let shape = LightFieldShape::new(GridSize::new(5, 5), GridSize::new(12, 10)).unwrap();
    let light_field = noise(shape, 1, |_| 200_u8);
    let refocus = Refocus::new(shape.views()).unwrap();
    for disparity in [0.0, 0.5, -2.3, 3.9, -40.0] {
        for &sample in &refocus.at_disparity(&light_field, disparity).unwrap() {
            assert!((f64::from(sample) - 200.0).abs() < bound(shape, 200.0), "{sample} at {disparity}");
        }
    }
    // Pixels that the aperture does not see are NaN: one view, two columns to the right, at
    // disparity 3.
    let one = Aperture::square(shape.views(), (2.0, 4.0), 0.5).unwrap();
    let image = Refocus::with_aperture(one).at_disparity(&light_field, 3.0).unwrap();
    for ((_, u, _), sample) in image.indexed_iter() {
        assert_eq!(sample.is_nan(), u < 6, "column {u}");
    }
    // The pixel without a disparity has no value, its neighbors have theirs.
    let mut map = Array2::from_elem((12, 10), 0.5_f32);
    map[[3, 4]] = f32::NAN;
    let image = refocus.all_in_focus(&light_field, &map).unwrap();
    assert!(image.indexed_iter().all(|((v, u, _), sample)| sample.is_nan() == ((v, u) == (3, 4))));
}

#[test]
fn slopes_agree_with_lftoolbox() {
    for views in [2_usize, 5, 9, 20] {
        for disparity in [1.0, -0.7, 2.15] {
            let slope = slope_from_disparity(disparity, views).unwrap();
            assert!((disparity_from_slope(slope, views).unwrap() - disparity).abs() < 1e-15);
            for view in 0..views {
                // The toolbox's shift of that view, linspace(-1/2, 1/2, T) * slope * T, which it adds to the place of a
                // sample.
                let linspace = -0.5 + view as f64 / (views - 1) as f64;
                let toolbox = linspace * slope * views as f64;
                // Here: -d times the views between it and the middle. Four roundings of numbers below 25.
                let here = -disparity * (view as f64 - (views - 1) as f64 / 2.0);
                assert!((toolbox - here).abs() < 1e-13, "view {view} of {views}: {toolbox} and {here}");
            }
        }
    }
    assert!(slope_from_disparity(1.0, 1).is_err() && disparity_from_slope(1.0, 0).is_err());
}

#[test]
fn distances_use_the_baselines_of_both_axes() {
    let shape = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(16, 16)).unwrap();
    let rig = Rig::builder(shape)
        .focal_length_m(0.1)
        .sensor_size_m(0.035)
        .baseline_x_m(0.04)
        .baseline_y_m(0.02)
        .focus_distance_m(4.0)
        .build()
        .unwrap();
    let light_field = noise(shape, 1, |byte| byte);
    let refocus = Refocus::new(shape.views()).unwrap().baseline_ratio(ratio(0.5));
    for distance_m in [2.0, 4.0, f64::INFINITY] {
        let disparity_px = rig.disparity_x().from_depth_m(distance_m);
        let expected = refocus.at_disparity(&light_field, disparity_px).unwrap();
        // The ratio applies to disparities only, and half of a double is exact.
        let without_ratio = Refocus::new(shape.views()).unwrap();
        assert_eq!(without_ratio.at_distance_m(&light_field, &rig, distance_m), Ok(expected));
    }
    for distance_m in [0.0, -1.0, f64::NAN] {
        assert!(refocus.at_distance_m(&light_field, &rig, distance_m).is_err(), "{distance_m}");
    }
    let other = light_field.clip_lenses(0..8, 0..16).unwrap();
    assert!(matches!(refocus.at_distance_m(&other, &rig, 4.0), Err(Error::Shape { .. })));
}

/// A rig of one axis: a baseline of 0 shifts nothing along it, however many views it has.
#[test]
fn a_baseline_of_zero_shifts_nothing() {
    let shape = LightFieldShape::new(GridSize::new(3, 5), GridSize::new(9, 16)).unwrap();
    let light_field = noise(shape, 1, |byte| byte);
    let plain = Refocus::new(shape.views()).unwrap();
    for (x_m, y_m, vertical, horizontal) in [(0.04, 0.0, 0.0, 1.5), (0.0, 0.04, 1.5, 0.0)] {
        let rig = Rig::builder(shape).baseline_x_m(x_m).baseline_y_m(y_m).focus_distance_m(4.0).build().unwrap();
        let found = plain.clone().baseline_ratio(rig.baseline_ratio()).at_disparity(&light_field, 1.5).unwrap();
        let aperture = Aperture::all(shape.views()).unwrap();
        // The reference implementation on the array with its axes exchanged where the horizontal baseline is 0.
        let expected = if horizontal > 0.0 {
            naive::refocused(&light_field, &aperture, Kernel::CatmullRom, (1.0, 2.0), vertical, &|_, _| horizontal)
        } else {
            let turned = light_field.samples().permuted_axes([1, 0, 3, 2, 4]).as_standard_layout().into_owned();
            let turned = LightField::new(turned).unwrap();
            let aperture = Aperture::all(turned.shape().views()).unwrap();
            let image =
                naive::refocused(&turned, &aperture, Kernel::CatmullRom, (2.0, 1.0), horizontal, &|_, _| vertical);
            image.permuted_axes([1, 0, 2])
        };
        assert_close(found.view(), expected.view(), bound(shape, 255.0), &format!("{x_m} {y_m}"));
        let map = Array2::from_elem((9, 16), 1.5);
        let everywhere = plain.clone().baseline_ratio(rig.baseline_ratio()).all_in_focus(&light_field, &map).unwrap();
        assert_close(everywhere.view(), expected.view(), bound(shape, 255.0), &format!("{x_m} {y_m}, every pixel"));
    }
}

/// LFFiltShiftSum: `linspace(-1/2, 1/2, T) * slope * T` rows and `linspace(-1/2, 1/2, S) * slope * S` columns.
#[test]
fn slopes_have_a_step_of_their_own_for_each_axis() {
    for (rows, columns) in [(3, 5), (1, 4), (4, 1), (2, 2)] {
        let shape = LightFieldShape::new(GridSize::new(rows, columns), GridSize::new(9, 16)).unwrap();
        let light_field = noise(shape, 1, |byte| byte);
        let middle = ((rows - 1) as f64 / 2.0, (columns - 1) as f64 / 2.0);
        let refocus = Refocus::new(shape.views()).unwrap().reference(middle.0, middle.1).unwrap();
        // The ratio of the baselines is none of the toolbox's business.
        let found = refocus.baseline_ratio(ratio(0.3)).at_slope(&light_field, 0.8).unwrap();
        let step = |views: usize| if views > 1 { 0.8 * views as f64 / (views - 1) as f64 } else { 0.0 };
        let aperture = Aperture::all(shape.views()).unwrap();
        // Added to the sample position, in contrast to the disparity.
        let (disparity, vertical_over_horizontal) = match step(columns) {
            0.0 => (-1e-9, step(rows) / 1e-9),
            along => (-along, step(rows) / along),
        };
        let expected =
            naive::refocused(&light_field, &aperture, Kernel::CatmullRom, middle, vertical_over_horizontal, &|_, _| {
                disparity
            });
        assert_close(found.view(), expected.view(), bound(shape, 255.0), &format!("{rows} x {columns}"));
    }
}

#[test]
fn wrong_numbers_and_shapes_are_errors() {
    let shape = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(4, 5)).unwrap();
    let light_field = noise(shape, 1, |byte| byte);
    let refocus = Refocus::new(shape.views()).unwrap();
    for value in [f64::NAN, f64::INFINITY] {
        assert!(refocus.at_disparity(&light_field, value).is_err());
        assert!(refocus.clone().reference(0.0, value).is_err() && refocus.at_slope(&light_field, value).is_err());
    }
    let other = Refocus::new(GridSize::new(3, 4)).unwrap();
    assert!(matches!(other.at_disparity(&light_field, 0.0), Err(Error::Shape { what: "aperture", .. })));
    let map = Array2::<f32>::zeros((5, 4));
    assert!(matches!(refocus.all_in_focus(&light_field, &map), Err(Error::Shape { what: "disparity map", .. })));
    // A huge but finite disparity: only the reference view is left.
    let image = refocus.at_disparity(&light_field, 1e300).unwrap();
    assert_eq!(image, light_field.view(1, 1).unwrap().mapv(f32::from));
    let one_pixel = LightField::new(Array5::from_elem((1, 1, 3, 3, 1), 7_u8)).unwrap();
    assert_eq!(refocus.at_disparity(&one_pixel, 0.2).unwrap()[[0, 0, 0]], 7.0);
}

/// The documented bound of a synthetic aperture: cameras at the place of the view show their own pixels, and the image is their mean.
#[test]
fn the_mean_of_images_is_within_the_stated_bound() {
    const COUNT: usize = 1000;
    let size = GridSize::new(7, 9);
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let camera = Pinhole::new(axes, [0.0; 3], 20.0, size).unwrap();
    let mut aperture = SyntheticAperture::new(camera, Kernel::Bilinear);
    let mut expected = Array3::<f64>::zeros((size.rows, size.columns, 1));
    let mut largest = 0.0_f64;
    for number in 0..COUNT {
        let value = |(row, column, _): (usize, usize, usize)| {
            // Magnitudes from 1e-3 to 1e3, so that sums round.
            let random = byte((number * size.rows + row) * size.columns + column);
            10_f32.powf(f32::from(random) / 42.5 - 3.0)
        };
        let image = Array3::from_shape_fn((size.rows, size.columns, 1), value);
        largest = image.iter().fold(largest, |most, &value| most.max(f64::from(value)));
        expected += &image.mapv(f64::from);
        aperture.add(&camera, image.view(), 1.0, FocalPlane::new(2.0).unwrap()).unwrap();
    }
    expected /= COUNT as f64;
    let bound = (COUNT + 20) as f64 * 2.0_f64.powi(-23) * largest;
    assert_close(aperture.image().unwrap().view(), expected.view(), bound, "synthetic aperture");
}
