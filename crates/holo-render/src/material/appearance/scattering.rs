//! The BSDF parameters of metals, glossy coats and glass, for [`crate::material::bsdf`].

use super::{Appearance, MaterialFlags, SurfacePoint, TextureLookup};
use crate::accel::RayHits;
use crate::geometry::Geometry;
use crate::material::SurfaceInteraction;
use crate::material::bsdf::{Bsdf, fresnel};
use crate::material::texture;
use crate::simd::LANES;

/// The scattering parameters of a material beyond its base color.
pub(super) struct Scattering {
    metallic: f32,
    roughness: f32,
    metallic_roughness: Option<TextureLookup>,
    specular: f32,
    specular_texture: Option<TextureLookup>,
    specular_color: [f32; 3],
    specular_color_texture: Option<TextureLookup>,
    ior: f32,
    transmission: f32,
    transmission_texture: Option<TextureLookup>,
    /// The absorption coefficient of the volume, 1/m; `None` for a thin pane.
    absorption: Option<[f32; 3]>,
}

impl Scattering {
    pub fn new(material: &holo_scene::Material) -> Self {
        let absorption = material.volume.map(|volume| {
            let distance = f64::from(volume.attenuation_distance_m);
            // Beer-Lambert law: color = exp(-absorption * distance). (f64 logarithms of f32 values, rounded to f32, are
            // the same on every machine in all but one of 2^29 cases.)
            volume.attenuation_color.map(|c| (-f64::from(c).ln() / distance) as f32)
        });
        Self {
            metallic: material.metallic,
            roughness: material.roughness,
            metallic_roughness: material.metallic_roughness_texture.map(TextureLookup::new),
            specular: material.specular,
            specular_texture: material.specular_texture.map(TextureLookup::new),
            specular_color: material.specular_color,
            specular_color_texture: material.specular_color_texture.map(TextureLookup::new),
            ior: material.ior,
            transmission: material.transmission,
            transmission_texture: material.transmission_texture.map(TextureLookup::new),
            absorption,
        }
    }

    /// Whether the BSDF has more lobes than the diffuse one.
    pub fn is_glossy(&self) -> bool {
        self.metallic > 0.0 || self.transmission > 0.0 || self.specular > 0.0
    }

    /// Whether light passes through an absorbing volume.
    pub fn has_volume(&self) -> bool {
        self.transmission > 0.0 && self.absorption.is_some_and(|absorption| absorption.iter().any(|&a| a > 0.0))
    }
}

impl Appearance {
    /// The BSDF of sixteen surface interactions; Lambertian for lanes that are not glossy.
    #[inline(always)]
    pub fn scattering(&self, geometry: &Geometry, packet: &RayHits, interaction: &SurfaceInteraction) -> Bsdf {
        let mut out = Bsdf::lambertian(interaction.base_color);
        for lane in 0..LANES {
            if !interaction.flags[lane].has(MaterialFlags::GLOSSY) {
                continue;
            }
            let point =
                SurfacePoint::new(geometry, interaction.triangle[lane], [packet.hits.u[lane], packet.hits.v[lane]]);
            let material = &self.materials[point.instance.material as usize].scattering;
            let (mut metallic, mut roughness) = (material.metallic, material.roughness);
            if let Some(lookup) = &material.metallic_roughness {
                let [_, g, b] = self.linear_texel(lookup, &point);
                (roughness, metallic) = (roughness * g, metallic * b);
            }
            let mut specular = material.specular;
            if let Some(lookup) = &material.specular_texture {
                specular *= texture::sample_alpha(&self.textures[lookup.texture], point.coordinates(lookup));
            }
            let mut specular_color = material.specular_color;
            if let Some(lookup) = &material.specular_color_texture {
                let texel = self.color(lookup, &point);
                for c in 0..3 {
                    specular_color[c] *= texel[c];
                }
            }
            let mut transmission = material.transmission;
            if let Some(lookup) = &material.transmission_texture {
                transmission *= self.linear_texel(lookup, &point)[0];
            }
            out.metallic[lane] = metallic;
            out.transmission[lane] = transmission;
            out.alpha[lane] = roughness * roughness;
            let normal = fresnel::normal_incidence(material.ior);
            for c in 0..3 {
                out.specular_f0[c][lane] = (normal * specular_color[c]).min(1.0) * specular;
            }
            out.specular_f90[lane] = specular;
            out.thin[lane] = material.absorption.is_none();
            let leaves = (interaction.side[lane] < 0.0) & material.absorption.is_some();
            out.eta[lane] = if leaves { 1.0 / material.ior } else { material.ior };
        }
        out
    }

    /// The transmittance of `length` meters in the volume that a ray is about to leave: 1 unless the ray hits the back
    /// of glass with a volume. Source: Beer-Lambert law.
    #[inline(always)]
    pub fn attenuation(
        &self,
        geometry: &Geometry,
        interaction: &SurfaceInteraction,
        length: &[f32; LANES],
    ) -> [[f32; LANES]; 3] {
        let mut depth = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            if interaction.flags[lane].has(MaterialFlags::VOLUME) & (interaction.side[lane] < 0.0) {
                let instance = geometry.instance(geometry.instance_index(interaction.triangle[lane]));
                if let Some(absorption) = self.materials[instance.material as usize].scattering.absorption {
                    for c in 0..3 {
                        depth[c][lane] = absorption[c] * length[lane];
                    }
                }
            }
        }
        for c in 0..3 {
            for lane in 0..LANES {
                depth[c][lane] = exp_of_minus(depth[c][lane]);
            }
        }
        depth
    }
}

/// exp(-x) for x >= 0 with a relative error below 2e-7, bitwise identical on all machines; 0 above 87.
#[inline(always)]
fn exp_of_minus(x: f32) -> f32 {
    const LOG2_E: f64 = std::f64::consts::LOG2_E;
    let x = x.min(100.0);
    // 2^-(k + f) with f between -1/2 and 1/2; in f64, so that k * ln 2 loses no precision.
    let exponent = f64::from(x) * LOG2_E;
    let whole = (exponent + 0.5).floor();
    let y = (whole - exponent) * std::f64::consts::LN_2;
    let power = 1.0
        + y * (1.0
            + y * (0.5 + y * (1.0 / 6.0 + y * (1.0 / 24.0 + y * (1.0 / 120.0 + y * (1.0 / 720.0 + y / 5040.0))))));
    let scale = f64::from_bits(((1023 - whole as i64) as u64) << 52);
    if x > 87.0 { 0.0 } else { (power * scale) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_right() {
        for k in 0..87_000 {
            let x = k as f32 / 1000.0;
            let exact = (-f64::from(x)).exp();
            assert!((f64::from(exp_of_minus(x)) / exact - 1.0).abs() < 2e-7, "{x}");
        }
        assert_eq!([exp_of_minus(0.0), exp_of_minus(1e30)], [1.0, 0.0]);
    }
}
