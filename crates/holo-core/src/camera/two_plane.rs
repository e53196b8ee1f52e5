//! Two-plane coordinates of rays and the 5 x 5 intrinsic matrix of a light field.

use super::{Rig, RigRay};

impl RigRay {
    /// Returns the ray in two-plane coordinates: x and y of its point in the plane of the cameras, and how far x and y
    /// change over one meter of depth; the second plane lies one meter in front of the first.
    ///
    /// # Units
    ///
    /// Meters, x to the right and y *down*, as in the publications of this parameterization.
    #[must_use]
    pub fn two_plane(&self) -> [f64; 4] {
        [self.origin_m[0], -self.origin_m[1], self.direction[0], -self.direction[1]]
    }
}

impl Rig {
    /// Returns the 5 x 5 intrinsic matrix H: `(x, y, dx, dy, 1) = H (s, t, u, v, 1)`, the
    /// [two-plane coordinates](RigRay::two_plane) of the ray through the center of pixel `(v, u)` of view `(t, s)`.
    /// Indices count from `first`: 0, or 1 as in MATLAB.
    ///
    /// # Source
    ///
    /// Dansereau, Pizarro, Williams: "Decoding, Calibration and Rectification for Lenselet-Based Plenoptic Cameras"
    /// (CVPR, 2013), Eq. 7 and 8, with x, y for its s, t in meters and dx, dy for its u, v in the relative two-plane
    /// parameterization.
    ///
    /// # Accuracy
    ///
    /// Rounding of f64: the ray of [`Rig::ray`] is linear in its indices.
    #[must_use]
    pub fn intrinsic_matrix(&self, first: u32) -> [[f64; 5]; 5] {
        let ray = |[s, t, u, v]: [usize; 4]| self.ray(v, u, t, s, 0.5, 0.5).two_plane();
        let origin = ray([0; 4]);
        let mut matrix = [[0.0; 5]; 5];
        for axis in 0..4 {
            let mut index = [0; 4];
            index[axis] = 1;
            let moved = ray(index);
            for row in 0..4 {
                matrix[row][axis] = moved[row] - origin[row];
            }
        }
        for row in 0..4 {
            matrix[row][4] = origin[row] - f64::from(first) * matrix[row][..4].iter().sum::<f64>();
        }
        matrix[4][4] = 1.0;
        matrix
    }
}

#[cfg(test)]
mod tests {
    use crate::{GridSize, LightFieldShape, Projection, Rig};

    #[test]
    fn the_matrix_gives_the_rays_of_the_rig() {
        let shape = LightFieldShape::new(GridSize::new(7, 9), GridSize::new(20, 30)).expect("a shape");
        let rig = |focus_m: f64, projection| {
            Rig::builder(shape)
                .baseline_m(1e-3)
                .focus_distance_m(focus_m)
                .projection(projection)
                .build()
                .expect("a rig")
        };
        for rig in [
            rig(0.8, Projection::Perspective),
            rig(f64::INFINITY, Projection::Perspective),
            rig(0.8, Projection::Orthographic),
        ] {
            for first in [0, 1] {
                let matrix = rig.intrinsic_matrix(first);
                for [s, t, u, v] in [[0, 0, 0, 0], [8, 6, 29, 19], [3, 5, 11, 2]] {
                    let index = [s, t, u, v].map(|k: usize| k as f64 + f64::from(first));
                    let expected = rig.ray(v, u, t, s, 0.5, 0.5).two_plane();
                    for (row, expected) in matrix.iter().zip(expected) {
                        let found = row[..4].iter().zip(index).map(|(a, b)| a * b).sum::<f64>() + row[4];
                        assert!((found - expected).abs() < 1e-14, "{first} {found} {expected}");
                    }
                }
                assert_eq!(matrix[4], [0.0, 0.0, 0.0, 0.0, 1.0]);
            }
        }
    }
}
