//! Resampled importance sampling: of several light samples one is kept, drawn by what each would contribute without its shadow, and
//! a single shadow ray goes to it (Talbot et al., "Importance Resampling for Global Illumination", 2005).

use holo_scene::MAX_RADIANCE;

use super::direct_light::Contribution;
use crate::simd::LANES;

/// The largest f32 below 1.
const ONE_MINUS: f32 = 1.0 - f32::EPSILON / 2.0;

/// One candidate for every lane, out of those that were offered so far.
pub(super) struct Reservoir {
    number: [f32; LANES],
    total: [f32; LANES],
    weight: [f32; LANES],
    kept: Contribution,
}

impl Reservoir {
    /// An empty one that chooses by these random numbers.
    #[inline(always)]
    pub fn new(number: [f32; LANES]) -> Self {
        let zero = [0.0; LANES];
        let kept = Contribution { value: [zero; 3], start: [zero; 3], to_light: [zero; 3], far: zero };
        Self { number, total: zero, weight: zero, kept }
    }

    /// The candidate takes the place with its share of what was seen so far; what is left of the random number within that
    /// share is used again.
    #[inline(always)]
    pub fn offer(&mut self, candidate: &Contribution) {
        let mut takes = [false; LANES];
        for lane in 0..LANES {
            let value = candidate.value[0][lane] + candidate.value[1][lane] + candidate.value[2][lane];
            let total = self.total[lane] + value;
            let share = if total > 0.0 { value / total } else { 0.0 };
            let number = self.number[lane];
            takes[lane] = number < share;
            let rest = if takes[lane] { number / share } else { (number - share) / (1.0 - share) };
            self.number[lane] = if rest >= 0.0 { rest.min(ONE_MINUS) } else { 0.0 };
            self.weight[lane] = if takes[lane] { value } else { self.weight[lane] };
            self.total[lane] = total;
        }
        for lane in 0..LANES {
            self.kept.far[lane] = if takes[lane] { candidate.far[lane] } else { self.kept.far[lane] };
        }
        for k in 0..3 {
            for lane in 0..LANES {
                self.kept.value[k][lane] =
                    if takes[lane] { candidate.value[k][lane] } else { self.kept.value[k][lane] };
                self.kept.start[k][lane] =
                    if takes[lane] { candidate.start[k][lane] } else { self.kept.start[k][lane] };
                let to_light = self.kept.to_light[k][lane];
                self.kept.to_light[k][lane] = if takes[lane] { candidate.to_light[k][lane] } else { to_light };
            }
        }
    }

    /// The candidate that was drawn, with the weight that makes up for the others.
    #[inline(always)]
    pub fn chosen(&self) -> Contribution {
        let mut out = self.kept;
        for lane in 0..LANES {
            let factor = if self.weight[lane] > 0.0 { self.total[lane] / self.weight[lane] } else { 0.0 };
            for c in 0..3 {
                out.value[c][lane] = (out.value[c][lane] * factor).min(MAX_RADIANCE);
            }
        }
        out
    }
}
