//! `holo epi`: an epipolar-plane image, one row or column of pixels as all views of a row or column see it.

use holo_core::LightFieldOwned;
use ndarray::ArrayView3;

use super::extract;
use super::raw::{self, Raw};
use crate::arguments::EpiOptions;
use crate::failure::Failure;

pub fn run(options: &EpiOptions) -> Result<(), Failure> {
    let input = &options.input;
    let (raw, _) = raw::read(&input.input, input.from, input.views)?;
    match &raw {
        Raw::U8(field) => extract::write(&options.out, &input.input, extract::Picture::U8(slice(field, options)?)),
        Raw::U16(field) => extract::write(&options.out, &input.input, extract::Picture::U16(slice(field, options)?)),
        Raw::Float(field) => {
            extract::write(&options.out, &input.input, extract::Picture::Float(slice(field, options)?))
        }
    }
}

fn slice<'a, T: Copy>(field: &'a LightFieldOwned<T>, options: &EpiOptions) -> Result<ArrayView3<'a, T>, Failure> {
    match (options.row, options.column) {
        (Some(at), _) => Ok(field.epi_row(at.column, at.row)?),
        (None, Some(at)) => Ok(field.epi_column(at.column, at.row)?),
        (None, None) => Err(Failure::Usage("give --row V,T or --column U,S".into())),
    }
}
