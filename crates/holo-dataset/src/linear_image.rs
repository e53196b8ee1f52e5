//! Images in linear light, from the files that hold them.

use std::path::Path;

use holo_core::color::srgb_to_linear;
use holo_core::{ColorEncoding, DynImage};
use holo_io::{FileFormat, Limits};
use ndarray::{Array2, Array3, Axis};

use crate::Error;

/// Reads an image in linear light, axes (row, column, channel), of one or three channels: OpenEXR, PFM, or PNG. Codes of a PNG
/// become values from 0 to 1: along the sRGB curve if the file says that it has that, else in proportion.
pub(crate) fn read_linear(path: &Path) -> Result<Array3<f32>, Error> {
    let limits = Limits::default();
    match holo_io::detect_format(path)? {
        FileFormat::Exr => {
            let image = holo_io::read_exr(path, &limits)?;
            let planes: Vec<&Array2<f32>> = ["R", "G", "B"].iter().filter_map(|name| image.channel(name)).collect();
            let gray = image.channel("Y").into_iter().collect::<Vec<_>>();
            let planes = if planes.len() == 3 { planes } else { gray };
            let views: Vec<_> = planes.iter().map(|plane| plane.view()).collect();
            ndarray::stack(Axis(2), &views)
                .map(|image| image.as_standard_layout().into_owned())
                .map_err(|_| Error::Failed(format!("{}: it has neither channels R, G, B nor Y", path.display())))
        }
        FileFormat::Pfm => Ok(holo_io::read_pfm(path, &limits)?.values),
        _ => {
            let encoding = holo_io::read_png_info(path)?.encoding;
            let linear = |code: f64| if encoding == ColorEncoding::Srgb { srgb_to_linear(code) } else { code };
            let image = match holo_io::read_png(path, &limits)? {
                DynImage::U8(image) => image.mapv(|code| linear(f64::from(code) / 255.0) as f32),
                DynImage::U16(image) => image.mapv(|code| linear(f64::from(code) / 65_535.0) as f32),
                _ => return Err(Error::Failed(format!("{}: not an image of 8 or 16 bits", path.display()))),
            };
            // Without alpha.
            let kept = if image.dim().2 >= 3 { 3 } else { 1 };
            Ok(image.slice_axis(Axis(2), (..kept).into()).as_standard_layout().into_owned())
        }
    }
}
