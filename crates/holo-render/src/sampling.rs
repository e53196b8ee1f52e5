//! Random numbers as a function of (seed, lens, view, sample): Owen-scrambled Sobol points, one sequence a pixel.
//!
//! Nothing else goes in, so an image is the same for any number of threads, any tiles and any part of it rendered alone.

/// The four numbers in [0, 1) of one sample: two place it in its pixel, two choose a direction.
#[inline]
pub(crate) fn sample(sequence: u32, index: u32) -> [f32; 4] {
    sobol_burley::sample_4d(index, 0, sequence)
}

/// Which sequence a pixel uses: lens and view are counted row by row.
#[inline(always)]
pub(crate) fn sequence(seed: u64, lens: u32, view: u32) -> u32 {
    // The finaliser of SplitMix64 over the three numbers.
    let mut z = seed ^ (u64::from(lens) << 32 | u64::from(view)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    (z ^ (z >> 31)) as u32
}

/// Samples a pixel at most: the length of the Sobol sequence.
pub(crate) const MOST_SAMPLES: u32 = 1 << 16;

/// A direction around +Z, distributed as its cosine with it (Malley's method over the concentric disk of Shirley and
/// Chiu, 1997).
#[inline(always)]
pub(crate) fn cosine_hemisphere(u: f32, v: f32) -> [f32; 3] {
    let (a, b) = (2.0 * u - 1.0, 2.0 * v - 1.0);
    if a == 0.0 && b == 0.0 {
        return [0.0, 0.0, 1.0];
    }
    let quarter = std::f32::consts::FRAC_PI_4;
    let (radius, angle) =
        if a.abs() > b.abs() { (a, quarter * (b / a)) } else { (b, 2.0 * quarter - quarter * (a / b)) };
    let (sin, cos) = angle.sin_cos();
    let (x, y) = (radius * cos, radius * sin);
    [x, y, (1.0 - x * x - y * y).max(0.0).sqrt()]
}

/// Two unit vectors that make a right-handed frame with the unit vector `n` (Duff et al., "Building an Orthonormal
/// Basis, Revisited", JCGT 6, 2017).
#[inline(always)]
pub(crate) fn frame(n: [f32; 3]) -> [[f32; 3]; 2] {
    let sign = 1.0f32.copysign(n[2]);
    let a = -1.0 / (sign + n[2]);
    let b = n[0] * n[1] * a;
    [[1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]], [b, sign + n[1] * n[1] * a, -n[1]]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_frame_is_orthonormal() {
        for n in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.6, 0.0, -0.8], [1.0, 0.0, 0.0], [0.48, 0.6, 0.64]] {
            let [x, y] = frame(n);
            let dot = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f32>();
            for (a, b, expected) in [(x, x, 1.0), (y, y, 1.0), (x, y, 0.0), (x, n, 0.0), (y, n, 0.0)] {
                assert!((dot(a, b) - expected).abs() < 1e-6, "{n:?}");
            }
        }
    }

    /// The mean of the cosine under a cosine distribution is 2/3, and x, y average to 0: within 1e-3 for 65536 points.
    #[test]
    fn the_hemisphere_has_the_right_moments() {
        let mut sums = [0.0f64; 3];
        for index in 0..MOST_SAMPLES {
            let [_, _, u, v] = sample(5, index);
            let direction = cosine_hemisphere(u, v);
            let length: f32 = direction.iter().map(|x| x * x).sum();
            assert!((length - 1.0).abs() < 1e-5);
            for axis in 0..3 {
                sums[axis] += f64::from(direction[axis]) / f64::from(MOST_SAMPLES);
            }
        }
        assert!(sums[0].abs() < 1e-3 && sums[1].abs() < 1e-3 && (sums[2] - 2.0 / 3.0).abs() < 1e-3, "{sums:?}");
    }
}
