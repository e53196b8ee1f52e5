//! A light field of level 7.3 that is written lens row by lens row, so that it never is in memory as a whole.
//!
//! In the file the lens row runs fastest, so rows that come one after another lie far apart: chunks bring them together
//! again. A chunk holds a few lenses and views, as in this crate's HDF5 files, and the rows of a chunk are gathered before they
//! are written.

use std::marker::PhantomData;
use std::path::Path;

use holo_core::{DynLightFieldRef, LightField, Rig, Sample, SampleKind};

use ::hdf5::{Dataset, File, Hyperslab, SliceOrIndex};
use ndarray::{Array5, ArrayD, ArrayView5, Axis, Dimension, Slice};

use super::light_field::{MatOrder, beside};
use super::order::column_major;
use super::{MatClass, v73};
use crate::hdf5::{Failure, Hdf5Options, Number};
use crate::rig_values::RigValues;
use crate::{Error, FileDigest};

/// Lens columns that are turned round at a time, in chunks.
const CHUNKS_AT_A_TIME: usize = 4;

/// Writes a light field into a MAT file of level 7.3, lens row by lens row: `H`, and the rig beside it.
///
/// In memory are four lens rows (79 MB for 64K pixels of 8 bits) and a small part of them turned round, whatever the size of the whole. The file appears when
/// [`finish`](Self::finish) succeeds, and not before. Level 5 cannot be written in this order.
///
/// # Errors
///
/// Every method: [`Error::Io`] if the file cannot be written, a full disk included; [`Error::BadInput`] if an argument does
/// not fit the rig. After an error the file can only be dropped.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightFieldShape, Rig};
/// use holo_io::{Limits, MatWriter, read_mat_light_field};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scene_5d.mat");
/// let rig = Rig::builder(LightFieldShape::new(GridSize::new(2, 3), GridSize::new(6, 5))?).focal_length_m(0.05).sensor_size_m(0.036).baseline_m(1e-3).focus_distance_m(1.0).build()?;
/// let mut mat = MatWriter::<u8>::create(&path, &rig, 3, true)?;
/// for row in 0..6 {
///     mat.write_lens_rows(ndarray::Array5::from_elem((1, 5, 2, 3, 3), row).view())?;
/// }
/// mat.finish()?;
/// assert_eq!(read_mat_light_field(&path, &Limits::default())?.rig, Some(rig));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct MatWriter<T> {
    // The order matters: the dataset is closed first, then the file, and then the temporary file can go.
    rows: AnyRows,
    file: File,
    place: crate::atomic::AtomicPath,
    samples: PhantomData<T>,
}

/// The rows of one of the types.
#[derive(Debug)]
enum AnyRows {
    U8(Rows<u8>),
    U16(Rows<u16>),
    F32(Rows<f32>),
    F64(Rows<f64>),
}

/// A dataset that is written lens row by lens row.
#[derive(Debug)]
struct Rows<T> {
    dataset: Dataset,
    /// (v, u, t, s, c) of the whole.
    shape: [usize; 5],
    /// Lens rows and columns of a chunk.
    chunk: [usize; 2],
    /// Rows on their way: as many as a chunk is high.
    band: Array5<T>,
    /// Rows that came so far.
    count: usize,
}

impl<T: Sample> MatWriter<T> {
    /// Starts a file with samples of `channels` channels.
    pub fn create(path: impl AsRef<Path>, rig: &Rig, channels: usize, is_compressed: bool) -> Result<Self, Error> {
        let path = path.as_ref();
        if channels == 0 {
            return Err(Error::bad_input(path, "a light field without channels"));
        }
        let values = RigValues::from(rig);
        let (place, file) = v73::begin(path)?;
        let failed = |error| Failure { path, is_writing: true }.error(error);
        let counts = [rig.shape().views(), rig.shape().lenses()].map(|size| [size.rows as f64, size.columns as f64]);
        for variable in beside(MatOrder::Lenses, &counts, Some(&values)) {
            v73::variable(&file, &variable, false).map_err(failed)?;
        }
        let shape = rig.shape().array_shape(channels);
        let rows = match T::KIND {
            SampleKind::U8 => Rows::create(&file, shape, MatClass::U8, is_compressed).map(AnyRows::U8),
            SampleKind::U16 => Rows::create(&file, shape, MatClass::U16, is_compressed).map(AnyRows::U16),
            SampleKind::F32 => Rows::create(&file, shape, MatClass::F32, is_compressed).map(AnyRows::F32),
            SampleKind::F64 => Rows::create(&file, shape, MatClass::F64, is_compressed).map(AnyRows::F64),
        }
        .map_err(failed)?;
        Ok(Self { rows, file, place, samples: PhantomData })
    }

