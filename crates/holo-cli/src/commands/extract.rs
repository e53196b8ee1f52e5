//! `holo extract`: one view or one elemental image.

use holo_core::LightFieldOwned;
use holo_io::{Compression, Meaning};
use ndarray::ArrayView3;

use super::raw::{self, Raw};
use crate::arguments::ExtractOptions;
use crate::failure::Failure;

pub fn run(options: &ExtractOptions) -> Result<(), Failure> {
    let (image, _) = raw::read(&options.input, options.from, options.views)?;
    let (out, meaning, compression) = (&options.out, Meaning::Srgb, Compression::Published);
    match &image {
        Raw::U8(field) => holo_io::write_png_u8(out, pick(field, options)?, meaning, compression)?,
        Raw::U16(field) => holo_io::write_png_u16(out, pick(field, options)?, meaning, compression)?,
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
