//! Images and samplers: PNG and JPEG, embedded or external, decoded to 8 bits per channel.
//!
//! 16-bit images are rounded to 8 bits, because [`Texture`] has 8-bit codes. Color profiles and gamma chunks are
//! ignored, as required by glTF.

use std::borrow::Cow;
use std::io::Cursor;

use image::{ImageFormat, ImageReader};
use rayon::prelude::*;

use super::Limits;
use super::buffer_views::BufferViews;
use super::container::Files;
use super::json::{Object, bad, unsupported};
use super::panic_guard;
use super::warnings::Warnings;
use crate::Error;
use crate::{Texture, Wrap};

/// The textures of the scene, and for each texture of the file its index (`None`: not needed, or without an image).
pub(super) struct Textures {
    pub(super) textures: Vec<Texture>,
    pub(super) index: Vec<Option<usize>>,
}

struct Plan {
    name: String,
    image: usize,
    wrap: [Wrap; 2],
}

struct Decoded {
    width: usize,
    height: usize,
    texels: Vec<[u8; 4]>,
}

/// Decodes those textures for which `needed` is true.
pub(super) fn load(
    root: &Object<'_>,
    buffer_views: &BufferViews<'_>,
    files: &Files,
    needed: &[bool],
    limits: &Limits,
    warnings: &mut Warnings,
) -> Result<Textures, Error> {
    let images = root.objects("images")?;
    let samplers = root.objects("samplers")?;
    let mut plans = Vec::new();
    let mut index = vec![None; needed.len()];
    for (k, texture) in root.objects("textures")?.iter().enumerate().filter(|&(k, _)| needed.get(k) == Some(&true)) {
        let Some(image) = texture.index("source", "images", images.len())? else {
            // The image is in an extension (KTX2, WebP), or there is none; the specification allows rendering without
            // it.
            warnings.note("the texture has no PNG or JPEG image: drawn without it", || texture.path().to_owned());
            continue;
        };
        let name = match texture.name()? {
            "" => images[image].name()?,
            name => name,
        };
        let wrap = match texture.index("sampler", "samplers", samplers.len())? {
            Some(sampler) => wrap_modes(&samplers[sampler], warnings)?,
            None => [Wrap::Repeat; 2],
        };
        index[k] = Some(plans.len());
        plans.push(Plan { name: name.to_owned(), image, wrap });
    }
    let textures = decode_all(&plans, &images, buffer_views, files, limits)?;
    Ok(Textures { textures, index })
}

fn decode_all(
    plans: &[Plan],
    images: &[Object<'_>],
    buffer_views: &BufferViews<'_>,
    files: &Files,
    limits: &Limits,
) -> Result<Vec<Texture>, Error> {
    // Textures that share an image decode it once; each has its own copy.
    let mut uses = vec![0_usize; images.len()];
    plans.iter().for_each(|plan| uses[plan.image] += 1);
    let mut sources = Vec::new();
    let mut pixels_left = limits.max_texture_pixels;
    for (image, &count) in images.iter().zip(&uses).filter(|&(_, &count)| count > 0) {
        let source = Source::new(image, buffer_views, files)?;
        let pixels = (source.width as u64).saturating_mul(source.height as u64).saturating_mul(count as u64);
        pixels_left = pixels_left.checked_sub(pixels).ok_or_else(|| {
            let what = format!(
                "with its {} x {} pixels the textures exceed the limit of {} pixels",
                source.width, source.height, limits.max_texture_pixels
            );
            bad(image.path(), what)
        })?;
        sources.push(source);
    }
    let decoded: Vec<Decoded> =
        sources.into_par_iter().map(|source| panic_guard::guarded(|| source.decode())).collect::<Result<_, Error>>()?;

    let mut by_image = vec![None; images.len()];
    let used = uses.iter().enumerate().filter(|&(_, &count)| count > 0).map(|(image, _)| image);
    used.zip(decoded).for_each(|(image, decoded)| by_image[image] = Some(decoded));
    let mut textures = Vec::with_capacity(plans.len());
    for plan in plans {
        uses[plan.image] -= 1;
        // The last use of an image takes it without copying.
        let decoded = if uses[plan.image] == 0 { by_image[plan.image].take() } else { by_image[plan.image].clone() };
        let Some(Decoded { width, height, texels }) = decoded else {
            return Err(bad(images[plan.image].path(), "was not decoded"));
        };
        let [wrap_u, wrap_v] = plan.wrap;
        textures.push(Texture { name: plan.name.clone(), width, height, texels, wrap_u, wrap_v });
    }
    Ok(textures)
}

impl Clone for Decoded {
    fn clone(&self) -> Self {
        Self { width: self.width, height: self.height, texels: self.texels.clone() }
    }
}

/// An encoded image of known size.
struct Source<'v> {
    at: String,
    bytes: Cow<'v, [u8]>,
    format: ImageFormat,
    width: u32,
    height: u32,
}

