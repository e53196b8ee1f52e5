//! Features of materials.

/// The features of a material beyond a base color.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct MaterialFlags(u8);

impl MaterialFlags {
    /// Metal, transmission, a specular coat or layers.
    pub const GLOSSY: Self = Self(1);
    /// Emission.
    pub const EMISSIVE: Self = Self(2);
    /// The base color is shown without lighting.
    pub const UNLIT: Self = Self(4);
    /// A normal map.
    pub const NORMAL_MAP: Self = Self(8);
    /// A body of glass.
    pub const VOLUME: Self = Self(16);
    /// Alpha other than opaque.
    pub const ALPHA: Self = Self(32);
    /// Layers and lobes of [`crate::material::bsdf::layered`].
    pub const LAYERED: Self = Self(64);
    /// Alpha that lets a part of the rays pass.
    pub const BLEND: Self = Self(128);

    #[inline(always)]
    pub const fn has(self, flag: Self) -> bool {
        self.0 & flag.0 != 0
    }

    #[inline(always)]
    pub const fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}
