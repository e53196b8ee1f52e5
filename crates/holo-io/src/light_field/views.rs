//! A light field from one image a view.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use holo_core::{
    DynImage, DynLightField, GridSize, Layout, LightFieldOwned, LightFieldShape, Sample, SampleKind, ViewOrder,
    for_each_sample,
};
use ndarray::{Array3, ArrayViewMut3, Axis, Slice};
use rayon::prelude::*;

use crate::files::folder::EntryKind;
use crate::images::image_file::{ImageInfo, read_image, read_image_info};
use crate::{Error, Limits};

/// Reads a list of PNGs, TIFFs or SGI images, one a view, as one light field.
///
/// `order` specifies which view each file of the list is. Alpha is dropped. All views must have the same size, the same
/// type of samples, and either gray or RGB.
///
/// # Shape
///
/// `(v, u, t, s, c)` with 1 or 3 channels; in memory a sub-aperture image array.
///
/// # Errors
///
/// [`Error::BadInput`] if there are more or fewer files than views; [`Error::Broken`] if a file differs from the first;
/// [`Error::TooLarge`] if the light field exceeds the limits; otherwise as [`read_png`](crate::read_png) and
/// `read_tiff`.
pub fn read_views(
    files: &[PathBuf],
    views: GridSize,
    order: ViewOrder,
    limits: &Limits,
) -> Result<DynLightField, Error> {
    let first = files.first().map_or(Path::new("list of views"), PathBuf::as_path);
    if files.len() != views.count() || files.is_empty() {
        let what = format!("{} x {} views need as many images, not {}", views.columns, views.rows, files.len());
        return Err(Error::bad_input(first, what));
    }
    let mut row_by_row = files.to_vec();
    for (index, file) in files.iter().enumerate() {
        let (t, s) = order.view(index, views).map_err(|error| Error::core(first, error))?;
        row_by_row[t * views.columns + s].clone_from(file);
    }
    Views { format: "list of views", views, files: &row_by_row, expected: None }.read(limits)
}

/// The files of a grid of views, view row by view row.
pub(crate) struct Views<'a> {
    /// The format of the folder in messages, such as `"HCI folder"`.
    pub(crate) format: &'static str,
    /// The views, T rows and S columns.
    pub(crate) views: GridSize,
    /// One file a view.
    pub(crate) files: &'a [PathBuf],
    /// The size that every view must have and the file that specifies it; `None`: the size of the first view.
    pub(crate) expected: Option<(GridSize, &'a str)>,
}

