//! `holo refocus`: one image from all views, sharp at one disparity or everywhere.
//!
//! Light is added up, not codes: the sRGB curve of integers is undone first and put back at the end.

use std::path::Path;

use holo_core::refocus::{Aperture, Refocus};
use holo_core::{DynImage, GridSize, Rig, SampleKind};
use holo_io::Limits;
use ndarray::Array3;

use super::array_view;
use super::files::{self, numbered};
use crate::arguments::RefocusOptions;
use crate::failure::{Failure, wrong_option};

pub fn run(options: &RefocusOptions) -> Result<(), Failure> {
    if options.tilt_deg.is_some() && options.distance_m.is_none() {
        return Err(Failure::Usage("--tilt-deg tilts the plane of --distance-m; give that too".into()));
    }
    if let Some(array) = array_view::opened(&options.input, &options.viewpoint)? {
        return array_view::refocus(options, &array);
    }
    let file = files::read(&options.input)?;
    let (views, rig) = (file.light_field.shape().views(), file.rig);
    let refocus = refocus(options, views, rig.as_ref())?;
    let kind = file.light_field.kind();
    let field = file.light_field.without_alpha()?.into_linear(file.color_encoding)?;
    if let Some(map) = &options.all_in_focus {
        let map = holo_io::read_pfm_gray(map, &Limits::default())?;
        return write(&options.out, &refocus.all_in_focus(&field, &map)?, kind);
    }
    if let Some((first, last, count)) = options.stack {
        let step = if count > 1 { (last - first) / (count - 1) as f64 } else { 0.0 };
        let disparities_px: Vec<f64> = (0..count).map(|number| first + step * number as f64).collect();
        for (number, image) in refocus.focal_stack(&field, &disparities_px).enumerate() {
            write(&numbered(&options.out, number, count), &image?, kind)?;
        }
        return Ok(());
    }
    let image = match (options.disparity, options.slope, options.distance_m) {
        (Some(disparity_px), _, _) => refocus.at_disparity(&field, disparity_px)?,
        (_, Some(slope), _) => refocus.at_slope(&field, slope)?,
        (_, _, Some(distance_m)) => {
            let rig = rig.ok_or_else(|| {
                let what = "the camera parameters are unknown, so a distance in meters has no meaning; give --disparity, or put parameters.cfg beside it";
                Failure::Usage(format!("{}: {what}", options.input.input.display()))
            })?;
            refocus.at_plane(&field, &rig, array_view::plane(distance_m, options.tilt_deg)?)?
        }
        _ => return Err(Failure::Usage("give --disparity, --distance-m, --slope, --all-in-focus or --stack".into())),
    };
    write(&options.out, &image, kind)
}

fn refocus(options: &RefocusOptions, views: GridSize, rig: Option<&Rig>) -> Result<Refocus, Failure> {
    let center = ((views.rows / 2) as f64, (views.columns / 2) as f64);
    let aperture = Aperture::shaped(views, center, options.aperture).map_err(wrong_option)?;
    let refocus = Refocus::with_aperture(aperture).kernel(options.kernel);
    Ok(rig.map_or(refocus.clone(), |rig| refocus.baseline_ratio(rig.baseline_ratio())))
}

/// Writes linear light: as it is into a PFM, on the sRGB curve into a PNG.
fn write(out: &Path, image: &Array3<f32>, source: SampleKind) -> Result<(), Failure> {
    files::write(out, &DynImage::from_linear(image.view(), files::kind_of(out, source))?)
}
