//! Slanted planes without noise: errors below a hundredth of a pixel for any number of views.

use holo_core::{BaselineRatio, Effort, Error, PlaneSweepOptions, plane_sweep};

use super::scenes::{Surface, plane, plane_of, worst};

const SLANTED: Surface = Surface { here: -0.9, by_row: 0.021, by_column: 0.008 };

fn options(effort: Effort) -> PlaneSweepOptions {
    PlaneSweepOptions::default().range_px(-1.5, 2.0).effort(effort)
}

/// The border: half a window of the last fit, within which a plane has neighbors on one side only.
const BORDER: usize = 7;

#[test]
fn a_slanted_plane_is_exact_to_a_hundredth() {
    for effort in [Effort::Balanced, Effort::Thorough] {
        let (light_field, truth) = plane([72, 80, 9, 9, 3], SLANTED);
        let found = plane_sweep(&light_field, &options(effort)).unwrap();
        let worst = worst(&found.disparity_px, &truth, BORDER);
        // The remaining error is that of cubic interpolation of waves of 9 pixels.
        assert!(worst < 0.01, "{effort:?}: {worst}");
        assert!(found.confidence.iter().all(|confidence| (0.9..=1.0).contains(confidence)));
    }
}

#[test]
fn lower_efforts_have_larger_errors() {
    let (light_field, truth) = plane([72, 80, 9, 9, 1], SLANTED);
    let [draft, fast] = [Effort::Draft, Effort::Fast]
        .map(|effort| worst(&plane_sweep(&light_field, &options(effort)).unwrap().disparity_px, &truth, BORDER));
    // One round from a step of a quarter of a pixel, and two.
    assert!(draft < 0.1, "{draft}");
    assert!(fast < 0.03, "{fast}");
}

#[test]
fn rows_columns_pairs_and_even_counts_of_views_are_accepted() {
    for (view_rows, view_columns, bound) in
        [(1, 9, 0.01), (9, 1, 0.01), (8, 6, 0.01), (2, 9, 0.01), (3, 3, 0.01), (1, 2, 0.02), (2, 1, 0.02)]
    {
        let surface = Surface { here: -0.5, by_row: 0.011, by_column: 0.006 };
        let (light_field, truth) = plane([64, 64, view_rows, view_columns, 3], surface);
        let found = plane_sweep(&light_field, &options(Effort::Balanced)).unwrap();
        let worst = worst(&found.disparity_px, &truth, BORDER);
        // A single other view has no opposite one, whose errors of interpolation have the other sign.
        assert!(worst < bound, "{view_rows} x {view_columns}: {worst}");
    }
}

#[test]
fn baselines_may_differ_and_one_of_them_may_be_zero() {
    let ratios = [2.0, 0.5, 0.3, 0.0].map(|ratio| BaselineRatio::vertical_over_horizontal(ratio).unwrap());
    for ratio in ratios.into_iter().chain([BaselineRatio::VERTICAL_ONLY]) {
        let (light_field, truth) = plane_of([72, 80, 9, 9, 3], SLANTED, ratio);
        let options = options(Effort::Balanced).baseline_ratio(ratio);
        let found = plane_sweep(&light_field, &options).unwrap();
        // Views that are twice as far away see the plane shortened by another hundredth: its waves of 9 pixels.
        let border = if ratio.vertical() > 1.0 { 2 * BORDER } else { BORDER };
        let worst = worst(&found.disparity_px, &truth, border);
        assert!(worst < 0.01, "{ratio:?}: {worst}");
        let wrong = plane_sweep(&light_field, &options.baseline_ratio(BaselineRatio::EQUAL)).unwrap();
        let bad = wrong.disparity_px.iter().zip(&truth).filter(|(one, other)| (**one - **other).abs() > 0.07).count();
        assert!(bad * 4 > truth.len(), "{ratio:?}: the wrong ratio must matter, {bad}");
    }
    let ratio = BaselineRatio::vertical_over_horizontal(0.0).unwrap();
    let (column, _) = plane_of([24, 24, 9, 1, 1], SLANTED, ratio);
    let found = plane_sweep(&column, &PlaneSweepOptions::default().baseline_ratio(ratio));
    assert_eq!(found.unwrap_err(), Error::NoBaseline);
}

#[test]
fn many_views_with_a_tiny_baseline_are_accurate() {
    let surface = Surface { here: -0.03, by_row: 0.0008, by_column: 0.0004 };
    let (light_field, truth) = plane([40, 44, 41, 41, 1], surface);
    let options = PlaneSweepOptions::default().range_px(-0.06, 0.06).effort(Effort::Balanced);
    let found = plane_sweep(&light_field, &options).unwrap();
    let worst = worst(&found.disparity_px, &truth, BORDER);
    // 0.01 px over the 20 steps to the rim.
    assert!(worst < 0.01 / 20.0, "{worst}");
}

#[test]
fn integers_and_floats_of_any_scale_agree() {
    let (floats, truth) = plane([48, 48, 7, 7, 3], SLANTED);
    let options = options(Effort::Fast);
    let expected = plane_sweep(&floats, &options).unwrap();
    let scaled = floats.map(|&sample| sample * 3000.0).unwrap();
    let bytes = floats.map(|&sample| (sample * 255.0).round() as u8).unwrap();
    let words = floats.map(|&sample| (sample * 65535.0).round() as u16).unwrap();
    let found = [
        plane_sweep(&scaled, &options).unwrap(),
        plane_sweep(&bytes, &options).unwrap(),
        plane_sweep(&words, &options).unwrap(),
    ];
    for found in found {
        assert!(worst(&found.disparity_px, &expected.disparity_px, BORDER) < 0.02);
        assert!(worst(&found.disparity_px, &truth, BORDER) < 0.04);
    }
}
