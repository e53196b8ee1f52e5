//! The environment map: radiance from infinitely far away.
//!
//! A world direction (x, y, z) lies at u = 1/2 + atan2(z, x) / (2 pi) of the width of the image and at v = acos(y) / pi
//! of its height, as in Blender (`tests/peers/environment_orientation.py`). Radiance is interpolated bilinearly between
//! the centers of texels, periodic horizontally, clamped at the poles. All directions here are in camera coordinates.
//!
//! Directions are sampled from a pdf that is constant in each of the [`cells`] of a grid and proportional to the
//! luminance there (Pharr, Jakob, Humphreys, "Physically Based Rendering", 4th ed., 12.5, with cells of equal solid
//! angle in a row). The returned pdf is exactly that of the sampling.
//!
//! # Accuracy
//! Of a direction in f32, in world coordinates, u and v have an error below 2e-7, which is 4e-3 texels in an image of
//! 16384 columns. The rounding of directions to f32 adds a larger error near the poles.

mod cells;
#[cfg(test)]
mod tests;

use std::f32::consts::{FRAC_1_PI, TAU};

use crate::sampling::Points;
use crate::simd::angles::{atan2, sin_cos};
use crate::simd::{LANES, at};
use cells::Cells;
use std::sync::Arc;

use holo_scene::{Environment, Transform};

/// An environment map in the frame of a camera. It owns a copy of the image, which clones share.
#[derive(Clone)]
pub(crate) struct EnvironmentLight {
    columns: i32,
    rows: i32,
    /// Row by row from the top, linear RGB.
    texels: Arc<[[f32; 3]]>,
    /// The axes of the camera in world coordinates.
    camera_axes: [[f32; 3]; 3],
    cells: Arc<Cells>,
}

/// Sixteen sampled directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EnvironmentSample {
    /// In camera coordinates, of unit length.
    pub direction: [[f32; LANES]; 3],
    /// The radiance from there, linear RGB.
    pub radiance: [[f32; LANES]; 3],
    /// The pdf per steradian: above 0 unless the environment is black.
    pub pdf: [f32; LANES],
}

impl EnvironmentLight {
    /// Prepares a valid `environment` for a camera at `pose`.
    pub fn new(environment: &Environment, pose: &Transform) -> Self {
        let (rows, columns, _) = environment.radiance.dim();
        let texels: Arc<[[f32; 3]]> = environment.radiance.rows().into_iter().map(|t| [t[0], t[1], t[2]]).collect();
        let cells = Arc::new(Cells::build(columns, rows, &texels));
        // A valid image has fewer than 2^32 / 3 texels.
        let (columns, rows) = (columns as i32, rows as i32);
        Self { columns, rows, texels, camera_axes: Default::default(), cells }.at(pose)
    }

    /// The same map in the frame of a camera at another pose.
    pub fn at(self, pose: &Transform) -> Self {
        Self { camera_axes: pose.columns.map(|axis| axis.map(|x| x as f32)), ..self }
    }

    /// Whether all radiance is 0; then every pdf is 0.
    pub fn is_black(&self) -> bool {
        self.cells.is_black()
    }

    /// The radiance from directions of any length (between 1e-18 and 1e18).
    #[inline(always)]
    pub fn radiance(&self, direction: &[[f32; LANES]; 3]) -> [[f32; LANES]; 3] {
        self.bilinear(&self.uv(direction))
    }

    /// The pdf, per steradian, with which [`Self::sample`] samples directions (of any length).
    ///
    /// It equals the pdf of `sample` up to the rounding of the direction: within about 3e-7 rad of the border of a cell
    /// it may be that of the neighboring cell.
    #[inline(always)]
    pub fn pdf(&self, direction: &[[f32; LANES]; 3]) -> [f32; LANES] {
        self.cells.pdf(&self.uv(direction))
    }

