//! The BSDF parameters of metals, glossy coats and glass, for [`crate::material::bsdf`].

use super::{Appearance, SurfacePoint, TextureLookup};
use crate::accel::RayHits;
use crate::geometry::Geometry;
use crate::material::MaterialFlags;
use crate::material::SurfaceInteraction;
use crate::material::bsdf::{Bsdf, fresnel};
use crate::material::media::{MediaStack, Medium, MediumId};
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
    /// The medium behind the surface; `None` for a thin pane.
    volume: Option<Medium>,
    diffuse_transmission: f32,
    /// Its number, 0 without.
    pub(super) medium: MediumId,
}

impl Scattering {
    pub fn new(material: &holo_scene::Material) -> Self {
        let volume = material.volume.map(|volume| {
            let distance = f64::from(volume.attenuation_distance_m);
            // Beer-Lambert law: color = exp(-absorption * distance). (f64 logarithms of f32 values, rounded to f32, are
            // the same on every machine in all but one of 2^29 cases.)
            let absorption = volume.attenuation_color.map(|c| (-f64::from(c).ln() / distance) as f32);
            Medium { ior: material.ior, dispersion: material.dispersion, absorption }
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
            volume,
            diffuse_transmission: material.diffuse_transmission.map_or(0.0, |through| through.factor),
            medium: 0,
        }
    }

    /// Whether the BSDF has more lobes than the diffuse one.
    pub fn is_glossy(&self) -> bool {
        self.metallic > 0.0 || self.transmission > 0.0 || self.specular > 0.0
    }

    /// The medium that light passes through behind the surface.
    pub fn medium(&self) -> Option<Medium> {
        self.volume.filter(|_| self.transmission > 0.0 || self.diffuse_transmission > 0.0)
    }
}

impl Appearance {
    /// The BSDF of sixteen surface interactions; Lambertian for lanes that are not glossy.
    #[inline(always)]
    pub fn scattering(
        &self,
        geometry: &Geometry,
        packet: &RayHits,
        interaction: &SurfaceInteraction,
        media: &[MediaStack; LANES],
        multiple_scattering: bool,
    ) -> Bsdf {
        let mut out = Bsdf { multiple_scattering, ..Bsdf::lambertian(interaction.base_color) };
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
            let body = material.volume.is_some();
            let leaves = (interaction.side[lane] < 0.0) & body;
            let outside = if leaves { media[lane].left(material.medium) } else { media[lane] };
            // Relative to what is around; a pane is glass in air.
            let around = if body | (transmission == 0.0) { self.medium(outside.top()).ior } else { 1.0 };
            let ior = material.ior / around;
            let normal = fresnel::normal_incidence(ior);
            for c in 0..3 {
                out.specular_f0[c][lane] = (normal * specular_color[c]).min(1.0) * specular;
            }
            out.specular_f90[lane] = specular;
            out.thin[lane] = !body;
            out.eta[lane] = if leaves { 1.0 / ior } else { ior };
        }
        out
    }

    /// The numbers of the media behind sixteen surfaces; 0 for surfaces that enclose none.
    #[inline(always)]
    pub fn media(&self, geometry: &Geometry, interaction: &SurfaceInteraction) -> [MediumId; LANES] {
        let mut out = [0; LANES];
        for lane in 0..LANES {
            if interaction.flags[lane].has(MaterialFlags::VOLUME) {
                let instance = geometry.instance(geometry.instance_index(interaction.triangle[lane]));
                out[lane] = self.materials[instance.material as usize].scattering.medium;
            }
        }
        out
    }

    /// The medium of a number.
    #[inline(always)]
    pub fn medium(&self, number: MediumId) -> Medium {
        self.media[usize::from(number)]
    }
}
