//! Materials: the metallic-roughness model of glTF 2.0 with its extensions for layers, specular reflection,
//! transmission, volumes and emission.
//!
//! A surface is a mixture of three parts: *metal* with the weight `metallic`, *glass* with the weight `transmission` of
//! the rest, and a *dielectric coat over diffuse* with the remaining weight. Sources: the glTF 2.0 specification,
//! appendix B; KHR_materials_specular, _ior, _transmission, _volume, _emissive_strength, _unlit, _clearcoat, _sheen,
//! _anisotropy, _iridescence, _dispersion, _diffuse_transmission; KHR_texture_transform.

/// A material. Every texture multiplies the factor beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// A name for messages.
    pub name: String,
    /// Base color, linear RGB, and alpha, all 0 to 1: the reflectance of diffuse and metal, the transmittance of glass.
    pub base_color: [f32; 4],
    /// RGB: sRGB color. Alpha: linear.
    pub base_color_texture: Option<TextureInfo>,
    /// Weight of metal, 0 to 1.
    pub metallic: f32,
    /// Roughness, 0 (smooth) to 1. The alpha of the GGX distribution is its square; below 0.03 the renderer treats it
    /// as perfectly smooth.
    pub roughness: f32,
    /// Green: roughness, blue: metallic, both linear.
    pub metallic_roughness_texture: Option<TextureInfo>,
    /// A tangent-space normal map that modifies the interpolated normal.
    pub normal_map: Option<NormalMap>,
    /// Emitted radiance, linear RGB, on the front; on both sides if `double_sided`.
    pub emission: [f32; 3],
    /// sRGB color.
    pub emission_texture: Option<TextureInfo>,
    /// The interpretation of the alpha of the base color.
    pub alpha: Alpha,
    /// Whether the back emits, too. Everything else is the same on both sides for any value.
    pub double_sided: bool,
    /// `specularFactor` of KHR_materials_specular, 0 to 1: strength of the dielectric reflection; 1 is that of the
    /// index of refraction. With 0 a material that is neither metal nor glass is exactly Lambertian.
    pub specular: f32,
    /// Alpha channel, linear.
    pub specular_texture: Option<TextureInfo>,
    /// `specularColorFactor`: color of the dielectric reflection at normal incidence, linear RGB.
    pub specular_color: [f32; 3],
    /// sRGB color.
    pub specular_color_texture: Option<TextureInfo>,
    /// Index of refraction, 1 to 1000.
    pub ior: f32,
    /// Weight of glass in the rest, 0 to 1.
    pub transmission: f32,
    /// Red channel, linear.
    pub transmission_texture: Option<TextureInfo>,
    /// The volume that the surface encloses; without it glass is a thin pane without refraction.
    pub volume: Option<Volume>,
    /// `dispersion` of KHR_materials_dispersion, 20 / Abbe number, at least 0: how much the index of refraction of a
    /// body of glass depends on the wavelength. Without a volume it has no effect.
    pub dispersion: f32,
    /// A clear coat over everything else.
    pub clearcoat: Option<Clearcoat>,
    /// Fibers over the surface, below the clearcoat.
    pub sheen: Option<Sheen>,
    /// A roughness that depends on the direction on the surface.
    pub anisotropy: Option<Anisotropy>,
    /// A thin film on the surface.
    pub iridescence: Option<Iridescence>,
    /// Diffuse light that passes through the surface.
    pub diffuse_transmission: Option<DiffuseTransmission>,
    /// Whether the base color is shown without lighting, as emitted radiance. It is visible to the camera and in
    /// mirrors, and illuminates other surfaces.
    pub unlit: bool,
}

/// A highlight of a roughness below this shows what is mirrored in it.
const MIRRORING: f32 = 0.3;

impl Material {
    /// Returns whether the surface mirrors light, as metal, glaze and water do, or lets it pass, as glass and veils do:
    /// what the surface shows then lies at another depth. By the numbers of the material, whatever its textures are.
    #[must_use]
    pub fn is_reflective(&self) -> bool {
        let is_coated = self.clearcoat.is_some_and(|coat| coat.factor >= 0.5);
        let is_glossy = self.specular > 0.0 && self.roughness < MIRRORING;
        let mirrors = self.metallic >= 0.5 || is_coated || is_glossy || self.iridescence.is_some();
        !self.unlit && mirrors || self.is_transparent()
    }

    /// Returns whether the surface lets light pass, as glass and veils do. By the numbers of the material.
    #[must_use]
    pub fn is_transparent(&self) -> bool {
        !self.unlit && self.transmission >= 0.5 || self.alpha == Alpha::Blend
    }
}

/// The absorbing volume inside a body of glass. The surface must be closed; it may lie inside another body,
/// but not touch it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// The distance, m (in world units), after which white light has the color `attenuation_color`; infinity: no
    /// absorption.
    pub attenuation_distance_m: f32,
    /// Transmittance at that distance, linear RGB, each above 0 and at most 1.
    pub attenuation_color: [f32; 3],
}

