//! `holo extract`: one, some or all views or elemental images.

use holo_core::GridSize;

use super::picture;
use super::raw;
use crate::arguments::{ExtractOptions, Places};
use crate::failure::Failure;

pub fn run(options: &ExtractOptions) -> Result<(), Failure> {
    let (raw, _) = raw::read_input(&options.input)?;
    let split = raw.shape();
    match (options.view, options.lens) {
        (Some(places), _) => write(options, places, split.views(), |row, column| raw.view(row, column)),
        (None, Some(places)) => write(options, places, split.lenses(), |row, column| raw.elemental(row, column)),
        (None, None) => Err(Failure::Usage("give --view S,T or --lens U,V".into())),
    }
}

/// Writes the pictures at `places` of a grid of `size`.
fn write<'a>(
    options: &ExtractOptions,
    places: Places,
    size: GridSize,
    picture_at: impl Fn(usize, usize) -> Result<picture::Picture<'a>, Failure>,
) -> Result<(), Failure> {
    let columns = places.columns.indices(size.columns);
    let at = places.rows.indices(size.rows).flat_map(|row| columns.clone().map(move |column| (row, column)));
    // Ends of ranges are looked at before anything is written.
    if let Some((row, column)) = at.clone().last() {
        picture_at(row, column)?;
    }
    for (row, column) in at {
        let cut = picture_at(row, column)?;
        let cut = match options.crop {
            Some(crop) => cut.crop(crop)?,
            None => cut,
        };
        let out = match places.is_one() {
            true => options.out.clone(),
            false => picture::placed(&options.out, [column, row], size.larger()),
        };
        cut.write(&out, &options.input.input)?;
    }
    Ok(())
}
