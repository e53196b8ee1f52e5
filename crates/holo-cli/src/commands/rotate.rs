//! `holo rotate-elements`: a raw image for an integral display.

use holo_core::{DynLightField, LightFieldOwned, Sample, for_each_sample};

use super::{files, remap};
use crate::arguments::RotateOptions;
use crate::failure::Failure;

pub fn run(options: &RotateOptions) -> Result<(), Failure> {
    let file = files::read(&options.input)?;
    let to = remap::output_layout(options.to, &options.output, file.layout)?;
    let rotated = for_each_sample!(DynLightField, file.light_field, field => rotate(field, options.whole));
    remap::write_grid(rotated, to, &options.output)
}

fn rotate<T: Sample>(field: LightFieldOwned<T>, whole: bool) -> DynLightField {
    if whole { field.rotate_raw() } else { field.rotate_elemental_images() }.into()
}
