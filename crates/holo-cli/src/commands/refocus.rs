//! `holo refocus`: one picture out of all views, sharp where it is wanted.
//!
//! Light is added up, not codes: the sRGB curve of integers is undone first and put back at the end.

use std::path::Path;

use holo_core::color::srgb_to_linear;
use holo_core::refocus::{Aperture, Kernel, Refocus, disparity_from_slope};
use holo_core::{GridSize, LightField, LightFieldOwned, LightFieldShape, Rig};
use holo_io::{ColorEncoding, Compression, Limits};
use holo_render::exposure;
use ndarray::{Array3, Axis, Slice};

use super::beside::Beside;
use super::picture::{numbered, write_pfm};
use super::raw::{self, Raw};
use crate::arguments::{ApertureArgument, KernelArgument, RefocusOptions};
use crate::failure::Failure;

/// Bits of the codes that a picture is written in.
#[derive(Clone, Copy)]
enum Codes {
    Bits8,
    Bits16,
}

pub fn run(options: &RefocusOptions) -> Result<(), Failure> {
    let (input, views) = (&options.input.input, options.input.views);
    let (raw, _) = raw::read_input(&options.input)?;
    let split = raw.shape();
    let rig = Beside::of(input, views.is_some())?.rig.filter(|rig| *rig.shape() == split);
    let refocus = refocus(options, split.views(), rig.as_ref())?;
    let codes = if matches!(raw, Raw::U8(_)) { Codes::Bits8 } else { Codes::Bits16 };
    let field = linear(raw)?;
    if let Some(map) = &options.all_in_focus {
        let map = holo_io::read_pfm_grey(map, &Limits::default())?;
        return write(&options.out, refocus.all_in_focus(&field, &map)?, codes);
    }
    if let Some((first, last, count)) = options.stack {
        let step = if count > 1 { (last - first) / (count - 1) as f64 } else { 0.0 };
        for number in 0..count {
            let picture = refocus.at_disparity(&field, first + step * number as f64)?;
            write(&numbered(&options.out, number, count), picture, codes)?;
        }
        return Ok(());
    }
    let disparity_px = match (options.disparity, options.slope, options.distance_m) {
        (Some(disparity_px), _, _) => disparity_px,
        (_, Some(slope), _) => disparity_from_slope(slope, split.views().columns)?,
        (_, _, Some(distance_m)) => {
            let rig = rig.ok_or_else(|| {
                let what = "no rig is known, so metres mean nothing; give --disparity, or put parameters.cfg beside it";
                Failure::Usage(format!("{}: {what}", input.display()))
            })?;
            rig.disparity().from_depth_m(distance_m)
        }
        _ => return Err(Failure::Usage("give --disparity, --distance-m, --slope, --all-in-focus or --stack".into())),
    };
    write(&options.out, refocus.at_disparity(&field, disparity_px)?, codes)
}

fn refocus(options: &RefocusOptions, views: GridSize, rig: Option<&Rig>) -> Result<Refocus, Failure> {
    let centre = ((views.rows / 2) as f64, (views.columns / 2) as f64);
    let aperture = match options.aperture {
        ApertureArgument::All => Aperture::all(views)?,
        ApertureArgument::Disc(diameter) => Aperture::disc(views, centre, diameter)?,
        ApertureArgument::Square(side) => Aperture::square(views, centre, side)?,
        ApertureArgument::Gaussian(deviation) => Aperture::gaussian(views, centre, deviation)?,
    };
    let refocus = Refocus::with_aperture(aperture).kernel(match options.kernel {
        KernelArgument::Cubic => Kernel::CatmullRom,
        KernelArgument::Bilinear => Kernel::Bilinear,
    });
    let baselines = rig.map(|rig| (rig.baseline_x_m(), rig.baseline_y_m()));
    Ok(match baselines {
        Some((x, y)) if x > 0.0 && y > 0.0 => refocus.vertical_ratio(y / x)?,
        _ => refocus,
    })
}

/// The colours in linear light, without alpha.
fn linear(raw: Raw) -> Result<LightFieldOwned<f32>, Failure> {
    let table = |codes: usize| {
        (0..codes).map(|code| srgb_to_linear(code as f64 / (codes - 1) as f64) as f32).collect::<Vec<_>>()
    };
    let field = match raw {
        Raw::U8(field) => {
            let table = table(1 << 8);
            field.map(|&code| table[usize::from(code)])?
        }
        Raw::U16(field) => {
            let table = table(1 << 16);
            field.map(|&code| table[usize::from(code)])?
        }
        Raw::Float(field) => field,
    };
    let colours = if field.channels() >= 3 { 3 } else { 1 };
    if field.channels() == colours {
        return Ok(field);
    }
    Ok(LightField::new(field.samples().slice_axis(Axis(4), Slice::from(..colours)).to_owned())?)
}

/// Writes linear light: as it is into floats, on the sRGB curve into integers.
fn write(out: &Path, picture: Array3<f32>, codes: Codes) -> Result<(), Failure> {
    if out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pfm")) {
        return write_pfm(out, picture.view());
    }
    let (rows, columns, _) = picture.dim();
    let split = LightFieldShape::new(GridSize::new(1, 1), GridSize::new(rows, columns))?;
    // What overshoots below black at an edge is black.
    let one = LightField::from_viewpoint_grid(picture.mapv(|value| value.max(0.0)), split)?;
    match codes {
        Codes::Bits8 => {
            let coded = exposure::encode_8bit(&one, 0.0)?;
            holo_io::write_png(out, coded.view(0, 0)?, ColorEncoding::Srgb, Compression::Best)?;
        }
        Codes::Bits16 => {
            let coded = exposure::encode_16bit(&one, 0.0)?;
            holo_io::write_png(out, coded.view(0, 0)?, ColorEncoding::Srgb, Compression::Best)?;
        }
    }
    Ok(())
}
