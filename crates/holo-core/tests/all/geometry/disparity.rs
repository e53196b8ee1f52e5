//! Eq. 2 and Eq. 3 against references of higher precision, at the ends of their ranges and at infinity.

use super::double_double::{DoubleDouble, exact, ulps};
use super::exact::{Exact, is_within};
use holo_core::{Disparity, Error, GridSize, LightFieldShape, Projection, Rig, StereoPair};
use ndarray::{Array2, array};
use proptest::prelude::*;

const BOTH: [Projection; 2] = [Projection::Perspective, Projection::Orthographic];

/// Eq. 3 with about 100 bits.
fn reference(scale: f64, focus_m: f64, depth_m: f64, projection: Projection) -> DoubleDouble {
    let (k, f, z) = (exact(scale), exact(focus_m), exact(depth_m));
    match projection {
        Projection::Perspective => k * (f - z) / (z * f),
        Projection::Orthographic => k * (f - z) / (f * f),
    }
}

/// Log-uniform numbers between two powers of ten.
fn decades(from: f64, to: f64) -> impl Strategy<Value = f64> {
    (from..to).prop_map(|exponent| 10_f64.powf(exponent))
}

/// Depths from near to far, and depths next to the focus plane, down to the next f64.
fn focus_and_depth() -> impl Strategy<Value = (f64, f64)> {
    (decades(-3.0, 9.0), decades(-3.0, 9.0), decades(-16.0, 0.0), any::<bool>(), 0..4_u8).prop_map(
        |(focus_m, depth_m, hair, nearer, kind)| match kind {
            0 | 1 => (focus_m, depth_m),
            2 => (focus_m, focus_m * if nearer { 1.0 - hair / 2.0 } else { 1.0 + hair }),
            _ => (focus_m, if nearer { focus_m.next_down() } else { focus_m.next_up() }),
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    /// Four roundings and no cancellation after the first: at most 4 ulp, at any distance from the focus plane. (The
    /// difference of reciprocals would be off by 1e15 ulp next to it.)
    #[test]
    fn disparity_is_within_4_ulp((focus_m, depth_m) in focus_and_depth(), scale in decades(-9.0, 6.0)) {
        for projection in BOTH {
            let disparity = Disparity::new(scale, focus_m, projection).unwrap().from_depth_m(depth_m);
            if depth_m == focus_m {
                prop_assert_eq!(disparity, 0.0);
            } else {
                let off = ulps(disparity, reference(scale, focus_m, depth_m, projection));
                prop_assert!(off <= 4.0, "{off} ulp at F = {focus_m:e}, Z = {depth_m:e}, k = {scale:e}");
            }
        }
    }

    /// The same without any rounding in the reference: integers of as many bits as it takes (up to 290 here).
    #[test]
    fn disparity_is_within_4_ulp_of_the_exact_quotient(
        (focus_m, depth_m) in focus_and_depth(),
        scale in decades(-9.0, 6.0),
    ) {
        let [k, f, z] = [scale, focus_m, depth_m].map(Exact::new);
        for projection in BOTH {
            let disparity = Disparity::new(scale, focus_m, projection).unwrap().from_depth_m(depth_m);
            let numerator = k.clone() * (f.clone() - z.clone());
            let denominator = match projection {
                Projection::Perspective => z.clone() * f.clone(),
                Projection::Orthographic => f.clone() * f.clone(),
            };
            prop_assert!(
                is_within(disparity, 4.0, numerator, denominator),
                "{disparity:e} at F = {focus_m:e}, Z = {depth_m:e}, k = {scale:e}"
            );
        }
    }

    /// A focus at infinity and a depth of infinity: k/Z and -k/F, one rounding each.
    #[test]
    fn infinite_distances_are_limits((focus_m, depth_m) in focus_and_depth(), scale in decades(-9.0, 6.0)) {
        let [k, f, z] = [scale, focus_m, depth_m].map(Exact::new);
        let unfocused = Disparity::new(scale, f64::INFINITY, Projection::Perspective).unwrap();
        prop_assert!(is_within(unfocused.from_depth_m(depth_m), 1.0, k.clone(), z));
        let focused = Disparity::new(scale, focus_m, Projection::Perspective).unwrap();
        let no_hit = focused.from_depth_m(f64::INFINITY);
        prop_assert!(is_within(-no_hit, 1.0, k, f));
    }

    /// In f32 maps, too, near and far from the focus plane: the f64 result, rounded once.
    #[test]
    fn f32_maps_round_once((focus_m, depth_m) in focus_and_depth(), scale in decades(-9.0, 6.0)) {
        for projection in BOTH {
            let map = Disparity::new(scale, focus_m, projection).unwrap();
            let stored_m = depth_m as f32;
            let found = map.map_from_depth_m(&array![stored_m])[0];
            prop_assert_eq!(found, map.from_depth_m(f64::from(stored_m)) as f32);
        }
    }

    /// From the parameters of a rig, with baselines from a nanometer to a meter: k = b f N / sensor has three more
    /// roundings.
    #[test]
    fn rigs_have_the_disparity_of_their_parameters(
        (focus_m, depth_m) in focus_and_depth(),
        baseline_m in decades(-9.0, 0.0),
        focal_m in decades(-3.0, 0.0),
        columns in 1_usize..5000,
    ) {
        let shape = LightFieldShape::new(GridSize::new(1, 2), GridSize::new(1, columns)).unwrap();
        let rig = Rig::builder(shape)
            .focal_length_m(focal_m)
            .sensor_size_m(0.036)
            .baseline_m(baseline_m)
            .focus_distance_m(focus_m)
            .build()
        .unwrap();
        if depth_m != focus_m {
            let [b, f, n, sensor] = [baseline_m, focal_m, columns as f64, 0.036].map(Exact::new);
            let [focus, z] = [focus_m, depth_m].map(Exact::new);
            let numerator = b * f * n * (focus.clone() - z.clone());
            let disparity = rig.disparity().from_depth_m(depth_m);
            let is_exact = is_within(disparity, 7.0, numerator, sensor * z * focus);
            prop_assert!(is_exact, "{disparity:e} at b = {baseline_m:e}");
        }
    }

    /// A fused multiply-add, a division and a multiplication: at most 3 ulp for the disparity as given.
    #[test]
    fn depth_is_within_3_ulp((focus_m, depth_m) in focus_and_depth(), scale in decades(-9.0, 6.0)) {
        for projection in BOTH {
            let map = Disparity::new(scale, focus_m, projection).unwrap();
            let disparity = map.from_depth_m(depth_m);
            let depth_again_m = map.to_depth_m(disparity);
            let (k, f, d) = (exact(scale), exact(focus_m), exact(disparity));
            let expected = match projection {
                Projection::Perspective => k * f / (d * f + k),
                Projection::Orthographic => f * (k - d * f) / k,
            };
            // The rounded disparity may equal the disparity of infinity.
            if depth_again_m.is_finite() {
                let off = ulps(depth_again_m, expected);
                prop_assert!(off <= 3.0, "{off} ulp at F = {focus_m:e}, Z = {depth_m:e}, k = {scale:e}");
            } else {
                prop_assert!(disparity == map.at_infinity_px());
            }
        }
    }

    /// The round trip: the disparity has an error of 4 ulp, which the inverse turns into `|F - Z|/F` (perspective:
    /// times Z/Z) of depth; 8 eps of the larger of the two depths, over the smaller, covers both directions.
    #[test]
    fn depth_survives_the_round_trip((focus_m, depth_m) in focus_and_depth(), scale in decades(-9.0, 6.0)) {
        for projection in BOTH {
            let map = Disparity::new(scale, focus_m, projection).unwrap();
            let again_m = map.to_depth_m(map.from_depth_m(depth_m));
            // dZ/Z = (Z/F - 1) * dd/d (perspective), (F/Z - 1) * dd/d (orthographic), dd/d <= 4 eps; the inverse adds 3
            // * eps.
            let amplification = match projection {
                Projection::Perspective => (depth_m / focus_m - 1.0).abs(),
                Projection::Orthographic => (focus_m / depth_m - 1.0).abs(),
            };
            let bound = (4.0 * amplification + 4.0) * f64::EPSILON * depth_m;
            // Beyond 1e14 times the focus distance, rounding may make it infinity: no first-order bound holds there.
            if bound < 0.01 * depth_m {
                prop_assert!((again_m - depth_m).abs() <= bound * 1.02, "{again_m:e} for {depth_m:e}");
            }
        }
    }

    #[test]
    fn eq_2_is_within_2_ulp(
        baseline_m in decades(-9.0, 1.0),
        focal_m in decades(-4.0, 1.0),
        depth_m in decades(-3.0, 9.0),
    ) {
        let pair = StereoPair::new(baseline_m, focal_m).unwrap();
        let displacement_m = pair.displacement_from_depth_m(depth_m);
        let scale = exact(baseline_m) * exact(focal_m);
        prop_assert!(ulps(displacement_m, scale / exact(depth_m)) <= 2.0);
        let again_m = pair.depth_from_displacement_m(displacement_m);
        prop_assert!(ulps(again_m, scale / exact(displacement_m)) <= 2.0);
    }
}

/// The reference has more digits than f64: 1/3 to 100 bits, and a cancellation.
#[test]
fn the_reference_has_twice_the_digits() {
    let third = exact(1.0) / exact(3.0);
    let one = third * exact(3.0);
    assert!(ulps(1.0, one) < 2_f64.powi(-45));
    // The difference of reciprocals is off by far more than 4 ulp there, so the test above can fail.
    let (k, focus_m) = (40.0, 4.25);
    let depth_m: f64 = focus_m * (1.0 + 1e-13);
    let naive = k * (1.0 / depth_m - 1.0 / focus_m);
    assert!(ulps(naive, reference(k, focus_m, depth_m, Projection::Perspective)) > 1e9);
}

#[test]
fn a_femto_away_from_the_focus_plane() {
    for focus_m in [1e-3, 0.3, 1.0, 4.25, 1e3, 1e9] {
        for relative in [1.0 + 1e-15, 1.0 - 1e-15, 1.0 + 3e-16, 1.0 - 2e-16] {
            let depth_m = focus_m * relative;
            for projection in BOTH {
                let map = Disparity::new(1e-9, focus_m, projection).unwrap();
                let disparity = map.from_depth_m(depth_m);
                assert!(disparity != 0.0 && (disparity > 0.0) == (depth_m < focus_m));
                assert!(ulps(disparity, reference(1e-9, focus_m, depth_m, projection)) <= 4.0);
                // The inverse's own 3 roundings; the 4 ulp of the disparity are shrunk by |Z/F - 1| = 1e-15.
                assert!(ulps(map.to_depth_m(disparity), exact(depth_m)) <= 3.0 + 1e-9);
            }
        }
    }
}

/// Z*F, F^2 and (F-Z)/F leave the range of f64 here, the results do not.
#[test]
fn intermediate_results_do_not_overflow() {
    let perspective =
        |focus_m, depth_m| Disparity::new(2.0, focus_m, Projection::Perspective).unwrap().from_depth_m(depth_m);
    // F tiny, Z huge: -k/F. Z tiny, F huge: k/Z. Both tiny, both huge.
    assert_eq!(perspective(1e-200, 1e200), -2.0 / 1e-200);
    assert_eq!(perspective(1e200, 1e-200), 2.0 / 1e-200);
    assert_eq!(perspective(4e-200, 2e-200), 2.0 * 0.5 / 2e-200);
    assert_eq!(perspective(2e200, 4e200), 2.0 * -0.5 / 2e200);
    assert_eq!(perspective(f64::MAX, f64::MAX), 0.0);
    assert_eq!(perspective(1e300, f64::MAX), -2.0 * ((f64::MAX - 1e300) / f64::MAX) / 1e300);
    let orthographic = Disparity::new(2.0, 1e-160, Projection::Orthographic).unwrap();
    assert_eq!(orthographic.from_depth_m(0.5e-160), 2.0 * 0.5 / 1e-160);
}

/// A scale of 2^-930 = 1.1e-280 loses no digit: every result is that of scale 1 times a power of two.
#[test]
fn tiny_scales_keep_all_digits() {
    let tiny = 2_f64.powi(-930);
    for projection in BOTH {
        for depth_m in [1e-3, 4.25_f64.next_down(), 4.25_f64.next_up(), 1e6] {
            let disparity = |scale| Disparity::new(scale, 4.25, projection).unwrap().from_depth_m(depth_m);
            assert_eq!(disparity(tiny), disparity(1.0) * tiny);
        }
    }
}

#[test]
fn the_infinite_cases() {
    let finite = Disparity::new(12.0, 4.0, Projection::Perspective).unwrap();
    assert_eq!(finite.from_depth_m(f64::INFINITY), -3.0);
    assert_eq!(finite.to_depth_m(-3.0), f64::INFINITY);
    assert_eq!(finite.at_infinity_px(), -3.0);
    // The limit of finite depths is the value at infinity.
    assert!(ulps(finite.from_depth_m(1e300), exact(-3.0)) <= 1.0);

    let at_infinity = Disparity::new(12.0, f64::INFINITY, Projection::Perspective).unwrap();
    assert_eq!(at_infinity.from_depth_m(4.0), 3.0);
    assert_eq!(at_infinity.to_depth_m(3.0), 4.0);
    assert_eq!(at_infinity.from_depth_m(f64::INFINITY), 0.0);
    assert_eq!(at_infinity.to_depth_m(0.0), f64::INFINITY);
    assert_eq!(at_infinity.to_depth_m(-0.0), f64::INFINITY, "not minus infinity");

    let orthographic = Disparity::new(12.0, 4.0, Projection::Orthographic).unwrap();
    assert_eq!(orthographic.from_depth_m(f64::INFINITY), f64::NEG_INFINITY);
    assert_eq!(orthographic.to_depth_m(f64::NEG_INFINITY), f64::INFINITY);
    // It is linear in depth and has Eq. 3's slope at the focus plane: -k/F^2 = -0.75 px/m.
    assert_eq!(orthographic.from_depth_m(3.0), 0.75);
    assert_eq!(orthographic.from_depth_m(6.0), -1.5);
    let step_m = 1e-6;
    let slope = (finite.from_depth_m(4.0 + step_m) - finite.from_depth_m(4.0 - step_m)) / (2.0 * step_m);
    // A central difference is off by step^2 * d'''/6 = 1e-12 * 0.05, plus eps/step = 2e-10 of rounding.
    assert!((slope + 0.75).abs() < 1e-9);
    assert!(finite.from_depth_m(f64::NAN).is_nan() && finite.to_depth_m(f64::NAN).is_nan());
}

/// -k/F is rounded for most k and F; the depth must be infinity and not a huge number of either
/// sign.
#[test]
fn infinity_round_trips_in_spite_of_rounding() {
    for numerator in 1..200 {
        for denominator in 1..50 {
            let map = Disparity::new(f64::from(numerator) / 7.0, f64::from(denominator) / 3.0, Projection::Perspective)
                .unwrap();
            assert_eq!(map.to_depth_m(map.from_depth_m(f64::INFINITY)), f64::INFINITY);
            let no_hit = array![f32::INFINITY];
            assert_eq!(map.map_to_depth_m(&map.map_from_depth_m(&no_hit)).unwrap(), no_hit);
        }
    }
}

#[test]
fn views_that_coincide_have_no_disparity() {
    for projection in BOTH {
        let map = Disparity::new(0.0, 4.0, projection).unwrap();
        for depth_m in [0.0, 1e-300, 4.0, f64::INFINITY] {
            assert_eq!(map.from_depth_m(depth_m), 0.0);
        }
        assert!(map.to_depth_m(0.0).is_nan());
        assert_eq!(map.map_to_depth_m(&array![0.0_f32]), Err(Error::NoBaseline));
    }
}

#[test]
fn impossible_numbers_are_errors() {
    for scale in [f64::NAN, -1.0, f64::INFINITY] {
        assert!(matches!(Disparity::new(scale, 4.0, Projection::Perspective), Err(Error::BadNumber { .. })), "{scale}");
    }
    for focus_m in [f64::NAN, 0.0, -4.0, f64::NEG_INFINITY] {
        assert!(
            matches!(Disparity::new(1.0, focus_m, Projection::Perspective), Err(Error::BadNumber { .. })),
            "{focus_m}"
        );
    }
    assert_eq!(
        Disparity::new(1.0, f64::INFINITY, Projection::Orthographic),
        Err(Error::OrthographicFocus { focus_distance_m: f64::INFINITY })
    );
}

/// Maps are the scalar form, rounded once, for any dimension and any strides.
#[test]
fn maps_are_the_scalar_form() {
    let map = Disparity::new(36.57, 4.25, Projection::Perspective).unwrap();
    let depth_m = Array2::from_shape_fn((7, 11), |(row, column)| {
        if (row + column) % 5 == 0 { f32::INFINITY } else { 0.5 + (row * 11 + column) as f32 / 3.0 }
    });
    let disparity = map.map_from_depth_m(&depth_m.t());
    assert_eq!(disparity.dim(), (11, 7));
    for ((row, column), &value) in disparity.indexed_iter() {
        assert_eq!(value, map.from_depth_m(f64::from(depth_m[[column, row]])) as f32);
    }
    let again_m = map.map_to_depth_m(&disparity).unwrap();
    for (&again_m, &depth_m) in again_m.iter().zip(depth_m.t().iter()) {
        if depth_m.is_infinite() {
            assert_eq!(again_m, f32::INFINITY);
        } else {
            // The f32 disparity is good to half an f32 eps, amplified by |Z/F - 1| < 5.3; rounding the depth adds
            // another half.
            assert!((again_m - depth_m).abs() <= 4.0 * f32::EPSILON * depth_m, "{again_m} for {depth_m}");
        }
    }
    // f64 maps are not rounded at all.
    let wide = array![[[3.5_f64, 6.0]]];
    assert_eq!(map.map_from_depth_m(&wide)[[0, 0, 1]], map.from_depth_m(6.0));
}

#[test]
fn eq_2_at_its_ends() {
    let pair = StereoPair::new(0.1, 0.05).unwrap();
    assert_eq!(pair.displacement_from_depth_m(f64::INFINITY), 0.0);
    assert_eq!(pair.depth_from_displacement_m(0.0), f64::INFINITY);
    assert_eq!(pair.depth_from_displacement_m(-0.0), f64::INFINITY);
    let depth_m = array![[1.0_f32, 2.0, f32::INFINITY]];
    let displacement_m = pair.map_displacement_from_depth_m(&depth_m);
    assert_eq!(displacement_m, array![[0.005_f32, 0.0025, 0.0]]);
    assert_eq!(pair.map_depth_from_displacement_m(&displacement_m).unwrap(), depth_m);
    let none = StereoPair::new(0.0, 0.05).unwrap();
    assert_eq!(none.displacement_from_depth_m(0.0), 0.0);
    assert!(none.depth_from_displacement_m(0.0).is_nan());
    assert_eq!(none.map_depth_from_displacement_m(&depth_m), Err(Error::NoBaseline));
    for (baseline_m, focal_m) in [(f64::NAN, 1.0), (-1.0, 1.0), (1.0, 0.0), (1.0, f64::NAN), (1e200, 1e200)] {
        assert!(StereoPair::new(baseline_m, focal_m).is_err());
    }
}

/// Eq. 2 is Eq. 3 with the focus at infinity: meters on the sensor instead of pixels.
#[test]
fn eq_2_is_eq_3_focused_at_infinity() {
    let (baseline_m, focal_m, sensor_m, pixels) = (0.025, 0.1, 0.035, 512.0);
    let pair = StereoPair::new(baseline_m, focal_m).unwrap();
    let map = Disparity::new(baseline_m * focal_m * pixels / sensor_m, f64::INFINITY, Projection::Perspective).unwrap();
    for depth_m in [0.1, 1.0, 3.7, 1e6] {
        let pixels_moved = pair.displacement_from_depth_m(depth_m) * pixels / sensor_m;
        // Eight roundings apart.
        assert!((pixels_moved / map.from_depth_m(depth_m) - 1.0).abs() < 8.0 * f64::EPSILON);
    }
}

/// Perspective and orthographic disparities agree to first order at the focus plane: they differ by k (F - Z)^2 / (F^2 Z).
#[test]
fn projections_agree_to_first_order_at_the_focus_plane() {
    let (k, focus_m) = (12.0, 1.7);
    let [perspective, orthographic] = [Projection::Perspective, Projection::Orthographic]
        .map(|projection| Disparity::new(k, focus_m, projection).unwrap());
    for depth_m in [0.4, 1.2, 1.69, 1.7, 1.701, 2.5, 80.0] {
        let difference = perspective.from_depth_m(depth_m) - orthographic.from_depth_m(depth_m);
        let expected = k * (focus_m - depth_m).powi(2) / (focus_m * focus_m * depth_m);
        assert!((difference - expected).abs() < 1e-13 * (1.0 + expected), "{depth_m}: {difference} {expected}");
    }
}
