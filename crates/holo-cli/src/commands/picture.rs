//! Pictures cut out of a light field, in the type of its file.

use std::path::{Path, PathBuf};

use holo_io::{ColorEncoding, Compression};
use ndarray::{ArrayView3, Axis, Slice};

use crate::arguments::Crop;
use crate::failure::Failure;

/// A picture `(row, column, channel)`: integers on the sRGB curve, or linear floats.
pub enum Picture<'a> {
    U8(ArrayView3<'a, u8>),
    U16(ArrayView3<'a, u16>),
    Float(ArrayView3<'a, f32>),
}

impl<'a> Picture<'a> {
    /// A part of it.
    pub fn crop(self, crop: Crop) -> Result<Self, Failure> {
        Ok(match self {
            Self::U8(image) => Self::U8(cropped(image, crop)?),
            Self::U16(image) => Self::U16(cropped(image, crop)?),
            Self::Float(image) => Self::Float(cropped(image, crop)?),
        })
    }

    /// Writes integers into a PNG and floats into a PFM: nothing is converted. `input` is where it comes from.
    pub fn write(self, out: &Path, input: &Path) -> Result<(), Failure> {
        let (meaning, compression) = (ColorEncoding::Srgb, Compression::Best);
        let floats = out.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("pfm"));
        match self {
            Self::Float(image) if floats => write_pfm(out, image),
            Self::Float(_) => Err(Failure::Usage(format!(
                "{} holds linear floats, which no PNG can; end the name of --out in .pfm",
                input.display()
            ))),
            Self::U8(_) | Self::U16(_) if floats => Err(Failure::Usage(format!(
                "{} holds integers on the sRGB curve; end the name of --out in .png",
                input.display()
            ))),
            Self::U8(image) => Ok(holo_io::write_png(out, image, meaning, compression).map(drop)?),
            Self::U16(image) => Ok(holo_io::write_png(out, image, meaning, compression).map(drop)?),
        }
    }
}

fn cropped<'a, T>(image: ArrayView3<'a, T>, crop: Crop) -> Result<ArrayView3<'a, T>, Failure> {
    let (rows, columns, _) = image.dim();
    let ends = [(crop.top, crop.size.rows, rows), (crop.left, crop.size.columns, columns)];
    if ends.iter().any(|&(first, count, all)| first.checked_add(count).is_none_or(|end| end > all)) {
        return Err(Failure::Usage(format!(
            "--crop {},{},{}x{} leaves the image of {columns} x {rows} pixels",
            crop.left, crop.top, crop.size.columns, crop.size.rows
        )));
    }
    let rows = Slice::from(crop.top..crop.top + crop.size.rows);
    let columns = Slice::from(crop.left..crop.left + crop.size.columns);
    Ok(image.slice_axis_move(Axis(0), rows).slice_axis_move(Axis(1), columns))
}

/// Writes floats of one channel or of three.
pub fn write_pfm(out: &Path, image: ArrayView3<f32>) -> Result<(), Failure> {
    match image.dim().2 {
        1 => holo_io::write_pfm(out, image.index_axis_move(Axis(2), 0))?,
        _ => holo_io::write_pfm_colour(out, image)?,
    };
    Ok(())
}

/// `stack.png` becomes `stack_007.png`.
pub fn numbered(out: &Path, number: usize, count: usize) -> PathBuf {
    let digits = count.saturating_sub(1).to_string().len().max(3);
    with_more(out, &format!("_{number:0digits$}"))
}

/// `view.png` becomes `view_r004_c012.png`: row first, so that names in order are pictures in reading order.
pub fn placed(out: &Path, [column, row]: [usize; 2], largest: usize) -> PathBuf {
    let digits = largest.saturating_sub(1).to_string().len().max(2);
    with_more(out, &format!("_r{row:0digits$}_c{column:0digits$}"))
}

fn with_more(out: &Path, more: &str) -> PathBuf {
    let mut name = out.file_stem().unwrap_or_default().to_os_string();
    name.push(more);
    if let Some(ending) = out.extension() {
        name.push(".");
        name.push(ending);
    }
    out.with_file_name(name)
}
