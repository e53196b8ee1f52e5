//! Drawing directions from the mixture.

use super::lobes::Lobes;
use super::{Bsdf, Directions, Sampled, fresnel, microfacet};
use crate::sampling::{self, Points};
use crate::simd::LANES;

/// Densities below this say that the direction was never drawn.
const LEAST_DENSITY: f32 = 1e-30;

/// What was picked, lane by lane.
struct Picked {
    glass: [bool; LANES],
    diffuse: [bool; LANES],
    /// It has a single direction: nothing is left to the facets.
    single: [bool; LANES],
    /// The choice between reflection and transmission of glass that is left in the number.
    choice: [f32; LANES],
}

impl Bsdf {
    /// Draws where the light comes from: `choice` picks the part, `point` the direction; all in [0, 1).
    #[inline(always)]
    pub fn sample(&self, out: &Directions, choice: &[f32; LANES], point: &Points) -> Sampled {
        let lobes = self.lobes(out);
        let mut sampled = Sampled {
            into: sampling::cosine_hemisphere(point),
            weight: [[0.0; LANES]; 3],
            pdf: [f32::INFINITY; LANES],
            transmitted: [false; LANES],
        };
        let mut valid = [true; LANES];
        let mut single = [false; LANES];
        if lobes.any_specular {
            let picked = pick(&lobes, choice);
            valid = self.sample_specular(&lobes, &picked, out, &mut sampled);
            single = picked.single;
        }
        let terms = self.terms(&lobes, out, &sampled.into);
        for lane in 0..LANES {
            let (pdf, one_way) = (terms.pdf[lane], single[lane]);
            let drawn = valid[lane] & (one_way | (pdf > LEAST_DENSITY));
            // Divided: Lambert's law alone gives exactly 1.
            let (tinted, inverse) = (terms.tinted[lane] / pdf, 1.0 / pdf);
            for c in 0..3 {
                let weight = self.base_color[c][lane] * tinted + terms.plain[c][lane] * inverse;
                let weight = if one_way { sampled.weight[c][lane] } else { weight };
                sampled.weight[c][lane] = if drawn { weight } else { 0.0 };
            }
            sampled.pdf[lane] = if one_way { f32::INFINITY } else { pdf };
            sampled.transmitted[lane] &= valid[lane];
        }
        sampled
    }

    /// Replaces the diffuse directions in `sampled` where something else was picked, and sets the weights where that has
    /// a single direction. Returns whether a direction was found.
    #[inline(always)]
    fn sample_specular(
        &self,
        lobes: &Lobes,
        picked: &Picked,
        out: &Directions,
        sampled: &mut Sampled,
    ) -> [bool; LANES] {
        let mut normal = [[0.0; LANES], [0.0; LANES], [1.0; LANES]];
        if lobes.any_facets {
            normal = microfacet::visible_normals(out, &self.width, &picked.single, &sampled.into);
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
            // A pane scatters to the other side as it does to this.
            let sign = if axis == 2 { -1.0 } else { 1.0 };
            for lane in 0..LANES {
                let (here, there) = (mirrored[axis][lane], refracted[axis][lane]);
                let passed = if self.thin[lane] { sign * here } else { there };
                let specular = if through[lane] { passed } else { here };
                let diffuse = sampled.into[axis][lane];
                sampled.into[axis][lane] = if picked.diffuse[lane] { diffuse } else { specular };
            }
        }
        if lobes.any_single {
            self.weigh_singles(lobes, &cosine, &strongest, &reflected, &through, &mut sampled.weight);
        }
        sampled.transmitted = through;
        valid
    }

    /// The weights of single directions, mirrored or let through; of use where one was picked. All parts that have the
    /// direction count, whichever of them it was.
    #[inline(always)]
    fn weigh_singles(
        &self,
        lobes: &Lobes,
        cosine: &[f32; LANES],
        strongest: &[f32; LANES],
        reflected: &[[f32; LANES]; 3],
        through: &[bool; LANES],
        weight: &mut [[f32; LANES]; 3],
    ) {
        let zero = [0.0; LANES];
        let (mut metal, mut varnish, mut glass, mut window, mut way) = (zero, zero, zero, zero, zero);
        for lane in 0..LANES {
            let smooth = if lobes.smooth[lane] { 1.0 } else { 0.0 };
            let clear = if lobes.clear[lane] { 1.0 } else { 0.0 };
            let (reflects, passes) = (strongest[lane], 1.0 - strongest[lane]);
            let pick = smooth * (lobes.pick_metal[lane] + lobes.pick_varnish[lane]);
            let pick = (pick + clear * lobes.pick_glass[lane] * reflects).max(LEAST_DENSITY);
            let inverse = 1.0 / pick;
            metal[lane] = smooth * lobes.metal[lane] * inverse;
            varnish[lane] = smooth * lobes.varnish[lane] * inverse;
            glass[lane] = clear * lobes.glass[lane] * inverse;
            let pick = (lobes.pick_glass[lane] * passes).max(LEAST_DENSITY);
            let square = self.eta[lane] * self.eta[lane];
            let spread = if self.thin[lane] { 1.0 } else { square };
            window[lane] = lobes.glass[lane] * passes / (pick * spread);
            way[lane] = fresnel::schlick(cosine[lane]);
        }
        for c in 0..3 {
            for lane in 0..LANES {
                let base = self.base_color[c][lane];
                let conductor = fresnel::between(base, self.metal_f90[c][lane], way[lane]);
                let coat = fresnel::between(self.specular_f0[c][lane], self.specular_f90[lane], way[lane]);
                let mirror = metal[lane] * conductor + varnish[lane] * coat + glass[lane] * reflected[c][lane];
                weight[c][lane] = if through[lane] { base * window[lane] } else { mirror };
            }
        }
    }
}

#[inline(always)]
fn pick(lobes: &Lobes, choice: &[f32; LANES]) -> Picked {
    let mut picked =
        Picked { glass: [false; LANES], diffuse: [false; LANES], single: [false; LANES], choice: [0.0; LANES] };
    for lane in 0..LANES {
        let metal = lobes.pick_metal[lane];
        let glass = metal + lobes.pick_glass[lane];
        let varnish = glass + lobes.pick_varnish[lane];
        let is_glass = (choice[lane] >= metal) & (choice[lane] < glass);
        picked.glass[lane] = is_glass;
        picked.diffuse[lane] = choice[lane] >= varnish;
        let single = if is_glass { lobes.clear[lane] } else { lobes.smooth[lane] };
        picked.single[lane] = single & (choice[lane] < varnish);
        picked.choice[lane] = (choice[lane] - metal) / lobes.pick_glass[lane].max(1e-30);
    }
    picked
}
