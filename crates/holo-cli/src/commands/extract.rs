//! `holo extract`: one view or one elemental image.

use std::path::Path;

use holo_core::LightFieldOwned;
use holo_io::{Compression, Meaning};
use ndarray::{ArrayView3, Axis};

use super::raw::{self, Raw};
use crate::arguments::ExtractOptions;
use crate::failure::Failure;

pub fn run(options: &ExtractOptions) -> Result<(), Failure> {
    let (image, _) = raw::read(&options.input, options.from, options.views)?;
    let picture = match &image {
        Raw::U8(field) => Picture::U8(pick(field, options)?),
        Raw::U16(field) => Picture::U16(pick(field, options)?),
        Raw::Float(field) => Picture::Float(pick(field, options)?),
    };
    write(&options.out, &options.input, picture)
}

/// A piece of a light field, in the type of its file.
pub enum Picture<'a> {
    U8(ArrayView3<'a, u8>),
    U16(ArrayView3<'a, u16>),
    Float(ArrayView3<'a, f32>),
}

/// Writes integers into a PNG and floats into a PFM: nothing is converted.
pub fn write(out: &Path, input: &Path, picture: Picture<'_>) -> Result<(), Failure> {
    let (meaning, compression) = (Meaning::Srgb, Compression::Published);
    let floats = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pfm"));
    match picture {
        Picture::Float(image) if floats => write_pfm(out, image),
        Picture::Float(_) => Err(Failure::Usage(format!(
            "{} holds linear floats, which no PNG can; end the name of --out in .pfm",
            input.display()
        ))),
        Picture::U8(_) | Picture::U16(_) if floats => Err(Failure::Usage(format!(
            "{} holds integers on the sRGB curve; end the name of --out in .png",
            input.display()
        ))),
        Picture::U8(image) => Ok(holo_io::write_png_u8(out, image, meaning, compression).map(drop)?),
        Picture::U16(image) => Ok(holo_io::write_png_u16(out, image, meaning, compression).map(drop)?),
    }
}

/// Writes floats of one channel or of three.
pub fn write_pfm(out: &Path, image: ArrayView3<f32>) -> Result<(), Failure> {
    match image.dim().2 {
        1 => holo_io::write_pfm(out, image.index_axis_move(Axis(2), 0))?,
        _ => holo_io::write_pfm_colour(out, image)?,
    };
    Ok(())
}

fn pick<'a, T: Copy>(field: &'a LightFieldOwned<T>, options: &ExtractOptions) -> Result<ArrayView3<'a, T>, Failure> {
    match (options.view, options.lens) {
        (Some(view), _) => Ok(field.view(view.row, view.column)?),
        (None, Some(lens)) => Ok(field.elemental(lens.row, lens.column)?),
        (None, None) => Err(Failure::Usage("give --view S,T or --lens U,V".into())),
    }
}
