//! Deviations of real cameras of an array from the ones that were meant.

use crate::Error;
use crate::base::error::not_negative;
use crate::sensor::{Purpose, Stream};

/// How far the cameras of an array deviate from what was meant, as the cameras of real arrays do: standard deviations of normal
/// distributions, and the end of an even distribution of the time. What is 0 is exact.
///
/// # Source
///
/// Wilburn et al., *High Performance Imaging Using Large Camera Arrays*, 2005: cameras whose poses, focus, response and times differ.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct CameraJitter {
    /// Of the position, along each axis, m.
    pub position_m: f64,
    /// Of the rotation, about each axis, rad.
    pub rotation_rad: f64,
    /// Of the focal length, relative; a camera that is focused nearer has a longer one.
    pub focal: f64,
    /// Of the gain, relative.
    pub gain: f64,
    /// Of the gain of each channel besides, relative.
    pub color: f64,
    /// The latest time at which a camera sees the scene, s; times are evenly distributed from 0.
    pub time_s: f64,
}

/// How a camera deviates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraDeviation {
    /// Right, up and back, m.
    pub position_m: [f64; 3],
    /// The vector about which it is turned, right, up and back, by its length, rad.
    pub rotation_rad: [f64; 3],
    /// The factor of the focal length.
    pub focal: f64,
    /// The factor of the light of each channel.
    pub gain: [f64; 3],
    /// How much later it sees the scene, s.
    pub time_s: f64,
}

/// The least factor of a focal length or a gain: deviations are small, and no camera is mirrored or dark.
const LEAST_FACTOR: f64 = 0.1;

impl CameraJitter {
    /// Returns the deviation of camera `k`. It follows from the seed and the number alone; what deviates is independent of the rest,
    /// so that another kind of jitter changes nothing of the first.
    ///
    /// # Errors
    ///
    /// [`Error::BadNumber`] if a number is negative or not finite.
    pub fn deviation(&self, seed: u64, k: u64) -> Result<CameraDeviation, Error> {
        for (what, value) in [
            ("jitter of the position in meters", self.position_m),
            ("jitter of the rotation in radians", self.rotation_rad),
            ("jitter of the focal length", self.focal),
            ("jitter of the gain", self.gain),
            ("jitter of the color", self.color),
            ("jitter of the time in seconds", self.time_s),
        ] {
            not_negative(what, value)?;
        }
        let normal = |purpose, axis: u64| Stream::new(seed, k, purpose).normal(axis);
        let three = |purpose, size: f64| [0, 1, 2].map(|axis| size * normal(purpose, axis));
        let factor = |deviation: f64| (1.0 + deviation).max(LEAST_FACTOR);
        let gain = factor(self.gain * normal(Purpose::CameraGain, 0));
        Ok(CameraDeviation {
            position_m: three(Purpose::CameraPosition, self.position_m),
            rotation_rad: three(Purpose::CameraRotation, self.rotation_rad),
            focal: factor(self.focal * normal(Purpose::CameraFocal, 0)),
            gain: three(Purpose::CameraColor, self.color).map(|color| gain * factor(color)),
            time_s: self.time_s * Stream::new(seed, k, Purpose::CameraTime).uniform(0),
        })
    }
}

