//! The pose of the rig in Blender's world space.

/// Position (m) and rotation (rad) of the rig as `parameters.cfg` contains them.
///
/// # Units
///
/// Meters and radians in Blender's world space: right-handed with Z up. The rotation is Euler XYZ: first about X, then
/// Y, then Z. A camera without rotation looks along -Z with +Y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraPose {
    /// Position: `center_cam_{x,y,z}_m`.
    pub position_m: [f64; 3],
    /// Euler angles: `center_cam_r{x,y,z}_rad`.
    pub rotation_rad: [f64; 3],
}

impl CameraPose {
    /// Converts the pose of a glTF camera to Blender's world space: `(x, y, z)` becomes `(x, -z, y)`.
    ///
    /// `right`, `up` and `back` are the directions of the camera's +X, +Y and +Z axes in the glTF world, orthonormal;
    /// `position_m` is its position, m. In both conventions a camera looks along its -Z.
    ///
    /// # Examples
    ///
    /// ```
    /// use std::f64::consts::FRAC_PI_2;
    ///
    /// // A glTF camera without rotation looks horizontally; in Blender that is a rotation by 90 degrees about X.
    /// let axes = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    /// let pose = holo_io::CameraPose::from_gltf([1.0, 2.0, 3.0], axes.0, axes.1, axes.2);
    /// assert_eq!(pose.position_m, [1.0, -3.0, 2.0]);
    /// assert_eq!(pose.rotation_rad, [FRAC_PI_2, 0.0, 0.0]);
    /// ```
    #[must_use]
    pub fn from_gltf(position_m: [f64; 3], right: [f64; 3], up: [f64; 3], back: [f64; 3]) -> Self {
        // `+ 0.0` turns -0 into 0.
        let turn = |[x, y, z]: [f64; 3]| [x + 0.0, -z + 0.0, y + 0.0];
        let (right, up, back) = (turn(right), turn(up), turn(back));
        // The columns of R = Rz(c) Ry(b) Rx(a).
        let cos_b = right[0].hypot(right[1]);
        let rotation_rad = if cos_b > 1e-9 {
            [up[2].atan2(back[2]), (-right[2]).atan2(cos_b), right[1].atan2(right[0])]
        } else {
            // Gimbal lock: only the sum of the other two angles is determined. All of it goes to X.
            [(-back[1]).atan2(up[1]), (-right[2]).atan2(cos_b), 0.0]
        };
        Self { position_m: turn(position_m), rotation_rad: rotation_rad.map(|angle| angle + 0.0) }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn multiply(a: [[f64; 3]; 3], b: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
    }

    /// Rows of Rz(c) Ry(b) Rx(a), written out from its definition.
    fn rotation([a, b, c]: [f64; 3]) -> [[f64; 3]; 3] {
        let x = [[1.0, 0.0, 0.0], [0.0, a.cos(), -a.sin()], [0.0, a.sin(), a.cos()]];
        let y = [[b.cos(), 0.0, b.sin()], [0.0, 1.0, 0.0], [-b.sin(), 0.0, b.cos()]];
        let z = [[c.cos(), -c.sin(), 0.0], [c.sin(), c.cos(), 0.0], [0.0, 0.0, 1.0]];
        multiply(z, multiply(y, x))
    }

    fn check(angles: [f64; 3]) {
        let gltf = rotation(angles);
        let column = |j: usize| [gltf[0][j], gltf[1][j], gltf[2][j]];
        let pose = CameraPose::from_gltf([0.0; 3], column(0), column(1), column(2));
        let [x, y, z] = gltf;
        for (found, expected) in
            rotation(pose.rotation_rad).iter().flatten().zip([x, z.map(|z| -z), y].iter().flatten())
        {
            assert!((found - expected).abs() < 1e-8, "{angles:?} gave {:?}", pose.rotation_rad);
        }
    }

    proptest! {
        #[test]
        fn the_angles_rebuild_the_axes(a in -3.2..3.2_f64, b in -3.2..3.2_f64, c in -3.2..3.2_f64) {
            check([a, b, c]);
        }
    }

    #[test]
    fn quarter_turns_rebuild_the_axes() {
        use std::f64::consts::FRAC_PI_2;
        for turns in 0..64 {
            check([turns % 4, turns / 4 % 4, turns / 16].map(|quarter| f64::from(quarter) * FRAC_PI_2));
        }
    }
}
