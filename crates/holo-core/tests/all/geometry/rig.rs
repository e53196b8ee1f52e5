//! The rig: rays, pixels and disparity agree.

use holo_core::{Error, GridSize, Intrinsics, LightFieldShape, Projection, Rig};
use proptest::prelude::*;

const BOTH: [Projection; 2] = [Projection::Perspective, Projection::Orthographic];

fn rig(views: (usize, usize), lenses: (usize, usize), focus_distance_m: f64, projection: Projection) -> Rig {
    Rig::builder(LightFieldShape::new(GridSize::new(views.0, views.1), GridSize::new(lenses.0, lenses.1)).unwrap())
        .focal_length_m(0.1)
        .sensor_size_m(0.035)
        .baseline_x_m(0.025)
        .baseline_y_m(0.0125)
        .focus_distance_m(focus_distance_m)
        .projection(projection)
        .build()
        .unwrap()
}

/// The intersection of the focus plane with the line through the rig's center and a pixel: the point P.
fn focus_point_m(rig: &Rig, row: f64, column: f64) -> [f64; 3] {
    let focus_m = rig.focus_distance_m();
    [rig.slope_x(column) * focus_m, rig.slope_y(row) * focus_m, -focus_m]
}

fn near(left: f64, right: f64, tolerance: f64) -> bool {
    (left - right).abs() <= tolerance
}

#[test]
fn the_published_numbers_of_a_known_rig() {
    // HCI "cotton": baseline 25 mm, f 100 mm, sensor 35 mm, 512 px, focus 4.25 m; printed to four digits.
    let rig = rig((9, 9), (512, 512), 4.25, Projection::Perspective);
    assert!(near(rig.disparity().from_depth_m(3.5), 1.8439, 5e-5));
    assert!(near(rig.disparity().from_depth_m(6.0), -2.5098, 5e-5));
    // The add-on's `offset` key is the disparity of infinity with the other sign: 8.605.
    assert!(near(rig.disparity().at_infinity_px(), -8.605, 5e-4));
    // Half the baseline, half the disparity: a power of two is exact.
    assert_eq!(rig.disparity_y().from_depth_m(3.5), rig.disparity_x().from_depth_m(3.5) / 2.0);
    assert_eq!(rig.disparity(), rig.disparity_x());
}

#[test]
fn views_are_centered_for_odd_and_even_counts() {
    let rig = rig((2, 5), (3, 4), 2.0, Projection::Perspective);
    assert_eq!((0..5).map(|s| rig.view_x_m(s)).collect::<Vec<_>>(), [-0.05, -0.025, 0.0, 0.025, 0.05]);
    // Row 0 is the top one: +Y.
    assert_eq!((0..2).map(|t| rig.view_y_m(t)).collect::<Vec<_>>(), [0.006_25, -0.006_25]);
    // Pixels: slopes increase to the right, decrease downward, and are 0 in the middle of the image.
    assert_eq!((rig.slope_x(2.0), rig.slope_y(1.5)), (0.0, 0.0));
    assert!(rig.slope_x(3.0) > 0.0 && rig.slope_y(3.0) < 0.0);
    // The larger side, 4 px, spans the sensor: its edges have the slope sens/(2f).
    assert!(near(rig.slope_x(4.0), 0.035 / 0.2, 1e-17));
    assert_eq!(rig.slope_x(0.0), -rig.slope_x(4.0));
}

/// All rays of one elemental image pass through one point of the focus plane, for either projection.
#[test]
fn rays_of_an_elemental_image_meet_in_one_point() {
    for projection in BOTH {
        for focus_m in [0.01, 4.25, 1e6] {
            let rig = rig((4, 5), (6, 7), focus_m, projection);
            for (v, u, jx, jy) in [(0, 0, 0.5, 0.5), (5, 6, 0.5, 0.5), (2, 3, 0.0, 1.0), (4, 1, 0.25, 0.75)] {
                let point_m = focus_point_m(&rig, v as f64 + jy, u as f64 + jx);
                for t in 0..4 {
                    for s in 0..5 {
                        let ray = rig.ray(v, u, t, s, jx, jy);
                        assert_eq!(ray.direction[2], -1.0);
                        assert_eq!(ray.origin_m[2], 0.0);
                        let at_focus_m = ray.at_depth_m(focus_m);
                        // A few roundings of numbers no larger than the view's position and the point.
                        let tolerance = 8.0 * f64::EPSILON * (focus_m + 0.05);
                        assert!((0..3).all(|axis| near(at_focus_m[axis], point_m[axis], tolerance)));
                    }
                }
            }
        }
    }
}

