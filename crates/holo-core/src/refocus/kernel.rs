//! Interpolation kernels, and the pixels that a shifted view covers.

use std::ops::Range;

use ndarray::ArrayView3;

use crate::Sample;

/// The interpolation kernel between pixels, along rows and columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum Kernel {
    /// Linear: two pixels per axis. It blurs, most at half pixels. A search for the sharpest plane is therefore biased,
    /// by some hundredths of a pixel, to disparities that shift many views by whole pixels.
    Bilinear,
    /// Cubic, four pixels per axis: Catmull-Rom, which is the kernel of Keys with a = -1/2. It preserves more detail,
    /// reproduces parabolas, and may overshoot at edges by up to an eighth of their height per axis.
    #[default]
    CatmullRom,
}

/// The padding in pixels: one for the width of the kernel and one for positions beyond the outermost pixel.
pub(super) const PAD: usize = 2;

impl Kernel {
    /// The weights of the pixels at -1, 0, 1 and 2 for the position `fraction`.
    pub(crate) fn weights(self, fraction: f64) -> [f64; 4] {
        let f = fraction;
        match self {
            Self::Bilinear => [0.0, 1.0 - f, f, 0.0],
            Self::CatmullRom => [
                0.5 * f * (-1.0 + f * (2.0 - f)),
                1.0 + 0.5 * f * f * (3.0 * f - 5.0),
                0.5 * f * (1.0 + f * (4.0 - 3.0 * f)),
                0.5 * f * f * (f - 1.0),
            ],
        }
    }
}

/// The shift of a whole image along one axis, with the same four weights for all pixels.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shift {
    /// The pixels of the result whose samples are within the view: between its outer edges, half a pixel beyond the
    /// outermost pixel centers.
    pub covered: Range<usize>,
    /// The first of the four view pixels for pixel 0 of the result.
    pub first: isize,
    /// Their weights.
    pub weights: [f32; 4],
}

impl Shift {
    /// The shift that samples a view of `count` pixels at `pixel + position`.
    pub fn new(position: f64, count: usize, kernel: Kernel) -> Self {
        // Conversions saturate: positions beyond all pixels, infinity included, cover none.
        let from = (-0.5 - position).ceil().max(0.0) as usize;
        let to = (count as f64 - 0.5 - position).ceil().max(0.0) as usize;
        let covered = from.min(count)..to.min(count);
        if covered.is_empty() {
            return Self { covered: 0..0, first: 0, weights: [0.0; 4] };
        }
        let whole = position.floor();
        let weights = kernel.weights(position - whole).map(|weight| weight as f32);
        Self { covered, first: whole as isize - 1, weights }
    }

    /// The view pixel with weight `tap` for a pixel of the result, clamped to the view.
    pub fn source(&self, pixel: usize, tap: usize, count: usize) -> usize {
        (pixel as isize + self.first + tap as isize).clamp(0, count as isize - 1) as usize
    }
}

/// Adds the weighted sample of an image at a place (row, column); the pixels of the border go on beyond it.
pub(crate) fn add_sample<T: Sample>(
    image: ArrayView3<'_, T>,
    place: [f64; 2],
    kernel: Kernel,
    weight: f32,
    sample: &mut [f32],
) {
    let [(first_row, down), (first_column, along)] =
        place.map(|at| (at.floor() as isize - 1, kernel.weights(at - at.floor()).map(|weight| weight as f32)));
    add_pixels(image, [first_row, first_column], [down.map(|part| weight * part), along], sample);
}

/// Adds 4 x 4 pixels of an image from a first row and column on, with their weights down and along; the pixels of the border go on
/// beyond it.
pub(crate) fn add_pixels<T: Sample>(
    image: ArrayView3<'_, T>,
    [first_row, first_column]: [isize; 2],
    [down, along]: [[f32; 4]; 2],
    sample: &mut [f32],
) {
    let (rows, columns, _) = image.dim();
    let inside = |at: isize, count: usize| at.clamp(0, count as isize - 1) as usize;
    let row_of = |k: usize| inside(first_row + k as isize, rows);
    let column_of = |k: usize| inside(first_column + k as isize, columns);
    for (k, weight) in (0..16).map(|k| (k, down[k / 4] * along[k % 4])).filter(|(_, weight)| *weight != 0.0) {
        for (channel, value) in sample.iter_mut().enumerate() {
            *value += weight * image[[row_of(k / 4), column_of(k % 4), channel]].to_f32();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_reproduce_polynomials_of_their_degree() {
        for step in 0..=64 {
            let f = f64::from(step) / 64.0;
            for (kernel, degree) in [(Kernel::Bilinear, 1), (Kernel::CatmullRom, 2)] {
                let weights = kernel.weights(f);
                for power in 0..=degree {
                    // The polynomial x^power at the places -1, 0, 1, 2.
                    let sum: f64 = weights.iter().zip([-1.0_f64, 0.0, 1.0, 2.0]).map(|(w, x)| w * x.powi(power)).sum();
                    assert!((sum - f.powi(power)).abs() < 1e-15, "{kernel:?} {f} {power}");
                }
            }
        }
        assert_eq!(Kernel::CatmullRom.weights(0.0), [0.0, 1.0, 0.0, 0.0]);
        assert_eq!(Kernel::CatmullRom.weights(0.5), [-0.0625, 0.5625, 0.5625, -0.0625]);
    }

    #[test]
    fn shifts_cover_what_lies_between_the_outer_edges() {
        let covered = |position| Shift::new(position, 10, Kernel::CatmullRom).covered;
        assert_eq!(covered(0.0), 0..10);
        assert_eq!(covered(0.49), 0..10);
        // Pixel 9 + 0.5 is on the right edge, which belongs to the next pixel. Pixel 0 - 0.5 is on the left edge, which
        // is inside.
        assert_eq!(covered(0.5), 0..9);
        assert_eq!(covered(-0.5), 0..10);
        assert_eq!(covered(-0.51), 1..10);
        assert_eq!(covered(3.2), 0..7);
        assert_eq!(covered(-3.2), 3..10);
        for far in [10.0, -11.0, 1e300, -1e300, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(covered(far).is_empty(), "{far}");
        }
    }

    #[test]
    fn no_weight_lies_beyond_the_padding() {
        for step in -200..200 {
            let shift = Shift::new(f64::from(step) / 16.0, 10, Kernel::CatmullRom);
            if !shift.covered.is_empty() {
                let reach = |pixel: usize, tap: isize| pixel as isize + shift.first + tap;
                assert!(reach(shift.covered.start, 0) >= -(PAD as isize), "{step}");
                assert!(reach(shift.covered.end - 1, 3) < 10 + PAD as isize, "{step}");
            }
        }
    }
}
