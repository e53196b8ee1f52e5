//! PNGs of one view each, as one light field.

use std::path::{Path, PathBuf};

use holo_core::{
    DynImage, DynLightField, GridSize, Layout, LightFieldOwned, LightFieldShape, Sample, ViewOrder, for_each_sample,
};
use ndarray::{Array3, ArrayViewMut3, Axis, Slice};
use rayon::prelude::*;

use crate::{Error, Limits, PngInfo, read_png, read_png_info};

/// Reads a list of PNGs, one a view, as one light field.
///
/// The views lie in memory side by side, as a viewpoint grid. Alpha is left out; the views must be alike in size, bits and
/// colour.
///
/// # Errors
///
/// [`Error::BadInput`] if there are more or fewer files than views; [`Error::Broken`] if a file is not like the first;
/// [`Error::TooLarge`] if the light field exceeds the limits; otherwise as [`read_png`].
pub fn read_views(
    files: &[PathBuf],
    views: GridSize,
    order: ViewOrder,
    limits: &Limits,
) -> Result<DynLightField, Error> {
    let first = files.first().map_or(Path::new("list of views"), PathBuf::as_path);
    if files.len() != views.count() || files.is_empty() {
        let what = format!("{} x {} views need as many pictures, not {}", views.columns, views.rows, files.len());
        return Err(Error::bad_input(first, what));
    }
    let mut row_by_row = files.to_vec();
    for (index, file) in files.iter().enumerate() {
        let (t, s) = order.view(index, views).map_err(|error| Error::core(first, error))?;
        row_by_row[t * views.columns + s].clone_from(file);
    }
    Views { format: "list of views", views, files: &row_by_row, expected: None }.read(limits)
}

/// The files of a grid of views, in reading order.
pub(crate) struct Views<'a> {
    /// What the folder is, such as `"HCI folder"`, for messages.
    pub(crate) format: &'static str,
    /// The views, T rows and S columns.
    pub(crate) views: GridSize,
    /// One file a view.
    pub(crate) files: &'a [PathBuf],
    /// The size that every view must have, and who says so; without it that of the first view.
    pub(crate) expected: Option<(GridSize, &'a str)>,
}

impl Views<'_> {
    /// Reads all views, on all threads.
    pub(crate) fn read(&self, limits: &Limits) -> Result<DynLightField, Error> {
        let first = &self.files[0];
        let info = self.info(first)?;
        let channels = colours(info.channels);
        let shape = LightFieldShape::new(self.views, info.size).map_err(|error| Error::core(first, error))?;
        let bytes = usize::from(info.bits / 8);
        limits.elements(first.parent().unwrap_or(first), "light field", &shape.array_shape(channels), bytes)?;
        let as_first = |file: &Path| {
            let found = self.info(file)?;
            let same = found.size == info.size && found.bits == info.bits && colours(found.channels) == channels;
            if same {
                return Ok(());
            }
            Err(self.broken(file, format!("it is {}, but {} is {}", in_words(&found), name(first), in_words(&info))))
        };
        if bytes == 1 {
            let pick = |samples| if let DynImage::U8(samples) = samples { Some(samples) } else { None };
            self.fill(shape, channels, limits, as_first, pick).map(DynLightField::U8)
        } else {
            let pick = |samples| if let DynImage::U16(samples) = samples { Some(samples) } else { None };
            self.fill(shape, channels, limits, as_first, pick).map(DynLightField::U16)
        }
    }

    /// Reads one view, without its alpha.
    pub(crate) fn read_one(&self, index: usize, limits: &Limits) -> Result<DynImage, Error> {
        let file = &self.files[index];
        self.info(file)?;
        Ok(without_alpha(read_png(file, limits)?))
    }

    /// Returns the place of view `(t, s)` among the files.
    pub(crate) fn index(&self, folder: &Path, t: usize, s: usize) -> Result<usize, Error> {
        for (what, index, count) in [("view row", t, self.views.rows), ("view column", s, self.views.columns)] {
            if index >= count {
                return Err(Error::core(folder, holo_core::Error::OutOfRange { what, index, count, first: 0 }));
            }
        }
        Ok(t * self.views.columns + s)
    }

    fn fill<T: Copy + Default + Send + Sync>(
        &self,
        shape: LightFieldShape,
        channels: usize,
        limits: &Limits,
        check: impl Fn(&Path) -> Result<(), Error> + Sync,
        pick: impl Fn(DynImage) -> Option<Array3<T>> + Sync,
    ) -> Result<LightFieldOwned<T>, Error> {
        let mut light_field = LightFieldOwned::filled(shape, channels, Layout::ViewpointGrid, T::default())
            .map_err(|error| Error::core(&self.files[0], error))?;
        let read = |file: &PathBuf, mut view: ArrayViewMut3<'_, T>| {
            check(file)?;
            let samples = pick(without_alpha(read_png(file, limits)?)).filter(|samples| samples.dim() == view.dim());
            let samples = samples.ok_or_else(|| self.broken(file, "it changed while it was read".to_owned()))?;
            view.assign(&samples);
            Ok(())
        };
        // The first error in reading order, whichever thread is the fastest.
        let failure = light_field
            .par_views_mut()
            .zip(self.files)
            .map(|((_, view), file)| read(file, view))
            .find_map_first(Result::err);
        failure.map_or(Ok(light_field), Err)
    }

    fn info(&self, file: &Path) -> Result<PngInfo, Error> {
        let info = read_png_info(file)?;
        match self.expected.filter(|(size, _)| *size != info.size) {
            Some((size, who)) => Err(self.broken(
                file,
                format!(
                    "it has {} x {} pixels, but {who} says {} x {}",
                    info.size.columns, info.size.rows, size.columns, size.rows
                ),
            )),
            None => Ok(info),
        }
    }

    fn broken(&self, file: &Path, what: String) -> Error {
        Error::broken(file, self.format, what)
    }
}

/// How many channels are left without alpha.
fn colours(channels: usize) -> usize {
    if channels > 2 { 3 } else { 1 }
}

/// Drops the alpha channel; the colours stay as they are stored, also where they are transparent.
fn without_alpha(samples: DynImage) -> DynImage {
    fn drop<T: Sample>(samples: Array3<T>) -> Array3<T> {
        let channels = samples.dim().2;
        if channels == colours(channels) {
            return samples;
        }
        samples.slice_axis(Axis(2), Slice::from(..colours(channels))).as_standard_layout().into_owned()
    }
    for_each_sample!(DynImage, samples, samples => drop(samples).into())
}

fn in_words(info: &PngInfo) -> String {
    let kind = if info.channels > 2 { "RGB" } else { "grey" };
    format!("{} x {} pixels of {kind} in {} bits", info.size.columns, info.size.rows, info.bits)
}

fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
