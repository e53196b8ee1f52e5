//! The BSDF of [`holo_scene::Material`], for sixteen lanes at a time.
//!
//! Directions are unit vectors in the frame of the shading normal: z is the normal on the side of the viewer, `out`
//! points to the viewer (`out.z` > 0), `into` to the light. The BSDF is a mixture of three parts. Each part conserves
//! energy and is reciprocal (for transmission up to the factor eta^2):
//!
//! - **metal**, with the weight `metallic`: a GGX microfacet lobe ([`microfacet`]) with Schlick's Fresnel term, from
//!   the base color at normal incidence to `metal_f90` at grazing incidence. glTF specifies 1; the base color itself
//!   gives a mirror with the same color at all angles.
//! - **glass**, with the weight `transmission` of the rest: GGX microfacets with Fresnel's equations ([`fresnel`])
//!   between the two ends of KHR_materials_specular. The transmitted part is multiplied by the base color. It is
//!   refracted by `eta` (Walter et al., 2007), with the radiance divided by eta^2; in a thin pane it is scattered as
//!   the reflection is, to the other side. Interreflection between the two faces of a pane is not modeled, as specified
//!   by KHR_materials_transmission.
//! - **dielectric coat over diffuse**, with the remaining weight: a GGX microfacet lobe with Schlick's Fresnel term
//!   over Lambert's law (`specular` in glTF). With E the directional albedo of the coat ([`albedo`]) and `<E>` its
//!   cosine-weighted mean, the diffuse lobe is `base / pi (1 - E(out)) (1 - E(into)) / (1 - <E>)` (Kelemen and
//!   Szirmay-Kalos, 2001): it is reciprocal, and with a white base color the two lobes together have an albedo of
//!   exactly 1. Without specular reflection it is bitwise equal to Lambert's law.
//!
//! If the specular color is not gray, all channels of the layer below are multiplied by 1 - the strongest channel of
//! the reflectance, as in KHR_materials_specular: energy is conserved, and a red coat does not tint the diffuse lobe
//! cyan.
//!
//! Below an alpha (roughness squared) of 1e-3 a lobe is a delta lobe: perfect reflection or refraction.
//! [`Bsdf::evaluate_lobes`] excludes delta lobes; [`Bsdf::sample_lobes`] marks them.
//!
//! # Multiple scattering
//! Light that is scattered more than once between the microfacets widens and brightens the lobes
//! ([`multiple_scattering`]): white metal, coats over white and panes of clear glass have an albedo of 1 within 0.3 % at
//! every roughness and angle (verified by a test). Rough *bodies* of glass have no such lobe; clear glass loses, in per cent (also verified):
//!
//! ```text
//! per cent      cosine of the angle of view
//! roughness     0.02    0.1    0.3    0.6    0.9      1
//!  clear glass of index 1.5, seen from the air
//!       0.1      8.0    0.4    0.0    0.0    0.0    0.0
//!       0.3      4.0    7.8    2.1    0.4    0.1    0.1
//!       0.5      4.0    8.4    7.0    2.9    1.1    0.8
//!       0.7      7.1   14.5   14.4    8.5    4.0    3.1
//!       1.0     12.8   25.9   29.6   23.1   13.4   10.7
//!  the same, seen from inside
//!       0.1      8.8    0.6    0.1    0.0    0.0    0.0
//!       0.3      8.4   13.2    6.0    2.5    1.1    0.9
//!       0.5     14.9   18.9   20.2   15.7    8.6    7.1
//!       0.7     26.3   30.6   34.1   32.3   26.4   23.8
//!       1.0     43.9   48.9   50.2   48.6   55.4   58.3
//! ```

mod albedo;
mod evaluate;
#[cfg(test)]
mod exact;
pub(crate) mod fresnel;
pub(crate) mod layered;

mod lobes;
mod microfacet;
mod multiple_scattering;
mod sample;

pub(crate) use lobes::Lobes;

use crate::simd::LANES;

/// Sixteen directions, axis by axis.
pub(crate) type Directions = [[f32; LANES]; 3];

/// The BSDF parameters of sixteen lanes.
#[derive(Clone, Debug)]
pub(crate) struct Bsdf {
    /// Base color, linear RGB, 0 to 1.
    pub base_color: [[f32; LANES]; 3],
    /// Weight of metal, 0 to 1.
    pub metallic: [f32; LANES],
    /// Weight of glass in the rest, 0 to 1.
    pub transmission: [f32; LANES],
    /// Alpha of the GGX distribution, the square of the roughness; 0 is smooth.
    pub alpha: [f32; LANES],
    /// Reflectance of metal at grazing incidence, linear RGB; 1 in glTF.
    pub metal_f90: [[f32; LANES]; 3],
    /// Reflectance of coat and glass at normal incidence: min(((n - 1)/(n + 1))^2 * specular color, 1) * specular.
    pub specular_f0: [[f32; LANES]; 3],
    /// Reflectance of coat and glass at grazing incidence: `specular` of glTF. At least `specular_f0`.
    pub specular_f90: [f32; LANES],
    /// Index of refraction behind the surface relative to that on the side of the viewer, 1e-3 to 1e3; for a thin pane
    /// the index of its glass relative to air, from either side.
    pub eta: [f32; LANES],
    /// Whether glass is a thin pane without refraction.
    pub thin: [bool; LANES],
    /// Whether light is scattered more than once between microfacets.
    pub multiple_scattering: bool,
}

/// Sixteen sampled directions.
#[derive(Clone, Debug)]
pub(crate) struct Sampled {
    /// The direction to the light.
    pub into: Directions,
    /// The weight of the radiance from there: BSDF * |into.z| / pdf without the delta lobes; for a delta lobe
    /// reflectance / probability. 0 if the sample is invalid.
    pub weight: [[f32; LANES]; 3],
    /// The pdf per solid angle without the delta lobes; infinite for a delta lobe.
    pub pdf: [f32; LANES],
    /// Whether the direction is transmitted through the surface.
    pub transmitted: [bool; LANES],
}

/// The BSDF evaluated for sixteen given directions, without the delta lobes.
#[derive(Clone, Debug)]
pub(crate) struct Evaluated {
    /// BSDF * |into.z|.
    pub value: [[f32; LANES]; 3],
    /// The pdf with which [`Bsdf::sample_lobes`] samples the direction.
    pub pdf: [f32; LANES],
}

impl Bsdf {
    /// Lambert's law.
    #[inline(always)]
    pub fn lambertian(base_color: [[f32; LANES]; 3]) -> Self {
        Self {
            base_color,
            metallic: [0.0; LANES],
            transmission: [0.0; LANES],
            alpha: [1.0; LANES],
            metal_f90: [[1.0; LANES]; 3],
            specular_f0: [[0.0; LANES]; 3],
            specular_f90: [0.0; LANES],
            eta: [1.5; LANES],
            thin: [false; LANES],
            multiple_scattering: true,
        }
    }

    #[cfg(test)]
    fn evaluate(&self, out: &Directions, into: &Directions) -> Evaluated {
        self.evaluate_lobes(&self.lobes(out), out, into)
    }

    #[cfg(test)]
    fn sample(&self, out: &Directions, choice: &[f32; LANES], point: &crate::sampling::Points) -> Sampled {
        self.sample_lobes(&self.lobes(out), out, choice, point)
    }
}

#[cfg(test)]
mod tests;