/// A clear coat of index 1.5 over the whole surface (KHR_materials_clearcoat).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clearcoat {
    /// Weight, 0 to 1.
    pub factor: f32,
    /// Red channel, linear.
    pub texture: Option<TextureInfo>,
    /// Roughness, 0 to 1.
    pub roughness: f32,
    /// Green channel, linear.
    pub roughness_texture: Option<TextureInfo>,
    /// The normal map of the coat; without one it has the interpolated normal.
    pub normal_map: Option<NormalMap>,
}

/// Fibers over a surface (KHR_materials_sheen).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sheen {
    /// Linear RGB, 0 to 1.
    pub color: [f32; 3],
    /// sRGB color.
    pub color_texture: Option<TextureInfo>,
    /// Roughness, 0 to 1; below 0.1 the renderer treats it as 0.1.
    pub roughness: f32,
    /// Alpha channel, linear.
    pub roughness_texture: Option<TextureInfo>,
}

/// A roughness that is larger along one direction of the surface (KHR_materials_anisotropy): alpha becomes
/// alpha + (1 - alpha) strength^2 there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Anisotropy {
    /// 0 (isotropic) to 1.
    pub strength: f32,
    /// The angle of that direction from the tangent towards the bitangent, rad.
    pub rotation_rad: f32,
    /// Red and green: the direction before the rotation, (2 r - 1, 2 g - 1) along tangent and bitangent; blue: factor
    /// of the strength; all linear.
    pub texture: Option<TextureInfo>,
}

/// A thin film on a surface (KHR_materials_iridescence).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Iridescence {
    /// Weight, 0 to 1.
    pub factor: f32,
    /// Red channel, linear.
    pub texture: Option<TextureInfo>,
    /// Index of refraction of the film, 1 to 1000.
    pub ior: f32,
    /// Thickness where the texture is 0 and where it is 1, nm; without a texture the second one.
    pub thickness_nm: [f32; 2],
    /// Green channel, linear.
    pub thickness_texture: Option<TextureInfo>,
}

impl Default for Iridescence {
    /// That of a glTF file.
    fn default() -> Self {
        Self { factor: 0.0, texture: None, ior: 1.3, thickness_nm: [100.0, 400.0], thickness_texture: None }
    }
}

/// Diffuse light that passes through a surface (KHR_materials_diffuse_transmission).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiffuseTransmission {
    /// The share of the diffuse light that passes, 0 to 1.
    pub factor: f32,
    /// Alpha channel, linear.
    pub texture: Option<TextureInfo>,
    /// Its color, linear RGB, 0 to 1.
    pub color: [f32; 3],
    /// sRGB color.
    pub color_texture: Option<TextureInfo>,
}

impl Default for DiffuseTransmission {
    /// That of a glTF file.
    fn default() -> Self {
        Self { factor: 0.0, texture: None, color: [1.0; 3], color_texture: None }
    }
}

/// The interpretation of the alpha of the base color.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Alpha is ignored.
    #[default]
    Opaque,
    /// A cutoff: the surface is a hole where alpha is smaller.
    Mask(f32),
    /// Alpha is the opacity: the share of rays that the surface stops.
    Blend,
}

/// A tangent-space normal map. The texels (r, g, b) give the normal ((2 r - 1) scale, (2 g - 1) scale, 2 b - 1) along
/// tangent, bitangent and normal of the mesh ([`Mesh::tangents`](crate::Mesh::tangents)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// Linear RGB.
    pub texture: TextureInfo,
    /// Factor of the x and y components.
    pub scale: f32,
}

/// A reference of a material to a texture (`textureInfo` of glTF).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TextureInfo {
    /// Index into [`crate::Scene::textures`].
    pub texture: usize,
    /// The texture coordinate set of the mesh: 0 or 1.
    pub set: usize,
    /// The transform of the texture coordinates.
    pub transform: TextureTransform,
}

impl TextureInfo {
    /// A reference to `texture` with the first texture coordinate set and no transform.
    #[must_use]
    pub fn new(texture: usize) -> Self {
        Self { texture, ..Self::default() }
    }
}

/// A transform of texture coordinates: scale (w, h), then rotation by the angle r, then offset (x, y):
/// u' = w u cos r + h v sin r + x, v' = h v cos r - w u sin r + y. Source: KHR_texture_transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureTransform {
    /// Offset, applied last.
    pub offset: [f32; 2],
    /// Rotation of the coordinates, rad, counter-clockwise in an image (v runs down).
    pub rotation_rad: f32,
    /// Scale, applied first.
    pub scale: [f32; 2],
}

