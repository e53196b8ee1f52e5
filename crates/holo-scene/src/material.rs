//! Materials: the metallic-roughness model of glTF 2.0 with its extensions for specular reflection, transmission,
//! volumes and emission.
//!
//! A surface is a mixture of three parts: *metal* with the weight `metallic`, *glass* with the weight `transmission` of
//! the rest, and a *dielectric coat over diffuse* with the remaining weight. Sources: the glTF 2.0 specification,
//! appendix B; KHR_materials_specular, _ior, _transmission, _volume, _emissive_strength, _unlit; KHR_texture_transform.

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
    /// Whether the base color is shown without lighting, as emitted radiance. It is visible to the camera and in
    /// mirrors, and illuminates other surfaces.
    pub unlit: bool,
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
            unlit: false,
        }
    }
}

impl Material {
    /// The texture coordinate set that tangents follow, if the material needs tangents.
    pub(crate) fn tangent_set(&self) -> Option<usize> {
        self.normal_map.map(|map| map.texture.set)
    }

    /// All texture references of the material, with the names of their fields.
    pub(crate) fn textures(&self) -> impl Iterator<Item = (&'static str, TextureInfo)> {
        [
            ("base_color_texture", self.base_color_texture),
            ("metallic_roughness_texture", self.metallic_roughness_texture),
            ("normal_map", self.normal_map.map(|map| map.texture)),
            ("emission_texture", self.emission_texture),
            ("specular_texture", self.specular_texture),
            ("specular_color_texture", self.specular_color_texture),
            ("transmission_texture", self.transmission_texture),
        ]
        .into_iter()
        .filter_map(|(name, used)| Some((name, used?)))
    }
}
