//! Resampled importance sampling (RIS): one of several light samples is selected with a probability proportional to its
//! unoccluded contribution, and only that one gets a shadow ray (Talbot et al., "Importance Resampling for Global
//! Illumination", 2005).

use holo_scene::MAX_RADIANCE;

use super::light_sampling::Contribution;
use crate::simd::LANES;

/// The largest f32 below 1.
const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// A reservoir: one selected candidate per lane out of those offered so far.
pub(super) struct Reservoir {
    number: [f32; LANES],
    total: [f32; LANES],
    weight: [f32; LANES],
    selected: Contribution,
}

impl Reservoir {
    /// An empty reservoir that selects by these random numbers.
    #[inline(always)]
    pub fn new(number: [f32; LANES]) -> Self {
        let zero = [0.0; LANES];
        let selected = Contribution {
            value: [zero; 3],
            start: [zero; 3],
            to_light: [zero; 3],
            far: zero,
            over_weight: [1.0; LANES],
        };
        Self { number, total: zero, weight: zero, selected }
    }

    /// Offers a candidate, which replaces the selected one with a probability of its share of the total weight. The
    /// random number is rescaled within that share and reused.
    #[inline(always)]
    pub fn offer(&mut self, candidate: &Contribution) {
        let mut replaces = [false; LANES];
        for lane in 0..LANES {
            let value = candidate.value[0][lane] + candidate.value[1][lane] + candidate.value[2][lane];
            let total = self.total[lane] + value;
            let share = if total > 0.0 { value / total } else { 0.0 };
            let number = self.number[lane];
            replaces[lane] = number < share;
            let rescaled = if replaces[lane] { number / share } else { (number - share) / (1.0 - share) };
            self.number[lane] = if rescaled >= 0.0 { rescaled.min(ONE_MINUS_EPSILON) } else { 0.0 };
            self.weight[lane] = if replaces[lane] { value } else { self.weight[lane] };
            self.total[lane] = total;
        }
        for lane in 0..LANES {
            self.selected.far[lane] = if replaces[lane] { candidate.far[lane] } else { self.selected.far[lane] };
            let over_weight = self.selected.over_weight[lane];
            self.selected.over_weight[lane] = if replaces[lane] { candidate.over_weight[lane] } else { over_weight };
        }
        for k in 0..3 {
            for lane in 0..LANES {
                self.selected.value[k][lane] =
                    if replaces[lane] { candidate.value[k][lane] } else { self.selected.value[k][lane] };
                self.selected.start[k][lane] =
                    if replaces[lane] { candidate.start[k][lane] } else { self.selected.start[k][lane] };
                let to_light = self.selected.to_light[k][lane];
                self.selected.to_light[k][lane] = if replaces[lane] { candidate.to_light[k][lane] } else { to_light };
            }
        }
    }

    /// The selected candidate, weighted by the inverse of its selection probability.
    #[inline(always)]
    pub fn selected(&self) -> Contribution {
        let mut out = self.selected;
        for lane in 0..LANES {
            let factor = if self.weight[lane] > 0.0 { self.total[lane] / self.weight[lane] } else { 0.0 };
            for c in 0..3 {
                out.value[c][lane] = (out.value[c][lane] * factor).min(MAX_RADIANCE);
            }
        }
        out
    }
}
