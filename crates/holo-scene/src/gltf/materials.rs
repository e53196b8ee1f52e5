//! The materials of the file, with the textures and texture coordinate sets that they need.

mod layers;
mod numbers;
mod specular_glossiness;
mod surface;

use serde_json::Value;

use super::extensions::SPECULAR_GLOSSINESS;
use super::json::Object;
use super::textures::Derived;
use super::uri::shorten;
use super::warnings::Warnings;
use crate::Error;
use crate::{Material, TextureInfo};

/// Materials before their textures are loaded.
pub(super) struct Materials {
    /// Texture indices refer to the *file* until [`Materials::finish`].
    pub(super) materials: Vec<Material>,
    /// For each material the texture coordinate sets that its primitives must have.
    pub(super) coordinate_sets: Vec<CoordinateSets>,
    /// For each texture of the file whether it must be decoded.
    pub(super) needed_textures: Vec<bool>,
    /// Textures that are computed from others; their numbers follow those of the file.
    pub(super) derived_textures: Vec<Derived>,
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
    /// The sets of a material without textures.
    const UNUSED: Self = Self { numbers: [0, 1], wanted: [false; 2] };
}

/// Reads all materials.
pub(super) fn load(root: &Object<'_>, warnings: &mut Warnings) -> Result<Materials, Error> {
    let texture_count = root.list("textures")?.len();
    let mut all = Materials {
        materials: Vec::new(),
        coordinate_sets: Vec::new(),
        needed_textures: Vec::new(),
        derived_textures: Vec::new(),
    };
    let mut read = vec![false; texture_count];
    let mut mentioned = vec![false; texture_count];
    for (k, material) in root.objects("materials")?.iter().enumerate() {
        let name = material.name()?;
        let place = || format!("materials[{k}] '{}'", shorten(name));
        let mut loaded = surface::read(material, name, texture_count, place, warnings)?;
        if let Some(extension) = material.extension(SPECULAR_GLOSSINESS)? {
            let derived = specular_glossiness::read(&extension, texture_count, &mut loaded, place, warnings)?;
            if let Some(derived) = derived {
                let number = texture_count + all.derived(derived);
                loaded.metallic_roughness_texture =
                    loaded.specular_color_texture.map(|used| TextureInfo { texture: number, ..used });
            }
        }
        all.coordinate_sets.push(choose_sets(&mut loaded, place, warnings));
        loaded.textures().for_each(|(_, used)| read.get_mut(used.texture).into_iter().for_each(|read| *read = true));
        note_textures(material, &mut mentioned);
        all.materials.push(loaded);
    }
    // Textures that only unsupported features use are not decoded; textures without any reference are.
    all.needed_textures = read.iter().zip(&mentioned).map(|(&read, &mentioned)| read || !mentioned).collect();
    Ok(all)
}

impl Materials {
    /// The number of a derived texture among the derived ones.
    fn derived(&mut self, derived: Derived) -> usize {
        self.derived_textures.iter().position(|known| *known == derived).unwrap_or_else(|| {
            self.derived_textures.push(derived);
            self.derived_textures.len() - 1
        })
    }

    /// Adds the default material for primitives without a material; returns its index.
    pub(super) fn default_material(&mut self) -> usize {
        self.materials.push(surface::standard("default"));
        self.coordinate_sets.push(CoordinateSets::UNUSED);
        self.materials.len() - 1
    }

    /// Replaces texture indices of the file by those of the scene.
    pub(super) fn finish(self, index: &[Option<usize>]) -> Vec<Material> {
        let mut materials = self.materials;
        let of_file = self.needed_textures.len();
        for material in &mut materials {
            // Without the image the whole surface has the glossiness of the factor.
            let roughness = material.metallic_roughness_texture.map(|used| used.texture);
            if let Some(number) = roughness.filter(|&number| index.get(number).copied().flatten().is_none())
                && let Some(derived) = number.checked_sub(of_file).and_then(|k| self.derived_textures.get(k))
            {
                material.roughness = 1.0 - derived.glossiness;
            }
            material.each_texture(|_, used| {
                let used = used?;
                let texture = index.get(used.texture).copied().flatten()?;
                Some(TextureInfo { texture, ..used })
            });
        }
        materials
    }
}

/// Selects the two texture coordinate sets of a mesh, and renumbers the sets of the textures. Sets 0 and 1 keep their
/// numbers; other sets get the numbers that are free.
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
    material.each_texture(|_, used| {
        let used = used?;
        let set = sets.iter().position(|&set| set == Some(used.set))?;
        Some(TextureInfo { set, ..used })
    });
    let [first, second] = sets;
    CoordinateSets { numbers: [first.unwrap_or(0), second.unwrap_or(1)], wanted: [first.is_some(), second.is_some()] }
}

/// Marks all textures that a material refers to.
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
