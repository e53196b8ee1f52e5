//! `holo rotate-elements`: a raw image for an integral display.

use holo_core::LightFieldOwned;

use super::raw::{self, Raw};
use super::remap;
use crate::arguments::RotateOptions;
use crate::failure::Failure;

pub fn run(options: &RotateOptions) -> Result<(), Failure> {
    let (image, from) = raw::read_input(&options.input)?;
    let to = remap::output_layout(options.to, &options.output, from)?;
    let turned = match image {
        Raw::U8(field) => Raw::U8(turn(field, options.whole)),
        Raw::U16(field) => Raw::U16(turn(field, options.whole)),
        Raw::Float(field) => Raw::Float(turn(field, options.whole)),
    };
    remap::write_grid(turned, to, &options.output, &options.input.input)
}

fn turn<T>(field: LightFieldOwned<T>, whole: bool) -> LightFieldOwned<T> {
    if whole { field.rotate_raw() } else { field.rotate_elemental_images() }
}
