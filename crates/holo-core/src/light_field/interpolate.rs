//! Interpolation between the samples of a light field.

use ndarray::Data;

use super::LightField;
use crate::Sample;

impl<S: Data> LightField<S>
where
    S::Elem: Sample,
{
    /// Returns the value of channel `channel` at fractional indices, by linear interpolation along all four axes.
    ///
    /// # Units
    ///
    /// Indices along `(v, u, t, s)`: whole numbers are samples. Indices outside the grid are clamped to it; NaN gives
    /// NaN.
    ///
    /// # Accuracy
    ///
    /// Exact at samples; between them a sum of 16 products in `f64`.
    ///
    /// # Panics
    ///
    /// If there is no such channel.
    ///
    /// # Source
    ///
    /// Quadrilinear interpolation (Levoy and Hanrahan, "Light Field Rendering", 1996).
    ///
    /// # Examples
    ///
    /// ```
    /// use holo_core::LightField;
    /// use ndarray::Array5;
    ///
    /// let sample = |(v, u, t, s, _)| (v + 10 * u + 100 * t + 1000 * s) as f32;
    /// let samples = Array5::from_shape_fn((3, 4, 2, 2, 1), sample);
    /// let light_field = LightField::new(samples)?;
    /// assert_eq!(light_field.sample(1.5, 2.25, 0.5, 1.0, 0), 1.5 + 22.5 + 50.0 + 1000.0);
    /// # Ok::<(), holo_core::Error>(())
    /// ```
    #[must_use]
    pub fn sample(&self, v: f64, u: f64, t: f64, s: f64, channel: usize) -> f64 {
        let (rows, columns, view_rows, view_columns, _) = self.samples.dim();
        let [v, u, t, s] = [(v, rows), (u, columns), (t, view_rows), (s, view_columns)].map(|(at, n)| Taps::new(at, n));
        let mut sum = 0.0;
        for (v, v_weight) in v.0 {
            for (u, u_weight) in u.0 {
                for (t, t_weight) in t.0 {
                    for (s, s_weight) in s.0 {
                        let weight = v_weight * u_weight * t_weight * s_weight;
                        // A sample of weight 0 may be infinite.
                        if weight != 0.0 {
                            sum += weight * self.samples[[v, u, t, s, channel]].to_f64();
                        }
                    }
                }
            }
        }
        sum
    }
}

/// The two samples around a fractional index, with their weights.
struct Taps([(usize, f64); 2]);

impl Taps {
    fn new(at: f64, count: usize) -> Self {
        let at = at.clamp(0.0, (count - 1) as f64);
        let fraction = at - at.floor();
        // NaN becomes index 0 and weights of NaN.
        let index = at as usize;
        Self([(index, 1.0 - fraction), ((index + 1).min(count - 1), fraction)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array5;

    fn field() -> LightField<ndarray::OwnedRepr<u8>> {
        let samples =
            Array5::from_shape_fn((3, 4, 2, 5, 2), |(v, u, t, s, c)| (v * 50 + u * 9 + t * 31 + s * 3 + c) as u8);
        LightField::new(samples).unwrap()
    }

    #[test]
    fn samples_are_exact_and_indices_outside_are_clamped() {
        let field = field();
        for ((v, u, t, s, c), &value) in field.samples().indexed_iter() {
            assert_eq!(field.sample(v as f64, u as f64, t as f64, s as f64, c), f64::from(value));
        }
        assert_eq!(field.sample(-3.0, 99.0, f64::INFINITY, f64::NEG_INFINITY, 1), field.sample(0.0, 3.0, 1.0, 0.0, 1));
        assert!(field.sample(f64::NAN, 0.0, 0.0, 0.0, 0).is_nan());
    }

    /// Against the definition: the mean of the sixteen corners with triangle weights.
    #[test]
    fn between_samples_it_is_the_weighted_mean_of_sixteen() {
        let field = field();
        for at in [[0.25, 1.5, 0.75, 2.125], [1.9, 0.1, 0.5, 3.3]] {
            let mut expected = 0.0;
            for ((v, u, t, s, c), &value) in field.samples().indexed_iter() {
                let weight_of = |index: usize, at: f64| (1.0 - (index as f64 - at).abs()).max(0.0);
                let weight = weight_of(v, at[0])
                    * weight_of(u, at[1])
                    * weight_of(t, at[2])
                    * weight_of(s, at[3])
                    * weight_of(c, 1.0);
                expected += weight * f64::from(value);
            }
            let found = field.sample(at[0], at[1], at[2], at[3], 1);
            assert!((found - expected).abs() < 1e-12 * expected, "{found} {expected}");
        }
    }

    #[test]
    fn a_single_sample_is_constant() {
        let field = LightField::new(Array5::from_elem((1, 1, 1, 1, 1), 7.5_f32)).unwrap();
        assert_eq!(field.sample(0.3, -2.0, 5.0, 0.0, 0), 7.5);
    }
}
