//! What depends on the viewer's direction alone: the shares of the parts, and how often each is drawn.

use super::albedo::{self, Albedo, Average, Rows};
use super::fresnel;
use super::microfacet::{CLEAR_BELOW, SMOOTH_BELOW};
use super::{Bsdf, Directions};
use crate::simd::LANES;

/// Metal that reflects less than this is drawn as if it did not: its facets may reflect more than the mean one.
const LEAST_ENERGY: f32 = 0.05;

/// The parts of sixteen mixtures under one viewer's direction each.
pub(super) struct Lobes {
    /// Shares of the mixture.
    pub metal: [f32; LANES],
    pub glass: [f32; LANES],
    pub varnish: [f32; LANES],
    /// Probabilities of metal, glass (reflection and transmission), the varnish's facets, the diffuser.
    pub pick_metal: [f32; LANES],
    pub pick_glass: [f32; LANES],
    pub pick_varnish: [f32; LANES],
    pub pick_diffuse: [f32; LANES],
    /// Metal and varnish have one direction only; glass has.
    pub smooth: [bool; LANES],
    pub clear: [bool; LANES],
    /// The strongest channel of `specular_f0`.
    pub strongest_f0: [f32; LANES],
    /// 1 - E(out), and 1 - `<E>`.
    pub below_out: [f32; LANES],
    pub below_average: [f32; LANES],
    /// If some lane has varnish that is not smooth.
    pub rows: Option<Rows>,
    /// Some lane is more than Lambert's; has facets; single directions; glass. Parts that no lane has are left out,
    /// which changes no other lane: there they add 0.
    pub any_specular: bool,
    pub any_facets: bool,
    pub any_single: bool,
    pub any_glass: bool,
}

impl Bsdf {
    #[inline(always)]
    pub(super) fn lobes(&self, out: &Directions) -> Lobes {
        let zero = [0.0; LANES];
        let mut lobes = Lobes {
            metal: zero,
            glass: zero,
            varnish: zero,
            pick_metal: zero,
            pick_glass: zero,
            pick_varnish: zero,
            pick_diffuse: [1.0; LANES],
            smooth: [false; LANES],
            clear: [false; LANES],
            strongest_f0: zero,
            below_out: [1.0; LANES],
            below_average: [1.0; LANES],
            rows: None,
            any_specular: false,
            any_facets: false,
            any_single: false,
            any_glass: false,
        };
        let [mut specular, mut facets, mut glass_facets, mut rough_varnish, mut single] = [0; 5];
        for lane in 0..LANES {
            let rest = 1.0 - self.metallic[lane];
            let (metal, glass) = (self.metallic[lane], rest * self.transmission[lane]);
            let varnish = rest * (1.0 - self.transmission[lane]);
            lobes.metal[lane] = metal;
            lobes.glass[lane] = glass;
            lobes.varnish[lane] = varnish;
            let smooth = self.width[lane] < SMOOTH_BELOW;
            let straight = !self.thin[lane] & ((self.eta[lane] - 1.0).abs() < CLEAR_BELOW);
            lobes.smooth[lane] = smooth;
            lobes.clear[lane] = smooth | straight;
            lobes.strongest_f0[lane] =
                self.specular_f0[0][lane].max(self.specular_f0[1][lane]).max(self.specular_f0[2][lane]);

            let varnish = varnish * self.specular_f90[lane];
            specular |= u32::from(metal + glass + varnish > 0.0);
            facets |= u32::from((metal + varnish > 0.0) & !smooth);
            glass_facets |= u32::from((glass > 0.0) & !(smooth | straight));
            rough_varnish |= u32::from((varnish > 0.0) & !smooth);
            single |= u32::from(smooth | straight);
        }
        for lane in 0..LANES {
            lobes.any_glass |= lobes.glass[lane] > 0.0;
        }
        lobes.any_specular = specular != 0;
        lobes.any_facets = facets | glass_facets != 0;
        lobes.any_single = single != 0;
        if !lobes.any_specular {
            return lobes;
        }

        let (mut here, mut mean) = (Albedo::SMOOTH, Average::SMOOTH);
        if rough_varnish != 0 {
            let (table, rows) = (albedo::table(), albedo::rows(&self.width));
            here = table.albedo(&rows, &out[2], &self.width, &lobes.smooth);
            mean = table.average(&rows, &lobes.smooth);
            lobes.rows = Some(rows);
        }
        for lane in 0..LANES {
            let (f0, f90) = (lobes.strongest_f0[lane], self.specular_f90[lane]);
            let way = fresnel::schlick(out[2][lane]);
            let albedo = here.of(lane, f0, f90, way);
            lobes.below_out[lane] = 1.0 - albedo;
            lobes.below_average[lane] = 1.0 - mean.of(lane, f0, f90);

            let mut metal = 0.0;
            let mut diffuse = 0.0;
            for c in 0..3 {
                metal += fresnel::between(self.base_color[c][lane], self.metal_f90[c][lane], way);
                diffuse += self.base_color[c][lane];
            }
            let metal = lobes.metal[lane] * (metal * (1.0 / 3.0)).max(LEAST_ENERGY);
            let glass = lobes.glass[lane];
            let varnish = lobes.varnish[lane] * albedo;
            let diffuse = lobes.varnish[lane] * (1.0 - albedo) * (diffuse * (1.0 / 3.0));
            // Divided, not multiplied by an inverse: a part that is alone gets exactly 1.
            let sum = metal + glass + varnish + diffuse;
            let some = sum > 0.0;
            let sum = if some { sum } else { 1.0 };
            lobes.pick_metal[lane] = metal / sum;
            lobes.pick_glass[lane] = glass / sum;
            lobes.pick_varnish[lane] = varnish / sum;
            let diffuse = diffuse / sum;
            lobes.pick_diffuse[lane] = if some { diffuse } else { 1.0 };
        }
        lobes
    }
}
