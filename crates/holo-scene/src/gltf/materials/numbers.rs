//! What all parts of a material read: numbers from 0 to 1, uses of textures.

use super::super::extensions::TEXTURE_TRANSFORM;
use super::super::json::Object;
use super::super::warnings::Warnings;
use crate::{Error, NormalMap, TextureInfo, TextureTransform};

/// The maximum index of refraction: a reflectance of 99.6 % at normal incidence.
pub(super) const MAX_IOR: f32 = 1000.0;

/// Reads numbers from 0 to 1. Exporters write numbers beyond, such as 1.0000001, which are clamped as in other loaders.
#[derive(Default)]
pub(super) struct Shares {
    clamped: bool,
}

impl Shares {
    pub(super) fn one(&mut self, object: &Object<'_>, key: &str) -> Result<Option<f32>, Error> {
        Ok(object.number(key)?.map(|x| self.clamp(x)))
    }

    pub(super) fn all<const N: usize>(&mut self, object: &Object<'_>, key: &str) -> Result<Option<[f32; N]>, Error> {
        Ok(object.numbers::<N>(key)?.map(|numbers| numbers.map(|x| self.clamp(x))))
    }

    fn clamp(&mut self, x: f64) -> f32 {
        let clamped = x.clamp(0.0, 1.0);
        // An error of single precision deserves no warning.
        self.clamped |= (clamped - x).abs() > f64::from(f32::EPSILON);
        clamped as f32
    }

    pub(super) fn note(&self, place: impl Fn() -> String, warnings: &mut Warnings) {
        if self.clamped {
            warnings.note("factors outside of the range 0 to 1 are clamped", place);
        }
    }
}

/// A normal map with its scale.
pub(super) fn normal_map(object: &Object<'_>, key: &str, texture_count: usize) -> Result<Option<NormalMap>, Error> {
    let Some(texture) = texture_use(object, key, texture_count)? else { return Ok(None) };
    let map = object.object(key)?;
    let scale = map.map(|map| map.within("scale", f32::MIN..=f32::MAX)).transpose()?.flatten();
    Ok(Some(NormalMap { texture, scale: scale.unwrap_or(1.0) }))
}

/// A texture reference of a material.
pub(super) fn texture_use(object: &Object<'_>, key: &str, texture_count: usize) -> Result<Option<TextureInfo>, Error> {
    let Some(info) = object.object(key)? else { return Ok(None) };
    let texture = info.index("index", "textures", texture_count)?.ok_or_else(|| info.missing("index"))?;
    let mut set = info.unsigned("texCoord")?;
    let mut transform = TextureTransform::IDENTITY;
    if let Some(extension) = info.extension(TEXTURE_TRANSFORM)? {
        let finite = f32::MIN..=f32::MAX;
        transform = TextureTransform {
            offset: extension.all_within("offset", finite.clone())?.unwrap_or(transform.offset),
            rotation_rad: extension.within("rotation", finite.clone())?.unwrap_or(transform.rotation_rad),
            scale: extension.all_within("scale", finite)?.unwrap_or(transform.scale),
        };
        // The extension may override the texture coordinate set.
        set = extension.unsigned("texCoord")?.or(set);
    }
    let set = usize::try_from(set.unwrap_or(0)).unwrap_or(usize::MAX);
    Ok(Some(TextureInfo { texture, set, transform }))
}
