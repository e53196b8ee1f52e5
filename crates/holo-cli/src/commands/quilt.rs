//! `holo quilt`: the views of one row as multi-view displays read them.

use holo_core::{DynImage, LightFieldOwned, Sample, evenly_spaced_views, for_each_sample};

use super::files;
use crate::arguments::QuiltOptions;
use crate::failure::Failure;

pub fn run(options: &QuiltOptions) -> Result<(), Failure> {
    let light_field = files::read(&options.input)?.light_field;
    let quilt = for_each_sample!(DynLightField, &light_field, field => quilt(field, options))?;
    files::write(&options.out, &quilt)
}

fn quilt<T: Sample>(field: &LightFieldOwned<T>, options: &QuiltOptions) -> Result<DynImage, Failure> {
    let views = field.shape().views();
    let row = options.row.unwrap_or(views.rows / 2);
    let shown = evenly_spaced_views(views, row, options.tiles.count())?;
    Ok(field.to_quilt(options.tiles, &shown)?.into())
}
