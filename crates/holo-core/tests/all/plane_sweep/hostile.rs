//! Images without texture, of one pixel, with NaN; and any number of threads.

use holo_core::{Effort, Error, LightField, PlaneSweepOptions, plane_sweep};
use ndarray::Array5;
use proptest::prelude::*;

use super::scenes::{Surface, plane};

const EFFORTS: [Effort; 4] = [Effort::Draft, Effort::Fast, Effort::Balanced, Effort::Thorough];

#[test]
fn an_image_of_one_color_has_confidence_zero() {
    for value in [0, 7, 255_u8] {
        let light_field = LightField::new(Array5::from_elem((20, 22, 5, 5, 3), value)).unwrap();
        for effort in EFFORTS {
            let options = PlaneSweepOptions::default().effort(effort);
            let found = plane_sweep(&light_field, &options).unwrap();
            assert!(found.confidence.iter().all(|&confidence| confidence == 0.0), "{value} {effort:?}");
            assert!(found.disparity_px.iter().all(|disparity_px| (-4.0..=4.0).contains(disparity_px)));
        }
    }
}

#[test]
fn threads_and_strides_change_no_bit() {
    let (light_field, _) = plane([40, 70, 5, 6, 3], Surface { here: -0.4, by_row: 0.01, by_column: 0.007 });
    let options = PlaneSweepOptions::default();
    let expected = plane_sweep(&light_field, &options).unwrap();
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| plane_sweep(&light_field, &options)).unwrap(), expected, "{threads} threads");
    }
    let shape = light_field.shape();
    let views = LightField::from_viewpoint_grid(light_field.to_viewpoint_grid().unwrap(), shape).unwrap();
    assert_eq!(plane_sweep(&views, &options).unwrap(), expected);
}

#[test]
fn impossible_inputs_are_errors() {
    let options = PlaneSweepOptions::default();
    let single = LightField::new(Array5::<u8>::zeros((8, 8, 1, 1, 3))).unwrap();
    let error = plane_sweep(&single, &options).unwrap_err();
    assert_eq!(error.to_string(), "the number of views beside the central one is 0; it must be at least 1");
    let mut samples = Array5::<f32>::zeros((8, 8, 3, 3, 1));
    samples[[4, 4, 1, 0, 0]] = f32::NAN;
    let holed = LightField::new(samples).unwrap();
    assert!(matches!(plane_sweep(&holed, &options), Err(Error::BadNumber { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// For all counts and samples the estimate is within the range, without a panic.
    #[test]
    fn any_light_field_has_an_estimate(
        counts in (1..12_usize, 1..12_usize, 1..5_usize, 1..5_usize, 1..5_usize),
        low in -20.0..20.0_f32,
        width in 0.001..30.0_f32,
        seed in any::<u32>(),
        effort in prop::sample::select(EFFORTS.to_vec()),
        exponent in -30..30_i32,
    ) {
        let mut state = seed;
        let samples = Array5::from_shape_fn(counts, |_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 * 10.0_f32.powi(exponent)
        });
        let light_field = LightField::new(samples).unwrap();
        let high = low + width;
        let options = PlaneSweepOptions::default().range_px(low, high).effort(effort);
        match plane_sweep(&light_field, &options) {
            Ok(found) => {
                prop_assert_eq!(found.disparity_px.dim(), (counts.0, counts.1));
                prop_assert!(found.disparity_px.iter().all(|disparity_px| (low..=high).contains(disparity_px)));
                prop_assert!(found.confidence.iter().all(|confidence| (0.0..=1.0).contains(confidence)));
            }
            Err(error) => prop_assert!(counts.2 * counts.3 == 1, "{}", error),
        }
    }
}
