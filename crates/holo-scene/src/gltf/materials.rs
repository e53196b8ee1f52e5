//! The materials of the scene: what the file says of each, which textures and texture coordinates they need.

mod surface;

use serde_json::Value;

use super::json::Object;
use super::uri::shorten;
use super::warnings::Warnings;
use crate::Error;
use crate::{Material, NormalMap, TextureUse};

/// Materials before their textures are loaded.
pub(super) struct Materials {
    /// Their textures are numbered as in the *file* until [`Materials::finish`].
    pub(super) materials: Vec<Material>,
    /// For each material what its primitives have to bring.
    pub(super) coordinate_sets: Vec<CoordinateSets>,
    /// For each texture of the file whether it has to be decoded.
    pub(super) needed_textures: Vec<bool>,
}

/// The two sets of texture coordinates of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct CoordinateSets {
    /// The `n` of `TEXCOORD_n` in the file.
    pub(super) numbers: [usize; 2],
    /// Whether a texture of the material reads them.
    pub(super) wanted: [bool; 2],
}

impl CoordinateSets {
    /// Those of a material without textures.
    const UNUSED: Self = Self { numbers: [0, 1], wanted: [false; 2] };
}

/// Reads all materials.
pub(super) fn load(root: &Object<'_>, warnings: &mut Warnings) -> Result<Materials, Error> {
    let texture_count = root.list("textures")?.len();
    let mut all = Materials { materials: Vec::new(), coordinate_sets: Vec::new(), needed_textures: Vec::new() };
    let mut read = vec![false; texture_count];
    let mut mentioned = vec![false; texture_count];
    for (k, material) in root.objects("materials")?.iter().enumerate() {
        let name = material.name()?;
        let place = || format!("materials[{k}] '{}'", shorten(name));
        let mut loaded = surface::read(material, name, texture_count, place, warnings)?;
        all.coordinate_sets.push(choose_sets(&mut loaded, place, warnings));
        loaded.textures().for_each(|(_, used)| read[used.texture] = true);
        note_textures(material, &mut mentioned);
        all.materials.push(loaded);
    }
    // Not needed are those that only serve what we do not model; textures that nothing refers to are kept as they are
    // in the file.
    all.needed_textures = read.iter().zip(&mentioned).map(|(&read, &mentioned)| read || !mentioned).collect();
    Ok(all)
}

impl Materials {
    /// The index of the material of primitives that have none.
    pub(super) fn default_material(&mut self) -> usize {
        self.materials.push(surface::standard("default"));
        self.coordinate_sets.push(CoordinateSets::UNUSED);
        self.materials.len() - 1
    }

    /// Puts the textures of the scene in place of those of the file.
    pub(super) fn finish(self, index: &[Option<usize>]) -> Vec<Material> {
        let mut materials = self.materials;
        for material in &mut materials {
            change_textures(material, |used| {
                let texture = index.get(used.texture).copied().flatten()?;
                Some(TextureUse { texture, ..used })
            });
        }
        materials
    }
}

/// Decides which sets of the file become the two of a mesh, and numbers the textures' sets by that. Sets 0 and 1 stay
/// what they are; others take the places that the material leaves free.
fn choose_sets(material: &mut Material, place: impl Fn() -> String, warnings: &mut Warnings) -> CoordinateSets {
    let mut wanted: Vec<usize> = material.textures().map(|(_, used)| used.set).collect();
    wanted.sort_unstable();
    wanted.dedup();
    let mut sets = [0, 1].map(|set| wanted.contains(&set).then_some(set));
    for &set in wanted.iter().filter(|&&set| set > 1) {
        match sets.iter_mut().find(|free| free.is_none()) {
            Some(free) => *free = Some(set),
            None => warnings.note("its textures read more than two sets of coordinates: drawn with two", &place),
        }
    }
    change_textures(material, |used| {
        let set = sets.iter().position(|&set| set == Some(used.set))?;
        Some(TextureUse { set, ..used })
    });
    let [first, second] = sets;
    CoordinateSets { numbers: [first.unwrap_or(0), second.unwrap_or(1)], wanted: [first.is_some(), second.is_some()] }
}

/// Replaces every texture of a material, or removes it.
fn change_textures(material: &mut Material, change: impl Fn(TextureUse) -> Option<TextureUse>) {
    for used in [
        &mut material.base_color_texture,
        &mut material.metallic_roughness_texture,
        &mut material.emission_texture,
        &mut material.specular_texture,
        &mut material.specular_color_texture,
        &mut material.transmission_texture,
    ] {
        *used = used.and_then(&change);
    }
    let map = material.normal_map;
    material.normal_map = map.and_then(|map| Some(NormalMap { texture: change(map.texture)?, ..map }));
}

/// Marks the textures that a material refers to for anything.
fn note_textures(material: &Object<'_>, mentioned: &mut [bool]) {
    fn mark(value: &Value, is_texture: bool, mentioned: &mut [bool]) {
        let Value::Object(map) = value else { return };
        let index = map.get("index").and_then(Value::as_u64).and_then(|index| usize::try_from(index).ok());
        if let Some(mentioned) = index.filter(|_| is_texture).and_then(|index| mentioned.get_mut(index)) {
            *mentioned = true;
        }
        map.iter().for_each(|(key, value)| mark(value, key.ends_with("Texture"), mentioned));
    }
    material.each(|key, value| mark(value, key.ends_with("Texture"), mentioned));
}
