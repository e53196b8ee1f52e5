//! `holo extract`: one, some or all views or elemental images.

use holo_core::{DynImage, DynImageRef, GridSize};
use holo_io::LightFieldReader;

use super::files;
use crate::arguments::{Crop, ExtractOptions, Places};
use crate::failure::Failure;

pub fn run(options: &ExtractOptions) -> Result<(), Failure> {
    let reader = files::open(&options.input.input, &options.input)?;
    files::say_source(&reader);
    if let (Some(places), Some(view)) = (options.view, only_view(options, &reader)?) {
        return write(options, places, reader.shape().views(), |_, _| Ok(view.as_image_ref()));
    }
    let light_field = files::read_samples(reader)?.light_field;
    let shape = light_field.shape();
    match (options.view, options.lens) {
        (Some(places), _) => write(options, places, shape.views(), |row, column| light_field.view(row, column)),
        (None, Some(places)) => {
            write(options, places, shape.lenses(), |row, column| light_field.elemental_image(row, column))
        }
        (None, None) => Err(Failure::Usage("give --view S,T or --lens U,V".into())),
    }
}

/// Reads the view without the others, if it is the only one and its file has it by itself.
fn only_view(options: &ExtractOptions, reader: &LightFieldReader) -> Result<Option<DynImage>, Failure> {
    let Some(places) = options.view.filter(|places| places.is_one()) else { return Ok(None) };
    let views = reader.shape().views();
    match (places.rows.indices(views.rows).next(), places.columns.indices(views.columns).next()) {
        (Some(row), Some(column)) if row < views.rows && column < views.columns => Ok(reader.read_view(row, column)?),
        // The light field says what is wrong.
        _ => Ok(None),
    }
}

/// Writes the images at `places` of a grid of `size`.
fn write<'a>(
    options: &ExtractOptions,
    places: Places,
    size: GridSize,
    image_at: impl Fn(usize, usize) -> Result<DynImageRef<'a>, holo_core::Error>,
) -> Result<(), Failure> {
    let columns = places.columns.indices(size.columns);
    let at = places.rows.indices(size.rows).flat_map(|row| columns.clone().map(move |column| (row, column)));
    // Ends of ranges are looked at before anything is written.
    if let Some((row, column)) = at.clone().last() {
        image_at(row, column)?;
    }
    files::create_folder_of(&options.out)?;
    for (row, column) in at {
        let image = image_at(row, column)?;
        let image = match options.crop {
            Some(crop) => cropped(image, crop)?,
            None => image,
        };
        let out = match places.is_one() {
            true => options.out.clone(),
            false => files::at_position(&options.out, [column, row], size.larger()),
        };
        files::write(&out, image)?;
    }
    Ok(())
}

fn cropped(image: DynImageRef<'_>, crop: Crop) -> Result<DynImageRef<'_>, Failure> {
    let Crop { left, top, size } = crop;
    let (bottom, right) = (top.saturating_add(size.rows), left.saturating_add(size.columns));
    image
        .crop(top..bottom, left..right)
        .map_err(|_| Failure::Usage(format!("--crop {left},{top},{size} leaves the image of {} pixels", image.size())))
}
