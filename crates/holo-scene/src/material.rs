//! What surfaces do with light: the metallic-roughness model of glTF 2.0 with its extensions for gloss, glass and glow.
//!
//! A surface is a mixture of three: a *metal* (share `metallic`), a *glass* (share `transmission` of the rest) and a
//! *varnished diffuser* (what remains). Sources: the glTF 2.0 specification, appendix B; KHR_materials_specular, _ior,
//! _transmission, _volume, _emissive_strength, _unlit; KHR_texture_transform.

/// A surface. Every texture multiplies the number beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// A name for messages.
    pub name: String,
    /// Linear RGB of what is reflected (transmitted by glass), and alpha.
    pub base_color: [f32; 4],
    /// sRGB color and linear alpha.
    pub base_color_texture: Option<TextureUse>,
    /// Share of metal, 0 to 1.
    pub metallic: f32,
    /// 0: polished (exactly smooth below 0.03), 1: dull. The square is the width of the GGX distribution.
    pub roughness: f32,
    /// Green: roughness, blue: metallic, both linear.
    pub metallic_roughness_texture: Option<TextureUse>,
    /// Bends the interpolated normal.
    pub normal_map: Option<NormalMap>,
    /// Radiance that the surface emits, linear RGB; to its front, or to both sides if it is double-sided.
    pub emission: [f32; 3],
    /// sRGB.
    pub emission_texture: Option<TextureUse>,
    /// What the alpha of the base color means.
    pub alpha: Alpha,
    /// Whether emission leaves the back as well. Everything else is alike on both sides, whatever this says.
    pub double_sided: bool,
    /// Strength of the reflection of what is no metal: 1 as the index of refraction has it, 0 none. With 0 a surface
    /// that is neither metal nor glass is exactly Lambert's.
    pub specular: f32,
    /// Alpha channel.
    pub specular_texture: Option<TextureUse>,
    /// Tints that reflection at normal incidence, linear RGB.
    pub specular_color: [f32; 3],
    /// sRGB.
    pub specular_color_texture: Option<TextureUse>,
    /// Index of refraction, at least 1.
    pub ior: f32,
    /// Share of glass in what is no metal, 0 to 1.
    pub transmission: f32,
    /// Red channel, linear.
    pub transmission_texture: Option<TextureUse>,
    /// What glass encloses; without it glass is a thin pane that bends no ray.
    pub volume: Option<Volume>,
    /// Shows its base color as it is, as radiance to whatever looks at it: the camera, mirrors, and other surfaces,
    /// which it so lights.
    pub unlit: bool,
}

/// What fills a body of glass. The body must be closed and stand in air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volume {
    /// White light has `attenuation_color` left after this many meters (in world units); infinity: clear.
    pub attenuation_distance_m: f32,
    /// Linear RGB, each above 0 and at most 1.
    pub attenuation_color: [f32; 3],
}

/// What the alpha of the base color means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Nothing.
    #[default]
    Opaque,
    /// A hole where alpha is below this.
    Mask(f32),
    /// The share of rays that meet the surface; the others pass.
    Blend,
}

/// A tangent-space normal map: (2 r - 1, 2 g - 1) times `scale` along the directions in which the texture coordinates
/// u and -v grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalMap {
    /// Linear RGB.
    pub texture: TextureUse,
    /// Strength of the relief.
    pub scale: f32,
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TextureUse {
    /// Index into [`crate::Scene::textures`].
    pub texture: usize,
    /// Which texture coordinates of the mesh: 0 or 1.
    pub set: usize,
    /// Applied to the coordinates.
    pub transform: TextureTransform,
}

impl TextureUse {
    /// The texture with the first coordinates as they are.
    #[must_use]
    pub fn new(texture: usize) -> Self {
        Self { texture, ..Self::default() }
    }
}

/// KHR_texture_transform: scale (w, h) first, then a turn by the angle r, then the offset (x, y):
/// u' = w u cos r + h v sin r + x, v' = h v cos r - w u sin r + y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureTransform {
    /// Added last.
    pub offset: [f32; 2],
    /// Turns the coordinates counter-clockwise as one sees them (v runs downward), rad.
    pub rotation_rad: f32,
    /// Multiplies first.
    pub scale: [f32; 2],
}

impl TextureTransform {
    /// Changes nothing.
    pub const IDENTITY: Self = Self { offset: [0.0; 2], rotation_rad: 0.0, scale: [1.0; 2] };
}

impl Default for TextureTransform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl Default for Material {
    /// White Lambert: no metal, no gloss, no glass, no glow. (The defaults of a glTF *file* are others.)
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
    /// All textures that the material uses.
    pub(crate) fn textures(&self) -> impl Iterator<Item = (&'static str, TextureUse)> {
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
