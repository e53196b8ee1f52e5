//! A camera that stands elsewhere than at the origin of the coordinates of its renderer: its rays are moved.
//!
//! # Accuracy
//! Rays are moved in f32, so that positions have the error of the coordinates of the renderer instead of those of the
//! camera: an image may differ along edges from that of a renderer at the pose of the camera. It is for images that are
//! looked at while a camera moves.

use crate::accel::Rays;
use crate::simd::LANES;
use holo_scene::Transform;

/// The pose of a camera in the coordinates of its renderer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moved {
    columns: [[f32; 3]; 3],
    translation: [f32; 3],
}

impl Moved {
    pub fn new(pose: &Transform) -> Self {
        let single = |v: [f64; 3]| v.map(|x| x as f32);
        Self { columns: pose.columns.map(single), translation: single(pose.translation) }
    }

    /// Moves rays of the camera to the coordinates of the renderer. Their parameter stays planar depth.
    #[inline(always)]
    pub fn move_rays(&self, rays: &mut Rays) {
        let (origin, direction) = (rays.origin, rays.direction);
        let [x, y, z] = &self.columns;
        for axis in 0..3 {
            for lane in 0..LANES {
                let along = |v: &[[f32; LANES]; 3]| x[axis] * v[0][lane] + y[axis] * v[1][lane] + z[axis] * v[2][lane];
                rays.origin[axis][lane] = along(&origin) + self.translation[axis];
                rays.direction[axis][lane] = along(&direction);
            }
        }
    }
}
