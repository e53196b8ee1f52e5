//! The automatic choice of the integrator: the cheapest one that is exact for the scene, given one choice of the
//! caller.
//!
//! The choice is whether indirect illumination is included ([`crate::Request::indirect`]). With it, any scene with
//! light needs [`super::path`]. Without it, a scene of Lambertian surfaces needs only [`super::direct`]; metal, glass
//! and dielectric coats need paths that continue from them and end at the first diffuse surface. A scene without light
//! sources gets ground truth only ([`super::depth`]).
//!
//! Features that a scene does not use cost nothing: the integrators evaluate textures, glossy lobes, transmission,
//! emission, alpha and the environment only for packets that need them.

use super::Integrator;

/// The properties of a scene that determine the integrator.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Contents {
    pub punctual_lights: usize,
    pub discs: usize,
    pub emitters: bool,
    /// A constant environment that is not black.
    pub sky: bool,
    /// An environment map that is not black.
    pub environment: bool,
    /// Any material with metal, transmission or a specular coat.
    pub glossy: bool,
    /// Any unlit material.
    pub unlit: bool,
    /// Only unlit materials.
    pub all_unlit: bool,
}

impl Contents {
    fn has_light(&self) -> bool {
        self.punctual_lights + self.discs > 0 || self.emitters || self.sky || self.environment || self.unlit
    }

    /// The light sources in words.
    fn lights(&self) -> String {
        let count = |n: usize, one: &str| match n {
            0 => None,
            1 => Some(format!("1 {one}")),
            n => Some(format!("{n} {one}s")),
        };
        let some = |has: bool, what: &str| has.then(|| what.to_owned());
        let list = [
            count(self.punctual_lights, "punctual light"),
            count(self.discs, "sun"),
            some(self.emitters, "emissive surfaces"),
            some(self.sky, "a constant sky"),
            some(self.environment, "an environment map"),
            some(self.unlit, "unlit surfaces"),
        ];
        list.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

/// The integrator for a scene, and the reason.
pub(crate) fn choose(contents: &Contents, indirect: bool) -> (Integrator, String) {
    let lights = contents.lights();
    let surfaces = if contents.glossy { "metal, glass or dielectric coats" } else { "Lambertian surfaces" };
    if !contents.has_light() {
        (Integrator::Depth, "the scene has no light sources".into())
    } else if contents.all_unlit {
        (Integrator::Direct, "all surfaces are unlit: they show their own color".into())
    } else if indirect {
        (Integrator::Path, format!("{surfaces}, {lights}, light between surfaces"))
    } else if contents.glossy {
        (Integrator::Path, format!("{surfaces}, {lights}; no light between matt surfaces"))
    } else {
        (Integrator::Direct, format!("{surfaces}, {lights}; no light between surfaces"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_exact_integrator_is_chosen() {
        let lit = Contents { punctual_lights: 2, sky: true, ..Contents::default() };
        let glossy = Contents { glossy: true, ..lit };
        let unlit = Contents { unlit: true, all_unlit: true, ..Contents::default() };
        for (contents, indirect, expected, why) in [
            (Contents::default(), true, Integrator::Depth, "no light sources"),
            (Contents { glossy: true, ..Contents::default() }, true, Integrator::Depth, "no light sources"),
            (lit, true, Integrator::Path, "Lambertian surfaces, 2 punctual lights, a constant sky, light between"),
            (lit, false, Integrator::Direct, "no light between surfaces"),
            (glossy, true, Integrator::Path, "metal"),
            (glossy, false, Integrator::Path, "no light between matt surfaces"),
            (unlit, true, Integrator::Direct, "own color"),
            (Contents { emitters: true, ..Contents::default() }, false, Integrator::Direct, "emissive"),
            (
                Contents { discs: 1, environment: true, ..Contents::default() },
                false,
                Integrator::Direct,
                "1 sun, an env",
            ),
        ] {
            let (integrator, reason) = choose(&contents, indirect);
            assert_eq!(integrator, expected, "{contents:?}");
            assert!(reason.contains(why), "{reason}");
        }
    }
}
