//! The value of a property between its keys.

use super::super::json::{Object, bad};
use super::super::uri::shorten;
use crate::Error;

/// Below this angle between two rotations, rad, they are interpolated linearly: the sine of it divides.
const SMALL_ANGLE: f64 = 1e-6;

/// How values between keys are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Interpolation {
    /// That of the key before.
    Step,
    /// Linear; along the shorter great circle for rotations.
    Linear,
    /// Cubic Hermite splines: every key has a tangent before its value and one after it.
    CubicSpline,
}

impl Interpolation {
    pub(super) fn read(sampler: &Object<'_>) -> Result<Self, Error> {
        match sampler.string("interpolation")? {
            None | Some("LINEAR") => Ok(Self::Linear),
            Some("STEP") => Ok(Self::Step),
            Some("CUBICSPLINE") => Ok(Self::CubicSpline),
            Some(other) => {
                Err(bad(sampler.at("interpolation"), format!("'{}' is no interpolation of glTF", shorten(other))))
            }
        }
    }

    /// Tangents and values of a key.
    pub(super) fn elements_a_key(self) -> usize {
        if self == Self::CubicSpline { 3 } else { 1 }
    }
}

/// The keys of a property.
#[derive(Clone, Copy)]
pub(super) struct Keys<'k> {
    /// Increasing, s.
    pub(super) times: &'k [f64],
    /// The components of all elements, key after key: as many for each key.
    pub(super) components: &'k [f64],
    /// Whether values are unit quaternions.
    pub(super) is_rotation: bool,
}

impl Keys<'_> {
    /// The value at a time: before the first key that of the first, after the last that of the last.
    pub(super) fn at(&self, time_s: f64, interpolation: Interpolation) -> Vec<f64> {
        let per_key = self.components.len() / self.times.len().max(1);
        let width = per_key / interpolation.elements_a_key();
        let part = |key: usize, which: usize| {
            let start = key * per_key + which * width;
            &self.components[start..start + width]
        };
        let middle = usize::from(interpolation == Interpolation::CubicSpline);
        let after = self.times.partition_point(|&key| key <= time_s);
        if after == 0 || after == self.times.len() || interpolation == Interpolation::Step {
            return part(after.saturating_sub(1), middle).to_vec();
        }
        let before = after - 1;
        let step = self.times[after] - self.times[before];
        let t = (time_s - self.times[before]) / step;
        let (a, b) = (part(before, middle), part(after, middle));
        match interpolation {
            Interpolation::CubicSpline => {
                // The Hermite polynomials of appendix C.
                let (squared, cubed) = (t * t, t * t * t);
                let weights = [
                    2.0 * cubed - 3.0 * squared + 1.0,
                    step * (cubed - 2.0 * squared + t),
                    -2.0 * cubed + 3.0 * squared,
                    step * (cubed - squared),
                ];
                let points = [a, part(before, 2), b, part(after, 0)];
                (0..width).map(|k| weights.iter().zip(points).map(|(weight, point)| weight * point[k]).sum()).collect()
            }
            _ if self.is_rotation => slerp(a, b, t),
            _ => mix(a, b, [1.0 - t, t]),
        }
    }
}

fn mix(a: &[f64], b: &[f64], [first, second]: [f64; 2]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| first * a + second * b).collect()
}

/// Spherical linear interpolation of unit quaternions.
fn slerp(a: &[f64], b: &[f64], t: f64) -> Vec<f64> {
    let cosine: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    let angle = cosine.abs().min(1.0).acos();
    // A quaternion and its negative are the same rotation; the nearer one is the shorter way.
    let sign = if cosine < 0.0 { -1.0 } else { 1.0 };
    if angle < SMALL_ANGLE {
        return mix(a, b, [1.0 - t, sign * t]);
    }
    mix(a, b, [((1.0 - t) * angle).sin() / angle.sin(), sign * (t * angle).sin() / angle.sin()])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(components: &[f64], time_s: f64, interpolation: Interpolation) -> Vec<f64> {
        Keys { times: &[1.0, 3.0], components, is_rotation: false }.at(time_s, interpolation)
    }

    #[test]
    fn values_between_keys() {
        let two = [10.0, 0.0, 20.0, 4.0];
        for (time, linear, step) in [
            (0.0, [10.0, 0.0], [10.0, 0.0]),
            (1.0, [10.0, 0.0], [10.0, 0.0]),
            (1.5, [12.5, 1.0], [10.0, 0.0]),
            (3.0, [20.0, 4.0], [20.0, 4.0]),
            (9.0, [20.0, 4.0], [20.0, 4.0]),
        ] {
            assert_eq!(at(&two, time, Interpolation::Linear), linear, "{time}");
            assert_eq!(at(&two, time, Interpolation::Step), step, "{time}");
        }
    }

    /// A cubic polynomial is its own spline.
    #[test]
    fn splines() {
        let f = |t: f64| 2.0 * t.powi(3) - t * t + 0.5 * t - 3.0;
        let slope = |t: f64| 6.0 * t * t - 2.0 * t + 0.5;
        let components = [9.0, f(1.0), slope(1.0), slope(3.0), f(3.0), 9.0];
        for time in [0.5, 1.0, 1.25, 2.0, 2.9, 3.0, 4.0_f64] {
            let [is] = at(&components, time, Interpolation::CubicSpline)[..] else { panic!("one value") };
            assert!((is - f(time.clamp(1.0, 3.0))).abs() < 1e-12, "{time}: {is}");
        }
    }

    /// A turn by 0.8 rad about z, a part of the way; the second quaternion with either sign.
    #[test]
    fn rotations_turn_evenly_the_shorter_way() {
        let about = |angle: f64| [0.0, 0.0, (angle / 2.0).sin(), (angle / 2.0).cos()];
        for (angle, tolerance) in [(0.8, 1e-15), (3.0, 1e-15), (1e-7, 1e-15), (0.0, 1e-15)] {
            for sign in [1.0, -1.0] {
                let is = slerp(&about(0.3), &about(0.3 + angle).map(|x| sign * x), 0.25);
                let expected = about(0.3 + 0.25 * angle);
                let worst = is.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                assert!(worst <= 4.0 * tolerance, "{angle} {sign}: {is:?}, {worst:e}");
            }
        }
    }
}
