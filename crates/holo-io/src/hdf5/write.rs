//! The writer: lens rows as they come.

use std::marker::PhantomData;
use std::path::Path;

use holo_core::{DynLightFieldRef, LightField, Rig, Sample, SampleKind};

use ::hdf5::{Dataset, File, Hyperslab, SliceOrIndex};
use ndarray::parallel::prelude::*;
use ndarray::{ArrayD, ArrayView2, ArrayView4, ArrayView5, ArrayViewD, Axis, IxDyn, Slice};

use super::library::{Failure, create};
use super::{Hdf5Map, Hdf5Options, Number, attributes};
use crate::atomic::AtomicPath;
use crate::{Error, FileDigest};

/// Writes a light field lens row by lens row, and the ground truth beside it.
///
/// In memory are as many lens rows as a chunk is high, of the samples and of each map, whatever the size of the whole: 256 MiB
/// at most for samples of 100 x 100 views up to 109K pixels wide, as float32 of three channels. The file appears when [`finish`](Self::finish) succeeds, and not before.
///
/// # Errors
///
/// Every method: [`Error::Io`] if the file cannot be written, a full disk included; [`Error::BadInput`] if an argument does
/// not fit the rig. After an error the file can only be dropped.
#[derive(Debug)]
pub struct Hdf5Writer<T> {
    // The order matters: datasets are closed first, then the file, and then the temporary file can go.
    samples: AnyRows,
    maps: Vec<(Hdf5Map, Rows<f32>)>,
    file: File,
    place: AtomicPath,
    options: Hdf5Options,
    rig: Rig,
    sample: PhantomData<T>,
}

/// The samples, of one of the types.
#[derive(Debug)]
enum AnyRows {
    U8(Rows<u8>),
    U16(Rows<u16>),
    F32(Rows<f32>),
    F64(Rows<f64>),
}

/// Runs the same on whichever it is.
macro_rules! any {
    ($rows:expr, $name:ident => $body:expr) => {
        match $rows {
            AnyRows::U8($name) => $body,
            AnyRows::U16($name) => $body,
            AnyRows::F32($name) => $body,
            AnyRows::F64($name) => $body,
        }
    };
}

/// A dataset that is written along its first axis.
#[derive(Debug)]
struct Rows<T> {
    dataset: Dataset,
    shape: Vec<usize>,
    /// Rows on their way: as many as a chunk is high.
    band: ArrayD<T>,
    /// Rows that came so far.
    count: usize,
}

impl<T: Sample> Hdf5Writer<T> {
    /// Starts a file with samples of `channels` channels, and with these maps of all views.
    pub fn create(
        path: impl AsRef<Path>,
        rig: &Rig,
        channels: usize,
        maps: &[Hdf5Map],
        options: &Hdf5Options,
    ) -> Result<Self, Error> {
        let path = path.as_ref();
        if channels == 0 {
            return Err(Error::bad_input(path, "a light field without channels"));
        }
        if options.gzip_level > 9 {
            return Err(Error::bad_input(path, format!("gzip has levels 0 to 9, not {}", options.gzip_level)));
        }
        let place = AtomicPath::create(path)?;
        let failed = |error| Failure { path, is_writing: true }.error(error);
        let file = create(place.temporary_path(), 0, false).map_err(failed)?;
        attributes::write_rig(&file, rig).map_err(failed)?;
        let shape = rig.shape().array_shape(channels);
        // Linear radiance has no unit here: 1 is what exposure 0 shows as white.
        let unit = if T::KIND.is_float() { "linear radiance" } else { "sRGB" };
        let (name, axes) = ("H", "vutsc");
        let samples = match T::KIND {
            SampleKind::U8 => AnyRows::U8(Rows::create(&file, name, &shape, axes, unit, options, path)?),
            SampleKind::U16 => AnyRows::U16(Rows::create(&file, name, &shape, axes, unit, options, path)?),
            SampleKind::F32 => AnyRows::F32(Rows::create(&file, name, &shape, axes, unit, options, path)?),
            SampleKind::F64 => AnyRows::F64(Rows::create(&file, name, &shape, axes, unit, options, path)?),
        };
        let mut rows = Vec::with_capacity(maps.len());
        for &kind in maps {
            if rows.iter().any(|&(other, _)| other == kind) {
                return Err(Error::bad_input(path, format!("two maps {}", kind.name())));
            }
            rows.push((kind, Rows::create(&file, kind.name(), &shape[..4], "vuts", kind.unit(), options, path)?));
        }
        Ok(Self { samples, maps: rows, file, place, options: *options, rig: *rig, sample: PhantomData })
    }

