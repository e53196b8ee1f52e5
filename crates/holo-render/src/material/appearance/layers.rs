//! The parameters of layers and rare lobes at hit points, for [`crate::material::bsdf::layered`].

use super::normal_map::tangent_axes;
use super::{Appearance, NormalMapLookup, SurfacePoint, TextureLookup, mix};
use crate::accel::RayHits;
use crate::geometry::Geometry;
use crate::material::SurfaceInteraction;
use crate::material::bsdf::Bsdf;
use crate::material::bsdf::fresnel;
use crate::material::bsdf::layered::film::Film;
use crate::material::bsdf::layered::sheen::{self, Sheen};
use crate::material::bsdf::layered::{Clearcoat, Layered};
use crate::material::media::MediaStack;
use crate::material::texture;
use crate::simd::at;
use holo_scene::NormalMap;

/// The layers of a material.
pub(super) struct Layers {
    clearcoat: Option<(holo_scene::Clearcoat, [Option<TextureLookup>; 2], Option<NormalMapLookup>)>,
    sheen: Option<(holo_scene::Sheen, [Option<TextureLookup>; 2])>,
    anisotropy: Option<(holo_scene::Anisotropy, Option<TextureLookup>)>,
    iridescence: Option<(holo_scene::Iridescence, [Option<TextureLookup>; 2])>,
    diffuse_transmission: Option<(holo_scene::DiffuseTransmission, [Option<TextureLookup>; 2])>,
}

impl Layers {
    /// `None` for a material without any that has an effect; `in_dispersive_media`: whether it is a body of glass in a
    /// scene with dispersion.
    pub fn new(material: &holo_scene::Material, in_dispersive_media: bool) -> Option<Box<Self>> {
        let lookup = |used: Option<holo_scene::TextureInfo>| used.map(TextureLookup::new);
        let map = |map: NormalMap| (TextureLookup::new(map.texture), map.scale);
        let layers = Self {
            clearcoat: material
                .clearcoat
                .filter(|coat| coat.factor > 0.0)
                .map(|coat| (coat, [lookup(coat.texture), lookup(coat.roughness_texture)], coat.normal_map.map(map))),
            sheen: material
                .sheen
                .filter(|sheen| sheen.color != [0.0; 3])
                .map(|sheen| (sheen, [lookup(sheen.color_texture), lookup(sheen.roughness_texture)])),
            anisotropy: material
                .anisotropy
                .filter(|anisotropy| anisotropy.strength > 0.0)
                .map(|anisotropy| (anisotropy, lookup(anisotropy.texture))),
            iridescence: material
                .iridescence
                .filter(|film| film.factor > 0.0)
                .map(|film| (film, [lookup(film.texture), lookup(film.thickness_texture)])),
            diffuse_transmission: material
                .diffuse_transmission
                .filter(|through| through.factor > 0.0)
                .map(|through| (through, [lookup(through.texture), lookup(through.color_texture)])),
        };
        let any = in_dispersive_media
            || layers.clearcoat.is_some()
            || layers.sheen.is_some()
            || layers.anisotropy.is_some()
            || layers.iridescence.is_some()
            || layers.diffuse_transmission.is_some();
        any.then(|| Box::new(layers))
    }
}

/// One lane of a packet of surface interactions.
#[derive(Clone, Copy)]
pub(crate) struct Lane<'a> {
    pub geometry: &'a Geometry,
    pub packet: &'a RayHits,
    pub interaction: &'a SurfaceInteraction,
    pub lane: usize,
    pub media: MediaStack,
    /// The axes of the shading frame; the last one is the normal on the side of the viewer.
    pub axes: [[f32; 3]; 3],
    /// The unit direction to the viewer.
    pub viewer: [f32; 3],
    /// The channels in which the path carries light.
    pub channels: [bool; 3],
}

