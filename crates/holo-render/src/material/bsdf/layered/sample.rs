//! Sampling of layered BSDFs.

use super::facet::visible_normal;
use super::{COAT_F0, LayeredView, Vector, dot, sheen, unit};
use crate::material::bsdf::fresnel;

/// Directions with a smaller pdf count as not sampled.
const MIN_PDF: f32 = 1e-30;

/// A sampled direction; fields as in [`crate::material::bsdf::Sampled`].
pub(crate) struct SampledOne {
    pub into: Vector,
    pub weight: [f32; 3],
    pub pdf: f32,
    pub transmitted: bool,
}

impl SampledOne {
    const NONE: Self = Self { into: [0.0, 0.0, 1.0], weight: [0.0; 3], pdf: 0.0, transmitted: false };

    fn delta(into: Vector, weight: [f32; 3]) -> Self {
        Self { into, weight, pdf: f32::INFINITY, transmitted: into[2] < 0.0 }
    }
}

impl LayeredView {
    /// Samples the direction to the light: `choice` selects the lobe; `disk` is a point of the unit disk with the
    /// height of the hemisphere over it.
    #[inline(never)]
    pub fn sample(&self, choice: f32, disk: Vector) -> SampledOne {
        let pick = &self.pick;
        let mut rest = choice;
        let mut chosen = |share: f32| {
            let is_chosen = rest < share;
            rest -= if is_chosen { 0.0 } else { share };
            is_chosen
        };
        if chosen(pick.diffuse) {
            return self.weighed(disk);
        }
        if chosen(pick.through) {
            return self.weighed([disk[0], disk[1], -disk[2]]);
        }
        if chosen(pick.sheen) {
            return self.weighed(sheen::direction(disk));
        }
        if chosen(pick.clearcoat) {
            return self.sample_clearcoat(disk);
        }
        if chosen(pick.glass) {
            return self.sample_glass((rest / pick.glass).min(1.0 - f32::EPSILON), disk);
        }
        // Metal and coat have the same microfacets.
        if pick.metal + pick.coat <= 0.0 {
            return SampledOne::NONE;
        }
        if self.smooth {
            return self.mirror();
        }
        let into = reflect(self.out, visible_normal(self.out, self.m.alpha, disk));
        if into[2] > 0.0 { self.weighed(into) } else { SampledOne::NONE }
    }

    /// The sample in a direction that is no delta lobe.
    fn weighed(&self, into: Vector) -> SampledOne {
        if into[2] == 0.0 {
            return SampledOne::NONE;
        }
        let (value, pdf) = self.evaluate(into);
        if pdf <= MIN_PDF {
            return SampledOne::NONE;
        }
        SampledOne { into, weight: value.map(|x| x / pdf), pdf, transmitted: into[2] < 0.0 }
    }

    fn sample_clearcoat(&self, disk: Vector) -> SampledOne {
        let Some(coat) = self.m.clearcoat else { return SampledOne::NONE };
        let mut out = coat.to_own(self.out);
        out[2] = out[2].max(super::MIN_COSINE);
        if !coat.is_smooth() {
            let own = reflect(unit(out), visible_normal(unit(out), [coat.alpha; 2], disk));
            let into = coat.to_shading(own);
            return if own[2] > 0.0 && into[2] > 0.0 { self.weighed(into) } else { SampledOne::NONE };
        }
        let into = coat.to_shading([-out[0], -out[1], out[2]]);
        if into[2] <= 0.0 {
            return SampledOne::NONE;
        }
        let reflected = fresnel::interpolate(COAT_F0, 1.0, fresnel::schlick(out[2]));
        SampledOne::delta(into, [coat.factor * reflected / self.pick.clearcoat.max(MIN_PDF); 3])
    }

    /// The reflection of the smooth lobes, which share their direction: metal, coat and glass.
    fn mirror(&self) -> SampledOne {
        let m = &self.m;
        let into = [-self.out[0], -self.out[1], self.out[2]];
        let mut probability = 0.0;
        let mut value = [0.0; 3];
        let cosine = self.out[2];
        if self.smooth {
            probability += self.pick.metal + self.pick.coat;
            let (metal, coat) = (m.metal_fresnel(cosine), m.coat_fresnel(cosine));
            (0..3).for_each(|c| value[c] += self.metal * metal[c] + self.coat * coat[c]);
        }
        if self.delta_glass && self.glass > 0.0 {
            let (active, count) = self.active();
            for c in 0..3 {
                let (reflected, strongest) = m.glass_fresnel(cosine, m.eta[c]);
                value[c] += self.glass * reflected[c];
                probability += if active[c] { self.pick.glass * strongest / count } else { 0.0 };
            }
        }
        let scale = self.left(into)[0] / probability.max(MIN_PDF);
        SampledOne::delta(into, value.map(|x| x * scale))
    }

    /// `choice` selects the channel, and whether glass reflects or transmits.
    fn sample_glass(&self, choice: f32, disk: Vector) -> SampledOne {
        let m = &self.m;
        let (active, count) = self.active();
        let scaled = choice * count;
        let number = (scaled as usize).min(count as usize - 1);
        let (eta, choice, channel) = if m.is_dispersive() {
            let channel = (0..3).filter(|&c| active[c]).nth(number).unwrap_or(1);
            (m.eta[channel], scaled - number as f32, Some(channel))
        } else {
            (m.eta[1], choice, None)
        };
        let normal = if self.delta_glass { [0.0, 0.0, 1.0] } else { visible_normal(self.out, m.alpha, disk) };
        let cosine = dot(self.out, normal);
        if cosine <= 0.0 {
            return SampledOne::NONE;
        }
        let (_, strongest) = m.glass_fresnel(cosine, eta);
        if choice < strongest {
            if self.delta_glass {
                return self.mirror();
            }
            let into = reflect(self.out, normal);
            return if into[2] > 0.0 { self.weighed(into) } else { SampledOne::NONE };
        }
        let into = if m.thin {
            let [x, y, z] = reflect(self.out, normal);
            if z <= 0.0 {
                return SampledOne::NONE;
            }
            [x, y, -z]
        } else {
            let into = refract(self.out, normal, cosine, fresnel::interface(cosine, eta).scaled_cosine);
            if into[2] >= 0.0 {
                return SampledOne::NONE;
            }
            into
        };
        if !self.delta_glass {
            return self.weighed(into);
        }
        let spread = if m.thin { 1.0 } else { eta * eta };
        let scale = self.left(into)[0] * self.glass / (self.pick.glass.max(MIN_PDF) * spread);
        // Refracted by a channel of its own, the others get nothing.
        let share = |c: usize| channel.map_or(1.0, |channel| if c == channel { count } else { 0.0 });
        SampledOne::delta(into, std::array::from_fn(|c| m.base_color[c] * scale * share(c)))
    }
}

fn reflect(out: Vector, normal: Vector) -> Vector {
    let twice = 2.0 * dot(out, normal);
    std::array::from_fn(|k| twice * normal[k] - out[k])
}

/// As [`fresnel::refract`].
fn refract(out: Vector, normal: Vector, cosine: f32, scaled_cosine: f32) -> Vector {
    unit(std::array::from_fn(|k| cosine * normal[k] - out[k] - scaled_cosine * normal[k]))
}