impl<'v> Source<'v> {
    fn new(image: &Object<'_>, buffer_views: &'v BufferViews<'_>, files: &Files) -> Result<Self, Error> {
        let bytes = match (image.index("bufferView", "bufferViews", buffer_views.len())?, image.string("uri")?) {
            (Some(view), _) => Cow::Borrowed(buffer_views.get(view)?.bytes),
            (None, Some(uri)) => Cow::Owned(files.fetch(uri, &image.at("uri"))?),
            (None, None) => return Err(bad(image.path(), "has neither bufferView nor uri")),
        };
        // Declared MIME types are often wrong; the first bytes decide.
        let format = match image::guess_format(&bytes) {
            Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) => format,
            Ok(other) => {
                return Err(unsupported(
                    image.path(),
                    format!("the image format {other:?} (convert it to PNG or JPEG)"),
                ));
            }
            Err(_) => return Err(bad(image.path(), "is neither PNG nor JPEG, or it is damaged")),
        };
        let at = image.path().to_owned();
        let size = ImageReader::with_format(Cursor::new(&*bytes), format).into_dimensions();
        let (width, height) = size.map_err(|e| bad(&at, format!("cannot be decoded: {e}")))?;
        if width == 0 || height == 0 {
            return Err(bad(at, "has no pixels"));
        }
        Ok(Self { at, bytes, format, width, height })
    }

    fn decode(self) -> Result<Decoded, Error> {
        let fail = |e: image::ImageError| bad(&self.at, format!("cannot be decoded: {e}"));
        let mut reader = ImageReader::with_format(Cursor::new(&*self.bytes), self.format);
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(self.width);
        limits.max_image_height = Some(self.height);
        // 16-bit RGBA, once for the decoder and once for the image, and some memory for tables.
        let pixels = u64::from(self.width) * u64::from(self.height);
        limits.max_alloc = Some(pixels.saturating_mul(16).saturating_add(64 << 20));
        reader.limits(limits);
        let image = reader.decode().map_err(fail)?.into_rgba8();
        let (width, height) = (image.width() as usize, image.height() as usize);
        let texels = image.as_raw().as_chunks::<4>().0.to_vec();
        if (width, height) != (self.width as usize, self.height as usize) || texels.len() != width * height {
            return Err(bad(&self.at, "changed its size while it was decoded"));
        }
        Ok(Decoded { width, height, texels })
    }
}

fn wrap_modes(sampler: &Object<'_>, warnings: &mut Warnings) -> Result<[Wrap; 2], Error> {
    let wrap = |key: &str| match sampler.unsigned(key)? {
        None | Some(10497) => Ok(Wrap::Repeat),
        Some(33071) => Ok(Wrap::Clamp),
        Some(33648) => Ok(Wrap::Mirror),
        Some(other) => Err(bad(sampler.at(key), format!("is {other}, which is no wrap mode of glTF"))),
    };
    if sampler.unsigned("magFilter")? == Some(9728) {
        warnings.note("nearest-texel filtering is drawn as bilinear", || sampler.path().to_owned());
    }
    Ok([wrap("wrapS")?, wrap("wrapT")?])
}