impl Appearance {
    /// The layered BSDF of one lane, whose parameters without layers `bsdf` has, with the axes of its shading frame.
    #[inline(never)]
    pub fn layered(&self, bsdf: &Bsdf, here: &Lane) -> Option<(Layered, [[f32; 3]; 3])> {
        let (packet, lane) = (here.packet, here.lane);
        let point = SurfacePoint::new(
            here.geometry,
            here.interaction.triangle[lane],
            [packet.hits.u[lane], packet.hits.v[lane]],
        );
        let layers = self.materials[point.instance.material as usize].layers.as_deref()?;
        let mut axes = here.axes;
        let alpha = bsdf.alpha[lane];
        let mut out = Layered {
            base_color: at(&bsdf.base_color, lane),
            metallic: bsdf.metallic[lane],
            transmission: bsdf.transmission[lane],
            alpha: [alpha; 2],
            specular_f0: at(&bsdf.specular_f0, lane),
            specular_f90: bsdf.specular_f90[lane],
            eta: [bsdf.eta[lane]; 3],
            usual_f0: 1.0,
            thin: bsdf.thin[lane],
            multiple_scattering: bsdf.multiple_scattering,
            diffuse_transmission: 0.0,
            diffuse_transmission_color: [1.0; 3],
            film: None,
            sheen: None,
            clearcoat: None,
            channels: here.channels,
        };
        if let Some((anisotropy, lookup)) = &layers.anisotropy {
            let mut strength = anisotropy.strength;
            let mut along = [1.0, 0.0];
            if let Some(lookup) = lookup {
                let [r, g, b] = self.linear_texel(lookup, &point);
                (along, strength) = ([2.0 * r - 1.0, 2.0 * g - 1.0], strength * b);
            }
            let set = lookup.as_ref().map_or(0, |lookup| lookup.set);
            if let Some(turned) = anisotropic_axes(&point, set, here, along, anisotropy.rotation_rad) {
                axes = turned;
                out.alpha = [alpha + (1.0 - alpha) * strength * strength, alpha];
            }
        }
        if let Some((film, lookups)) = &layers.iridescence {
            let factor = film.factor * self.channel(&lookups[0], &point, 0);
            let [least, most] = film.thickness_nm;
            let thickness_nm = least + (most - least) * self.channel(&lookups[1], &point, 1);
            out.film = (factor > 0.0).then_some(Film { factor, ior: film.ior, thickness_nm });
        }
        if let Some((sheen, [color, roughness])) = &layers.sheen {
            let color = self.tinted(sheen.color, color, &point);
            let roughness = sheen.roughness * self.alpha_channel(roughness, &point);
            out.sheen = Some(Sheen { color, alpha: (roughness * roughness).max(sheen::MIN_ALPHA) });
        }
        if let Some((through, [factor, color])) = &layers.diffuse_transmission {
            out.diffuse_transmission = through.factor * self.alpha_channel(factor, &point);
            out.diffuse_transmission_color = self.tinted(through.color, color, &point);
        }
        if let Some((coat, lookups, map)) = &layers.clearcoat {
            let factor = coat.factor * self.channel(&lookups[0], &point, 0);
            let roughness = coat.roughness * self.channel(&lookups[1], &point, 1);
            let own = self.clearcoat_axes(&point, map, here, &axes);
            out.clearcoat = (factor > 0.0).then_some(Clearcoat { factor, alpha: roughness * roughness, axes: own });
        }
        self.disperse(&point, here, &mut out);
        Some((out, axes))
    }

    /// The indices of refraction of the channels of a body of glass.
    fn disperse(&self, point: &SurfacePoint, here: &Lane, out: &mut Layered) {
        let scattering = &self.materials[point.instance.material as usize].scattering;
        let Some(own) = scattering.medium().filter(|_| !out.thin) else { return };
        let leaves = here.interaction.side[here.lane] < 0.0;
        let outside = self.medium(if leaves { here.media.left(scattering.medium) } else { here.media }.top());
        if own.dispersion == 0.0 && outside.dispersion == 0.0 {
            return;
        }
        out.usual_f0 = fresnel::normal_incidence(own.ior / outside.ior);
        for c in 0..3 {
            let ior = own.ior_of(c) / outside.ior_of(c);
            out.eta[c] = if leaves { 1.0 / ior } else { ior };
        }
    }

