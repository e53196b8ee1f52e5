//! The rotation that axes are meant to be.

use crate::Error;

/// Axes this close to a right-handed orthonormal frame are kept unchanged, so that what is written is read again to the bit.
const EXACT: f64 = 1e-12;

/// How far rounded axes may be from a rotation: numbers of files have single precision.
const ROUNDED: f64 = 1e-4;

/// Returns the right-handed frame of unit vectors of the axes +X, +Y and +Z: scale, shear and mirroring are removed such that the
/// directions of +Z (back) and, in its plane with it, +Y (up) stay. `None` if an axis has no length.
#[must_use]
pub fn rotation_of([x, y, z]: [[f64; 3]; 3]) -> Option<[[f64; 3]; 3]> {
    let products =
        [(dot(x, x), 1.0), (dot(y, y), 1.0), (dot(z, z), 1.0), (dot(x, y), 0.0), (dot(y, z), 0.0), (dot(z, x), 0.0)];
    if products.iter().all(|(is, should)| (is - should).abs() <= EXACT) && dot(cross(x, y), z) > 0.0 {
        return Some([x, y, z]);
    }
    let back = unit(z)?;
    let y = unit(y)?;
    let along = dot(y, back);
    let up = unit([y[0] - along * back[0], y[1] - along * back[1], y[2] - along * back[2]])?;
    Some([cross(up, back), up, back])
}

/// Returns the rotation of axes that are one but for rounding, by up to 1e-4.
///
/// # Errors
///
/// [`Error::BadNumber`] if they are farther from it: scaled, mirrored, or no axes.
pub fn rotation_near(axes: [[f64; 3]; 3]) -> Result<[[f64; 3]; 3], Error> {
    let deviations = |rotation: &[[f64; 3]; 3]| -> [f64; 9] {
        std::array::from_fn(|k| (rotation[k / 3][k % 3] - axes[k / 3][k % 3]).abs())
    };
    match rotation_of(axes) {
        Some(rotation) if deviations(&rotation).iter().all(|x| *x <= ROUNDED) => Ok(rotation),
        found => Err(Error::BadNumber {
            what: "deviation of the axes of a camera from a rotation",
            value: found.map_or(f64::NAN, |rotation| deviations(&rotation).into_iter().fold(f64::NAN, f64::max)),
            need: "at most 1e-4: right-handed, without scale",
        }),
    }
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The normalized vector; `None` for zero, and for what is not finite.
fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    // Scaled first: squares of very large or small numbers overflow or underflow.
    let largest = v.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let v = v.map(|x| x / largest);
    let length = dot(v, v).sqrt();
    Some(v.map(|x| x / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_stay_and_others_become_one() {
        let (sin, cos) = 0.3_f64.sin_cos();
        let frame = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(rotation_of(frame), Some(frame));
        let [x, y, z] = frame;
        let sheared = [x, [y[0] * 3.0, y[1] * 3.0, 0.5], z.map(|a| 1e-200 * a)];
        let is_frame = |found: [[f64; 3]; 3], from: usize| {
            let pairs = found[from..].as_flattened().iter().zip(frame[from..].as_flattened());
            pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-15)
        };
        assert!(is_frame(rotation_of(sheared).expect("axes with lengths"), 0));
        // A mirrored frame keeps its directions up and back.
        assert!(is_frame(rotation_of([x.map(|a| -a), y, z]).expect("axes"), 1));
        assert_eq!(rotation_of([x, [0.0; 3], z]), None);
    }

    #[test]
    fn rounded_axes_are_rotations_and_others_are_refused() {
        let (sin, cos) = 0.3_f64.sin_cos();
        let [x, y, z] = [[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]];
        let rounded = rotation_near([x, y.map(|a| (a * 1e5).round() / 1e5), z]).expect("rounded axes");
        assert!(dot(rounded[0], rounded[1]).abs() < 1e-15 && (dot(rounded[1], rounded[1]) - 1.0).abs() < 1e-15);
        for axes in [
            [x, y, z.map(|a| -a)],
            [x, y, z.map(|a| 1.01 * a)],
            [y, x, z],
            [[0.0; 3]; 3],
            [x, y, [f64::NAN; 3]],
            [[f64::NAN; 3], y, z],
        ] {
            assert!(rotation_near(axes).is_err(), "{axes:?}");
        }
    }
}
