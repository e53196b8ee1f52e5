//! The mixture towards given directions.

use std::f32::consts::FRAC_1_PI;

use super::albedo::{self, Albedo};
use super::lobes::Lobes;
use super::{Bsdf, Directions, Evaluated, fresnel, microfacet};
use crate::simd::LANES;

/// f |into.z| = base colour * `tinted` + `plain`: so that Lambert's law, sampled, weighs exactly its base colour.
pub(super) struct Terms {
    pub tinted: [f32; LANES],
    pub plain: [[f32; LANES]; 3],
    pub pdf: [f32; LANES],
}

/// Glass under one angle.
pub(super) struct Glass {
    /// Share that is reflected.
    pub reflected: [[f32; LANES]; 3],
    /// The strongest channel: the share that is not let through, and the probability of reflection.
    pub strongest: [f32; LANES],
    /// See [`fresnel::Interface`].
    pub scaled_cosine: [f32; LANES],
}

impl Bsdf {
    /// The mixture seen from `out` under light from `into`, without the parts that have a single direction.
    #[inline(always)]
    pub fn evaluate(&self, out: &Directions, into: &Directions) -> Evaluated {
        let terms = self.terms(&self.lobes(out), out, into);
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
        let mut there = Albedo::SMOOTH;
        if let Some(rows) = &lobes.rows {
            there = albedo::table().albedo(rows, &into[2], &self.width, &lobes.smooth);
        }
        for lane in 0..LANES {
            let z = into[2][lane].max(0.0);
            let lambert = z * FRAC_1_PI;
            let way = fresnel::schlick(z);
            let below = 1.0 - there.of(lane, lobes.strongest_f0[lane], self.specular_f90[lane], way);
            let coupling = lobes.below_out[lane] * below / lobes.below_average[lane].max(1e-7);
            terms.tinted[lane] = lambert * (lobes.varnish[lane] * coupling);
            terms.pdf[lane] = lambert * lobes.pick_diffuse[lane];
        }
        if lobes.any_facets {
            self.add_facets(lobes, out, into, &mut terms);
        }
        terms
    }

    #[inline(always)]
    fn add_facets(&self, lobes: &Lobes, out: &Directions, into: &Directions, terms: &mut Terms) {
        let facets = microfacet::facets(out, into, &self.width, &self.eta, &self.thin);
        for lane in 0..LANES {
            let mirror = (into[2][lane] > 0.0) & !lobes.smooth[lane];
            let value = if mirror { facets.value[lane] } else { 0.0 };
            let pdf = if mirror { facets.pdf[lane] } else { 0.0 };
            let way = fresnel::schlick(facets.cosine[lane]);
            let (metal, varnish) = (value * lobes.metal[lane], value * lobes.varnish[lane]);
            for c in 0..3 {
                let conductor = fresnel::between(self.base_color[c][lane], self.metal_f90[c][lane], way);
                let coat = fresnel::between(self.specular_f0[c][lane], self.specular_f90[lane], way);
                terms.plain[c][lane] += metal * conductor + varnish * coat;
            }
            terms.pdf[lane] += (lobes.pick_metal[lane] + lobes.pick_varnish[lane]) * pdf;
        }
        if !lobes.any_glass {
            return;
        }
        let glass = self.glass(lobes, &facets.cosine, &facets.eta);
        for lane in 0..LANES {
            let rough = !lobes.clear[lane];
            let value = if rough { lobes.glass[lane] * facets.value[lane] } else { 0.0 };
            let pdf = if rough { lobes.pick_glass[lane] * facets.pdf[lane] } else { 0.0 };
            let behind = into[2][lane] < 0.0;
            let through = 1.0 - glass.strongest[lane];
            terms.tinted[lane] += if behind { value * through } else { 0.0 };
            for c in 0..3 {
                terms.plain[c][lane] += if behind { 0.0 } else { value * glass.reflected[c][lane] };
            }
            terms.pdf[lane] += pdf * if behind { through } else { glass.strongest[lane] };
        }
    }

    /// What glass reflects where its facets stand at `cosine`.
    #[inline(always)]
    pub(super) fn glass(&self, lobes: &Lobes, cosine: &[f32; LANES], eta: &[f32; LANES]) -> Glass {
        let zero = [0.0; LANES];
        let mut glass = Glass { reflected: [zero; 3], strongest: zero, scaled_cosine: zero };
        for lane in 0..LANES {
            let interface = fresnel::interface(cosine[lane], eta[lane]);
            let way = fresnel::towards_grazing(interface.reflected, eta[lane]);
            let f90 = self.specular_f90[lane];
            for c in 0..3 {
                let share = fresnel::between(self.specular_f0[c][lane], f90, way);
                glass.reflected[c][lane] = if interface.total { 1.0 } else { share };
            }
            let share = fresnel::between(lobes.strongest_f0[lane], f90, way);
            glass.strongest[lane] = if interface.total { 1.0 } else { share };
            glass.scaled_cosine[lane] = interface.scaled_cosine;
        }
        glass
    }
}
