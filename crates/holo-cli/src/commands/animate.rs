//! `holo animate`: a way through the views as a moving picture, or as one picture a view.

use holo_core::{DynLightField, LightFieldOwned, Sample, ViewPath};
use holo_io::ColorEncoding;

use super::files::{self, numbered};
use crate::arguments::{AnimateOptions, PathArgument};
use crate::failure::Failure;

pub fn run(options: &AnimateOptions) -> Result<(), Failure> {
    let light_field = files::read(&options.input)?.light_field;
    let views = light_field.shape().views();
    let row = options.row.unwrap_or(views.rows / 2);
    let path = match options.path {
        PathArgument::Circle => ViewPath::Circle,
        PathArgument::Sweep => ViewPath::Sweep { row },
        PathArgument::Swing => ViewPath::PingPong { row },
        PathArgument::Serpentine => ViewPath::Serpentine,
    };
    if options.row.is_some() && matches!(options.path, PathArgument::Circle | PathArgument::Serpentine) {
        return Err(Failure::Usage("--row is for the paths sweep and swing".into()));
    }
    let shown = path.views(views)?;
    if options.frames {
        for (number, &(t, s)) in shown.iter().enumerate() {
            let out = numbered(&options.out, number, shown.len());
            files::write(&out, light_field.view(t, s)?)?;
        }
        return Ok(());
    }
    match &light_field {
        DynLightField::U8(field) => write(field, &shown, options),
        DynLightField::U16(field) => write(field, &shown, options),
        DynLightField::F32(_) | DynLightField::F64(_) => Err(Failure::Usage(format!(
            "{} holds linear floats, which no PNG can; give --frames and a name that ends in .pfm",
            options.input.input.display()
        ))),
    }
}

fn write<T: Sample>(
    field: &LightFieldOwned<T>,
    shown: &[(usize, usize)],
    options: &AnimateOptions,
) -> Result<(), Failure> {
    if options.out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pfm")) {
        return Err(Failure::Usage("a moving picture is a PNG; end the name of --out in .png".into()));
    }
    let frames: Vec<_> = shown.iter().map(|&(t, s)| field.view(t, s)).collect::<Result<_, _>>()?;
    holo_io::write_png_animation(&options.out, &frames, options.fps, ColorEncoding::Srgb)?;
    Ok(())
}
