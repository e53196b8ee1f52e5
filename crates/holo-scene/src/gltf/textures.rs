//! Images and samplers: PNG, JPEG and WebP, embedded or external, decoded to 8 bits per channel.
//!
//! A texture whose image is missing, of another format or damaged is left out with a warning, as other loaders do. A
//! texture may have two images: one in `EXT_texture_webp` or `KHR_texture_basisu`, and a fallback in `source`, which is
//! used if the first one cannot be decoded. KTX2 images never can.
//!
//! 16-bit images are rounded to 8 bits, because [`Texture`] has 8-bit codes. Color profiles and gamma chunks are
//! ignored, as required by glTF.

mod image_format;
mod source;

use rayon::prelude::*;

use self::source::{Decoded, Source};
use super::Limits;
use super::buffer_views::BufferViews;
use super::container::Files;
use super::extensions::{TEXTURE_BASISU, TEXTURE_WEBP};
use super::json::{Object, bad};
use super::panic_guard;
use super::uri::shorten;
use super::warnings::Warnings;
use crate::Error;
use crate::{Filter, Texture, Wrap};

/// The textures of the scene, and for each texture of the file, and after them each derived one, its index (`None`: not
/// needed, or without an image).
pub(super) struct Textures {
    pub(super) textures: Vec<Texture>,
    pub(super) index: Vec<Option<usize>>,
}

/// A texture that is computed from another one: the roughness of `KHR_materials_pbrSpecularGlossiness`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Derived {
    /// The texture of the file whose alpha is the glossiness.
    pub(super) source: usize,
    /// The factor of the glossiness, 0 to 1.
    pub(super) glossiness: f32,
}

impl Derived {
    /// Roughness in the green channel: 1 - factor * glossiness.
    fn apply(self, texels: &mut [[u8; 4]]) {
        let roughness = |code: u8| (255.0 - self.glossiness * f32::from(code)).round() as u8;
        texels.iter_mut().for_each(|texel| *texel = [0, roughness(texel[3]), 0, 255]);
    }
}

struct Plan<'f> {
    /// The JSON path of the texture; that of its source for a derived one.
    at: String,
    name: &'f str,
    /// Images of the file, the preferred one first.
    candidates: Vec<usize>,
    wrap: [Wrap; 2],
    filter: Filter,
    derived: Option<Derived>,
}

/// Decodes those textures for which `needed` is true, and the derived ones.
pub(super) fn load(
    root: &Object<'_>,
    (buffer_views, files): (&BufferViews<'_>, &Files),
    needed: &[bool],
    derived: &[Derived],
    limits: &Limits,
    warnings: &mut Warnings,
) -> Result<Textures, Error> {
    let images = root.objects("images")?;
    let samplers = root.objects("samplers")?;
    let textures = root.objects("textures")?;
    let of_file = (0..needed.len()).map(|k| (k, needed[k].then_some(k), None));
    let after = derived.iter().enumerate().map(|(k, derived)| (needed.len() + k, Some(derived.source), Some(*derived)));
    let (mut plans, mut numbers) = (Vec::new(), Vec::new());
    for (number, source, derived) in of_file.chain(after) {
        let Some(texture) = source.and_then(|source| textures.get(source)) else { continue };
        if let Some(plan) = plan(texture, &images, &samplers, derived)? {
            plans.push(plan);
            numbers.push(number);
        } else {
            warnings.note("the texture has no image: drawn without it", || texture.path().to_owned());
        }
    }
    let choices =
        Images { images: &images, buffer_views, files, max_pixels: limits.max_texture_pixels }.decode(&plans)?;
    choices.note_failures(&plans, &images, warnings);
    let mut index = vec![None; needed.len() + derived.len()];
    let mut loaded = Vec::new();
    for (number, texture) in numbers.into_iter().zip(choices.into_textures(&plans)) {
        let Some(texture) = texture else { continue };
        index[number] = Some(loaded.len());
        loaded.push(texture);
    }
    Ok(Textures { textures: loaded, index })
}

/// `None` for a texture without an image.
fn plan<'f>(
    texture: &Object<'f>,
    images: &[Object<'f>],
    samplers: &[Object<'f>],
    derived: Option<Derived>,
) -> Result<Option<Plan<'f>>, Error> {
    let mut candidates = Vec::new();
    for name in [TEXTURE_WEBP, TEXTURE_BASISU] {
        if let Some(extension) = texture.extension(name)? {
            candidates.extend(extension.index("source", "images", images.len())?);
        }
    }
    candidates.extend(texture.index("source", "images", images.len())?);
    let Some(&first) = candidates.first() else { return Ok(None) };
    let name = match texture.name()? {
        "" => images[first].name()?,
        name => name,
    };
    let (wrap, filter) = match texture.index("sampler", "samplers", samplers.len())? {
        Some(sampler) => (wrap_modes(&samplers[sampler])?, filter(&samplers[sampler])?),
        None => ([Wrap::Repeat; 2], Filter::Linear),
    };
    Ok(Some(Plan { at: texture.path().to_owned(), name, candidates, wrap, filter, derived }))
}

/// The images of a file and how many pixels they may have.
struct Images<'i, 'f> {
    images: &'i [Object<'f>],
    buffer_views: &'i BufferViews<'f>,
    files: &'i Files,
    max_pixels: u64,
}

