//! Evaluation of the BSDF for given directions.

use std::f32::consts::FRAC_1_PI;

use super::albedo::{self, Albedo};
use super::lobes::Lobes;
use super::{Bsdf, Directions, Evaluated, fresnel, microfacet};
use crate::simd::LANES;

/// The terms of BSDF * |into.z| = base color * `tinted` + `plain`. Separate, so that the weight of a sampled Lambertian
/// direction is exactly the base color.
pub(super) struct Terms {
    pub tinted: [f32; LANES],
    pub plain: [[f32; LANES]; 3],
    pub pdf: [f32; LANES],
}

/// The Fresnel reflectance of glass.
pub(super) struct Glass {
    /// The reflectance per channel.
    pub reflected: [[f32; LANES]; 3],
    /// The reflectance of the strongest channel: 1 - transmittance, and the probability of reflection.
    pub strongest: [f32; LANES],
    /// See [`fresnel::Interface`].
    pub scaled_cosine: [f32; LANES],
}

impl Bsdf {
    /// Evaluates the BSDF from `into` to `out`, whose lobes are `lobes`, without the delta lobes.
    #[inline(always)]
    pub fn evaluate_lobes(&self, lobes: &Lobes, out: &Directions, into: &Directions) -> Evaluated {
        let terms = self.terms(lobes, out, into);
        let mut value = terms.plain;
        for c in 0..3 {
            for lane in 0..LANES {
                value[c][lane] += self.base_color[c][lane] * terms.tinted[lane];
            }
        }
        Evaluated { value, pdf: terms.pdf }
    }

    #[inline(always)]
    pub(super) fn terms(&self, lobes: &Lobes, out: &Directions, into: &Directions) -> Terms {
        let mut terms = Terms { tinted: [0.0; LANES], plain: [[0.0; LANES]; 3], pdf: [0.0; LANES] };
        let mut albedo_into = Albedo::SMOOTH;
        if let Some(rows) = &lobes.rows {
            albedo_into = albedo::table().albedo(rows, &into[2].map(f32::abs), &self.alpha, &lobes.smooth);
        }
        for lane in 0..LANES {
            let z = into[2][lane].max(0.0);
            let lambert = z * FRAC_1_PI;
            let schlick_weight = fresnel::schlick(z);
            let albedo = albedo_into.of(lane, lobes.strongest_f0[lane], self.specular_f90[lane], schlick_weight);
            let again = lobes.strongest_again[lane] * (1.0 - albedo_into.scale[lane]).max(0.0);
            let transmittance_into = (1.0 - albedo - again).max(0.0);
            let coupling =
                lobes.coat_transmittance_out[lane] * transmittance_into / lobes.coat_transmittance_mean[lane].max(1e-7);
            terms.tinted[lane] = lambert * (lobes.coat[lane] * coupling);
            terms.pdf[lane] = lambert * lobes.pick_diffuse[lane];
        }
        if lobes.any_rough {
            self.add_microfacets(lobes, out, into, &albedo_into.gain, &mut terms);
        }
        terms
    }

    #[inline(always)]
    fn add_microfacets(
        &self,
        lobes: &Lobes,
        out: &Directions,
        into: &Directions,
        gain_into: &[f32; LANES],
        terms: &mut Terms,
    ) {
        let microfacets = microfacet::microfacets(out, into, &self.alpha, &self.eta, &self.thin);
        for lane in 0..LANES {
            let mirror = (into[2][lane] > 0.0) & !lobes.smooth[lane];
            let value = if mirror { microfacets.value[lane] } else { 0.0 };
            let pdf = if mirror { microfacets.pdf[lane] } else { 0.0 };
            let schlick_weight = fresnel::schlick(microfacets.cosine[lane]);
            let (metal, coat) = (value * lobes.metal[lane], value * lobes.coat[lane]);
            let again = if self.multiple_scattering { lobes.gain_out[lane] * gain_into[lane] - 1.0 } else { 0.0 };
            for c in 0..3 {
                let conductor = fresnel::interpolate(self.base_color[c][lane], self.metal_f90[c][lane], schlick_weight);
                let dielectric =
                    fresnel::interpolate(self.specular_f0[c][lane], self.specular_f90[lane], schlick_weight);
                // The gains of two directions of little loss are slightly below 1.
                let conductor = (conductor + lobes.metal_again[c][lane] * again).max(0.0);
                let dielectric = (dielectric + lobes.coat_again[c][lane] * again).max(0.0);
                terms.plain[c][lane] += metal * conductor + coat * dielectric;
            }
            terms.pdf[lane] += (lobes.pick_metal[lane] + lobes.pick_coat[lane]) * pdf;
        }
        if !lobes.any_glass {
            return;
        }
        let glass = self.glass(lobes, &microfacets.cosine, &microfacets.eta);
        for lane in 0..LANES {
            let rough = !lobes.delta_transmission[lane];
            let gain =
                if self.thin[lane] & self.multiple_scattering { lobes.gain_out[lane] * gain_into[lane] } else { 1.0 };
            let value = if rough { lobes.glass[lane] * microfacets.value[lane] * gain } else { 0.0 };
            let pdf = if rough { lobes.pick_glass[lane] * microfacets.pdf[lane] } else { 0.0 };
            let behind = into[2][lane] < 0.0;
            let through = 1.0 - glass.strongest[lane];
            terms.tinted[lane] += if behind { value * through } else { 0.0 };
            for c in 0..3 {
                terms.plain[c][lane] += if behind { 0.0 } else { value * glass.reflected[c][lane] };
            }
            terms.pdf[lane] += pdf * if behind { through } else { glass.strongest[lane] };
        }
    }

    /// What smooth glass lets pass without bending it, at `cosine` in the thinner medium; 0 for other materials.
    #[inline(always)]
    pub fn straight_transmittance(&self, cosine: &[f32; LANES]) -> [[f32; LANES]; 3] {
        let mut out = [[0.0; LANES]; 3];
        let mut lobes = Lobes::LAMBERTIAN;
        self.set_weights(&mut lobes);
        // A ray that is refracted into a body and out again has the same angle outside; it is never totally reflected.
        let eta = self.eta.map(|eta| eta.max(1.0 / eta));
        let glass = self.glass(&lobes, cosine, &eta);
        for c in 0..3 {
            for lane in 0..LANES {
                let passes = lobes.glass[lane] * (1.0 - glass.strongest[lane]) * self.base_color[c][lane];
                out[c][lane] = if lobes.delta_transmission[lane] { passes } else { 0.0 };
            }
        }
        out
    }

    /// The reflectance of glass for microfacets at `cosine`.
    #[inline(always)]
    pub(super) fn glass(&self, lobes: &Lobes, cosine: &[f32; LANES], eta: &[f32; LANES]) -> Glass {
        let zero = [0.0; LANES];
        let mut glass = Glass { reflected: [zero; 3], strongest: zero, scaled_cosine: zero };
        for lane in 0..LANES {
            let interface = fresnel::interface(cosine[lane], eta[lane]);
            let schlick_weight = fresnel::grazing_weight(interface.reflected, eta[lane]);
            let f90 = self.specular_f90[lane];
            for c in 0..3 {
                let share = fresnel::interpolate(self.specular_f0[c][lane], f90, schlick_weight);
                glass.reflected[c][lane] = if interface.total { 1.0 } else { share };
            }
            let share = fresnel::interpolate(lobes.strongest_f0[lane], f90, schlick_weight);
            glass.strongest[lane] = if interface.total { 1.0 } else { share };
            glass.scaled_cosine[lane] = interface.scaled_cosine;
        }
        glass
    }
}
