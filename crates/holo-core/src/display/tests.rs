use ndarray::Array3;

use super::*;
use crate::{LightField, LightFieldOwned, LightFieldShape, Projection, Rig};

/// A panel of as many pixels with a lens over every `across` ones.
fn display(size: GridSize, across: f64, grid: SheetGrid, stripes: PixelStripes, distance_m: f64) -> Display {
    let panel = Panel { size, pitch_m: 1e-4, stripes };
    let lenses = LensSheet { grid, pitch_m: across * 1e-4, gap_m: 3e-3, focal_length_m: 3e-3, offset_m: [2e-5, -3e-5] };
    Display::new(panel, lenses, distance_m).unwrap()
}

/// A wall with smooth colors at a depth, in the light field of a rig and as a function.
#[derive(Clone, Copy)]
struct Wall(f64);

impl Wall {
    fn color([x, y]: [f64; 2], channel: usize) -> f64 {
        let phase = channel as f64;
        0.5 + 0.2 * (11.0 * x + 3.0 * y + phase).sin() + 0.2 * (7.0 * y - 2.0 * x + 2.0 * phase).cos()
    }

    fn light_field(self, rig: &Rig) -> LightFieldOwned<f32> {
        let (views, lenses) = (rig.shape().views(), rig.shape().lenses());
        let grid = Array3::from_shape_fn((views.rows * lenses.rows, views.columns * lenses.columns, 3), |place| {
            let (t, v) = (place.0 / lenses.rows, place.0 % lenses.rows);
            let (s, u) = (place.1 / lenses.columns, place.1 % lenses.columns);
            let [x, y, _] = rig.ray(v, u, t, s, 0.5, 0.5).at_depth_m(self.0);
            Self::color([x, y], place.2) as f32
        });
        LightField::from_viewpoint_grid(grid, *rig.shape()).unwrap()
    }

    /// What an eye sees through a place of a window at depth `screen_m`, by straight rays.
    fn seen(self, eye: [f64; 3], window: [f64; 2], screen_m: f64, channel: usize) -> f64 {
        let eye_depth = screen_m - eye[2];
        let reach = (self.0 - eye_depth) / eye[2];
        Self::color(std::array::from_fn(|axis| eye[axis] + (window[axis] - eye[axis]) * reach), channel)
    }
}

/// A rig whose window at 1.2 m is as wide as high; its views 20 mm apart.
fn rig(views: GridSize, side: usize, projection: Projection) -> Rig {
    let shape = LightFieldShape::new(views, GridSize::new(side, side)).unwrap();
    let builder = Rig::builder(shape).focal_length_m(0.05).sensor_size_m(0.03).baseline_m(0.02);
    builder.focus_distance_m(1.2).projection(projection).build().unwrap()
}

/// The root mean squares of what eyes see less what they should see, apart from the margins of the images.
fn errors(display: &Display, rig: &Rig, wall: Wall, mapping: &PanelMapping, eyes_m: &[[f64; 3]]) -> Vec<f64> {
    let panel = display.panel_image(&wall.light_field(rig), mapping).unwrap();
    let screen_m = rig.disparity_x().to_depth_m(mapping.screen_disparity_px);
    let window_m = match rig.projection() {
        Projection::Perspective => rig.sensor_size_m() / rig.focal_length_m() * screen_m,
        Projection::Orthographic => rig.sensor_size_m() / rig.focal_length_m() * rig.focus_distance_m(),
    };
    let scale = display.size_m()[0] / window_m;
    let seen = |&eye_m: &[f64; 3]| {
        let image = display.seen_from(&panel, eye_m, GridSize::new(24, 24), 20).unwrap();
        let eye = eye_m.map(|length| length / scale);
        let (mut sum, mut count) = (0.0, 0);
        let inside = |index: usize| (3..21).contains(&index);
        for ((row, column, channel), &found) in image.indexed_iter().filter(|(at, _)| inside(at.0) && inside(at.1)) {
            // The mean over a pixel of the image.
            let mut expected = 0.0;
            for place in 0..16 {
                let [down, right] = [place / 4, place % 4].map(|index| (f64::from(index) + 0.5) / 4.0);
                let window = [(column as f64 + right) / 24.0 - 0.5, 0.5 - (row as f64 + down) / 24.0];
                expected += wall.seen(eye, window.map(|at| at * window_m), screen_m, channel) / 16.0;
            }
            sum += (f64::from(found) - expected).powi(2);
            count += 1;
        }
        (sum / f64::from(count)).sqrt()
    };
    eyes_m.iter().map(seen).collect()
}

fn to_scale(rig: &Rig, screen_disparity_px: f64) -> PanelMapping {
    PanelMapping { spread: ViewSpread::ToScale(*rig), screen_disparity_px, ..PanelMapping::default() }
}

