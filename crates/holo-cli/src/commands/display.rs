//! `holo display`: the image for a panel behind lenses, or what an eye sees of it.
//!
//! Light is averaged, not codes: the sRGB curve of integers is undone first and put back at the end.

use holo_core::DynImage;
use holo_core::display::{PanelMapping, ViewSpread};
use holo_io::DisplayFile;

use super::files;
use crate::arguments::DisplayOptions;
use crate::console::say;
use crate::failure::{Failure, wrong_option};

/// The rays across and down of a pixel that an eye sees: enough for the colors of several lenses.
const RAYS: usize = 16;

pub fn run(options: &DisplayOptions) -> Result<(), Failure> {
    let DisplayFile { name, display } = DisplayFile::read(&options.display)?;
    let file = files::read(&options.input)?;
    let rig = || {
        file.rig.ok_or_else(|| {
            let what = "the camera parameters are unknown, so --distance-m and --to-scale have no meaning";
            Failure::Usage(format!("{}: {what}; put its parameters.cfg next to it", options.input.input.display()))
        })
    };
    let screen_disparity_px = match options.distance_m {
        Some(distance_m) => rig()?.disparity_x().from_depth_m(distance_m),
        None => options.disparity.unwrap_or(0.0),
    };
    let mut mapping = PanelMapping { screen_disparity_px, view_row: options.row, ..PanelMapping::default() };
    if let Some(rig) = &file.rig {
        mapping.baseline_ratio = rig.baseline_ratio();
    }
    if options.to_scale {
        mapping.spread = ViewSpread::ToScale(rig()?);
    }
    let kind = files::kind_of(&options.out, file.light_field.kind());
    let field = file.light_field.without_alpha()?.into_linear(file.color_encoding)?;
    let panel = display.panel_image(&field, &mapping).map_err(wrong_option)?;
    let image = match options.eye {
        None => panel,
        Some(eye_m) => display.seen_from(&panel, eye_m, display.resolution(), RAYS).map_err(wrong_option)?,
    };
    let [width, height] = display.size_m().map(|size| 1000.0 * size);
    say!("note: the display {} is {width:.0} x {height:.0} mm large", holo_core::shown(&name));
    files::write(&options.out, &DynImage::from_linear(image.view(), kind)?)
}