    /// Samples one direction per lane.
    #[inline(always)]
    pub fn sample(&self, point: &Points) -> EnvironmentSample {
        let cell = self.cells.sample(point);
        let mut world = [[0.0; LANES]; 3];
        let mut uv = [cell.u, [0.0; LANES]];
        for lane in 0..LANES {
            let height = cell.versine[lane];
            // From the distance to the pole, because the cosine has no precision next to it.
            let level = (height * (2.0 - height)).max(0.0).sqrt();
            let (sin, cos) = sin_cos((cell.u[lane] - 0.5) * TAU);
            let up = cell.pole[lane] * (1.0 - height);
            world[0][lane] = level * cos;
            world[1][lane] = up;
            world[2][lane] = level * sin;
            uv[1][lane] = atan2(level, up) * FRAC_1_PI;
        }
        let mut direction = [[0.0; LANES]; 3];
        for axis in 0..3 {
            let [x, y, z] = self.camera_axes[axis];
            for lane in 0..LANES {
                direction[axis][lane] = x * world[0][lane] + y * world[1][lane] + z * world[2][lane];
            }
        }
        EnvironmentSample { direction, radiance: self.bilinear(&uv), pdf: cell.pdf }
    }

    /// The texture coordinates (u, v) of directions, both from 0 to 1.
    #[inline(always)]
    fn uv(&self, direction: &[[f32; LANES]; 3]) -> Points {
        let [right, up, back] = self.camera_axes;
        let mut uv = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let [a, b, c] = at(direction, lane);
            let x = a * right[0] + b * up[0] + c * back[0];
            let y = a * right[1] + b * up[1] + c * back[1];
            let z = a * right[2] + b * up[2] + c * back[2];
            let level = (x * x + z * z).sqrt();
            uv[0][lane] = 0.5 + atan2(z, x) * (0.5 * FRAC_1_PI);
            // acos(y) from both legs of the angle: accurate next to the poles, and for any length.
            uv[1][lane] = atan2(level, y) * FRAC_1_PI;
        }
        uv
    }

    #[inline(always)]
    fn bilinear(&self, [u, v]: &Points) -> [[f32; LANES]; 3] {
        let (columns, rows) = (self.columns, self.rows);
        let mut index = [[0; LANES]; 4];
        let mut fraction = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            let x = u[lane] * columns as f32 - 0.5;
            let y = v[lane] * rows as f32 - 0.5;
            let (whole_x, whole_y) = (x.floor(), y.floor());
            fraction[0][lane] = x - whole_x;
            fraction[1][lane] = y - whole_y;
            let (column, row) = ((whole_x as i32).min(columns - 1), whole_y as i32);
            let left = if column < 0 { columns - 1 } else { column };
            let right = if column + 1 < columns { column + 1 } else { 0 };
            let upper = row.max(0).min(rows - 1);
            let lower = (row + 1).max(0).min(rows - 1);
            index[0][lane] = (upper * columns + left) as u32;
            index[1][lane] = (upper * columns + right) as u32;
            index[2][lane] = (lower * columns + left) as u32;
            index[3][lane] = (lower * columns + right) as u32;
        }
        let mut corner = [[[0.0; LANES]; 3]; 4];
        for k in 0..4 {
            for lane in 0..LANES {
                let [r, g, b] = self.texels[index[k][lane] as usize];
                corner[k][0][lane] = r;
                corner[k][1][lane] = g;
                corner[k][2][lane] = b;
            }
        }
        let mut out = [[0.0; LANES]; 3];
        for c in 0..3 {
            for lane in 0..LANES {
                let (fx, fy) = (fraction[0][lane], fraction[1][lane]);
                let upper = corner[0][c][lane] * (1.0 - fx) + corner[1][c][lane] * fx;
                let lower = corner[2][c][lane] * (1.0 - fx) + corner[3][c][lane] * fx;
                out[c][lane] = upper * (1.0 - fy) + lower * fy;
            }
        }
        out
    }
}