/// Whole pixels behind lenses that stand as those of the camera: the elemental images turned around, without a second row
/// or column of any.
#[test]
fn elemental_images_are_turned_around() {
    let shape = LightFieldShape::new(GridSize::new(3, 4), GridSize::new(5, 6)).unwrap();
    let raw = Array3::from_shape_fn((15, 24, 2), |(row, column, c)| (100 * row + 2 * column + c) as f32);
    let light_field = LightField::from_elemental_grid(raw, shape).unwrap();
    let panel = Panel { size: GridSize::new(20, 24), pitch_m: 1e-4, stripes: PixelStripes::None };
    // Lenses of 4 x 4 pixels; the light field has three rows of views for them.
    let lenses =
        LensSheet { grid: SheetGrid::Square, pitch_m: 4e-4, gap_m: 1e-3, focal_length_m: 1e-3, offset_m: [2e-4, 0.0] };
    let display = Display::new(panel, lenses, f64::INFINITY).unwrap();
    let refused = display.panel_image(&light_field, &PanelMapping::default()).unwrap_err();
    assert!(matches!(refused, Error::FinerThanLightField { found, .. } if found == 3.0), "{refused}");

    let whole = LightFieldShape::new(GridSize::new(4, 4), GridSize::new(5, 6)).unwrap();
    let raw = Array3::from_shape_fn((20, 24, 2), |(row, column, c)| (100 * row + 2 * column + c) as f32);
    let light_field = LightField::from_elemental_grid(raw, whole).unwrap();
    let image = display.panel_image(&light_field, &PanelMapping::default()).unwrap();
    let turned = light_field.rotate_elemental_images().to_elemental_grid().unwrap();
    assert_eq!(image.dim(), turned.dim());
    for (found, expected) in image.iter().zip(&turned) {
        assert!((found - expected).abs() < 1e-3, "{found} {expected}");
    }
}

/// The eye's image is the wall seen with straight rays, before, in and behind the screen, from places in the zone at,
/// before and behind the distance of the cameras, for every arrangement of lenses.
#[test]
fn an_eye_sees_the_scene_to_scale() {
    let slanted = |slant_rad| SheetGrid::Lenticular { slant_rad };
    let grids = [
        (SheetGrid::Square, PixelStripes::None, 1.0),
        (SheetGrid::HexRows, PixelStripes::None, 1.0),
        (slanted(0.0), PixelStripes::None, 0.0),
        (slanted(0.16), PixelStripes::Bgr, 0.0),
        (slanted(-0.18), PixelStripes::Rgb, 0.0),
    ];
    let rig = rig(GridSize::new(21, 21), 48, Projection::Perspective);
    for (grid, stripes, up) in grids {
        for (depth_m, screen_disparity_px) in [(1.2, 0.0), (1.05, 0.0), (1.5, 0.0), (1.3, 0.2)] {
            let mapping = to_scale(&rig, screen_disparity_px);
            let display = display(GridSize::new(400, 400), 10.0, grid, stripes, 0.07);
            let eyes_m = [[0.0, 0.0, 0.07], [0.004, 0.003 * up, 0.08], [-0.005, -0.002 * up, 0.06]];
            let found = errors(&display, &rig, Wall(depth_m), &mapping, &eyes_m);
            // Directions a pixel over the gap apart, views between views; colors of lenses that differ.
            let bound = if stripes == PixelStripes::None { 0.008 } else { 0.025 };
            assert!(found.iter().all(|&found| found < bound), "{grid:?} {stripes:?} {depth_m}: {found:.4?}");
        }
    }
}

/// Views that are directions, on a display for viewers far away.
#[test]
fn an_eye_sees_an_orthographic_rig_to_scale() {
    let rig = rig(GridSize::new(21, 21), 48, Projection::Orthographic);
    for depth_m in [1.2, 1.05, 1.5] {
        let display = display(GridSize::new(400, 400), 10.0, SheetGrid::Square, PixelStripes::None, f64::INFINITY);
        let eyes_m = [[0.0, 0.0, 0.4], [0.02, -0.01, 0.5]];
        let found = errors(&display, &rig, Wall(depth_m), &to_scale(&rig, 0.0), &eyes_m);
        assert!(found.iter().all(|&found| found < 0.008), "{depth_m}: {found:.4?}");
    }
}

/// An eye that moves by the zone of a lens sees the same again: the lenses show it the pixels of their neighbors.
#[test]
fn the_image_repeats_beyond_the_zone() {
    let rig = rig(GridSize::new(9, 9), 48, Projection::Perspective);
    let display = display(GridSize::new(400, 400), 10.0, SheetGrid::Square, PixelStripes::None, 0.07);
    let panel = display.panel_image(&Wall(1.1).light_field(&rig), &PanelMapping::default());
    let refused = panel.unwrap_err().to_string();
    assert_eq!(
        refused,
        "the display is finer than the light field: it has 10.4 pixels behind a lens from left to right, and the light \
         field 9.0 views for them; use a light field with more views, or a coarser display"
    );
    let wide = self::rig(GridSize::new(11, 11), 48, Projection::Perspective);
    let panel = display.panel_image(&Wall(1.1).light_field(&wide), &PanelMapping::default()).unwrap();
    let zone_m = 1e-3 * (0.07 + 3e-3) / 3e-3;
    let size = GridSize::new(20, 20);
    let [middle, aside] = [0.0, zone_m].map(|x_m| display.seen_from(&panel, [x_m, 0.0, 0.07], size, 16).unwrap());
    let mut worst = 0.0_f32;
    // The last lenses have no neighbor.
    for ((_, column, _), (middle, aside)) in middle.indexed_iter().map(|(at, &m)| (at, (m, aside[at]))) {
        if (1..19).contains(&column) {
            worst = worst.max((middle - aside).abs());
        }
    }
    // A lens shows its own pixels or its neighbor's, which belong to a place 1 mm aside.
    assert!(worst < 0.05, "{worst}");
}

