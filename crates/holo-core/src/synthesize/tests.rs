//! Synthesized views of a scene with a closed form: a textured square before a textured wall.

use ndarray::{Array2, Array4, Array5};

use super::*;
use crate::LightFieldOwned;

const SIZE: usize = 48;
/// Disparities of wall and square, px between adjacent views.
const WALL: f64 = -1.3;
const SQUARE: f64 = 1.7;

/// A smooth texture.
fn texture(v: f64, u: f64, phase: f64) -> f64 {
    0.5 + 0.2 * (0.55 * v + phase).sin() + 0.25 * (0.4 * u + 0.3 * v + 2.0 * phase).cos()
}

/// Whether a place of the view `away` from the middle lies on the square.
fn is_square([v, u]: [f64; 2], away: [f64; 2]) -> bool {
    [v + SQUARE * away[0], u + SQUARE * away[1]].iter().all(|x| (x - 24.0).abs() < 9.0)
}

/// The color and the disparity of a pixel of the view `away` from the middle: the mean over its area.
fn pixel(v: usize, u: usize, away: [f64; 2]) -> (f64, f64) {
    let side = 8;
    let color = |k: usize| {
        let at = |x: usize, k: usize| x as f64 + (k as f64 + 0.5) / side as f64 - 0.5;
        let place = [at(v, k / side), at(u, k % side)];
        let (disparity, phase) = if is_square(place, away) { (SQUARE, 1.0) } else { (WALL, 0.0) };
        texture(place[0] + disparity * away[0], place[1] + disparity * away[1], phase)
    };
    let mean = (0..side * side).map(color).sum::<f64>() / (side * side) as f64;
    (mean, if is_square([v as f64, u as f64], away) { SQUARE } else { WALL })
}

/// 3 x 3 views, and their disparity maps.
fn scene() -> (LightFieldOwned<f32>, Array4<f32>) {
    let away = |t: usize, s: usize| [t as f64 - 1.0, s as f64 - 1.0];
    let color = |(v, u, t, s, _)| pixel(v, u, away(t, s)).0 as f32;
    let maps = Array4::from_shape_fn((SIZE, SIZE, 3, 3), |(v, u, t, s)| pixel(v, u, away(t, s)).1 as f32);
    (LightField::new(Array5::from_shape_fn((SIZE, SIZE, 3, 3, 1), color)).expect("a light field"), maps)
}

/// The deviation of a view at a place of the grid from the closed form, over all pixels but those of the border.
fn deviation(view: &SynthesizedView, (t, s): (f64, f64)) -> f64 {
    let inside = || (4..SIZE - 4).flat_map(|v| (4..SIZE - 4).map(move |u| (v, u)));
    let error = |(v, u)| f64::from(view.image[[v, u, 0]]) - pixel(v, u, [t - 1.0, s - 1.0]).0;
    (inside().map(|at| error(at).powi(2)).sum::<f64>() / inside().count() as f64).sqrt()
}

const HALF_WAY: [(f64, f64); 4] = [(0.5, 0.5), (1.5, 0.5), (1.0, 0.5), (0.25, 1.75)];

#[test]
fn a_view_of_the_grid_is_itself() {
    let (field, maps) = scene();
    let central = maps.index_axis(ndarray::Axis(3), 1).index_axis(ndarray::Axis(2), 1).to_owned();
    let middle = ViewIndex { row: 1, column: 1 };
    for disparities in [
        ViewDisparities::Plane(0.7),
        ViewDisparities::OfAll(maps.view()),
        ViewDisparities::OfView(central.view(), middle),
    ] {
        for (t, s) in [(1usize, 1usize), (0, 2), (2, 0)] {
            let view = ViewSynthesis::default().at(&field, disparities, (t as f64, s as f64)).expect("a view");
            assert_eq!(view.image, field.view(t, s).expect("a view"), "{disparities:?}");
            assert!(view.holes.iter().all(|&hole| !hole));
        }
    }
}

/// With the disparities of all views, views half-way are nearer to those of the scene than by quadrilinear interpolation, by 5 dB
/// and more; with those of one view by 1 dB. What is left are the edges of the square, which cross a sixth of all pixels.
#[test]
fn half_way_views_are_those_of_the_scene() {
    let (field, maps) = scene();
    let central = maps.index_axis(ndarray::Axis(3), 1).index_axis(ndarray::Axis(2), 1).to_owned();
    let middle = ViewIndex { row: 1, column: 1 };
    for at in HALF_WAY {
        let error = |disparities| deviation(&ViewSynthesis::default().at(&field, disparities, at).expect("a view"), at);
        let off = error(ViewDisparities::Plane(0.0));
        let all = error(ViewDisparities::OfAll(maps.view()));
        let one = error(ViewDisparities::OfView(central.view(), middle));
        let gain = |error: f64| 20.0 * (off / error).log10();
        println!("{at:?}: {off:.4}, {all:.4} ({:.1} dB), {one:.4} ({:.1} dB)", gain(all), gain(one));
        assert!(gain(all) > 5.0 && gain(one) > 1.0, "{at:?}: {} {}", gain(all), gain(one));
    }
}

