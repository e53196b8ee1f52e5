//! Warnings about the result of a render.

use std::fmt;

use holo_core::Rig;
use holo_core::plenoptic::PlenopticMode;
use holo_io::CameraFile;
use holo_render::Layers;
use ndarray::Array3;

use crate::settings::text;

/// A warning that an image is probably not what was wanted. [`Display`](fmt::Display) gives one line.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum RenderWarning {
    /// No ray of the central view hits anything.
    NothingHit,
    /// All views are almost the same image: nothing moves by a pixel between the first and the last view.
    ViewsAlmostEqual {
        /// The largest movement of a point of the central view, from the first to the last view of a row or a column,
        /// pixels.
        largest_px: f64,
    },
}

impl fmt::Display for RenderWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NothingHit => write!(
                f,
                "nothing is hit: every pixel of the central view misses the scene; does the camera look at it? \
                 `holo info` shows bounds and cameras"
            ),
            Self::ViewsAlmostEqual { largest_px } => write!(
                f,
                "the views hardly differ: from the first to the last view nothing moves by more than {largest_px:.2} \
                 px; choose disparities (`disparity=-1,1`) or a larger `baseline-m`"
            ),
        }
    }
}

/// The warnings about a rig whose central view has these layers.
pub(super) fn of(rig: &Rig, central: &Layers<Array3<f32>>) -> Vec<RenderWarning> {
    match central.depth_m().map(hits) {
        None => Vec::new(),
        Some(None) => vec![RenderWarning::NothingHit],
        Some(Some(depths)) => almost_equal(rig, depths).into_iter().collect(),
    }
}

/// The nearest and the farthest depth that are finite.
fn hits(depths_m: &Array3<f32>) -> Option<(f64, f64)> {
    let hits = depths_m.iter().filter(|z| z.is_finite()).map(|&z| f64::from(z));
    hits.fold(None, |range, z| Some(range.map_or((z, z), |(near, far): (f64, f64)| (near.min(z), far.max(z)))))
}

fn almost_equal(rig: &Rig, (near_m, far_m): (f64, f64)) -> Option<RenderWarning> {
    let views = rig.shape().views();
    let axes = [(rig.disparity_x(), views.columns), (rig.disparity_y(), views.rows)];
    let moves = axes.iter().flat_map(|(disparity, count)| {
        [near_m, far_m].map(|depth_m| disparity.from_depth_m(depth_m).abs() * (count - 1) as f64)
    });
    let largest_px = moves.fold(0.0_f64, f64::max);
    (views.count() > 1 && largest_px < 1.0).then_some(RenderWarning::ViewsAlmostEqual { largest_px })
}

/// What is probably not wanted of a camera, with numbers.
#[must_use]
pub fn camera_warnings(file: &CameraFile) -> Vec<String> {
    let camera = &file.camera;
    let mut lines = Vec::new();
    if file.is_approximate {
        lines.push(format!(
            "the maker did not publish some values of the camera '{}'; they are estimates",
            holo_io::shown(&file.name)
        ));
    }
    let pitch_px = camera.array().pitch_m / camera.sensor().pixel_m;
    if pitch_px < 4.0 {
        lines.push(format!("a microlens covers only {} pixels", text::number(pitch_px)));
    }
    let image_pitch_px = camera.micro_image_pitch_px();
    let half_px = camera.micro_image_radii_m(0)[1] / camera.sensor().pixel_m;
    if camera.mode(0) == PlenopticMode::Unfocused {
        let filled = 2.0 * half_px / image_pitch_px;
        // f-numbers match where micro-images touch.
        let matching = camera.main_lens().f_number * filled;
        if filled > 1.01 {
            lines.push(format!(
                "micro-images are {} px wide and {} px apart: they overlap; f/{} would match the microlenses",
                text::number(2.0 * half_px),
                text::number(image_pitch_px),
                text::number(matching)
            ));
        } else if filled < 0.8 {
            lines.push(format!(
                "micro-images are {} px wide and {} px apart: much of the sensor stays dark; f/{} would match the \
                 microlenses",
                text::number(2.0 * half_px),
                text::number(image_pitch_px),
                text::number(matching)
            ));
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use holo_core::{GridSize, LightFieldShape};

    #[test]
    fn views_that_hardly_differ() {
        // k = 0.05 * 360 / 0.036 = 500 times the baseline.
        let rig = |views: GridSize, baseline_m: f64| {
            Rig::builder(LightFieldShape::new(views, GridSize::new(240, 360)).unwrap())
                .focal_length_m(0.05)
                .sensor_size_m(0.036)
                .baseline_m(baseline_m)
                .focus_distance_m(3.0)
                .build()
                .unwrap()
        };
        // From 2 m to 6 m: 500 b / 6 px in either direction, over 8 gaps; b = 1 mm: 0.667 px.
        let nine = GridSize::new(1, 9);
        let Some(RenderWarning::ViewsAlmostEqual { largest_px }) = almost_equal(&rig(nine, 1e-3), (2.0, 6.0)) else {
            panic!("no warning")
        };
        assert!((largest_px - 2.0 / 3.0).abs() < 1e-12);
        assert_eq!(almost_equal(&rig(nine, 1.6e-3), (2.0, 6.0)), None);
        // More rows than columns; and a single view, which has no other.
        assert_eq!(almost_equal(&rig(GridSize::new(13, 9), 1e-3), (2.0, 6.0)), None);
        assert_eq!(almost_equal(&rig(GridSize::new(1, 1), 1e-3), (2.0, 6.0)), None);
    }

    #[test]
    fn hits_are_finite_depths() {
        let depths = |values: &[f32]| Array3::from_shape_vec((1, values.len(), 1), values.to_vec()).unwrap();
        assert_eq!(hits(&depths(&[f32::INFINITY; 3])), None);
        assert_eq!(hits(&depths(&[f32::INFINITY, 2.0, 0.5, 1.0])), Some((0.5, 2.0)));
    }
}
