//! The BSDF of materials with layers and lobes that few materials have, for one lane at a time: a clearcoat, sheen, a
//! thin film, anisotropic roughness, dispersion and diffuse transmission.
//!
//! Without any of these it is the BSDF of [`super`] (verified by a test). It is scalar and is not compiled into the
//! kernels, so that materials without such lobes pay for none of it.
//!
//! - **Clearcoat** (KHR_materials_clearcoat): a GGX lobe of a dielectric of index 1.5 over everything else, with a
//!   normal of its own. **Sheen** ([`sheen`]) lies below it. With E the directional albedo of a layer times its weight,
//!   the light that reaches what is below, and returns from there, is multiplied by min(1 - E(out), 1 - E(into)), as
//!   KHR_materials_sheen specifies for sheen. KHR_materials_clearcoat has 1 - F(out) alone, which is not reciprocal.
//!   The minimum conserves energy whatever is below, exactly for a mirror; of white diffuse light it loses up to 5 %
//!   under a smooth clearcoat (the light that is reflected back to the surface is not modeled).
//! - **Iridescence** ([`film`]): the Fresnel term of metal, of the dielectric coat over diffuse and of glass is mixed
//!   with that of a thin film. What the coat leaves for the diffuse lobe is then the minimum, too.
//! - **Anisotropy** ([`facet`]): an alpha along the tangent and one across. The albedo W of its lobe is integrated
//!   where it is needed ([`facet::albedo`]). Light that is scattered more than once multiplies the lobe by 1 /
//!   max(W(out), W(into)) instead of the gains of [`super::multiple_scattering`]: it conserves energy and is
//!   reciprocal, but white metal loses up to 13 %, and may gain 2 % by the error of W (verified by a test). What the
//!   coat leaves for the diffuse lobe is the minimum, as under a film.
//! - **Dispersion**: an index of refraction for each channel. A path that is refracted by a smooth surface continues
//!   with one channel, chosen with equal probability among those that carry light; elsewhere all channels share their
//!   samples, whose pdf is the mean of the pdfs of the channels (balance heuristic). Unbiased.
//! - **Diffuse transmission** (KHR_materials_diffuse_transmission): a share of the diffuse lobe leaves on the other
//!   side, with a color of its own. Radiance behind the surface of a body is larger by eta^2; since both sides transmit
//!   the same share, the lobe conserves energy there, but is reciprocal for thin surfaces alone.
//!
//! # Energy
//! White surfaces under white layers gain nothing and lose at most 5 % (clearcoat), 14 % (sheen), 9 % (a film over a
//! diffuse surface; none over metal), at any roughness and angle; 0.8 % is the error of the test that verifies it.

mod evaluate;
mod facet;
pub(crate) mod film;
mod sample;
pub(crate) mod sheen;

use self::film::Film;
use self::sheen::Sheen;
use super::albedo::Single;
use super::fresnel;
use super::microfacet::{INDEX_MATCHED_BELOW, SMOOTH_BELOW};
use super::multiple_scattering::{mean_schlick, repeated};

pub(super) type Vector = [f32; 3];

/// The reflectance of the clearcoat at normal incidence: index 1.5.
const COAT_F0: f32 = 0.04;

/// The parameters of one lane; what [`super::Bsdf`] has too is described there.
#[derive(Clone, Debug)]
pub(crate) struct Layered {
    pub base_color: [f32; 3],
    pub metallic: f32,
    pub transmission: f32,
    /// Alpha along the x axis of the shading frame and along its y axis.
    pub alpha: [f32; 2],
    pub specular_f0: [f32; 3],
    pub specular_f90: f32,
    /// For each channel.
    pub eta: [f32; 3],
    /// The reflectance at normal incidence of the index that `specular_f0` is for; with dispersion that of glass is
    /// scaled to the index of a channel.
    pub usual_f0: f32,
    pub thin: bool,
    pub multiple_scattering: bool,
    /// Share of the diffuse lobe that is transmitted, and its color.
    pub diffuse_transmission: f32,
    pub diffuse_transmission_color: [f32; 3],
    pub film: Option<Film>,
    pub sheen: Option<Sheen>,
    pub clearcoat: Option<Clearcoat>,
    /// The channels that carry light; at least one.
    pub channels: [bool; 3],
}

