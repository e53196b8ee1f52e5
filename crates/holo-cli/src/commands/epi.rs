//! `holo epi`: an epipolar-plane image, one row or column of pixels as all views of a row or column see it.

use super::files;
use crate::arguments::EpiOptions;
use crate::failure::Failure;

pub fn run(options: &EpiOptions) -> Result<(), Failure> {
    let light_field = files::read(&options.input)?.light_field;
    let slice = match (options.row, options.column) {
        (Some(at), _) => light_field.epi_row(at.column, at.row)?,
        (None, Some(at)) => light_field.epi_column(at.column, at.row)?,
        (None, None) => {
            let shape = light_field.shape();
            light_field.epi_row(shape.lenses().rows / 2, shape.views().rows / 2)?
        }
    };
    files::write(&options.out, slice)
}