    /// Writes the next lens rows.
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
        match (&mut self.rows, DynLightFieldRef::from(rows)) {
            (AnyRows::U8(out), DynLightFieldRef::U8(rows)) => out.push(rows.into_samples(), path),
            (AnyRows::U16(out), DynLightFieldRef::U16(rows)) => out.push(rows.into_samples(), path),
            (AnyRows::F32(out), DynLightFieldRef::F32(rows)) => out.push(rows.into_samples(), path),
            (AnyRows::F64(out), DynLightFieldRef::F64(rows)) => out.push(rows.into_samples(), path),
            _ => Err(Error::bad_input(path, "rows of another type")),
        }
    }

    /// Completes the file and gives it its name.
    pub fn finish(self) -> Result<FileDigest, Error> {
        let Self { rows, file, place, .. } = self;
        let (count, all) = match &rows {
            AnyRows::U8(rows) => (rows.count, rows.shape[0]),
            AnyRows::U16(rows) => (rows.count, rows.shape[0]),
            AnyRows::F32(rows) => (rows.count, rows.shape[0]),
            AnyRows::F64(rows) => (rows.count, rows.shape[0]),
        };
        if count < all {
            return Err(Error::bad_input(place.path(), format!("only {count} of {all} lens rows were written")));
        }
        drop(rows);
        v73::end(place, file)
    }
}

impl<T: Number> Rows<T> {
    fn create(file: &File, shape: [usize; 5], class: MatClass, is_compressed: bool) -> ::hdf5::Result<Self> {
        let chunk = Hdf5Options::default().chunk_of(&shape, size_of::<T>());
        let reversed = |sides: &[usize]| sides.iter().rev().copied().collect::<Vec<_>>();
        let name = MatOrder::Lenses.name();
        let dataset = v73::chunked::<T>(file, name, &reversed(&shape), reversed(&chunk), class, is_compressed)?;
        let band = Array5::default([chunk[0], shape[1], shape[2], shape[3], shape[4]]);
        Ok(Self { dataset, shape, chunk: [chunk[0], chunk[1]], band, count: 0 })
    }

    /// Takes rows, and writes what makes whole chunks.
    fn push(&mut self, rows: ArrayView5<'_, T>, path: &Path) -> Result<(), Error> {
        let left = self.shape[0] - self.count;
        let given = rows.raw_dim();
        if given.slice()[1..] != self.shape[1..] || given[0] > left {
            let what = format!("rows of shape {given:?} do not fit {:?}, of which {left} rows are left", self.shape);
            return Err(Error::bad_input(path, what));
        }
        let height = self.chunk[0];
        let mut taken = 0;
        while taken < given[0] {
            let filled = self.count % height;
            let count = (height - filled).min(given[0] - taken);
            let source = rows.slice_axis(Axis(0), Slice::from(taken..taken + count));
            let start = self.count - filled;
            let end = self.count + count;
            let is_full = end.is_multiple_of(height) || end == self.shape[0];
            let failure = Failure { path, is_writing: true };
            if filled == 0 && is_full {
                self.write(start, source).map_err(|error| failure.error(error))?;
            } else {
                self.band.slice_axis_mut(Axis(0), Slice::from(filled..filled + count)).assign(&source);
                if is_full {
                    let band = self.band.slice_axis(Axis(0), Slice::from(..end - start));
                    self.write(start, band).map_err(|error| failure.error(error))?;
                }
            }
            taken += count;
            self.count += count;
        }
        Ok(())
    }

    /// Writes the rows of a chunk, some columns of chunks at a time.
    fn write(&self, first: usize, rows: ArrayView5<'_, T>) -> ::hdf5::Result<()> {
        let step = self.chunk[1] * CHUNKS_AT_A_TIME;
        for start in (0..self.shape[1]).step_by(step) {
            let end = self.shape[1].min(start + step);
            let part = rows.slice_axis(Axis(1), Slice::from(start..end));
            let mut turned = Vec::with_capacity(part.len());
            let gathered = column_major(&part.into_dyn(), <[T]>::to_vec, |slab| {
                turned.extend(slab);
                Ok::<_, std::convert::Infallible>(())
            });
            let Ok(()) = gathered;
            let shape: Vec<usize> = part.shape().iter().rev().copied().collect();
            let turned = ArrayD::from_shape_vec(shape.clone(), turned).map_err(|error| error.to_string())?;
            let mut slices: Vec<SliceOrIndex> = shape[..3].iter().map(|&count| (0..count).into()).collect();
            slices.extend([start..end, first..first + shape[4]].map(SliceOrIndex::from));
            self.dataset.write_slice(turned.view(), Hyperslab::from(slices))?;
        }
        Ok(())
    }
}