/// A clearcoat.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clearcoat {
    /// Weight, 0 to 1.
    pub factor: f32,
    pub alpha: f32,
    /// The axes of its frame in the shading frame; the last one is its normal.
    pub axes: [[f32; 3]; 3],
}

impl Clearcoat {
    pub(crate) const ALIGNED: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

    fn to_own(self, v: Vector) -> Vector {
        self.axes.map(|axis| dot(axis, v))
    }

    fn to_shading(self, v: Vector) -> Vector {
        std::array::from_fn(|k| self.axes[0][k] * v[0] + self.axes[1][k] * v[1] + self.axes[2][k] * v[2])
    }

    fn is_smooth(&self) -> bool {
        self.alpha < SMOOTH_BELOW
    }

    /// The directional albedo times the weight.
    fn albedo(&self, cosine: f32, multiple_scattering: bool) -> f32 {
        let here = Single::new(self.alpha, cosine);
        let again = if multiple_scattering { self.again(here.mean_scale) } else { 0.0 };
        let once = here.of(COAT_F0, 1.0, fresnel::schlick(cosine));
        self.factor * (once + again * (1.0 - here.scale).max(0.0)).clamp(0.0, 1.0)
    }

    fn again(&self, escape: f32) -> f32 {
        repeated(mean_schlick(COAT_F0, 1.0), escape)
    }
}

/// The sampling probabilities of the lobes.
#[derive(Clone, Copy, Debug, Default)]
struct Pick {
    clearcoat: f32,
    sheen: f32,
    metal: f32,
    glass: f32,
    coat: f32,
    through: f32,
    diffuse: f32,
}

/// A layered BSDF with what depends on the direction to the viewer.
pub(crate) struct LayeredView {
    m: Layered,
    out: Vector,
    /// Weights of the mixture: metal, glass, and diffuse with dielectric coat.
    metal: f32,
    glass: f32,
    coat: f32,
    smooth: bool,
    delta_glass: bool,
    /// The tables in the direction of the viewer.
    here: Single,
    /// S of the light that is scattered more than once, by metal and by the dielectric coat.
    metal_again: [f32; 3],
    coat_again: [f32; 3],
    /// What the dielectric coat leaves in the direction of the viewer, and of its mean.
    coat_left_out: f32,
    coat_left_mean: f32,
    /// What clearcoat and sheen leave in the direction of the viewer.
    clearcoat_left: f32,
    sheen_left: f32,
    pick: Pick,
}

impl Layered {
    fn strongest_f0(&self) -> f32 {
        strongest(self.specular_f0)
    }

    fn is_dispersive(&self) -> bool {
        self.eta[0] != self.eta[1] || self.eta[2] != self.eta[1]
    }

    fn is_smooth(&self) -> bool {
        self.alpha[0].max(self.alpha[1]) < SMOOTH_BELOW
    }

    fn is_anisotropic(&self) -> bool {
        self.alpha[0] != self.alpha[1]
    }

    /// The albedos of the lobe in a direction, and their means; those of an anisotropic one are of the mean alpha.
    fn table(&self, v: Vector) -> Single {
        if self.is_smooth() {
            return Single::SMOOTH;
        }
        let isotropic = Single::new(0.5 * (self.alpha[0] + self.alpha[1]), v[2].abs());
        if !self.is_anisotropic() {
            return isotropic;
        }
        let [scale, bias] = facet::albedo([v[0], v[1], v[2].abs()], self.alpha);
        Single { scale, bias, ..isotropic }
    }

    /// The factor of the lobe by light that is scattered more than once between microfacets of a reflectance of 1.
    fn gain(&self, out: &Single, into: &Single) -> f32 {
        match (self.multiple_scattering, self.is_anisotropic()) {
            (false, _) => 1.0,
            (true, false) => out.gain * into.gain,
            (true, true) => 1.0 / out.scale.max(into.scale).max(1e-3),
        }
    }

    /// Whether the coat leaves the minimum of two directions, instead of the coupling of [`super`].
    fn leaves_minimum(&self) -> bool {
        self.film.is_some() || self.is_anisotropic()
    }

    /// The reflectance of microfacets of metal.
    fn metal_fresnel(&self, cosine: f32) -> [f32; 3] {
        let weight = fresnel::schlick(cosine);
        let plain = self.base_color.map(|f0| fresnel::interpolate(f0, 1.0, weight));
        self.filmed(plain, cosine, self.base_color, 1.0)
    }

