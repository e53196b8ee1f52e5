//! The lobe weights of the mixture and their sampling probabilities, which depend only on the direction to the viewer.

use super::albedo::{self, Albedo, Average, Rows};
use super::fresnel;
use super::microfacet::{INDEX_MATCHED_BELOW, SMOOTH_BELOW};
use super::multiple_scattering::{mean_schlick, repeated};
use super::{Bsdf, Directions};
use crate::simd::LANES;

/// The minimum reflectance of metal for the sampling probability: microfacets may reflect more than the mean direction.
const MIN_METAL_REFLECTANCE: f32 = 0.05;

/// The lobes of sixteen BSDFs for given directions to the viewer.
pub(crate) struct Lobes {
    /// Weights of the mixture: metal, glass, and diffuse with coat.
    pub metal: [f32; LANES],
    pub glass: [f32; LANES],
    pub coat: [f32; LANES],
    /// Sampling probabilities of metal, glass (reflection and transmission), the coat, and the diffuse lobe.
    pub pick_metal: [f32; LANES],
    pub pick_glass: [f32; LANES],
    pub pick_coat: [f32; LANES],
    pub pick_diffuse: [f32; LANES],
    /// Whether metal and coat are delta lobes; whether glass is (delta reflection and transmission).
    pub smooth: [bool; LANES],
    pub delta_transmission: [bool; LANES],
    /// The strongest channel of `specular_f0`.
    pub strongest_f0: [f32; LANES],
    /// E(out) of the coat.
    pub coat_albedo: [f32; LANES],
    /// 1 - E(out), and 1 - `<E>`.
    pub coat_transmittance_out: [f32; LANES],
    pub coat_transmittance_mean: [f32; LANES],
    /// 1 - W(out); the gain k(out) of the light that is scattered more than once; its strength S for metal and for the
    /// coat, per channel, and for the strongest channel of the coat.
    pub missing_out: [f32; LANES],
    pub gain_out: [f32; LANES],
    pub metal_again: [[f32; LANES]; 3],
    pub coat_again: [[f32; LANES]; 3],
    pub strongest_again: [f32; LANES],
    /// The table rows, if any lane has rough metal, a rough coat or a rough pane.
    pub(super) rows: Option<Rows>,
    /// Whether any lane is not purely Lambertian; has rough lobes; has delta lobes; has glass. Lobes that no lane has
    /// are skipped, which does not change the results: they would add 0.
    pub any_specular: bool,
    pub any_rough: bool,
    pub any_delta: bool,
    pub any_glass: bool,
}

impl Lobes {
    /// The lobes of Lambertian lanes.
    pub const LAMBERTIAN: Self = {
        let zero = [0.0; LANES];
        Self {
            metal: zero,
            glass: zero,
            coat: zero,
            pick_metal: zero,
            pick_glass: zero,
            pick_coat: zero,
            pick_diffuse: [1.0; LANES],
            smooth: [false; LANES],
            delta_transmission: [false; LANES],
            strongest_f0: zero,
            coat_albedo: zero,
            coat_transmittance_out: [1.0; LANES],
            coat_transmittance_mean: [1.0; LANES],
            missing_out: zero,
            gain_out: [1.0; LANES],
            metal_again: [zero; 3],
            coat_again: [zero; 3],
            strongest_again: zero,
            rows: None,
            any_specular: false,
            any_rough: false,
            any_delta: false,
            any_glass: false,
        }
    };
}

impl Bsdf {
    /// The lobes for directions `out` to the viewer.
    #[inline(always)]
    pub fn lobes(&self, out: &Directions) -> Lobes {
        let mut lobes = Lobes::LAMBERTIAN;
        let needs_table = self.set_weights(&mut lobes);
        if lobes.any_specular {
            self.set_albedos(out, needs_table, &mut lobes);
            self.set_probabilities(out, &mut lobes);
        }
        lobes
    }