impl TextureTransform {
    /// The identity.
    pub const IDENTITY: Self = Self { offset: [0.0; 2], rotation_rad: 0.0, scale: [1.0; 2] };
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Default for Material {
    /// A white Lambertian material. (The defaults of a glTF *file* differ.)
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: [1.0; 4],
            base_color_texture: None,
            metallic: 0.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_map: None,
            emission: [0.0; 3],
            emission_texture: None,
            alpha: Alpha::Opaque,
            double_sided: true,
            specular: 0.0,
            specular_texture: None,
            specular_color: [1.0; 3],
            specular_color_texture: None,
            ior: 1.5,
            transmission: 0.0,
            transmission_texture: None,
            volume: None,
            dispersion: 0.0,
            clearcoat: None,
            sheen: None,
            anisotropy: None,
            iridescence: None,
            diffuse_transmission: None,
            unlit: false,
        }
    }
}

impl Material {
    /// The texture coordinate set that tangents follow, if the material needs tangents.
    pub(crate) fn tangent_set(&self) -> Option<usize> {
        let anisotropic = |anisotropy: Anisotropy| anisotropy.texture.map_or(0, |used| used.set);
        let coat_map = self.clearcoat.and_then(|coat| coat.normal_map);
        let map_set = self.normal_map.or(coat_map).map(|map| map.texture.set);
        map_set.or(self.anisotropy.map(anisotropic))
    }

    /// All texture references of the material, with the names of their fields.
    pub(crate) fn textures(&self) -> impl Iterator<Item = (&'static str, TextureInfo)> {
        let mut found = Vec::new();
        // A copy, because the list is made by what changes the references.
        self.clone().each_texture(|name, used| {
            found.extend(used.map(|used| (name, used)));
            used
        });
        found.into_iter()
    }

    /// Replaces or removes every texture reference; a normal map goes with its texture.
    pub(crate) fn each_texture(
        &mut self,
        mut change: impl FnMut(&'static str, Option<TextureInfo>) -> Option<TextureInfo>,
    ) {
        let mut map = |name, map: &mut Option<NormalMap>| {
            let texture = change(name, map.map(|map| map.texture));
            *map = map.and_then(|map| texture.map(|texture| NormalMap { texture, ..map }));
        };
        map("normal_map", &mut self.normal_map);
        if let Some(coat) = &mut self.clearcoat {
            map("clearcoat.normal_map", &mut coat.normal_map);
        }
        let mut all = vec![
            ("base_color_texture", &mut self.base_color_texture),
            ("metallic_roughness_texture", &mut self.metallic_roughness_texture),
            ("emission_texture", &mut self.emission_texture),
            ("specular_texture", &mut self.specular_texture),
            ("specular_color_texture", &mut self.specular_color_texture),
            ("transmission_texture", &mut self.transmission_texture),
        ];
        if let Some(coat) = &mut self.clearcoat {
            all.push(("clearcoat.texture", &mut coat.texture));
            all.push(("clearcoat.roughness_texture", &mut coat.roughness_texture));
        }
        if let Some(sheen) = &mut self.sheen {
            all.push(("sheen.color_texture", &mut sheen.color_texture));
            all.push(("sheen.roughness_texture", &mut sheen.roughness_texture));
        }
        if let Some(anisotropy) = &mut self.anisotropy {
            all.push(("anisotropy.texture", &mut anisotropy.texture));
        }
        if let Some(iridescence) = &mut self.iridescence {
            all.push(("iridescence.texture", &mut iridescence.texture));
            all.push(("iridescence.thickness_texture", &mut iridescence.thickness_texture));
        }
        if let Some(through) = &mut self.diffuse_transmission {
            all.push(("diffuse_transmission.texture", &mut through.texture));
            all.push(("diffuse_transmission.color_texture", &mut through.color_texture));
        }
        for (name, used) in all {
            *used = change(name, *used);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_mirrors_or_lets_light_pass_is_reflective() {
        let plain = Material::default();
        let coat = |factor| Some(Clearcoat { factor, ..Clearcoat::default() });
        let (neither, mirrors, lets_pass) = ([false, false], [true, false], [true, true]);
        for (expected, material) in [
            (neither, plain.clone()),
            (neither, Material { specular: 1.0, roughness: 0.5, ..plain.clone() }),
            (mirrors, Material { specular: 1.0, roughness: 0.1, ..plain.clone() }),
            (mirrors, Material { metallic: 1.0, roughness: 0.9, ..plain.clone() }),
            (lets_pass, Material { transmission: 1.0, ..plain.clone() }),
            (mirrors, Material { clearcoat: coat(1.0), ..plain.clone() }),
            (neither, Material { clearcoat: coat(0.1), ..plain.clone() }),
            (lets_pass, Material { alpha: Alpha::Blend, ..plain.clone() }),
            (neither, Material { alpha: Alpha::Mask(0.5), ..plain.clone() }),
            (neither, Material { metallic: 1.0, unlit: true, ..plain }),
        ] {
            assert_eq!([material.is_reflective(), material.is_transparent()], expected, "{material:?}");
        }
    }
}
