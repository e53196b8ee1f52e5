//! `holo refocus`: one image from all views, sharp at one disparity or everywhere.
//!
//! Light is added up, not codes: the sRGB curve of integers is undone first and put back at the end.

use std::path::Path;

use holo_core::refocus::{Aperture, Refocus, disparity_from_slope};
use holo_core::{DynImage, GridSize, Rig, SampleKind};
use holo_io::Limits;
use ndarray::Array3;

use super::files::{self, numbered};
use crate::arguments::{ApertureArgument, RefocusOptions};
use crate::failure::Failure;

pub fn run(options: &RefocusOptions) -> Result<(), Failure> {
    let file = files::read(&options.input)?;
    let (views, rig) = (file.light_field.shape().views(), file.rig);
    let refocus = refocus(options, views, rig.as_ref())?;
    // A PNG has as many bits as its source; floats get the most.
    let kind = if file.light_field.kind() == SampleKind::U8 { SampleKind::U8 } else { SampleKind::U16 };
    let field = file.light_field.without_alpha()?.into_linear(file.color_encoding)?;
    if let Some(map) = &options.all_in_focus {
        let map = holo_io::read_pfm_gray(map, &Limits::default())?;
        return write(&options.out, &refocus.all_in_focus(&field, &map)?, kind);
    }
    if let Some((first, last, count)) = options.stack {
        let step = if count > 1 { (last - first) / (count - 1) as f64 } else { 0.0 };
        for number in 0..count {
            let image = refocus.at_disparity(&field, first + step * number as f64)?;
            write(&numbered(&options.out, number, count), &image, kind)?;
        }
        return Ok(());
    }
    let disparity_px = match (options.disparity, options.slope, options.distance_m) {
        (Some(disparity_px), _, _) => disparity_px,
        (_, Some(slope), _) => disparity_from_slope(slope, views.columns)?,
        (_, _, Some(distance_m)) => {
            let rig = rig.ok_or_else(|| {
                let what = "the camera parameters are unknown, so a distance in meters has no meaning; give --disparity, or put parameters.cfg beside it";
                Failure::Usage(format!("{}: {what}", options.input.input.display()))
            })?;
            rig.disparity().from_depth_m(distance_m)
        }
        _ => return Err(Failure::Usage("give --disparity, --distance-m, --slope, --all-in-focus or --stack".into())),
    };
    write(&options.out, &refocus.at_disparity(&field, disparity_px)?, kind)
}

fn refocus(options: &RefocusOptions, views: GridSize, rig: Option<&Rig>) -> Result<Refocus, Failure> {
    let center = ((views.rows / 2) as f64, (views.columns / 2) as f64);
    let aperture = match options.aperture {
        ApertureArgument::All => Aperture::all(views)?,
        ApertureArgument::Disc(diameter) => Aperture::disc(views, center, diameter)?,
        ApertureArgument::Square(side) => Aperture::square(views, center, side)?,
        ApertureArgument::Gaussian(deviation) => Aperture::gaussian(views, center, deviation)?,
    };
    let refocus = Refocus::with_aperture(aperture).kernel(options.kernel);
    let baselines = rig.map(|rig| (rig.baseline_x_m(), rig.baseline_y_m()));
    Ok(match baselines {
        Some((x, y)) if x > 0.0 && y > 0.0 => refocus.vertical_ratio(y / x)?,
        _ => refocus,
    })
}

/// Writes linear light: as it is into a PFM, on the sRGB curve into a PNG of `kind`.
fn write(out: &Path, image: &Array3<f32>, kind: SampleKind) -> Result<(), Failure> {
    let is_pfm = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pfm"));
    files::write(out, &DynImage::from_linear(image.view(), if is_pfm { SampleKind::F32 } else { kind })?)
}
