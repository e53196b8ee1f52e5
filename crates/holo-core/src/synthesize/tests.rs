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

/// The middle of the square in the middle view, for edges at several places between pixels.
const MIDDLES: [f64; 4] = [24.0, 24.27, 24.5, 23.61];

/// Whether a place of the view `away` from the middle lies on the square.
fn is_square([v, u]: [f64; 2], away: [f64; 2], middle: f64) -> bool {
    [v + SQUARE * away[0], u + SQUARE * away[1]].iter().all(|x| (x - middle).abs() < 9.0)
}

/// The color and the disparity of a pixel of the view `away` from the middle: the mean over its area.
fn pixel(v: usize, u: usize, away: [f64; 2], middle: f64) -> (f64, f64) {
    let side = 8;
    let color = |k: usize| {
        let at = |x: usize, k: usize| x as f64 + (k as f64 + 0.5) / side as f64 - 0.5;
        let place = [at(v, k / side), at(u, k % side)];
        let (disparity, phase) = if is_square(place, away, middle) { (SQUARE, 1.0) } else { (WALL, 0.0) };
        texture(place[0] + disparity * away[0], place[1] + disparity * away[1], phase)
    };
    let mean = (0..side * side).map(color).sum::<f64>() / (side * side) as f64;
    (mean, if is_square([v as f64, u as f64], away, middle) { SQUARE } else { WALL })
}

/// 3 x 3 views, and their disparity maps.
fn scene(middle: f64) -> (LightFieldOwned<f32>, Array4<f32>) {
    let away = |t: usize, s: usize| [t as f64 - 1.0, s as f64 - 1.0];
    let color = |(v, u, t, s, _)| pixel(v, u, away(t, s), middle).0 as f32;
    let maps = Array4::from_shape_fn((SIZE, SIZE, 3, 3), |(v, u, t, s)| pixel(v, u, away(t, s), middle).1 as f32);
    (LightField::new(Array5::from_shape_fn((SIZE, SIZE, 3, 3, 1), color)).expect("a light field"), maps)
}

/// The deviation of a view at a place of the grid from the closed form, over all pixels but those of the border.
fn deviation(view: &SynthesizedView, (t, s): (f64, f64), middle: f64) -> f64 {
    let inside = || (4..SIZE - 4).flat_map(|v| (4..SIZE - 4).map(move |u| (v, u)));
    let error = |(v, u)| f64::from(view.image[[v, u, 0]]) - pixel(v, u, [t - 1.0, s - 1.0], middle).0;
    (inside().map(|at| error(at).powi(2)).sum::<f64>() / inside().count() as f64).sqrt()
}

const HALF_WAY: [(f64, f64); 4] = [(0.5, 0.5), (1.5, 0.5), (1.0, 0.5), (0.25, 1.75)];

#[test]
fn a_view_of_the_grid_is_itself() {
    let (field, maps) = scene(24.0);
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

/// Views half-way are nearer to those of the scene than by quadrilinear interpolation, for edges at several places between pixels: by
/// 5 dB and more with the disparities of one view, and by 1.5 dB with those of all views, whose edges are up to a pixel apart. What is
/// left are the edges of the square, which cross a sixth of all pixels.
#[test]
fn half_way_views_are_those_of_the_scene() {
    let index = ViewIndex { row: 1, column: 1 };
    for at in HALF_WAY {
        let mut squares = [0.0; 3];
        for middle in MIDDLES {
            let (field, maps) = scene(middle);
            let central = maps.index_axis(ndarray::Axis(3), 1).index_axis(ndarray::Axis(2), 1).to_owned();
            for (sum, disparities) in squares.iter_mut().zip([
                ViewDisparities::Plane(0.0),
                ViewDisparities::OfAll(maps.view()),
                ViewDisparities::OfView(central.view(), index),
            ]) {
                let view = ViewSynthesis::default().at(&field, disparities, at).expect("a view");
                let deviation = deviation(&view, at, middle);
                *sum += deviation.powi(2);
            }
        }
        let gain = |k: usize| 10.0 * (squares[0] / squares[k]).log10();
        println!("{at:?}: {:.1} dB, {:.1} dB", gain(1), gain(2));
        assert!(gain(1) > 1.5 && gain(2) > 5.0, "{at:?}: {} {}", gain(1), gain(2));
    }
}

/// Within a surface only the kernel errs: less than 1e-3 for waves of 9 px and more.
#[test]
fn surfaces_are_interpolated_along_their_disparity() {
    let (field, maps) = scene(24.0);
    for at in HALF_WAY {
        let view = ViewSynthesis::default().at(&field, ViewDisparities::OfAll(maps.view()), at).expect("a view");
        for v in 20..28 {
            for u in 20..28 {
                let (color, disparity) = pixel(v, u, [at.0 - 1.0, at.1 - 1.0], 24.0);
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
        // Pixels within two of an edge have up to 4 % of what is beyond it, 0.75 brighter or darker: kriging averages noise.
        let error = (view.image[[row, u, 0]] - expected).abs();
        let is_edge = (14..24).contains(&u);
        assert!(is_hole || error < if is_edge { 0.03 } else { 1e-6 }, "{row} {u}: {error}");
        assert!(view.image[[row, u, 0]].is_finite());
    }
}

/// With a second slot, a third view sees the wall behind the first slot, and no other does.
#[test]
fn farther_views_show_what_the_next_ones_do_not() {
    let is_slot = |u: usize, s: usize| [20, 32].iter().any(|from| (from - 8 * s..from + 6 - 8 * s).contains(&u));
    let disparity = |u: usize, s: usize| if is_slot(u, s) { 0.0f32 } else { 8.0 };
    let wall = |u: usize| 0.2 + 0.01 * u as f32;
    let color = |(_, u, _, s, _)| if is_slot(u, s) { wall(u) } else { 1.0 };
    let maps = Array4::from_shape_fn((4, 40, 1, 3), |(_, u, _, s)| disparity(u, s));
    let field = LightField::new(Array5::from_shape_fn((4, 40, 1, 3, 1), color)).expect("a light field");
    let view = ViewSynthesis::default().at(&field, ViewDisparities::OfAll(maps.view()), (0.0, 0.5)).expect("a view");
    for u in 17..21 {
        assert!(
            !view.holes[[1, u]] && (view.image[[1, u, 0]] - wall(u)).abs() < 1e-6,
            "{u}: {}",
            view.image[[1, u, 0]]
        );
    }
    assert!((29..33).all(|u| view.holes[[1, u]]), "{:?}", view.holes.row(1));
}

/// A number that is no disparity costs no time, and changes the pixels around it only: lines are followed within the view.
#[test]
fn absurd_disparities_end_at_the_border_of_the_view() {
    let (field, mut maps) = scene(24.0);
    let error = |maps: &Array4<f32>| {
        let view =
            ViewSynthesis::default().at(&field, ViewDisparities::OfAll(maps.view()), (0.5, 0.5)).expect("a view");
        assert!(view.image.iter().all(|x| x.is_finite()));
        deviation(&view, (0.5, 0.5), 24.0)
    };
    let sound = error(&maps);
    (maps[[0, 0, 1, 1]], maps[[0, 47, 0, 0]]) = (1e30, -1e30);
    let absurd = error(&maps);
    assert!((absurd / sound - 1.0).abs() < 1e-3, "{sound} {absurd}");
}

#[test]
fn wrong_input_is_refused() {
    let (field, maps) = scene(24.0);
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