    /// The reflectance of microfacets of the dielectric coat.
    fn coat_fresnel(&self, cosine: f32) -> [f32; 3] {
        let weight = fresnel::schlick(cosine);
        let plain = self.specular_f0.map(|f0| fresnel::interpolate(f0, self.specular_f90, weight));
        self.filmed(plain, cosine, self.specular_f0, self.specular_f90)
    }

    /// The reflectance of microfacets of glass at `cosine`, whose indices of refraction are relative to that side, and
    /// that of the strongest channel, by which nothing is transmitted. For refraction the cosine is that of the side
    /// with the lower index.
    fn glass_fresnel(&self, cosine: f32, eta: f32) -> ([f32; 3], f32) {
        let interface = fresnel::interface(cosine, eta);
        if interface.total {
            return ([1.0; 3], 1.0);
        }
        let weight = fresnel::grazing_weight(interface.reflected, eta);
        // By the index of the channel for all channels, so that the strongest is that of the specular color.
        let scale = if self.is_dispersive() { fresnel::normal_incidence(eta) / self.usual_f0.max(1e-12) } else { 1.0 };
        let specular_f0 =
            self.specular_f0.map(|f0| if scale == 1.0 { f0 } else { (f0 * scale).min(self.specular_f90) });
        let plain = specular_f0.map(|f0| fresnel::interpolate(f0, self.specular_f90, weight));
        // The film is seen under the same angle from either side.
        let in_air = if eta < 1.0 { interface.scaled_cosine / eta } else { cosine };
        let reflected = self.filmed(plain, in_air, specular_f0, self.specular_f90);
        (reflected, strongest(reflected))
    }

    fn filmed(&self, plain: [f32; 3], cosine: f32, f0: [f32; 3], f90: f32) -> [f32; 3] {
        let Some(film) = &self.film else { return plain };
        if f90 <= 0.0 {
            return plain;
        }
        let seen = film.reflectance(cosine, f0.map(|f0| f0 / f90));
        std::array::from_fn(|c| plain[c] + (seen[c] * f90 - plain[c]) * film.factor)
    }

    /// The cosine-weighted mean of a reflectance over the hemisphere: Schlick's in closed form, that of a film from
    /// four nodes.
    fn mean(&self, f0: [f32; 3], f90: f32, of: impl Fn(f32) -> [f32; 3]) -> [f32; 3] {
        if self.film.is_none() {
            return f0.map(|f0| mean_schlick(f0, f90));
        }
        let mut sum = [0.0; 3];
        for k in 0..4 {
            let reflected = of(((k as f32 + 0.5) / 4.0).sqrt());
            (0..3).for_each(|c| sum[c] += 0.25 * reflected[c]);
        }
        sum
    }

    /// What the dielectric coat leaves for the diffuse lobe in a direction.
    fn coat_left(&self, table: &Single, cosine: f32, strongest_again: f32) -> f32 {
        let (f0, f90) = (self.strongest_f0(), self.specular_f90);
        let once = if self.film.is_some() {
            table.scale * strongest(self.coat_fresnel(cosine)) + (f90 - f0) * table.bias
        } else {
            table.of(f0, f90, fresnel::schlick(cosine))
        };
        (1.0 - once - strongest_again * (1.0 - table.scale).max(0.0)).max(0.0)
    }
}

impl LayeredView {
    /// Prepares a BSDF for the direction `out` to the viewer.
    #[inline(never)]
    pub fn new(m: Layered, out: Vector) -> Self {
        let rest = 1.0 - m.metallic;
        let (metal, glass, coat) = (m.metallic, rest * m.transmission, rest * (1.0 - m.transmission));
        let smooth = m.is_smooth();
        let matched = !m.thin && m.eta.iter().any(|eta| (eta - 1.0).abs() < INDEX_MATCHED_BELOW);
        let here = m.table(out);
        let escape = here.mean_scale;
        let repeat = |mean: [f32; 3]| {
            if m.multiple_scattering && !smooth { mean.map(|f| repeated(f, escape)) } else { [0.0; 3] }
        };
        let metal_again = repeat(m.mean(m.base_color, 1.0, |z| m.metal_fresnel(z)));
        let coat_again = repeat(m.mean(m.specular_f0, m.specular_f90, |z| m.coat_fresnel(z)));
        let again = strongest(coat_again);
        let coat_left_out = m.coat_left(&here, out[2], again);
        let (f0, f90) = (m.strongest_f0(), m.specular_f90);
        let mean = (escape * f0 + (f90 - f0) * here.mean_grazing).clamp(0.0, 1.0);
        let coat_left_mean = (1.0 - mean - again * (1.0 - escape)).max(1e-7);
        let clearcoat_left = m
            .clearcoat
            .map_or(1.0, |coat| 1.0 - coat.albedo(coat.to_own(out)[2].max(MIN_COSINE), m.multiple_scattering));
        let sheen_left = m.sheen.map_or(1.0, |sheen| 1.0 - strongest(sheen.color) * sheen.albedo(out[2]));
        let mut view = Self {
            m,
            out,
            metal,
            glass,
            coat,
            smooth,
            delta_glass: smooth || matched,
            here,
            metal_again,
            coat_again,
            coat_left_out,
            coat_left_mean,
            clearcoat_left,
            sheen_left,
            pick: Pick::default(),
        };
        view.set_probabilities();
        view
    }

