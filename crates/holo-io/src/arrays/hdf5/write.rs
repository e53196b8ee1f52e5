//! The writer of a light field, lens row by lens row.

use std::marker::PhantomData;
use std::ops::Range;

use holo_core::{DynLightFieldRef, LightField, Rig, Sample};

use ::hdf5::{Dataset, File, Hyperslab, SliceOrIndex};
use ndarray::{ArrayView2, ArrayView4, ArrayView5, ArrayViewD};

use super::library::{Failure, create};
use super::rows::{RowDataset, Rows, SampleRows};
use super::scales::{self, Scales};
use super::{Hdf5Map, Hdf5Options, Number, attributes, with_sample_type};
use crate::files::atomic::AtomicPath;
use crate::files::folder::Destination;
use crate::{Error, FileDigest};

/// The axes of a light field, a letter each.
const AXES: &str = "vutsc";

/// A writer of an HDF5 light field with ground truth, lens row by lens row.
///
/// It needs the memory of the lens rows of one chunk, of the samples and of each map, whatever the size of the light
/// field: at most 256 MiB for float32 samples of three channels and 100 x 100 views, up to a raw image of 109K pixels
/// across. The file appears when [`finish`](Self::finish) succeeds.
///
/// # Errors
///
/// Every method: [`Error::Io`] if the file cannot be written, for example on a full disk; [`Error::BadInput`] if an
/// argument contradicts the rig. After an error the writer can only be dropped, which leaves no file.
#[derive(Debug)]
pub struct Hdf5Writer<T> {
    // Fields are dropped in order: datasets and file are closed before the temporary file is removed.
    /// `None`: maps alone.
    samples: Option<SampleRows<RowMajor>>,
    maps: Vec<(Hdf5Map, Rows<f32, RowMajor>)>,
    scales: Scales,
    file: File,
    target: AtomicPath,
    options: Hdf5Options,
    rig: Rig,
    sample: PhantomData<T>,
}

/// A dataset with the axes of the array in memory.
#[derive(Debug)]
struct RowMajor(Dataset);

impl RowDataset for RowMajor {
    const NEEDS_ROW_MAJOR: bool = true;

    fn write<T: Number>(&self, rows: Range<usize>, values: ArrayViewD<'_, T>) -> ::hdf5::Result<()> {
        let others = values.shape()[1..].iter().map(|&count| SliceOrIndex::from(0..count));
        let slab: Vec<SliceOrIndex> = std::iter::once(SliceOrIndex::from(rows)).chain(others).collect();
        self.0.write_slice(values, Hyperslab::from(slab))
    }
}

impl<T: Sample> Hdf5Writer<T> {
    /// Starts a file with samples of `channels` channels, and with these maps of all views.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if `channels` is 0, the level of gzip is above 9, or a map occurs twice; [`Error::Io`] if
    /// the file cannot be written.
    pub fn create(
        path: impl Destination,
        rig: &Rig,
        channels: usize,
        maps: &[Hdf5Map],
        options: &Hdf5Options,
    ) -> Result<Self, Error> {
        if channels == 0 {
            return Err(Error::bad_input(path.path(), "a light field without channels"));
        }
        Self::start(&path, rig, Some(channels), maps, options)
    }

    /// Starts a file with samples, or without channels one of maps alone.
    pub(super) fn start(
        destination: &dyn Destination,
        rig: &Rig,
        channels: Option<usize>,
        maps: &[Hdf5Map],
        options: &Hdf5Options,
    ) -> Result<Self, Error> {
        let path = destination.path();
        if let Some(level) = options.gzip_level.filter(|level| *level > 9) {
            return Err(Error::bad_input(path, format!("gzip has the levels 0 to 9, not {level}")));
        }
        let target = AtomicPath::create(destination)?;
        let failed = |error| Failure { path, is_writing: true }.error(error);
        let text = scales::text_type(target.temporary_path(), path)?;
        let file = create(target.temporary_path(), 0, false).map_err(failed)?;
        attributes::write_rig(&file, attributes::LAYOUT, AXES, rig).map_err(failed)?;
        let shape = rig.shape().array_shape(channels.unwrap_or(1));
        let axes = AXES.chars().zip(shape.map(scales::indices)).take(if channels.is_some() { 5 } else { 4 });
        let mut scales = Scales::create(&file, axes.collect(), &text).map_err(failed)?;
        // Radiance has no unit: 1 is white at exposure 0.
        let unit = if T::KIND.is_float() { "linear radiance" } else { "sRGB" };
        let samples = channels.map(|_| {
            let (dataset, chunk_rows) = with_sample_type!(T::KIND, S => {
                create_dataset::<S>(&file, &mut scales, "H", &shape, (AXES, unit), options)
            })
            .map_err(failed)?;
            Ok::<_, Error>(SampleRows::new(T::KIND, dataset, &shape, chunk_rows))
        });
        let samples = samples.transpose()?;
        let mut rows = Vec::with_capacity(maps.len());
        for &kind in maps {
            if rows.iter().any(|&(other, _)| other == kind) {
                return Err(Error::bad_input(path, format!("two maps {}", kind.name())));
            }
            let (dataset, chunk_rows) =
                create_dataset::<f32>(&file, &mut scales, kind.name(), &shape[..4], ("vuts", kind.unit()), options)
                    .map_err(failed)?;
            rows.push((kind, Rows::new(dataset, &shape[..4], chunk_rows)));
        }
        Ok(Self { samples, maps: rows, scales, file, target, options: *options, rig: *rig, sample: PhantomData })
    }