    /// The axes of the clearcoat in the shading frame `axes`.
    fn clearcoat_axes(
        &self,
        point: &SurfacePoint,
        map: &Option<NormalMapLookup>,
        here: &Lane,
        axes: &[[f32; 3]; 3],
    ) -> [[f32; 3]; 3] {
        let is_mapped = self.materials[point.instance.material as usize].normal_map.is_some();
        if map.is_none() && !is_mapped {
            return Clearcoat::ALIGNED;
        }
        let side = here.interaction.side[here.lane];
        let mut normal = at(&here.interaction.geometric_normal, here.lane).map(|x| x * side);
        if point.instance.smooth {
            let smooth = mix(&point.geometry.normals_of(point.triangle), point.barycentrics);
            normal = unit(smooth).unwrap_or(normal);
        }
        if let Some(map) = map
            && let Some(axes) = tangent_axes(point, map.0.set, normal)
        {
            normal = self.mapped_normal(map, point, &axes, normal).unwrap_or(normal);
        }
        // Normals that face away from the viewer are turned to be just visible.
        let mut normal = normal.map(|x| x * side);
        let lift = (0.01 - dot(normal, here.viewer)).max(0.0);
        normal = std::array::from_fn(|k| normal[k] + here.viewer[k] * lift);
        let Some(normal) = unit(normal) else { return Clearcoat::ALIGNED };
        let [x, y] = crate::sampling::frame(normal);
        [x, y, normal].map(|own| axes.map(|axis| dot(axis, own)))
    }

    /// A channel of a texture of linear values; 1 without one.
    fn channel(&self, lookup: &Option<TextureLookup>, point: &SurfacePoint, channel: usize) -> f32 {
        lookup.as_ref().map_or(1.0, |lookup| self.linear_texel(lookup, point)[channel])
    }

    /// The alpha of a texture; 1 without one.
    fn alpha_channel(&self, lookup: &Option<TextureLookup>, point: &SurfacePoint) -> f32 {
        lookup
            .as_ref()
            .map_or(1.0, |lookup| texture::sample_alpha(&self.textures[lookup.texture], point.coordinates(lookup)))
    }

    fn tinted(&self, color: [f32; 3], lookup: &Option<TextureLookup>, point: &SurfacePoint) -> [f32; 3] {
        let Some(lookup) = lookup else { return color };
        let texel = self.color(lookup, point);
        std::array::from_fn(|c| color[c] * texel[c])
    }
}

/// The shading frame turned so that x is the direction `along` (tangent and bitangent), turned by `rotation_rad`.
fn anisotropic_axes(
    point: &SurfacePoint,
    set: usize,
    here: &Lane,
    along: [f32; 2],
    rotation_rad: f32,
) -> Option<[[f32; 3]; 3]> {
    let normal = here.axes[2];
    let front = normal.map(|x| x * here.interaction.side[here.lane]);
    let on_surface = tangent_axes(point, set, front)?;
    let (sin, cos) = f64::from(rotation_rad).sin_cos();
    let (sin, cos) = (sin as f32, cos as f32);
    let (x, y) = (cos * along[0] - sin * along[1], sin * along[0] + cos * along[1]);
    let turned = unit(std::array::from_fn(|k| on_surface.x[k] * x + on_surface.y[k] * y))?;
    let [a, b, c] = normal;
    let [d, e, f] = turned;
    Some([turned, [b * f - c * e, c * d - a * f, a * e - b * d], normal])
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(v: [f32; 3]) -> Option<[f32; 3]> {
    let inverse = 1.0 / dot(v, v).sqrt();
    inverse.is_finite().then(|| v.map(|x| x * inverse))
}