/// White is white on stripes too, and nothing lies beside the views.
#[test]
fn white_is_white_and_the_rest_dark() {
    let shape = LightFieldShape::new(GridSize::new(11, 11), GridSize::new(20, 40)).unwrap();
    let white = LightField::filled(shape, 1, crate::Layout::ElementalGrid, 1.0_f32).unwrap();
    let grid = SheetGrid::Lenticular { slant_rad: 0.16 };
    let display = display(GridSize::new(400, 400), 10.0, grid, PixelStripes::Rgb, 0.5);
    let panel = display.panel_image(&white, &PanelMapping::default()).unwrap();
    assert_eq!(panel.dim(), (400, 400, 3));
    // The view is twice as wide as high: a quarter above and below is dark.
    assert_eq!((panel[[90, 200, 1]], panel[[110, 200, 1]], panel[[310, 200, 1]]), (0.0, 1.0, 0.0));
    let seen = display.seen_from(&panel, [0.0, 0.0, 0.5], GridSize::new(20, 20), 24).unwrap();
    for channel in 0..3 {
        assert!((seen[[10, 10, channel]] - 1.0).abs() < 0.05, "{}", seen[[10, 10, channel]]);
        assert_eq!(seen[[2, 10, channel]], 0.0);
    }
}

#[test]
fn impossible_displays_and_eyes_are_errors() {
    let panel = Panel { size: GridSize::new(40, 40), pitch_m: 1e-4, stripes: PixelStripes::None };
    let lenses =
        LensSheet { grid: SheetGrid::Square, pitch_m: 1e-3, gap_m: 3e-3, focal_length_m: 3e-3, offset_m: [0.0; 2] };
    let good = Display::new(panel, lenses, 1.0).unwrap();
    let bad = [
        Display::new(Panel { size: GridSize::new(0, 3), ..panel }, lenses, 1.0),
        Display::new(Panel { pitch_m: f64::NAN, ..panel }, lenses, 1.0),
        Display::new(panel, LensSheet { pitch_m: 5e-5, ..lenses }, 1.0),
        Display::new(panel, LensSheet { gap_m: 0.0, ..lenses }, 1.0),
        Display::new(panel, LensSheet { focal_length_m: -1.0, ..lenses }, 1.0),
        Display::new(panel, LensSheet { offset_m: [0.0, f64::INFINITY], ..lenses }, 1.0),
        Display::new(panel, LensSheet { grid: SheetGrid::Lenticular { slant_rad: 1.2 }, ..lenses }, 1.0),
        Display::new(panel, LensSheet { grid: SheetGrid::Lenticular { slant_rad: f64::NAN }, ..lenses }, 1.0),
        Display::new(panel, lenses, 0.0),
    ];
    assert!(bad.iter().all(Result::is_err), "{bad:?}");

    let image = Array3::<f32>::zeros((40, 40, 1));
    let size = GridSize::new(4, 4);
    assert!(good.seen_from(&image, [0.0, 0.0, 1.0], size, 2).is_ok());
    for eye_m in [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [f64::NAN, 0.0, 1.0]] {
        assert!(matches!(good.seen_from(&image, eye_m, size, 2), Err(Error::BadNumber { .. })));
    }
    assert!(matches!(good.seen_from(&image, [0.0, 0.0, 1.0], size, 0), Err(Error::ZeroCount { .. })));
    let other = Array3::<f32>::zeros((40, 41, 1));
    assert!(matches!(good.seen_from(&other, [0.0, 0.0, 1.0], size, 2), Err(Error::Shape { .. })));

    // A rig focused at infinity has its screen there, unless a disparity brings it nearer.
    let shape = LightFieldShape::new(GridSize::new(11, 11), GridSize::new(8, 8)).unwrap();
    let far = Rig::builder(shape).focal_length_m(0.05).sensor_size_m(0.03).baseline_m(0.02).build().unwrap();
    let field = LightField::filled(shape, 1, crate::Layout::ElementalGrid, 1.0_f32).unwrap();
    assert!(matches!(good.panel_image(&field, &to_scale(&far, 0.0)), Err(Error::BadNumber { .. })));
    assert!(good.panel_image(&field, &to_scale(&far, 0.2)).is_ok());
    let still = far.to_builder().baseline_m(0.0).build().unwrap();
    assert!(matches!(good.panel_image(&field, &to_scale(&still, 0.2)), Err(Error::NoBaseline)));
    let row = PanelMapping { view_row: Some(11), ..PanelMapping::default() };
    assert!(matches!(good.panel_image(&field, &row), Err(Error::OutOfRange { .. })));
}