    /// Returns the number of lens rows of a chunk. Rows that are written in such groups are not copied into a buffer,
    /// if they are contiguous in row-major order.
    #[must_use]
    pub fn lens_rows_at_a_time(&self) -> usize {
        let maps = || self.maps.first().map_or(1, |(_, rows)| rows.chunk_rows());
        self.samples.as_ref().map_or_else(maps, SampleRows::chunk_rows)
    }

    /// Writes the next lens rows of the samples.
    ///
    /// # Shape
    ///
    /// `(rows, u, t, s, c)`, any strides and any number of rows up to those that are left.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if the shape is wrong or there are too many rows; [`Error::Io`] if the file cannot be
    /// written.
    pub fn write_lens_rows(&mut self, rows: ArrayView5<'_, T>) -> Result<(), Error> {
        if rows.is_empty() {
            return Ok(());
        }
        let path = self.target.path();
        let rows = LightField::new(rows).map_err(|error| Error::core(path, error))?;
        match &mut self.samples {
            Some(samples) => samples.push(DynLightFieldRef::from(rows), path),
            None => Err(Error::bad_input(path, "the file was started without samples")),
        }
    }

    /// Writes the next lens rows of a map of all views.
    ///
    /// # Shape
    ///
    /// `(rows, u, t, s)`, any strides and any number of rows up to those that are left.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if the file was started without this map, the shape is wrong or there are too many rows;
    /// [`Error::Io`] if the file cannot be written.
    pub fn write_map_lens_rows(&mut self, map: Hdf5Map, rows: ArrayView4<'_, f32>) -> Result<(), Error> {
        let path = self.target.path();
        match self.maps.iter_mut().find(|&&mut (kind, _)| kind == map) {
            Some((_, dataset)) => dataset.push(rows.into_dyn(), path),
            None => Err(Error::bad_input(path, format!("the file was started without a map {}", map.name()))),
        }
    }

    /// Writes a map of the central view, which is row floor(T/2), column floor(S/2).
    ///
    /// # Shape
    ///
    /// `(v, u)`, any strides.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if the shape is wrong or the map was written before; [`Error::Io`] if the file cannot be
    /// written.
    pub fn write_central_map(&mut self, map: Hdf5Map, values: ArrayView2<'_, f32>) -> Result<(), Error> {
        let path = self.target.path();
        let failed = |error| Failure { path, is_writing: true }.error(error);
        if self.file.link_exists("central") {
            let group = self.file.group("central").map_err(failed)?;
            if group.link_exists(map.name()) {
                return Err(Error::bad_input(path, format!("two central maps {}", map.name())));
            }
        } else {
            // No clock in the file.
            self.file.create_group_builder().obj_track_times(false).create("central").map_err(failed)?;
        }
        let lenses = self.rig.shape().lenses();
        let name = format!("central/{}", map.name());
        let whole = Hdf5Options { chunk: Some([lenses.rows, lenses.columns, 1, 1]), ..self.options };
        let shape = [lenses.rows, lenses.columns];
        let (dataset, chunk_rows) =
            create_dataset::<f32>(&self.file, &mut self.scales, &name, &shape, ("vu", map.unit()), &whole)
                .map_err(failed)?;
        let mut rows = Rows::new(dataset, &shape, chunk_rows);
        rows.push(values.into_dyn(), path)?;
        rows.check_complete(&name, path)
    }

    /// Completes the file and renames it to its path.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if lens rows are missing; [`Error::Io`] if the file cannot be written.
    pub fn finish(self) -> Result<FileDigest, Error> {
        let Self { samples, maps, scales, file, target, .. } = self;
        let failed = |error| Failure { path: target.path(), is_writing: true }.error(error);
        samples.iter().try_for_each(|samples| samples.check_complete("H", target.path()))?;
        maps.iter().try_for_each(|(kind, rows)| rows.check_complete(kind.name(), target.path()))?;
        scales.finish(&file).map_err(failed)?;
        drop((samples, maps));
        // Explicitly, because closing reports no errors.
        file.flush().map_err(failed)?;
        file.close().map_err(failed)?;
        target.commit()
    }
}

/// Creates a dataset, and returns it with the number of rows of a chunk. `axes` has a letter for each axis.
fn create_dataset<T: Number>(
    file: &File,
    scales: &mut Scales,
    name: &str,
    shape: &[usize],
    (axes, units): (&str, &str),
    options: &Hdf5Options,
) -> ::hdf5::Result<(RowMajor, usize)> {
    let chunk = options.chunk_of(shape, size_of::<T>());
    let chunk_rows = chunk[0];
    let mut builder = file
        .new_dataset::<T>()
        .shape(shape)
        .chunk(chunk)
        // No clock in the file, and no fill value, because everything is written.
        .obj_track_times(false)
        .fill_time(::hdf5::dataset::FillTime::Never);
    let level = options.gzip_level_of(shape);
    if level > 0 {
        builder = builder.shuffle().deflate(level);
    }
    let dataset = builder.create(name)?;
    attributes::write_axes(&dataset, axes, units)?;
    scales.attach(file, name, axes)?;
    Ok((RowMajor(dataset), chunk_rows))
}