/// The decoded images, and which of its candidates each texture uses (their number if it uses none).
struct Choices {
    decoded: Vec<Option<Result<Decoded, String>>>,
    chosen: Vec<usize>,
}

impl Images<'_, '_> {
    /// Decodes the preferred image of every texture, then the fallbacks of those that cannot be decoded.
    fn decode(&self, plans: &[Plan<'_>]) -> Result<Choices, Error> {
        let mut decoded: Vec<Option<Result<Decoded, String>>> = self.images.iter().map(|_| None).collect();
        let mut chosen = vec![0; plans.len()];
        let mut pixels_left = self.max_pixels;
        loop {
            let mut next: Vec<usize> = Vec::new();
            for (plan, chosen) in plans.iter().zip(&mut chosen) {
                while plan.candidates.get(*chosen).is_some_and(|&image| matches!(decoded[image], Some(Err(_)))) {
                    *chosen += 1;
                }
                next.extend(plan.candidates.get(*chosen).filter(|&&image| decoded[image].is_none()));
            }
            if next.is_empty() {
                break;
            }
            // Textures that share an image decode it once.
            next.sort_unstable();
            next.dedup();
            let mut sources = Vec::new();
            for k in next {
                match Source::new(&self.images[k], self.buffer_views, self.files)? {
                    Ok(source) => {
                        pixels_left = self.count(pixels_left, k, (source.width as usize, source.height as usize))?;
                        sources.push((k, source));
                    }
                    Err(why) => decoded[k] = Some(Err(why)),
                }
            }
            let done: Vec<_> =
                sources.into_par_iter().map(|(k, source)| (k, panic_guard::guarded(|| source.decode()))).collect();
            done.into_iter().for_each(|(k, result)| decoded[k] = Some(result));
        }
        // Each texture has its own copy of its image.
        let mut pixels_left = self.max_pixels;
        for (plan, &chosen) in plans.iter().zip(&chosen) {
            let Some(&image) = plan.candidates.get(chosen) else { continue };
            if let Some(Ok(Decoded { width, height, .. })) = decoded[image] {
                pixels_left = self.count(pixels_left, image, (width, height))?;
            }
        }
        Ok(Choices { decoded, chosen })
    }

    /// How many pixels are left after an image.
    fn count(&self, left: u64, image: usize, (width, height): (usize, usize)) -> Result<u64, Error> {
        left.checked_sub((width as u64).saturating_mul(height as u64)).ok_or_else(|| {
            let most = self.max_pixels;
            let what = format!("with its {width} x {height} pixels the textures exceed the limit of {most} pixels");
            bad(self.images[image].path(), what)
        })
    }
}

impl Choices {
    /// Warns of images that were not decoded: of textures without another image, and of fallbacks.
    fn note_failures(&self, plans: &[Plan<'_>], images: &[Object<'_>], warnings: &mut Warnings) {
        for (plan, &chosen) in plans.iter().zip(&self.chosen).filter(|(plan, _)| plan.derived.is_none()) {
            let Some(&first) = plan.candidates.first().filter(|_| chosen > 0) else { continue };
            let Some(Err(why)) = &self.decoded[first] else { continue };
            let outcome = if chosen < plan.candidates.len() { "its fallback is used" } else { "drawn without it" };
            warnings.note(&format!("{why}: {outcome}"), || {
                let file = images[first].string("uri").ok().flatten().filter(|uri| !uri.starts_with("data:"));
                let file = file.map(|uri| format!(" '{}'", shorten(uri))).unwrap_or_default();
                format!("{} ({}{file})", plan.at, images[first].path())
            });
        }
    }

    fn into_textures(self, plans: &[Plan<'_>]) -> Vec<Option<Texture>> {
        let Self { mut decoded, chosen } = self;
        let image = |k: usize| plans[k].candidates.get(chosen[k]).copied();
        let mut uses = vec![0_usize; decoded.len()];
        (0..plans.len()).filter_map(image).for_each(|image| uses[image] += 1);
        let mut textures = Vec::with_capacity(plans.len());
        for (k, plan) in plans.iter().enumerate() {
            let taken = image(k).and_then(|image| {
                uses[image] -= 1;
                // The last use of an image takes it without copying.
                if uses[image] == 0 { decoded[image].take() } else { decoded[image].clone() }
            });
            textures.push(taken.and_then(Result::ok).map(|Decoded { width, height, mut texels }| {
                if let Some(derived) = plan.derived {
                    derived.apply(&mut texels);
                }
                let [wrap_u, wrap_v] = plan.wrap;
                Texture { name: plan.name.to_owned(), width, height, texels, wrap_u, wrap_v, filter: plan.filter }
            }));
        }
        textures
    }
}

fn wrap_modes(sampler: &Object<'_>) -> Result<[Wrap; 2], Error> {
    let wrap = |key: &str| match sampler.unsigned(key)? {
        None | Some(10497) => Ok(Wrap::Repeat),
        Some(33071) => Ok(Wrap::Clamp),
        Some(33648) => Ok(Wrap::Mirror),
        Some(other) => Err(bad(sampler.at(key), format!("is {other}, which is no wrap mode of glTF"))),
    };
    Ok([wrap("wrapS")?, wrap("wrapT")?])
}

/// The filter for magnification; there are no mipmaps, so that for minification does not matter.
fn filter(sampler: &Object<'_>) -> Result<Filter, Error> {
    Ok(if sampler.unsigned("magFilter")? == Some(9728) { Filter::Nearest } else { Filter::Linear })
}
