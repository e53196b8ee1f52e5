//! Emission of surfaces.

use super::{Appearance, SurfacePoint, TextureLookup};
use crate::geometry::{Geometry, Hit};
use crate::material::MaterialFlags;
use crate::material::footprint::Footprints;
use crate::simd::LANES;

/// The emission of a material.
pub(super) struct Emission {
    /// Radiance, linear RGB.
    factor: [f32; 3],
    texture: Option<TextureLookup>,
    /// Whether the back emits as well as the front.
    pub(super) both_sides: bool,
}

impl Emission {
    pub fn new(material: &holo_scene::Material) -> Self {
        let texture = material.emission_texture.map(TextureLookup::new);
        Self { factor: material.emission, texture, both_sides: material.double_sided }
    }

    pub fn is_emissive(&self) -> bool {
        self.factor.iter().any(|&x| x > 0.0)
    }
}

impl Appearance {
    /// The radiance that sixteen points emit towards the side `side` (1 front, -1 back), linear RGB; 0 without
    /// emission. The mean over footprints, if there are any.
    #[inline(always)]
    pub fn emission(
        &self,
        geometry: &Geometry,
        triangles: &[Hit; LANES],
        footprints: Option<&Footprints>,
        [u, v]: [&[f32; LANES]; 2],
        side: &[f32; LANES],
        wanted: &[bool; LANES],
    ) -> [[f32; LANES]; 3] {
        let mut out = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            if !wanted[lane] {
                continue;
            }
            let point = SurfacePoint::new(geometry, triangles[lane], [u[lane], v[lane]]);
            let material = &self.materials[point.instance.material as usize];
            let emission = &material.emission;
            if !material.flags.has(MaterialFlags::EMISSIVE) | ((side[lane] < 0.0) & !emission.both_sides) {
                continue;
            }
            let mut radiance = emission.factor;
            if let Some(lookup) = &emission.texture {
                let texel = self.mean_color(material, lookup, &point, footprints.map(|all| (all, lane)));
                for c in 0..3 {
                    radiance[c] *= texel[c];
                }
            }
            for c in 0..3 {
                out[c][lane] = radiance[c];
            }
        }
        out
    }
}
