//! Sampling of the BSDF.

use super::lobes::Lobes;
use super::{Bsdf, Directions, Sampled, fresnel, microfacet};
use crate::sampling::{self, Points};
use crate::simd::LANES;

/// Directions with a smaller pdf count as not sampled.
const MIN_PDF: f32 = 1e-30;

/// The selected lobes.
struct Picked {
    glass: [bool; LANES],
    diffuse: [bool; LANES],
    /// Whether the selected lobe is a delta lobe.
    delta: [bool; LANES],
    /// The rescaled random number for the choice between reflection and transmission of glass.
    choice: [f32; LANES],
}

impl Bsdf {
    /// Samples the direction to the light for `out`, whose lobes are `lobes`: `choice` selects the lobe, `point` the
    /// direction; all in [0, 1).
    #[inline(always)]
    pub fn sample_lobes(&self, lobes: &Lobes, out: &Directions, choice: &[f32; LANES], point: &Points) -> Sampled {
        let mut sampled = Sampled {
            into: sampling::cosine_hemisphere(point),
            weight: [[0.0; LANES]; 3],
            pdf: [f32::INFINITY; LANES],
            transmitted: [false; LANES],
        };
        let mut valid = [true; LANES];
        let mut delta = [false; LANES];
        if lobes.any_specular {
            let picked = pick(lobes, choice);
            valid = self.sample_specular(lobes, &picked, out, &mut sampled);
            delta = picked.delta;
        }
        let terms = self.terms(lobes, out, &sampled.into);
        for lane in 0..LANES {
            let (pdf, is_delta) = (terms.pdf[lane], delta[lane]);
            let drawn = valid[lane] & (is_delta | (pdf > MIN_PDF));
            // Divided: a purely Lambertian lane gets exactly its base color.
            let (tinted, inverse) = (terms.tinted[lane] / pdf, 1.0 / pdf);
            for c in 0..3 {
                let weight = self.base_color[c][lane] * tinted + terms.plain[c][lane] * inverse;
                let weight = if is_delta { sampled.weight[c][lane] } else { weight };
                sampled.weight[c][lane] = if drawn { weight } else { 0.0 };
            }
            sampled.pdf[lane] = if is_delta { f32::INFINITY } else { pdf };
            sampled.transmitted[lane] &= valid[lane];
        }
        sampled
    }

    /// Replaces the diffuse directions of `sampled` where another lobe was selected, and sets the weights of delta
    /// lobes. Returns whether the direction is valid.
    #[inline(always)]
    fn sample_specular(
        &self,
        lobes: &Lobes,
        picked: &Picked,
        out: &Directions,
        sampled: &mut Sampled,
    ) -> [bool; LANES] {
        let mut normal = [[0.0; LANES], [0.0; LANES], [1.0; LANES]];
        if lobes.any_rough {
            normal = microfacet::visible_normals(out, &self.alpha, &picked.delta, &sampled.into);
        }
        let mut cosine = [0.0; LANES];
        for lane in 0..LANES {
            cosine[lane] =
                out[0][lane] * normal[0][lane] + out[1][lane] * normal[1][lane] + out[2][lane] * normal[2][lane];
        }
        let mut mirrored = [[0.0; LANES]; 3];
        for axis in 0..3 {
            for lane in 0..LANES {
                mirrored[axis][lane] = 2.0 * cosine[lane] * normal[axis][lane] - out[axis][lane];
            }
        }
        let mut strongest = [0.0; LANES];
        let mut reflected = [[0.0; LANES]; 3];
        let mut refracted = mirrored;
        if lobes.any_glass {
            let glass = self.glass(lobes, &cosine, &self.eta);
            refracted = fresnel::refract(out, &normal, &cosine, &glass.scaled_cosine);
            strongest = glass.strongest;
            reflected = glass.reflected;
        }
        let mut valid = [true; LANES];
        let mut through = [false; LANES];
        for lane in 0..LANES {
            let (above, bent) = (mirrored[2][lane] > 0.0, refracted[2][lane] < 0.0);
            let passes = picked.glass[lane] & (picked.choice[lane] >= strongest[lane]);
            let reached = if passes & !self.thin[lane] { bent } else { above };
            valid[lane] = picked.diffuse[lane] | (reached & (cosine[lane] > 0.0));
            through[lane] = passes;
        }
        for axis in 0..3 {
            // A thin pane transmits as it reflects, to the other side.
            let sign = if axis == 2 { -1.0 } else { 1.0 };
            for lane in 0..LANES {
                let (here, there) = (mirrored[axis][lane], refracted[axis][lane]);
                let passed = if self.thin[lane] { sign * here } else { there };
                let specular = if through[lane] { passed } else { here };
                let diffuse = sampled.into[axis][lane];
                sampled.into[axis][lane] = if picked.diffuse[lane] { diffuse } else { specular };
            }
        }
        if lobes.any_delta {
            self.weigh_delta_lobes(lobes, &cosine, &strongest, &reflected, &through, &mut sampled.weight);
        }
        sampled.transmitted = through;
        valid
    }

