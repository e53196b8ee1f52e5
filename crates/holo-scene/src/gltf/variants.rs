//! `KHR_materials_variants`: several materials for a primitive, chosen by name.

use super::extensions::VARIANTS;
use super::json::{Object, bad};
use super::uri::shorten;
use crate::Error;

/// The names of the variants of a file, in its order.
pub(super) fn names(root: &Object<'_>) -> Result<Vec<String>, Error> {
    let Some(extension) = root.extension(VARIANTS)? else { return Ok(Vec::new()) };
    extension.objects("variants")?.iter().map(|variant| Ok(variant.name()?.to_owned())).collect()
}

/// The index of the variant with this name.
///
/// # Errors
/// No variant with this name.
pub(super) fn choose(names: &[String], wanted: Option<&str>) -> Result<Option<usize>, Error> {
    let Some(wanted) = wanted else { return Ok(None) };
    names.iter().position(|name| name == wanted).map(Some).ok_or_else(|| {
        let known: Vec<String> = names.iter().map(|name| format!("'{}'", shorten(name))).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        bad(VARIANTS, format!("there is no material variant '{}'; the file has {known}", shorten(wanted)))
    })
}

/// The material of a primitive in a variant; its own one if the variant has none for it.
pub(super) fn material(
    primitive: &Object<'_>,
    variant: Option<usize>,
    material_count: usize,
) -> Result<Option<usize>, Error> {
    let own = primitive.index("material", "materials", material_count)?;
    let (Some(variant), Some(extension)) = (variant, primitive.extension(VARIANTS)?) else { return Ok(own) };
    for mapping in extension.objects("mappings")? {
        if mapping.indices("variants", "variants", usize::MAX)?.contains(&variant) {
            let material = mapping.index("material", "materials", material_count)?;
            return material.map(Some).ok_or_else(|| mapping.missing("material"));
        }
    }
    Ok(own)
}
