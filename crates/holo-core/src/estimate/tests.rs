//! Tests of bands, ranges and steps, which are private.

use super::*;
use crate::GridSize;

#[test]
fn bands_change_at_most_one_pixel_in_a_hundred() {
    let mut views = views::test_views(300, 8, 1);
    // A wall at disparity 0, with noise of half its contrast.
    let views::Views { center, others, .. } = &mut views;
    for view in others {
        view.samples.iter_mut().zip(&*center).for_each(|(sample, center)| *sample = 0.5 * *sample + 0.5 * center);
    }
    let planes = Planes { first_px: -1.0, step_px: 0.25, count: 9 };
    let guide = views.guide().unwrap();
    let whole = sweep::sweep(&views, &planes, &guide, None, sweep::BAND_BYTES).unwrap();
    // A budget of 0 gives the smallest band: 128 rows, of which 64 are used.
    let banded = sweep::sweep(&views, &planes, &guide, None, 0).unwrap();
    let different = whole.iter().zip(&banded).filter(|(one, other)| (**one - **other).abs() > 0.01).count();
    // Only pixels without other evidence depend on paths from beyond the margin: at most one in a hundred.
    assert!(different * 100 < whole.len(), "{different} of {}", whole.len());
}

#[test]
fn steps_follow_the_outermost_view() {
    let mut views = views::test_views(4, 4, 1);
    let settings = Effort::Balanced.settings();
    // Three steps to the outermost view, half a pixel there: 1/6 px.
    let planes = spread(&views, &settings, -1.0, 1.0).unwrap();
    assert_eq!((planes.count, planes.first_px), (13, -1.0));
    assert!((planes.disparity_px(12.0) - 1.0).abs() < 1e-6);
    views.size = GridSize::new(4, 4);
    assert_eq!(spread(&views, &settings, 0.0, 1e-9).unwrap().count, 5);
    // Half the vertical baseline and no horizontal one: the outermost view moves half as far.
    let ratio = BaselineRatio::vertical_over_horizontal(0.5).unwrap();
    assert_eq!(views::test_views_of(4, 4, 1, ratio).reach(), 3.0);
    assert_eq!(views::test_views_of(4, 4, 1, BaselineRatio::VERTICAL_ONLY).reach(), 3.0);
}

#[test]
fn a_range_gets_its_step_or_an_error_with_the_numbers() {
    let views = views::test_views(4, 4, 1);
    let settings = Effort::Balanced.settings();
    let planes = spread(&views, &settings, -300.0, 300.0).unwrap();
    assert_eq!(planes.count, 3601);
    assert!(planes.step_px <= 0.5 / 3.0 + 1e-6, "{}", planes.step_px);
    let error = spread(&views, &settings, -400.0, 400.0).unwrap_err();
    assert_eq!(
        error.to_string(),
        "disparities from -400 to 400 px take 4801 planes at this effort, and at most 4096 are possible; narrow the \
         range or lower the effort"
    );
    // With coarser levels too, whose ranges are halves of this one.
    let large = views::test_views(128, 128, 1);
    assert_eq!(solve(&large, &settings, -400.0, 400.0, 0).unwrap_err(), error);
    assert!(spread(&views, &Effort::Draft.settings(), -400.0, 400.0).is_ok());
    assert!(spread(&views, &settings, -1e6, 1e6).is_err());
}

#[test]
fn impossible_ranges_are_errors() {
    for (low, high) in [(f32::NAN, 1.0), (0.0, f32::INFINITY), (1.0, 1.0), (2.0, 1.0), (-2e6, 0.0)] {
        assert!(check_range(low, high).is_err(), "{low}..{high}");
    }
    let message = check_range(1.0, -1.0).unwrap_err().to_string();
    assert_eq!(message, "the largest disparity in pixels is -1; it must be above the smallest disparity");
}

#[test]
fn confidence_stays_between_0_and_1() {
    assert_eq!(confidence(0.0), 0.0);
    assert_eq!(confidence(f32::INFINITY), 1.0);
    assert!((confidence(2500.0) - 0.5).abs() < 1e-6);
}