    /// The weights of delta lobes, reflected or transmitted. All delta lobes with the same direction contribute,
    /// whichever was selected.
    #[inline(always)]
    fn weigh_delta_lobes(
        &self,
        lobes: &Lobes,
        cosine: &[f32; LANES],
        strongest: &[f32; LANES],
        reflected: &[[f32; LANES]; 3],
        through: &[bool; LANES],
        weight: &mut [[f32; LANES]; 3],
    ) {
        let zero = [0.0; LANES];
        let (mut metal, mut coat, mut glass, mut window, mut schlick_weight) = (zero, zero, zero, zero, zero);
        for lane in 0..LANES {
            let smooth = if lobes.smooth[lane] { 1.0 } else { 0.0 };
            let delta_transmission = if lobes.delta_transmission[lane] { 1.0 } else { 0.0 };
            let (reflects, passes) = (strongest[lane], 1.0 - strongest[lane]);
            let pick = smooth * (lobes.pick_metal[lane] + lobes.pick_coat[lane]);
            let pick = (pick + delta_transmission * lobes.pick_glass[lane] * reflects).max(MIN_PDF);
            let inverse = 1.0 / pick;
            metal[lane] = smooth * lobes.metal[lane] * inverse;
            coat[lane] = smooth * lobes.coat[lane] * inverse;
            glass[lane] = delta_transmission * lobes.glass[lane] * inverse;
            let pick = (lobes.pick_glass[lane] * passes).max(MIN_PDF);
            let square = self.eta[lane] * self.eta[lane];
            let spread = if self.thin[lane] { 1.0 } else { square };
            window[lane] = lobes.glass[lane] * passes / (pick * spread);
            schlick_weight[lane] = fresnel::schlick(cosine[lane]);
        }
        for c in 0..3 {
            for lane in 0..LANES {
                let base = self.base_color[c][lane];
                let conductor = fresnel::interpolate(base, self.metal_f90[c][lane], schlick_weight[lane]);
                let dielectric =
                    fresnel::interpolate(self.specular_f0[c][lane], self.specular_f90[lane], schlick_weight[lane]);
                let mirror = metal[lane] * conductor + coat[lane] * dielectric + glass[lane] * reflected[c][lane];
                weight[c][lane] = if through[lane] { base * window[lane] } else { mirror };
            }
        }
    }
}

#[inline(always)]
fn pick(lobes: &Lobes, choice: &[f32; LANES]) -> Picked {
    let mut picked =
        Picked { glass: [false; LANES], diffuse: [false; LANES], delta: [false; LANES], choice: [0.0; LANES] };
    for lane in 0..LANES {
        let metal = lobes.pick_metal[lane];
        let glass = metal + lobes.pick_glass[lane];
        let coat = glass + lobes.pick_coat[lane];
        let is_glass = (choice[lane] >= metal) & (choice[lane] < glass);
        picked.glass[lane] = is_glass;
        picked.diffuse[lane] = choice[lane] >= coat;
        let delta = if is_glass { lobes.delta_transmission[lane] } else { lobes.smooth[lane] };
        picked.delta[lane] = delta & (choice[lane] < coat);
        picked.choice[lane] = (choice[lane] - metal) / lobes.pick_glass[lane].max(1e-30);
    }
    picked
}