/// Within a surface only the kernel errs: less than 1e-3 for waves of 9 px and more.
#[test]
fn surfaces_are_interpolated_along_their_disparity() {
    let (field, maps) = scene();
    for at in HALF_WAY {
        let view = ViewSynthesis::default().at(&field, ViewDisparities::OfAll(maps.view()), at).expect("a view");
        for v in 20..28 {
            for u in 20..28 {
                let (color, disparity) = pixel(v, u, [at.0 - 1.0, at.1 - 1.0]);
                let error = (f64::from(view.image[[v, u, 0]]) - color).abs();
                assert!(error < 2e-3, "{at:?}, {v} {u}: {error}");
                assert!((f64::from(view.disparity_px[[v, u]]) - disparity).abs() < 1e-3);
            }
        }
    }
}

/// Through the slot of a near plane each of two views sees another part of the wall: none sees what is behind the slot half-way.
#[test]
fn what_no_view_sees_is_a_hole() {
    let disparity = |u: usize, s: usize| if (20 - 8 * s..26 - 8 * s).contains(&u) { 0.0 } else { 8.0 };
    let maps = Array4::from_shape_fn((4, 40, 1, 2), |(_, u, _, s)| disparity(u, s));
    let color = |(_, u, _, s, _)| if disparity(u, s) > 0.0 { 1.0f32 } else { 0.25 };
    let field = LightField::new(Array5::from_shape_fn((4, 40, 1, 2, 1), color)).expect("a light field");
    let view = ViewSynthesis::default().at(&field, ViewDisparities::OfAll(maps.view()), (0.0, 0.5)).expect("a view");
    for ((row, u), &is_hole) in view.holes.indexed_iter() {
        // The near plane is a pixel wider than it is: pixels that its edges cross move with it.
        assert_eq!(is_hole, (17..21).contains(&u), "{row} {u}");
        let expected = if (16..22).contains(&u) { 0.25 } else { 1.0 };
        assert!(is_hole || (view.image[[row, u, 0]] - expected).abs() < 1e-6, "{row} {u}");
        assert!(view.image[[row, u, 0]].is_finite());
    }
}

/// A number that is no disparity costs no time, and hardly anything of the other pixels: lines are followed within the view only.
/// They are followed in steps from the nearest disparity on, so that other edges are met within half a pixel.
#[test]
fn absurd_disparities_end_at_the_border_of_the_view() {
    let (field, mut maps) = scene();
    let error = |maps: &Array4<f32>| {
        let view =
            ViewSynthesis::default().at(&field, ViewDisparities::OfAll(maps.view()), (0.5, 0.5)).expect("a view");
        assert!(view.image.iter().all(|x| x.is_finite()));
        deviation(&view, (0.5, 0.5))
    };
    let sound = error(&maps);
    (maps[[0, 0, 1, 1]], maps[[0, 47, 0, 0]]) = (1e30, -1e30);
    let absurd = error(&maps);
    println!("{sound} {absurd}");
    assert!(absurd < 2.0 * sound, "{sound} {absurd}");
}

#[test]
fn wrong_input_is_refused() {
    let (field, maps) = scene();
    let synthesis = ViewSynthesis::default();
    for at in [(-0.1, 0.0), (0.0, 2.01), (f64::NAN, 0.0)] {
        assert!(
            matches!(synthesis.at(&field, ViewDisparities::Plane(0.0), at), Err(Error::BadNumber { .. })),
            "{at:?}"
        );
    }
    let small = Array2::<f32>::zeros((SIZE, SIZE - 1));
    let index = |row, column| ViewIndex { row, column };
    let of = |map: &'_ Array2<f32>, view| {
        synthesis.at(&field, ViewDisparities::OfView(map.view(), view), (0.0, 0.5)).map(drop)
    };
    assert!(matches!(of(&small, index(0, 0)), Err(Error::Shape { .. })));
    let map = Array2::<f32>::zeros((SIZE, SIZE));
    assert!(matches!(of(&map, index(0, 3)), Err(Error::OutOfRange { .. })));
    assert!(matches!(of(&map.mapv(|_| f32::NAN), index(0, 0)), Err(Error::BadNumber { .. })));
    let three = maps.slice_axis(ndarray::Axis(3), (0..2).into());
    assert!(matches!(synthesis.at(&field, ViewDisparities::OfAll(three), (0.0, 0.5)), Err(Error::Shape { .. })));
    assert!(synthesis.at(&field, ViewDisparities::Plane(f64::INFINITY), (0.0, 0.5)).is_err());
}