    /// Returns how many lens rows are best written in one call: fewer or more are right too, but are copied once.
    #[must_use]
    pub fn lens_rows_at_a_time(&self) -> usize {
        any!(&self.samples, rows => rows.band.len_of(Axis(0)))
    }

    /// Writes the next lens rows of the samples.
    ///
    /// # Shape
    ///
    /// `(rows, u, t, s, c)`, any strides and any number of rows that are left.
    pub fn write_lens_rows(&mut self, rows: ArrayView5<'_, T>) -> Result<(), Error> {
        if rows.is_empty() {
            return Ok(());
        }
        let path = self.place.path();
        let rows = LightField::new(rows).map_err(|error| Error::core(path, error))?;
        match (&mut self.samples, DynLightFieldRef::from(rows)) {
            (AnyRows::U8(out), DynLightFieldRef::U8(rows)) => out.push(rows.into_samples().into_dyn(), path),
            (AnyRows::U16(out), DynLightFieldRef::U16(rows)) => out.push(rows.into_samples().into_dyn(), path),
            (AnyRows::F32(out), DynLightFieldRef::F32(rows)) => out.push(rows.into_samples().into_dyn(), path),
            (AnyRows::F64(out), DynLightFieldRef::F64(rows)) => out.push(rows.into_samples().into_dyn(), path),
            _ => Err(Error::bad_input(path, "rows of another type")),
        }
    }

    /// Writes the next lens rows of a map of all views.
    ///
    /// # Shape
    ///
    /// `(rows, u, t, s)`, any strides and any number of rows that are left.
    pub fn write_map_lens_rows(&mut self, map: Hdf5Map, rows: ArrayView4<'_, f32>) -> Result<(), Error> {
        let path = self.place.path();
        match self.maps.iter_mut().find(|&&mut (kind, _)| kind == map) {
            Some((_, dataset)) => dataset.push(rows.into_dyn(), path),
            None => Err(Error::bad_input(path, format!("the file was started without a map {}", map.name()))),
        }
    }

    /// Writes a map of the central view, which is row T/2, column S/2.
    ///
    /// # Shape
    ///
    /// `(v, u)`, any strides.
    pub fn write_central_map(&mut self, map: Hdf5Map, values: ArrayView2<'_, f32>) -> Result<(), Error> {
        let path = self.place.path();
        let failed = |error| Failure { path, is_writing: true }.error(error);
        if self.file.link_exists("central") {
            let group = self.file.group("central").map_err(failed)?;
            if group.link_exists(map.name()) {
                return Err(Error::bad_input(path, format!("two central maps {}", map.name())));
            }
        } else {
            // Without a clock, like everything here.
            self.file.create_group_builder().obj_track_times(false).create("central").map_err(failed)?;
        }
        let lenses = self.rig.shape().lenses();
        let name = format!("central/{}", map.name());
        let whole = Hdf5Options { chunk: Some([lenses.rows, lenses.columns, 1, 1]), ..self.options };
        let shape = [lenses.rows, lenses.columns];
        let mut rows = Rows::create(&self.file, &name, &shape, "vu", map.unit(), &whole, path)?;
        rows.push(values.into_dyn(), path)?;
        rows.check_complete(&name, path)
    }

