//! Evaluation of layered BSDFs.

use std::f32::consts::FRAC_1_PI;

use super::facet::Facet;
use super::{COAT_F0, LayeredView, Vector, sheen};
use crate::material::bsdf::albedo::Single;
use crate::material::bsdf::fresnel;

impl LayeredView {
    /// BSDF * |into.z| from `into` to the viewer, and the pdf with which [`Self::sample`] samples it; without the delta
    /// lobes.
    #[inline(never)]
    pub fn evaluate(&self, into: Vector) -> ([f32; 3], f32) {
        let mut value = [0.0; 3];
        let mut pdf = 0.0;
        self.add_diffuse(into, &mut value, &mut pdf);
        if !self.smooth && into[2] > 0.0 && self.metal + self.coat > 0.0 {
            self.add_reflection(into, &mut value, &mut pdf);
        }
        if !self.delta_glass && self.glass > 0.0 {
            self.add_glass(into, &mut value, &mut pdf);
        }
        if self.m.sheen.is_none() && self.m.clearcoat.is_none() {
            return (value, pdf);
        }
        let [under, below] = self.left(into);
        value = value.map(|x| x * under);
        if let Some(sheen) = self.m.sheen.filter(|_| into[2] > 0.0) {
            let fibers = below * sheen.value(self.out, into);
            (0..3).for_each(|c| value[c] += sheen.color[c] * fibers);
            pdf += self.pick.sheen * sheen::PDF;
        }
        self.add_clearcoat(into, &mut value, &mut pdf);
        (value, pdf)
    }

    /// Tables in the direction `into`.
    fn table_into(&self, into: Vector) -> Single {
        self.m.table(into)
    }

    fn add_diffuse(&self, into: Vector, value: &mut [f32; 3], pdf: &mut f32) {
        let z = into[2].abs();
        let m = &self.m;
        let above = into[2] > 0.0;
        if self.coat <= 0.0 || !above && m.diffuse_transmission <= 0.0 {
            // The diffuse lobe is sampled where nothing reflects.
            *pdf += if above { z * FRAC_1_PI * self.pick.diffuse } else { 0.0 };
            return;
        }
        let again = super::strongest(self.coat_again);
        let left = m.coat_left(&self.table_into(into), z, again);
        let coupling = if m.leaves_minimum() {
            self.coat_left_out.min(left)
        } else {
            self.coat_left_out * left / self.coat_left_mean
        };
        let lambert = z * FRAC_1_PI;
        let (color, share, pick) = if above {
            (m.base_color, 1.0 - m.diffuse_transmission, self.pick.diffuse)
        } else {
            (m.diffuse_transmission_color, m.diffuse_transmission, self.pick.through)
        };
        // Behind the surface of a body radiance is larger by eta^2.
        let spread = |c: usize| if above || m.thin { 1.0 } else { m.eta[c] * m.eta[c] };
        (0..3).for_each(|c| value[c] += color[c] * (lambert * (self.coat * share * coupling)) / spread(c));
        *pdf += lambert * pick;
    }

    fn add_reflection(&self, into: Vector, value: &mut [f32; 3], pdf: &mut f32) {
        let m = &self.m;
        let facet = Facet::new(self.out, into, m.alpha, 1.0, true);
        if facet.value <= 0.0 {
            return;
        }
        let again = m.gain(&self.here, &self.table_into(into)) - 1.0;
        let mut add = |weight: f32, fresnel: [f32; 3], repeated: &[f32; 3]| {
            for c in 0..3 {
                value[c] += weight * facet.value * (fresnel[c] + repeated[c] * again).max(0.0);
            }
        };
        if self.metal > 0.0 {
            add(self.metal, m.metal_fresnel(facet.cosine), &self.metal_again);
        }
        if self.coat > 0.0 {
            add(self.coat, m.coat_fresnel(facet.cosine), &self.coat_again);
        }
        *pdf += (self.pick.metal + self.pick.coat) * facet.pdf;
    }

    /// Glass; with dispersion every channel has its own microfacets and pdf.
    fn add_glass(&self, into: Vector, value: &mut [f32; 3], pdf: &mut f32) {
        let m = &self.m;
        let gain = if m.thin { m.gain(&self.here, &self.table_into(into)) } else { 1.0 };
        let behind = into[2] < 0.0;
        let mut add = |eta: f32, of: [bool; 3], share: f32| {
            let facet = Facet::new(self.out, into, m.alpha, eta, m.thin);
            if facet.value <= 0.0 {
                return;
            }
            let (reflected, strongest) = m.glass_fresnel(facet.cosine, facet.eta);
            let value_here = self.glass * facet.value * gain;
            for c in (0..3).filter(|&c| of[c]) {
                value[c] += value_here * if behind { m.base_color[c] * (1.0 - strongest) } else { reflected[c] };
            }
            *pdf += share * self.pick.glass * facet.pdf * if behind { 1.0 - strongest } else { strongest };
        };
        if !m.is_dispersive() {
            add(m.eta[1], [true; 3], 1.0);
            return;
        }
        let (active, count) = self.active();
        for c in (0..3).filter(|&c| active[c]) {
            add(m.eta[c], std::array::from_fn(|k| k == c), 1.0 / count);
        }
    }

    fn add_clearcoat(&self, into: Vector, value: &mut [f32; 3], pdf: &mut f32) {
        let Some(coat) = self.m.clearcoat.filter(|coat| !coat.is_smooth()) else { return };
        let (mut own_out, own_into) = (coat.to_own(self.out), coat.to_own(into));
        own_out[2] = own_out[2].max(super::MIN_COSINE);
        if own_into[2] <= 0.0 || into[2] <= 0.0 {
            return;
        }
        let facet = Facet::new(own_out, own_into, [coat.alpha; 2], 1.0, true);
        let [here, there] = [own_out, own_into].map(|v| Single::new(coat.alpha, v[2]));
        let again = if self.m.multiple_scattering { here.gain * there.gain - 1.0 } else { 0.0 };
        let once = fresnel::interpolate(COAT_F0, 1.0, fresnel::schlick(facet.cosine));
        let light = coat.factor * facet.value * (once + coat.again(here.mean_scale) * again).max(0.0);
        value.iter_mut().for_each(|value| *value += light);
        *pdf += self.pick.clearcoat * facet.pdf;
    }
}
