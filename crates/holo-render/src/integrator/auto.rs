//! Which integrator a scene needs: the cheapest one that is exact for it, up to one choice of the caller's.
//!
//! The choice is whether light is followed from surface to surface ([`crate::Request::indirect`]). With it anything lit
//! needs [`super::path`]. Without it a scene of Lambertian surfaces needs [`super::direct`] alone; metal, glass and
//! varnish need paths that go on from them and end where they meet a matt surface. Where nothing shines there is no
//! picture, only ground truth ([`super::depth`]).
//!
//! What a scene lacks it does not pay for. This is decided packet by packet, inside the integrators: textures, gloss,
//! glass, glow, holes and surroundings are looked up where a packet meets them and nowhere else.

use super::Integrator;

/// What a scene holds that decides.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Contents {
    pub punctual_lights: usize,
    pub discs: usize,
    pub emitters: bool,
    /// A constant sky that is not black.
    pub sky: bool,
    /// Surroundings with a map that is not black.
    pub surroundings: bool,
    /// Any material with metal, glass or varnish.
    pub glossy: bool,
    /// Any material that shows its colour without light.
    pub unlit: bool,
    /// Nothing but such materials.
    pub all_unlit: bool,
}

impl Contents {
    fn shines(&self) -> bool {
        self.punctual_lights + self.discs > 0 || self.emitters || self.sky || self.surroundings || self.unlit
    }

    /// What shines, in words.
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
            some(self.surroundings, "an environment map"),
            some(self.unlit, "unlit surfaces"),
        ];
        list.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }
}

/// The integrator for a scene, and why.
pub(crate) fn choose(contents: &Contents, indirect: bool) -> (Integrator, String) {
    let lights = contents.lights();
    let surfaces = if contents.glossy { "metal, glass or varnish" } else { "Lambertian surfaces" };
    if !contents.shines() {
        (Integrator::Depth, "nothing in the scene shines".into())
    } else if contents.all_unlit {
        (Integrator::Direct, "every surface shows its own colour".into())
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
            (Contents::default(), true, Integrator::Depth, "nothing"),
            (Contents { glossy: true, ..Contents::default() }, true, Integrator::Depth, "nothing"),
            (lit, true, Integrator::Path, "Lambertian surfaces, 2 punctual lights, a constant sky, light between"),
            (lit, false, Integrator::Direct, "no light between surfaces"),
            (glossy, true, Integrator::Path, "metal"),
            (glossy, false, Integrator::Path, "no light between matt surfaces"),
            (unlit, true, Integrator::Direct, "own colour"),
            (Contents { emitters: true, ..Contents::default() }, false, Integrator::Direct, "emissive"),
            (
                Contents { discs: 1, surroundings: true, ..Contents::default() },
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