    /// Completes the file and gives it its name.
    pub fn finish(self) -> Result<FileDigest, Error> {
        let Self { samples, maps, file, place, .. } = self;
        let failed = |error| Failure { path: place.path(), is_writing: true }.error(error);
        any!(&samples, rows => rows.check_complete("H", place.path()))?;
        maps.iter().try_for_each(|(kind, rows)| rows.check_complete(kind.name(), place.path()))?;
        drop((samples, maps));
        // By its own call, because closing tells no errors.
        file.flush().map_err(failed)?;
        file.close().map_err(failed)?;
        place.commit()
    }
}

impl<T: Number> Rows<T> {
    fn create(
        file: &File,
        name: &str,
        shape: &[usize],
        axes: &str,
        units: &str,
        options: &Hdf5Options,
        path: &Path,
    ) -> Result<Self, Error> {
        let failed = |error| Failure { path, is_writing: true }.error(error);
        let chunk = options.chunk_of(shape, size_of::<T>());
        let mut builder = file
            .new_dataset::<T>()
            .shape(shape)
            .chunk(chunk.clone())
            // No clock in the file, and no value for what will be written anyway.
            .obj_track_times(false)
            .fill_time(::hdf5::dataset::FillTime::Never);
        if options.gzip_level > 0 {
            builder = builder.shuffle().deflate(options.gzip_level);
        }
        let dataset = builder.create(name).map_err(failed)?;
        attributes::write_axes(&dataset, axes, units).map_err(failed)?;
        let mut band = shape.to_vec();
        band[0] = chunk[0];
        Ok(Self { dataset, shape: shape.to_vec(), band: ArrayD::default(IxDyn(&band)), count: 0 })
    }

    /// Takes rows, and writes what makes whole chunks.
    fn push(&mut self, rows: ArrayViewD<'_, T>, path: &Path) -> Result<(), Error> {
        let left = self.shape[0] - self.count;
        if rows.shape()[1..] != self.shape[1..] || rows.shape()[0] > left {
            return Err(Error::bad_input(
                path,
                format!("rows of shape {:?} do not fit {:?}, of which {left} rows are left", rows.shape(), self.shape),
            ));
        }
        let height = self.band.len_of(Axis(0));
        let mut taken = 0;
        while taken < rows.shape()[0] {
            let filled = self.count % height;
            let count = (height - filled).min(rows.shape()[0] - taken);
            let source = rows.slice_axis(Axis(0), Slice::from(taken..taken + count));
            let start = self.count - filled;
            let end = self.count + count;
            let is_full = end.is_multiple_of(height) || end == self.shape[0];
            if filled == 0 && is_full && source.is_standard_layout() {
                self.write(start..end, source).map_err(|error| Failure { path, is_writing: true }.error(error))?;
            } else {
                copy(source, self.band.slice_axis_mut(Axis(0), Slice::from(filled..filled + count)));
                if is_full {
                    let band = self.band.slice_axis(Axis(0), Slice::from(..end - start));
                    self.write(start..end, band).map_err(|error| Failure { path, is_writing: true }.error(error))?;
                }
            }
            taken += count;
            self.count += count;
        }
        Ok(())
    }

    fn write(&self, rows: std::ops::Range<usize>, values: ArrayViewD<'_, T>) -> ::hdf5::Result<()> {
        let whole = self.shape[1..].iter().map(|&count| SliceOrIndex::from(0..count));
        let slab: Vec<SliceOrIndex> = std::iter::once(SliceOrIndex::from(rows)).chain(whole).collect();
        self.dataset.write_slice(values, Hyperslab::from(slab))
    }

    fn check_complete(&self, name: &str, path: &Path) -> Result<(), Error> {
        if self.count < self.shape[0] {
            let what = format!("only {} of {} lens rows of '{name}' were written", self.count, self.shape[0]);
            return Err(Error::bad_input(path, what));
        }
        Ok(())
    }
}

/// Copies rows of any strides, side by side.
fn copy<T: Copy + Send + Sync>(source: ArrayViewD<'_, T>, mut target: ndarray::ArrayViewMutD<'_, T>) {
    let (source, target) = (source.axis_iter(Axis(1)), target.axis_iter_mut(Axis(1)));
    target.into_par_iter().zip(source.into_par_iter()).for_each(|(mut target, source)| target.assign(&source));
}
