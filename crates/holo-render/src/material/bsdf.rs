//! What a surface does with light that reaches it: the materials of [`holo_scene::Material`], sixteen at a time.
//!
//! Directions are unit vectors in the frame of the shading normal: z is the normal on the viewer's side, `out` points
//! back to the viewer (`out.z` > 0), `into` to where the light comes from. A surface is a mixture of three, each of
//! which gives back no more than it gets and (but for glass seen from two sides, where n^2 comes in) the same in both
//! directions:
//!
//! - **metal**, share `metallic`: GGX facets ([`microfacet`]) with Schlick's reflectance, from the base colour at normal
//!   to `metal_f90` at grazing incidence. 1 is what glTF says; the base colour itself makes a mirror that is alike at
//!   all angles.
//! - **glass**, share `transmission` of the rest: the same facets with the reflectance of Fresnel's equations
//!   ([`fresnel`]) between the two ends that KHR_materials_specular gives. What is not reflected is let through and
//!   multiplied by the base colour: bent by `eta` (Walter et al., 2007), or, in a thin pane, scattered as the reflection
//!   is, only to the other side. Radiance is divided by eta^2 where rays are bent. Reflections to and fro between the
//!   two faces of a pane are not modelled: it reflects as one face does, as KHR_materials_transmission says.
//! - **varnished diffuser**, what remains: GGX facets with Schlick's reflectance over Lambert's law. With E the albedo of
//!   the facets ([`albedo`]) and `<E>` its mean weighted by the cosine, the diffuser is
//!   `base / pi (1 - E(out)) (1 - E(into)) / (1 - <E>)` (Kelemen and Szirmay-Kalos, 2001): reciprocal, and together with
//!   the facets exactly as bright as the base colour allows. Without specular reflection it is Lambert's to the bit.
//!
//! Where the specular colour is not grey, what lies below the reflection gets 1 - the strongest channel, in all three
//! (KHR_materials_specular does so too): nothing is gained, and a red varnish does not make the diffuser cyan.
//!
//! A width (the square of the roughness) below 1e-3 is perfectly smooth: reflection and refraction have one direction
//! each. [`Bsdf::evaluate`] knows nothing of these; [`Bsdf::sample`] marks them.
//!
//! # What is lost
//! Light that facets throw at one another is lost, as in Cycles' GGX and Mitsuba's rough conductor and dielectric (which
//! lose more: their facets shadow and mask independently). White metal and clear glass lose these shares (a test holds
//! the numbers):
//!
//! ```text
//! per cent      cosine of the angle of view
//! roughness     0.02    0.1    0.3    0.6    0.9      1
//!  white metal; panes of clear glass
//!       0.1      8.7    0.6    0.1    0.0    0.0    0.0
//!       0.3      4.7   11.6    5.4    1.9    1.1    0.9
//!       0.5      3.2   10.8   16.2   12.8    9.3    8.4
//!       0.7      4.4   13.8   25.1   30.5   30.7   30.2
//!       1.0      7.9   24.0   44.0   58.9   67.2   69.3
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
//!
//! # Speed
//! Sixteen lanes on one core of an AMD EPYC with AVX-512, `sample` / `evaluate`, ns: Lambert 60 / 20, mirror 110 / 30,
//! rough metal 170 / 60, smooth glass 140 / 30, rough glass 230 / 95, smooth varnish 120 / 30, rough varnish 310 / 190,
//! random mixtures 370 / 220.

mod albedo;
mod evaluate;
#[cfg(test)]
mod exact;
pub(crate) mod fresnel;
mod lobes;
mod microfacet;
mod sample;

use crate::simd::LANES;

/// Sixteen directions, axis by axis.
pub(crate) type Directions = [[f32; LANES]; 3];

/// Sixteen surfaces.
#[derive(Clone, Debug)]
pub(crate) struct Bsdf {
    /// Linear RGB, 0 to 1.
    pub base_color: [[f32; LANES]; 3],
    /// Share of metal, 0 to 1.
    pub metallic: [f32; LANES],
    /// Share of glass in what is no metal, 0 to 1.
    pub transmission: [f32; LANES],
    /// Width of the GGX distribution (its alpha), the square of the roughness; 0: smooth.
    pub width: [f32; LANES],
    /// What metal reflects at grazing incidence, linear RGB; 1 in glTF.
    pub metal_f90: [[f32; LANES]; 3],
    /// What varnish and glass reflect at normal incidence: min(((n - 1)/(n + 1))^2 * specular colour, 1) * specular.
    pub specular_f0: [[f32; LANES]; 3],
    /// What varnish and glass reflect at grazing incidence: specular. No less than `specular_f0`.
    pub specular_f90: [f32; LANES],
    /// Index of refraction behind the surface over that on the viewer's side, 1e-3 to 1e3; for a pane that of its glass
    /// over that of the air, from either side.
    pub eta: [f32; LANES],
    /// Glass is a pane that bends no ray.
    pub thin: [bool; LANES],
}

/// Sixteen directions drawn.
#[derive(Clone, Debug)]
pub(crate) struct Sampled {
    /// Where the light comes from.
    pub into: Directions,
    /// What the radiance from there is multiplied by: f |into.z| / pdf of the whole mixture, but for the parts with a
    /// single direction; of those, if one was drawn, reflectance over probability. 0 where no direction was found.
    pub weight: [[f32; LANES]; 3],
    /// Per solid angle, of everything but the parts with a single direction; infinite if one of those was drawn.
    pub pdf: [f32; LANES],
    /// The light comes through the surface.
    pub transmitted: [bool; LANES],
}

/// The mixture towards sixteen given directions, without the parts that have a single direction.
#[derive(Clone, Debug)]
pub(crate) struct Evaluated {
    /// f |into.z|.
    pub value: [[f32; LANES]; 3],
    /// The density with which [`Bsdf::sample`] draws the direction.
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
            width: [1.0; LANES],
            metal_f90: [[1.0; LANES]; 3],
            specular_f0: [[0.0; LANES]; 3],
            specular_f90: [0.0; LANES],
            eta: [1.5; LANES],
            thin: [false; LANES],
        }
    }
}

#[cfg(test)]
mod tests;
