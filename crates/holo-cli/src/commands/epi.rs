//! `holo epi`: an epipolar-plane image, one row or column of pixels as all views of a row or column see it.

use super::raw;
use crate::arguments::EpiOptions;
use crate::failure::Failure;

pub fn run(options: &EpiOptions) -> Result<(), Failure> {
    let (raw, _) = raw::read_input(&options.input)?;
    let slice = match (options.row, options.column) {
        (Some(at), _) => raw.epi_row(at.column, at.row)?,
        (None, Some(at)) => raw.epi_column(at.column, at.row)?,
        (None, None) => return Err(Failure::Usage("give --row V,T or --column U,S".into())),
    };
    slice.write(&options.out, &options.input.input)
}