#[test]
fn perspective_rays_start_at_the_view_and_orthographic_ones_are_parallel() {
    let perspective = rig((4, 5), (6, 7), 4.0, Projection::Perspective);
    let orthographic = rig((4, 5), (6, 7), 4.0, Projection::Orthographic);
    for (t, s) in (0..4).flat_map(|t| (0..5).map(move |s| (t, s))) {
        let first = orthographic.ray(0, 0, t, s, 0.5, 0.5);
        for (v, u) in (0..6).flat_map(|v| (0..7).map(move |u| (v, u))) {
            let origin_m = perspective.ray(v, u, t, s, 0.5, 0.5).origin_m;
            assert_eq!(origin_m, [perspective.view_x_m(s), perspective.view_y_m(t), 0.0]);
            let direction = orthographic.ray(v, u, t, s, 0.5, 0.5).direction;
            assert_eq!(direction, first.direction);
            assert_eq!(direction, [-orthographic.view_x_m(s) / 4.0, -orthographic.view_y_m(t) / 4.0, -1.0]);
        }
    }
}

#[test]
fn without_a_focus_plane_there_is_no_shift() {
    let unshifted = rig((3, 3), (4, 4), f64::INFINITY, Projection::Perspective);
    assert_eq!(unshifted.inverse_focus_per_m(), 0.0);
    let directions: Vec<_> = (0..3).map(|s| unshifted.ray(1, 2, 0, s, 0.5, 0.5).direction).collect();
    assert_eq!(directions[0], directions[2]);
    assert_eq!(directions[1], [unshifted.slope_x(2.5), unshifted.slope_y(1.5), -1.0]);
    assert!(unshifted.disparity().from_depth_m(2.0) > 0.0);
    assert_eq!(unshifted.disparity().from_depth_m(f64::INFINITY), 0.0);
    let finite = rig((3, 3), (4, 4), 4.0, Projection::Perspective);
    assert_eq!(finite.inverse_focus_per_m(), 0.25);
}

fn lengths() -> impl Strategy<Value = f64> {
    (-2.0..4.0_f64).prop_map(|exponent| 10_f64.powf(exponent))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// The rays agree with Eq. 3: a point moves by `-d_x` columns per view to the right and `-d_y` rows per view
    /// down.
    #[test]
    fn disparity_agrees_with_rays(
        focus_m in lengths(),
        depth_m in lengths(),
        (views, lenses) in ((1..7_usize, 1..7_usize), (1..40_usize, 1..40_usize)),
        (x, y) in (-1.0..1.0_f64, -1.0..1.0_f64),
    ) {
        for projection in BOTH {
            let rig = rig(views, lenses, focus_m, projection);
            let point_m = [x * depth_m, y * depth_m, -depth_m];
            let (row, column) = rig.project(point_m, 0, 0).unwrap();
            let d_x = rig.disparity_x().from_depth_m(depth_m);
            let d_y = rig.disparity_y().from_depth_m(depth_m);
            for (t, s) in [(0, views.1 - 1), (views.0 - 1, 0), (views.0 - 1, views.1 - 1)] {
                let (row_there, column_there) = rig.project(point_m, t, s).unwrap();
                let (row_expected, column_expected) = (row - d_y * t as f64, column - d_x * s as f64);
                // Both are sums of a few terms, each good to some eps of the largest: the pixel itself, and the terms
                // of the disparity, k/Z and k/F (perspective) or those times Z/F (orthographic).
                let scale = rig.disparity_x().scale_m_px();
                let largest = column.abs().max(row.abs()).max(40.0)
                    + 6.0 * scale * (1.0 / depth_m + 1.0 / focus_m) * (1.0 + depth_m / focus_m);
                let tolerance = 32.0 * f64::EPSILON * largest;
                prop_assert!(near(row_there, row_expected, tolerance), "{row_there} is not {row_expected}");
                prop_assert!(near(column_there, column_expected, tolerance), "{column_there} is not {column_expected}");
            }
        }
    }

    /// The points of the ray of a pixel project to that pixel.
    #[test]
    fn project_is_the_inverse_of_ray(
        focus_m in lengths(),
        depth_m in lengths(),
        (v, u, t, s) in (0..30_usize, 0..40_usize, 0..5_usize, 0..6_usize),
        (jx, jy) in (0.0..1.0_f64, 0.0..1.0_f64),
    ) {
        for projection in BOTH {
            let rig = rig((5, 6), (30, 40), focus_m, projection);
            let point_m = rig.ray(v, u, t, s, jx, jy).at_depth_m(depth_m);
            let (row, column) = rig.project(point_m, t, s).unwrap();
            let scale = rig.disparity_x().scale_m_px();
            let largest = 40.0 + 6.0 * scale * (1.0 / depth_m + 1.0 / focus_m) * (1.0 + depth_m / focus_m);
            let tolerance = 32.0 * f64::EPSILON * largest;
            prop_assert!(near(row, v as f64 + jy, tolerance) && near(column, u as f64 + jx, tolerance));
        }
    }
}