    /// Sets the sampling probabilities, which are proportional to the approximate albedos of the lobes.
    fn set_probabilities(&mut self) {
        let m = &self.m;
        let mean = |x: [f32; 3]| (x[0] + x[1] + x[2]) * (1.0 / 3.0);
        let missing = (1.0 - self.here.scale).max(0.0);
        let once = m.metal_fresnel(self.out[2]);
        let metal: [f32; 3] = std::array::from_fn(|c| once[c] * (1.0 - missing) + self.metal_again[c] * missing);
        let below = self.clearcoat_left;
        let under = below * self.sheen_left;
        let diffuse = under * self.coat * self.coat_left_out;
        let mut pick = Pick {
            clearcoat: 1.0 - below,
            sheen: m.sheen.map_or(0.0, |sheen| below * mean(sheen.color) * sheen.albedo(self.out[2])),
            metal: under * self.metal * mean(metal).max(MIN_METAL_REFLECTANCE),
            glass: under * self.glass,
            coat: under * self.coat * (1.0 - self.coat_left_out),
            through: diffuse * m.diffuse_transmission * mean(m.diffuse_transmission_color),
            diffuse: diffuse * (1.0 - m.diffuse_transmission) * mean(m.base_color),
        };
        let parts = [
            &mut pick.clearcoat,
            &mut pick.sheen,
            &mut pick.metal,
            &mut pick.glass,
            &mut pick.coat,
            &mut pick.through,
            &mut pick.diffuse,
        ];
        let sum: f32 = parts.iter().map(|part| **part).sum();
        if sum > 0.0 {
            parts.into_iter().for_each(|part| *part /= sum);
        } else {
            pick = Pick { diffuse: 1.0, ..Pick::default() };
        }
        self.pick = pick;
    }

    /// What clearcoat and sheen leave of light from `into` that reaches the lobes below them, and what the clearcoat
    /// leaves of the light of the sheen.
    fn left(&self, into: Vector) -> [f32; 2] {
        let clearcoat = self.m.clearcoat.map_or(1.0, |coat| {
            let z = coat.to_own(into)[2].abs().max(MIN_COSINE);
            self.clearcoat_left.min(1.0 - coat.albedo(z, self.m.multiple_scattering))
        });
        let sheen = self
            .m
            .sheen
            .map_or(1.0, |sheen| self.sheen_left.min(1.0 - strongest(sheen.color) * sheen.albedo(into[2].abs())));
        [clearcoat * sheen, clearcoat]
    }

    /// The number of channels that share samples of glass, and whether a channel is one of them.
    fn active(&self) -> ([bool; 3], f32) {
        let channels = if self.m.channels == [false; 3] { [true; 3] } else { self.m.channels };
        (channels, channels.iter().filter(|&&active| active).count() as f32)
    }
}

/// As for metal in [`super::lobes`].
const MIN_METAL_REFLECTANCE: f32 = 0.05;

/// Cosines with the normal of the clearcoat are clamped to this minimum.
const MIN_COSINE: f32 = 1e-3;

fn strongest([r, g, b]: [f32; 3]) -> f32 {
    r.max(g).max(b)
}

fn dot(a: Vector, b: Vector) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: Vector) -> Vector {
    let inverse = 1.0 / dot(v, v).max(1e-30).sqrt();
    v.map(|x| x * inverse)
}

#[cfg(test)]
mod tests;
