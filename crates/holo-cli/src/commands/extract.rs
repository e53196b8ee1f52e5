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
    let (out, meaning, compression) = (&options.out, Meaning::Srgb, Compression::Published);
    let floats = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pfm"));
    match &image {
        Raw::Float(field) if floats => write_pfm(out, pick(field, options)?),
        Raw::Float(_) => Err(Failure::Usage(format!(
            "{} holds linear floats, which no PNG can; end the name of --out in .pfm",
            options.input.display()
        ))),
        Raw::U8(_) | Raw::U16(_) if floats => Err(Failure::Usage(format!(
            "{} holds integers on the sRGB curve; end the name of --out in .png",
            options.input.display()
        ))),
        Raw::U8(field) => Ok(holo_io::write_png_u8(out, pick(field, options)?, meaning, compression).map(drop)?),
        Raw::U16(field) => Ok(holo_io::write_png_u16(out, pick(field, options)?, meaning, compression).map(drop)?),
    }
}

fn write_pfm(out: &Path, image: ArrayView3<f32>) -> Result<(), Failure> {
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
