//! Encodes an image as TIFF in memory.

use std::io::Cursor;
use std::path::Path;

use holo_core::DynImageRef;
use ndarray::ArrayView3;
use tiff::TiffResult;
use tiff::encoder::colortype::{self, ColorType};
use tiff::encoder::{Compression, DeflateLevel, Predictor, TiffEncoder, TiffValue};

use crate::Error;

/// The largest file of TIFF's 32-bit offsets, with room for headers.
const MAX_BYTES: usize = u32::MAX as usize - (1 << 20);

pub(super) fn encode(path: &Path, image: DynImageRef<'_>) -> Result<Vec<u8>, Error> {
    let (size, channels) = (image.size(), image.channels());
    let bad = |what: String| Error::bad_input(path, what);
    if size.count() == 0 || !matches!(channels, 1 | 3 | 4) {
        return Err(bad(format!(
            "an image of {size} pixels and {channels} channels cannot be written as TIFF; it needs pixels of 1, 3 or 4 \
             channels"
        )));
    }
    let samples = [size.rows, size.columns, channels, 8].iter().try_fold(1_usize, |a, &b| a.checked_mul(b));
    // The widest samples have eight bytes; smaller ones get the room that they need.
    if samples.is_none_or(|bytes| bytes / 8 * image.kind().bytes() > MAX_BYTES) {
        return Err(bad(format!("an image of {size} pixels is too large for a TIFF; write a PNG or EXR")));
    }
    let encoded = match image {
        DynImageRef::U8(image) => by_channels::<colortype::Gray8, colortype::RGB8, colortype::RGBA8>(image, true),
        DynImageRef::U16(image) => by_channels::<colortype::Gray16, colortype::RGB16, colortype::RGBA16>(image, true),
        DynImageRef::F32(image) => {
            by_channels::<colortype::Gray32Float, colortype::RGB32Float, colortype::RGBA32Float>(image, false)
        }
        DynImageRef::F64(image) => {
            by_channels::<colortype::Gray64Float, colortype::RGB64Float, colortype::RGBA64Float>(image, false)
        }
    };
    encoded.map_err(|error| bad(error.to_string()))
}

fn by_channels<G, C, A>(image: ArrayView3<'_, G::Inner>, has_predictor: bool) -> TiffResult<Vec<u8>>
where
    G: ColorType,
    C: ColorType<Inner = G::Inner>,
    A: ColorType<Inner = G::Inner>,
    G::Inner: Copy,
    [G::Inner]: TiffValue,
{
    match image.dim().2 {
        1 => rows::<G>(image, has_predictor),
        3 => rows::<C>(image, has_predictor),
        _ => rows::<A>(image, has_predictor),
    }
}

/// Encodes the image.
fn rows<C: ColorType>(image: ArrayView3<'_, C::Inner>, has_predictor: bool) -> TiffResult<Vec<u8>>
where
    C::Inner: Copy,
    [C::Inner]: TiffValue,
{
    let (height, width, _) = image.dim();
    let mut bytes = Cursor::new(Vec::new());
    let mut encoder = TiffEncoder::new(&mut bytes)?.with_compression(Compression::Deflate(DeflateLevel::Balanced));
    if has_predictor {
        encoder = encoder.with_predictor(Predictor::Horizontal);
    }
    // `size` was compared with the limits of the format. All strips at once: `tiff` 0.11 compresses none of those that are
    // written one by one, although it marks them as compressed.
    let out = encoder.new_image::<C>(width as u32, height as u32)?;
    match image.as_slice() {
        Some(samples) => out.write_data(samples)?,
        None => out.write_data(&image.iter().copied().collect::<Vec<_>>())?,
    }
    Ok(bytes.into_inner())
}