    /// Sets the weights of the mixture and the kinds of lobes; returns whether any lane has rough metal, a rough
    /// coat or a rough pane.
    #[inline(always)]
    pub(super) fn set_weights(&self, lobes: &mut Lobes) -> bool {
        let [mut specular, mut microfacets, mut rough_glass, mut tabulated, mut delta] = [0; 5];
        for lane in 0..LANES {
            let rest = 1.0 - self.metallic[lane];
            let (metal, glass) = (self.metallic[lane], rest * self.transmission[lane]);
            let coat = rest * (1.0 - self.transmission[lane]);
            lobes.metal[lane] = metal;
            lobes.glass[lane] = glass;
            lobes.coat[lane] = coat;
            let smooth = self.alpha[lane] < SMOOTH_BELOW;
            let index_matched = !self.thin[lane] & ((self.eta[lane] - 1.0).abs() < INDEX_MATCHED_BELOW);
            lobes.smooth[lane] = smooth;
            lobes.delta_transmission[lane] = smooth | index_matched;
            lobes.strongest_f0[lane] =
                self.specular_f0[0][lane].max(self.specular_f0[1][lane]).max(self.specular_f0[2][lane]);

            let coat = coat * self.specular_f90[lane];
            specular |= u32::from(metal + glass + coat > 0.0);
            microfacets |= u32::from((metal + coat > 0.0) & !smooth);
            rough_glass |= u32::from((glass > 0.0) & !(smooth | index_matched));
            let pane = if self.thin[lane] { glass } else { 0.0 };
            tabulated |= u32::from((metal + coat + pane > 0.0) & !smooth);
            delta |= u32::from(smooth | index_matched);
        }
        for lane in 0..LANES {
            lobes.any_glass |= lobes.glass[lane] > 0.0;
        }
        lobes.any_specular = specular != 0;
        lobes.any_rough = microfacets | rough_glass != 0;
        lobes.any_delta = delta != 0;
        tabulated != 0
    }

    /// Sets what the table says of the direction `out`.
    #[inline(always)]
    fn set_albedos(&self, out: &Directions, needs_table: bool, lobes: &mut Lobes) {
        let (mut here, mut mean) = (Albedo::SMOOTH, Average::SMOOTH);
        if needs_table {
            let (table, rows) = (albedo::table(), albedo::rows(&self.alpha));
            here = table.albedo(&rows, &out[2], &self.alpha, &lobes.smooth);
            mean = table.average(&rows, &lobes.smooth);
            lobes.rows = Some(rows);
        }
        for lane in 0..LANES {
            let escape = mean.scale[lane];
            let repeated = |reflectance| if self.multiple_scattering { repeated(reflectance, escape) } else { 0.0 };
            lobes.missing_out[lane] = (1.0 - here.scale[lane]).max(0.0);
            lobes.gain_out[lane] = if self.multiple_scattering { here.gain[lane] } else { 1.0 };
            let (f0, f90) = (lobes.strongest_f0[lane], self.specular_f90[lane]);
            let again = repeated(mean_schlick(f0, f90));
            let albedo = here.of(lane, f0, f90, fresnel::schlick(out[2][lane])) + again * lobes.missing_out[lane];
            lobes.strongest_again[lane] = again;
            lobes.coat_albedo[lane] = albedo;
            lobes.coat_transmittance_out[lane] = (1.0 - albedo).max(0.0);
            lobes.coat_transmittance_mean[lane] = 1.0 - mean.of(lane, f0, f90) - again * (1.0 - escape);
            for c in 0..3 {
                let metal = mean_schlick(self.base_color[c][lane], self.metal_f90[c][lane]);
                lobes.metal_again[c][lane] = repeated(metal);
                lobes.coat_again[c][lane] = repeated(mean_schlick(self.specular_f0[c][lane], f90));
            }
        }
    }

    /// Sets the sampling probabilities, which are proportional to the approximate albedos of the lobes.
    #[inline(always)]
    fn set_probabilities(&self, out: &Directions, lobes: &mut Lobes) {
        for lane in 0..LANES {
            let schlick_weight = fresnel::schlick(out[2][lane]);
            let missing = lobes.missing_out[lane];
            let mut metal = 0.0;
            let mut diffuse = 0.0;
            for c in 0..3 {
                let once = fresnel::interpolate(self.base_color[c][lane], self.metal_f90[c][lane], schlick_weight);
                metal += once * (1.0 - missing) + lobes.metal_again[c][lane] * missing;
                diffuse += self.base_color[c][lane];
            }
            let metal = lobes.metal[lane] * (metal * (1.0 / 3.0)).max(MIN_METAL_REFLECTANCE);
            let glass = lobes.glass[lane];
            let coat = lobes.coat[lane] * lobes.coat_albedo[lane];
            let diffuse = lobes.coat[lane] * lobes.coat_transmittance_out[lane] * (diffuse * (1.0 / 3.0));
            // Divided, not multiplied by an inverse: a single lobe gets a probability of exactly 1.
            let sum = metal + glass + coat + diffuse;
            let some = sum > 0.0;
            let sum = if some { sum } else { 1.0 };
            lobes.pick_metal[lane] = metal / sum;
            lobes.pick_glass[lane] = glass / sum;
            lobes.pick_coat[lane] = coat / sum;
            let diffuse = diffuse / sum;
            lobes.pick_diffuse[lane] = if some { diffuse } else { 1.0 };
        }
    }
}
