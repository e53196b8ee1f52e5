//! `holo animate`: a camera path through the views as an animation, or as one image per frame.

use holo_core::{DynLightField, LightFieldOwned, Sample, ViewPath};

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
        PathArgument::PingPong => ViewPath::PingPong { row },
        PathArgument::Serpentine => ViewPath::Serpentine,
    };
    if options.row.is_some() && matches!(options.path, PathArgument::Circle | PathArgument::Serpentine) {
        return Err(Failure::Usage("--row is for the paths sweep and ping-pong".into()));
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
            "{} holds linear floats, which no animation can; give --frames and a name that ends in .pfm or .tif",
            options.input.input.display()
        ))),
    }
}

fn write<T: Sample>(
    field: &LightFieldOwned<T>,
    shown: &[(usize, usize)],
    options: &AnimateOptions,
) -> Result<(), Failure> {
    let frames: Vec<_> = shown.iter().map(|&(t, s)| field.view(t, s)).collect::<Result<_, _>>()?;
    match holo_io::write_animation(&options.out, &frames, options.fps) {
        Err(error @ holo_io::Error::BadInput { .. }) => Err(Failure::Usage(format!("{error}, or give --frames"))),
        other => Ok(other?),
    }
}