#[test]
fn what_lies_behind_the_camera_is_not_seen() {
    let rig = rig((3, 3), (4, 4), 4.0, Projection::Perspective);
    for point_m in [[0.0, 0.0, 1.0], [0.0, 0.0, 0.0], [0.0, 0.0, f64::NEG_INFINITY], [f64::NAN, 0.0, -1.0]] {
        assert_eq!(rig.project(point_m, 0, 0), None);
    }
    assert_eq!(rig.project([0.0, 0.0, -4.0], 0, 0), Some((2.0, 2.0)));
}

#[test]
fn rows_and_columns_round_trip_through_slopes() {
    let rig = rig((3, 3), (31, 47), 4.0, Projection::Perspective);
    for pixel in [0.0, 0.5, 11.25, 30.0, 47.0, -3.0] {
        // Differences of at most 47 px from the middle, two roundings each way.
        assert!(near(rig.column(rig.slope_x(pixel)), pixel, 1e-13));
        assert!(near(rig.row(rig.slope_y(pixel)), pixel, 1e-13));
    }
}

#[test]
fn impossible_rigs_are_errors() {
    let good = rig((3, 3), (4, 4), 4.0, Projection::Perspective);
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0] {
        let bad = [
            good.to_builder().focal_length_m(value),
            good.to_builder().sensor_size_m(value),
            good.to_builder().baseline_x_m(value),
            good.to_builder().baseline_y_m(value),
        ];
        for bad in bad {
            assert!(matches!(bad.build(), Err(Error::BadNumber { .. })), "{bad:?}");
        }
    }
    for focus_distance_m in [f64::NAN, 0.0, -0.0, -4.0, f64::NEG_INFINITY] {
        assert!(good.to_builder().focus_distance_m(focus_distance_m).build().is_err(), "{focus_distance_m}");
    }
    assert!(matches!(
        good.to_builder().focus_distance_m(f64::INFINITY).projection(Projection::Orthographic).build(),
        Err(Error::OrthographicFocus { .. })
    ));
    // Numbers that are valid alone and overflow together.
    let tiny_focal = Intrinsics { focal_length_m: 1e-300, sensor_size_m: 1e300 };
    assert!(good.to_builder().intrinsics(tiny_focal).build().is_err());
    assert!(good.to_builder().baseline_x_m(f64::MAX).build().is_err());
    assert!(good.to_builder().baseline_x_m(1e10).focus_distance_m(f64::MIN_POSITIVE).build().is_err());
    assert!(good.to_builder().baseline_y_m(1e-310).build().is_err());
    // A baseline of 0 is valid: all views are equal.
    let still = good.to_builder().baseline_x_m(0.0).baseline_y_m(-0.0).build().unwrap();
    assert_eq!(still.disparity().from_depth_m(1.0), 0.0);
}

/// A baseline of 10 micrometers is not rounded to 0.
#[test]
fn a_baseline_of_ten_micrometers_survives() {
    let rig = rig((1, 3), (4, 4), 1e6, Projection::Perspective).to_builder().baseline_x_m(1e-5).build().unwrap();
    assert_eq!([rig.view_x_m(0), rig.view_x_m(1), rig.view_x_m(2)], [-1e-5, 0.0, 1e-5]);
    assert!(rig.disparity().from_depth_m(1.0) > 0.0);
}
