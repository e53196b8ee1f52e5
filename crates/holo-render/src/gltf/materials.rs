//! Materials: so far the base colour of a two-sided Lambertian surface, and warnings about everything else.

use serde_json::Value;

use super::extensions::SPECULAR;
use super::json::{Object, bad};
use super::uri::shorten;
use super::warnings::Warnings;
use crate::Error;
use crate::scene::{Material, TextureUse};

/// Materials before their textures are loaded.
pub(super) struct Materials {
    /// `base_color_texture` refers to the textures of the *file* until [`Materials::finish`].
    pub(super) materials: Vec<Material>,
    /// For each material the set of texture coordinates that its base colour texture wants.
    pub(super) coordinate_set: Vec<u64>,
    /// For each texture of the file whether it has to be decoded.
    pub(super) needed_textures: Vec<bool>,
}

/// Reads all materials.
pub(super) fn load(root: &Object<'_>, warnings: &mut Warnings) -> Result<Materials, Error> {
    let texture_count = root.list("textures")?.len();
    let mut all = Materials { materials: Vec::new(), coordinate_set: Vec::new(), needed_textures: Vec::new() };
    let mut base_color = vec![false; texture_count];
    let mut elsewhere = vec![false; texture_count];
    for (k, material) in root.objects("materials")?.iter().enumerate() {
        let name = material.name()?;
        warn(material, || format!("materials[{k}] '{}'", shorten(name)), warnings)?;
        let mut loaded = Material { name: name.to_owned(), ..Material::default() };
        let mut coordinate_set = 0;
        if let Some(surface) = material.object("pbrMetallicRoughness")? {
            if let Some(color) = surface.numbers::<4>("baseColorFactor")? {
                if color.iter().any(|c| !(0.0..=1.0).contains(c)) {
                    return Err(bad(surface.at("baseColorFactor"), "must lie between 0 and 1"));
                }
                loaded.base_color = color.map(|c| c as f32);
            }
            if let Some(texture) = surface.object("baseColorTexture")? {
                let index = texture.index("index", "textures", texture_count)?;
                let index = index.ok_or_else(|| texture.missing("index"))?;
                base_color[index] = true;
                loaded.base_color_texture = Some(TextureUse::new(index));
                coordinate_set = texture.unsigned("texCoord")?.unwrap_or(0);
            }
        }
        note_textures(material, &mut elsewhere);
        all.materials.push(loaded);
        all.coordinate_set.push(coordinate_set);
    }
    // Normal maps and their like are not read yet; textures that nothing refers to are kept as they are in the file.
    all.needed_textures = base_color.iter().zip(&elsewhere).map(|(&base, &other)| base || !other).collect();
    Ok(all)
}

impl Materials {
    /// The index of the material of primitives that have none.
    pub(super) fn default_material(&mut self) -> usize {
        self.materials.push(Material { name: "default".into(), ..Material::default() });
        self.coordinate_set.push(0);
        self.materials.len() - 1
    }

    /// Puts the textures of the scene in place of those of the file.
    pub(super) fn finish(self, index: &[Option<usize>]) -> Vec<Material> {
        let mut materials = self.materials;
        for material in &mut materials {
            let texture = material.base_color_texture.and_then(|used| index.get(used.texture).copied().flatten());
            material.base_color_texture = texture.map(TextureUse::new);
        }
        materials
    }
}

/// Marks the textures that a material uses for anything, its base colour included (that is undone by the caller).
fn note_textures(material: &Object<'_>, used: &mut [bool]) {
    fn mark(value: &Value, is_texture: bool, used: &mut [bool]) {
        let Value::Object(map) = value else { return };
        let index = map.get("index").and_then(Value::as_u64).and_then(|index| usize::try_from(index).ok());
        if let Some(used) = index.filter(|_| is_texture).and_then(|index| used.get_mut(index)) {
            *used = true;
        }
        map.iter().for_each(|(key, value)| mark(value, key.ends_with("Texture"), used));
    }
    material.each(|key, value| mark(value, key.ends_with("Texture"), used));
}

/// Notes what makes a material other than Lambertian, opaque and dark.
fn warn(material: &Object<'_>, place: impl Fn() -> String, warnings: &mut Warnings) -> Result<(), Error> {
    let surface = material.object("pbrMetallicRoughness")?;
    let factor = |object: &Option<Object<'_>>, key: &str, default: f64| {
        let value = object.as_ref().map(|object| object.number(key)).transpose()?.flatten();
        Ok::<f64, Error>(value.unwrap_or(default))
    };
    let specular = material.extension(SPECULAR)?;
    let gloss = match &specular {
        Some(_) => factor(&specular, "specularFactor", 1.0)?,
        None => 1.0,
    };
    let metallic = factor(&surface, "metallicFactor", 1.0)?;
    let unlit = material.extension("KHR_materials_unlit")?.is_some();
    if metallic > 0.0 && !unlit {
        warnings.note("metal (metallicFactor above 0) is shaded as Lambertian", &place);
    } else if gloss > 0.0 && !unlit {
        warnings.note("the gloss of a dielectric is not modelled: shaded as Lambertian", &place);
    }
    if material.numbers::<3>("emissiveFactor")?.is_some_and(|factor| factor.iter().any(|&c| c > 0.0)) {
        warnings.note("emitted light is not modelled: the surface is dark where no light falls on it", &place);
    }
    if material.has("normalTexture") {
        warnings.note("normal maps are not modelled: the surface is smooth", &place);
    }
    if material.string("alphaMode")?.is_some_and(|mode| mode != "OPAQUE") {
        warnings.note("transparency (alphaMode) is not modelled: the surface is opaque", &place);
    }
    Ok(())
}