impl CameraDeviation {
    /// Turns and moves the axes right, up and back and the position of a camera.
    #[must_use]
    pub fn moved(&self, axes: [[f64; 3]; 3], position_m: [f64; 3]) -> ([[f64; 3]; 3], [f64; 3]) {
        let in_world = |v: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|k| v[0] * axes[0][k] + v[1] * axes[1][k] + v[2] * axes[2][k])
        };
        let offset = in_world(self.position_m);
        let angle = self.rotation_rad.iter().map(|x| x * x).sum::<f64>().sqrt();
        let position_m = std::array::from_fn(|k| position_m[k] + offset[k]);
        if angle == 0.0 {
            return (axes, position_m);
        }
        // The rotation about a vector (Rodrigues).
        let axis = self.rotation_rad.map(|x| x / angle);
        let (sin, cos) = angle.sin_cos();
        let turned = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|v: [f64; 3]| {
            let cross =
                [axis[1] * v[2] - axis[2] * v[1], axis[2] * v[0] - axis[0] * v[2], axis[0] * v[1] - axis[1] * v[0]];
            let along = (0..3).map(|k| axis[k] * v[k]).sum::<f64>() * (1.0 - cos);
            std::array::from_fn(|k| v[k] * cos + cross[k] * sin + axis[k] * along)
        });
        (turned.map(in_world), position_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const JITTER: CameraJitter =
        CameraJitter { position_m: 0.01, rotation_rad: 0.02, focal: 0.03, gain: 0.1, color: 0.05, time_s: 0.5 };

    #[test]
    fn deviations_have_the_distribution_that_was_asked_for() {
        const COUNT: u64 = 4000;
        let all: Vec<CameraDeviation> = (0..COUNT).map(|k| JITTER.deviation(7, k).expect("a deviation")).collect();
        let moments = |of: &dyn Fn(&CameraDeviation) -> f64| {
            let mean = all.iter().map(of).sum::<f64>() / COUNT as f64;
            (mean, (all.iter().map(|x| (of(x) - mean).powi(2)).sum::<f64>() / COUNT as f64).sqrt())
        };
        // Means within 5 standard errors, deviations within 5 %.
        for (of, mean, deviation) in [
            (&(|x: &CameraDeviation| x.position_m[1]) as &dyn Fn(&CameraDeviation) -> f64, 0.0, 0.01),
            (&|x| x.rotation_rad[2], 0.0, 0.02),
            (&|x| x.focal, 1.0, 0.03),
            (&|x| x.gain[0] / x.gain[1], 1.0, 0.05 * 2.0_f64.sqrt()),
            (&|x| x.time_s, 0.25, 0.5 / 12.0_f64.sqrt()),
        ] {
            let (found, spread) = moments(of);
            assert!((found - mean).abs() < 5.0 * deviation / (COUNT as f64).sqrt(), "{found} {mean}");
            assert!((spread / deviation - 1.0).abs() < 0.05, "{spread} {deviation}");
        }
        let (_, gain) = moments(&|x| x.gain[2]);
        // A product of two independent factors around 1.
        assert!((gain / 0.1_f64.hypot(0.05).hypot(0.1 * 0.05) - 1.0).abs() < 0.05, "{gain}");
    }

    #[test]
    fn each_kind_is_its_own() {
        let whole = JITTER.deviation(3, 5).expect("a deviation");
        let only = CameraJitter { position_m: 0.01, ..CameraJitter::default() }.deviation(3, 5).expect("a deviation");
        assert_eq!(only.position_m, whole.position_m);
        assert_eq!((only.rotation_rad, only.focal, only.gain, only.time_s), ([0.0; 3], 1.0, [1.0; 3], 0.0));
        assert_ne!(JITTER.deviation(4, 5).expect("a deviation"), whole);
        assert_ne!(JITTER.deviation(3, 6).expect("a deviation"), whole);
        assert!(CameraJitter { gain: -0.1, ..JITTER }.deviation(0, 0).is_err());
        assert!(CameraJitter { time_s: f64::INFINITY, ..JITTER }.deviation(0, 0).is_err());
    }

    #[test]
    fn cameras_are_turned_about_their_own_axes() {
        let none = CameraJitter::default().deviation(0, 0).expect("none");
        let axes = [[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
        assert_eq!(none.moved(axes, [1.0, 2.0, 3.0]), (axes, [1.0, 2.0, 3.0]));
        let turn = CameraDeviation { rotation_rad: [0.0, 0.0, 0.3], position_m: [0.1, 0.0, 0.0], ..none };
        let (turned, position) = turn.moved(axes, [0.0; 3]);
        assert_eq!(position, [0.0, 0.0, -0.1]);
        let (sin, cos) = 0.3_f64.sin_cos();
        for (found, expected) in turned.iter().zip([[0.0, sin, -cos], [0.0, cos, sin], [1.0, 0.0, 0.0]]) {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-15), "{turned:?}");
        }
        let any = JITTER.deviation(1, 1).expect("a deviation").moved(axes, [0.0; 3]).0;
        let products = (0..9).map(|k| (any[k / 3].iter().zip(any[k % 3]).map(|(a, b)| a * b).sum::<f64>(), k % 4 == 0));
        assert!(products.into_iter().all(|(found, is_one)| (found - f64::from(u8::from(is_one))).abs() < 1e-14));
    }
}