impl Views<'_> {
    /// Reads all views, in parallel.
    pub(crate) fn read(&self, limits: &Limits) -> Result<DynLightField, Error> {
        let first = &self.files[0];
        let info = self.info(first)?;
        let channels = without_alpha_count(info.channels);
        let shape = LightFieldShape::new(self.views, info.size).map_err(|error| Error::core(first, error))?;
        let bytes = info.kind.bytes();
        limits.elements(first.parent().unwrap_or(first), "light field", &shape.array_shape(channels), bytes)?;
        let check_like_first = |file: &Path| {
            let found = self.info(file)?;
            let same =
                found.size == info.size && found.kind == info.kind && without_alpha_count(found.channels) == channels;
            if same {
                return Ok(());
            }
            Err(self.broken(file, format!("it is {}, but {} is {}", in_words(&found), name(first), in_words(&info))))
        };
        macro_rules! fill {
            ($kind:ident) => {{
                let pick = |samples| if let DynImage::$kind(samples) = samples { Some(samples) } else { None };
                self.fill(shape, channels, limits, check_like_first, pick).map(DynLightField::$kind)
            }};
        }
        match info.kind {
            SampleKind::U8 => fill!(U8),
            SampleKind::U16 => fill!(U16),
            SampleKind::F32 => fill!(F32),
            SampleKind::F64 => fill!(F64),
        }
    }

    /// Reads one view, without its alpha.
    pub(crate) fn read_one(&self, index: usize, limits: &Limits) -> Result<DynImage, Error> {
        let file = &self.files[index];
        self.info(file)?;
        Ok(without_alpha(read_image(file, limits)?))
    }

    /// Returns the index of the file of view `(t, s)`.
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
            let samples = pick(without_alpha(read_image(file, limits)?)).filter(|samples| samples.dim() == view.dim());
            let samples = samples.ok_or_else(|| self.broken(file, "it changed while it was read".to_owned()))?;
            view.assign(&samples);
            Ok(())
        };
        // The first error in the order of the views, whatever the timing of the threads.
        let failure = light_field
            .par_views_mut()
            .zip(self.files)
            .map(|((_, view), file)| read(file, view))
            .find_map_first(Result::err);
        failure.map_or(Ok(light_field), Err)
    }

    fn info(&self, file: &Path) -> Result<ImageInfo, Error> {
        let info = read_image_info(file)?;
        match self.expected.filter(|(size, _)| *size != info.size) {
            Some((size, who)) => Err(self.broken(
                file,
                format!(
                    "it has {} x {} pixels, but {who} specifies {} x {}",
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

/// The number of channels without alpha.
fn without_alpha_count(channels: usize) -> usize {
    if channels > 2 { 3 } else { 1 }
}

/// Drops the alpha channel. The color values stay as they are stored, also where alpha is 0.
fn without_alpha(samples: DynImage) -> DynImage {
    fn drop<T: Sample>(samples: Array3<T>) -> Array3<T> {
        let channels = samples.dim().2;
        if channels == without_alpha_count(channels) {
            return samples;
        }
        samples.slice_axis(Axis(2), Slice::from(..without_alpha_count(channels))).as_standard_layout().into_owned()
    }
    for_each_sample!(DynImage, samples, samples => drop(samples).into())
}

/// Whether a folder has a file or folder whose name is UTF-8 and satisfies `is_wanted`.
pub(crate) fn has_file(folder: &Path, is_wanted: impl Fn(&str) -> bool) -> Result<bool, Error> {
    let failed = |source| Error::io("list", folder, source);
    for entry in fs::read_dir(folder).map_err(failed)? {
        if entry.map_err(failed)?.file_name().to_str().is_some_and(&is_wanted) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// The files of a folder by a key from their names, each with a value from its name; `parse` returns `None` for files
/// to ignore.
///
/// # Errors
///
/// [`Error::Io`] if the folder cannot be listed; [`Error::Broken`] if two files have the same key. `conflict` completes
/// that message: "FILE `conflict`; remove ...".
pub(crate) fn files_by_key<K: Ord, V>(
    folder: &Path,
    format: &'static str,
    conflict: &str,
    parse: impl Fn(&str) -> Option<(K, V)>,
) -> Result<BTreeMap<K, (PathBuf, V)>, Error> {
    let failed = |source| Error::io("list", folder, source);
    let mut files = BTreeMap::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let Some((key, value)) = path.file_name().and_then(|name| name.to_str()).and_then(&parse) else { continue };
        if let Some((other, _)) = files.insert(key, (path.clone(), value)) {
            // The file system returns them in any order; the message does not depend on it.
            let (first, second) = if other < path { (other, path) } else { (path, other) };
            let what = format!("{} {conflict}; remove the one that does not belong here", first.display());
            return Err(Error::broken(&second, format, what));
        }
    }
    Ok(files)
}

/// Checks that a file of a folder is one, and no link to another place.
pub(crate) fn check_regular(path: &Path) -> Result<(), Error> {
    let kind = path.symlink_metadata().map_err(|source| Error::io("read", path, source))?.file_type();
    if kind.is_file() { Ok(()) } else { Err(EntryKind::from(kind).refused("read", path)) }
}

fn in_words(info: &ImageInfo) -> String {
    let color = if info.channels > 2 { "RGB" } else { "gray" };
    let bits = 8 * info.kind.bytes();
    let samples = if info.kind.is_float() { format!("{bits}-bit floats") } else { format!("{bits} bits") };
    format!("{} x {} pixels of {color} in {samples}", info.size.columns, info.size.rows)
}

fn name(file: &Path) -> String {
    file.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
