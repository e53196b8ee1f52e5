//! The choice of the window: the largest one whose mean does not differ from those of smaller ones by more than noise
//! explains.
//!
//! The squared error of a mean over a window is its variance plus the square of its bias. The half differences, averaged
//! over the same window, give the variance. The bias against a smaller window j shows in the difference of the two
//! means, whose expected square is bias^2 + variance_j - variance. Both are averaged over the pixels of a block of
//! views and 5 x 5 microlenses, relative to their luminance. A difference below two standard errors of that average
//! counts as noise. (The comparison of nested windows is that of Lepski, 1991, and of Goldenshluger and Nemirovski,
//! 1997, known in image processing as the intersection of confidence intervals.)

use super::windows::LEVELS;

/// Microlenses on each side over which evidence is averaged.
pub(super) const LENSES: usize = 2;

/// Standard errors above which a difference counts as bias.
const STANDARD_ERRORS: f64 = 2.0;

/// The share of the mean squared luminance that is added to that of a block: errors are relative where there is light.
const FLOOR: f64 = 0.01;

/// The pairs of levels, the smaller first.
const PAIRS: usize = LEVELS * (LEVELS - 1) / 2;

/// Sums over the sampled pixels of a block of views of one microlens; in f64, because squares of radiance may exceed f32.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Evidence {
    /// Of the squares of the mean half differences, by level.
    variance: [f64; LEVELS],
    /// Of the squares of the differences between the means of two levels.
    difference: [f64; PAIRS],
    /// Of the squares of the luminance.
    luminance: f64,
    pixels: f64,
    /// The number of levels of the microlens.
    levels: usize,
}

/// The window of a block of views, and its error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Choice {
    /// A level; fractions stand for mixtures of two.
    pub level: f32,
    /// The estimated relative squared error.
    pub error: f32,
}

fn pair(smaller: usize, larger: usize) -> usize {
    larger * (larger - 1) / 2 + smaller
}

impl Evidence {
    pub fn new(levels: usize) -> Self {
        Self { levels, ..Self::default() }
    }

    /// Adds a pixel: luminances and half differences of the means by level.
    pub fn add(&mut self, luminance: &[f32; LEVELS], difference: &[f32; LEVELS]) {
        for larger in 0..self.levels {
            self.variance[larger] += f64::from(difference[larger]).powi(2);
            for smaller in 0..larger {
                let apart = f64::from(luminance[larger]) - f64::from(luminance[smaller]);
                self.difference[pair(smaller, larger)] += apart * apart;
            }
        }
        let mean = f64::from(luminance[self.levels - 1]);
        self.luminance += mean * mean;
        self.pixels += 1.0;
    }
}

/// Chooses for the block of views of a microlens. `near` has the evidence of the same block of the microlenses around it;
/// `levels` is the number of levels of the microlens, and `window_views` the views of each window. Neighbors with fewer
/// windows are left out; those with more, whose windows differ a little, are taken as evidence all the same.
pub(super) fn choose(near: &[Evidence], levels: usize, window_views: &[f64; LEVELS], block_views: f64) -> Choice {
    let mut brightness = 0.0;
    let mut lenses = 0.0;
    for evidence in near.iter().filter(|evidence| evidence.levels >= levels) {
        brightness += evidence.luminance / evidence.pixels;
        lenses += 1.0;
    }
    let floor = FLOOR * brightness / lenses;
    let mut sum = Evidence::new(levels);
    for evidence in near.iter().filter(|evidence| evidence.levels >= levels) {
        let weight = 1.0 / (evidence.luminance / evidence.pixels + floor).max(f64::MIN_POSITIVE) / evidence.pixels;
        for level in 0..levels {
            sum.variance[level] += evidence.variance[level] * weight / lenses;
        }
        for k in 0..pair(0, levels) {
            sum.difference[k] += evidence.difference[k] * weight / lenses;
        }
        sum.pixels += evidence.pixels;
    }
    let (mut level, mut least) = (0, sum.variance[0]);
    for larger in 1..levels {
        let mut error = sum.variance[larger];
        for smaller in 0..larger {
            let noise = (sum.variance[smaller] - sum.variance[larger]).max(0.0);
            let found = sum.difference[pair(smaller, larger)];
            // Means over overlapping windows are one observation.
            let observations = (lenses * (block_views / window_views[smaller]).max(1.0)).min(sum.pixels);
            // Of the mean of squared normal numbers, for the difference and for its expectation.
            let standard_error = noise * (4.0 / observations).sqrt();
            let bias = found - noise;
            if bias > STANDARD_ERRORS * standard_error {
                error = error.max(sum.variance[larger] + bias);
            }
        }
        if error <= least {
            (level, least) = (larger, error);
        }
    }
    Choice { level: level as f32, error: least as f32 }
}
