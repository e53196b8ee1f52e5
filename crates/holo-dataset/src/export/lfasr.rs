//! The HDF5 files of LFASR-geometry: all light fields of an export as one array, views first.
//!
//! `OUT/train.h5` has `LFI`, uint8 `[N T S V U]`: luma; `OUT/test.h5` has `LFI_ycbcr`, uint8 `[N T S V U 3]`.
//!
//! # Source
//! Luma and chroma of 8 bits by ITU-R BT.601, rounded: what `rgb2ycbcr` of MATLAB makes of 8-bit images.

use super::source::SourceField;
use super::{ExportTarget, Writer};
use crate::Error;
use crate::output::OutputFolder;

pub(super) const TARGET: ExportTarget = ExportTarget {
    name: "lfasr",
    help: "LFASR-geometry: HDF5 files for view synthesis, all light fields in one",
    usage: "train.py takes train.h5 as its dataset, test_pretrained.py takes test.h5.",
    has_groups: false,
    has_objects: false,
    writer: Writer::Joined(write),
};

#[cfg(not(feature = "hdf5"))]
fn write(_: &mut OutputFolder, _: &[SourceField]) -> Result<(), Error> {
    Err(Error::BadRequest("lfasr takes HDF5 files, and this program was built without them".into()))
}

#[cfg(feature = "hdf5")]
fn write(folder: &mut OutputFolder, sources: &[SourceField]) -> Result<(), Error> {
    use holo_io::Hdf5Arrays;

    let files = [("train.h5", "LFI"), ("test.h5", "LFI_ycbcr")];
    let mut open: Vec<Hdf5Arrays> = Vec::new();
    let mut first = None;
    for (number, source) in sources.iter().enumerate() {
        let loaded = source.load(number)?;
        let shape = loaded.field.shape();
        if loaded.field.channels() != 3 {
            return Err(loaded.lacks("the readers take colors of three channels", "render it in color"));
        }
        if *first.get_or_insert(shape) != shape {
            return Err(loaded.lacks("all light fields of an export have the same views and pixels", "choose `views`"));
        }
        let colors = ycbcr(loaded.field.samples().permuted_axes([2, 3, 0, 1, 4]));
        let luma = colors.index_axis(ndarray::Axis(4), 0);
        for (k, (name, array)) in files.into_iter().enumerate() {
            let part = if k == 0 { luma.into_dyn() } else { colors.view().into_dyn() };
            if number == 0 {
                let file = Hdf5Arrays::create(folder.file(name))?;
                let all: Vec<usize> = std::iter::once(sources.len()).chain(part.shape().iter().copied()).collect();
                file.add(array, &all)?;
                open.push(file);
            }
            open[k].write_part(array, number, part)?;
        }
    }
    for ((name, _), file) in files.into_iter().zip(open) {
        folder.add(name, file.finish()?);
    }
    Ok(())
}

/// Luma and chroma of RGB codes, along the last axis.
#[cfg(any(feature = "hdf5", test))]
fn ycbcr(codes: ndarray::ArrayView5<u8>) -> ndarray::Array5<u8> {
    const ROWS: [[f64; 4]; 3] =
        [[65.481, 128.553, 24.966, 16.0], [-37.797, -74.203, 112.0, 128.0], [112.0, -93.786, -18.214, 128.0]];
    let mut out = ndarray::Array5::zeros(codes.raw_dim());
    for (mut out, rgb) in out.lanes_mut(ndarray::Axis(4)).into_iter().zip(codes.lanes(ndarray::Axis(4))) {
        for (out, row) in out.iter_mut().zip(ROWS) {
            let sum: f64 = (0..3).map(|c| row[c] * f64::from(rgb[c])).sum();
            *out = (sum / 255.0 + row[3]).round() as u8;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `rgb2ycbcr(uint8([0 0 0; 255 255 255; 255 0 0; 10 200 30]))` by its documented formula.
    #[test]
    fn colors_are_those_of_bt_601() {
        let codes = [[0, 0, 0], [255, 255, 255], [255, 0, 0], [10, 200, 30]];
        let image = ndarray::Array5::from_shape_fn((1, 1, 1, 4, 3), |(_, _, _, k, c)| codes[k][c]);
        let found = ycbcr(image.view());
        let expected = [[16, 128, 128], [235, 128, 128], [81, 90, 240], [122, 81, 57]];
        for (k, expected) in expected.into_iter().enumerate() {
            assert_eq!([0, 1, 2].map(|c| found[[0, 0, 0, k, c]]), expected, "{:?}", codes[k]);
        }
    }
}
