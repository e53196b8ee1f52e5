//! What an image of another aspect ratio than that of its camera shows.

use std::fmt;

use holo_core::GridSize;
use holo_scene::{Camera, CameraProjection};

/// The relative difference of aspect ratios that nobody notices: that of whole pixels of small views.
const TOLERANCE: f64 = 0.02;

/// An image of another aspect ratio than that of its camera, so that it shows more or less along one side.
/// [`Display`](fmt::Display) gives one line with all numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AspectChange {
    /// Width / height of the camera.
    pub camera_aspect: f64,
    /// Width / height of the image.
    pub image_aspect: f64,
    /// Full horizontal and vertical angle of view of the camera, rad.
    pub camera_angles_rad: [f64; 2],
    /// Full horizontal and vertical angle of view of the image, rad.
    pub image_angles_rad: [f64; 2],
}

impl AspectChange {
    /// `None` if the aspect ratios differ by less than 2 %, or if the camera has none. `half_slope` is the tangent of
    /// half the angle of view along the larger image side.
    pub(super) fn new(camera: &Camera, lenses: GridSize, half_slope: f64) -> Option<Self> {
        let CameraProjection::Perspective { vertical_angle_rad, aspect_ratio: Some(camera_aspect) } = camera.projection
        else {
            return None;
        };
        let [columns, rows] = [lenses.columns as f64, lenses.rows as f64];
        let image_aspect = columns / rows;
        if (image_aspect / camera_aspect - 1.0).abs() < TOLERANCE {
            return None;
        }
        let angle = |slope: f64| 2.0 * slope.atan();
        let pixel = half_slope / columns.max(rows);
        Some(Self {
            camera_aspect,
            image_aspect,
            camera_angles_rad: [angle(camera_aspect * (vertical_angle_rad / 2.0).tan()), vertical_angle_rad],
            image_angles_rad: [angle(pixel * columns), angle(pixel * rows)],
        })
    }
}

impl fmt::Display for AspectChange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [camera, image] = [self.camera_angles_rad, self.image_angles_rad].map(|angles| angles.map(f64::to_degrees));
        write!(
            f,
            "the camera sees {:.1} x {:.1} degrees (width / height {:.3}), the image {:.1} x {:.1} ({:.3})",
            camera[0], camera[1], self.camera_aspect, image[0], image[1], self.image_aspect
        )
    }
}
