//! A writer of light fields of version 7.3 lens row by lens row, for those that do not fit into memory.
//!
//! In the file the index of the lens row runs fastest, so consecutive lens rows are far apart in a contiguous dataset.
//! Therefore the dataset has the chunks of this crate's HDF5 files, a few microlenses and views, and the lens rows of a
//! chunk are collected before they are written.

use std::convert::Infallible;
use std::marker::PhantomData;
use std::ops::Range;
use std::path::Path;

use holo_core::{DynLightFieldRef, LightField, Rig, Sample, SampleKind};

use ::hdf5::{Dataset, File, Hyperslab, SliceOrIndex};
use ndarray::{ArrayD, ArrayView5, ArrayViewD, Axis, Slice};

use super::light_field::{MatOrder, metadata};
use super::order::column_major;
use super::{MatClass, v73};
use crate::arrays::hdf5::{Failure, Hdf5Options, Number, RowDataset, SampleRows, with_sample_type};
use crate::arrays::rig_values::RigValues;
use crate::files::atomic::AtomicPath;
use crate::{Error, FileDigest};

/// Lens columns that are reversed at a time, in chunks.
const CHUNKS_AT_A_TIME: usize = 4;

/// A writer of a light field into a MAT file of version 7.3, lens row by lens row; the variables are `H` and those of
/// the rig as in [`write_mat_light_field`](crate::write_mat_light_field).
///
/// It needs the memory of four lens rows, fewer where they are large, and of a small part of them, whatever the size of
/// the light field. The file appears when [`finish`](Self::finish) succeeds. Version 5 cannot be written in this order.
///
/// # Errors
///
/// Every method: [`Error::Io`] if the file cannot be written, for example on a full disk; [`Error::BadInput`] if an
/// argument contradicts the rig. After an error the writer can only be dropped, which leaves no file.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, Rig, LightFieldShape};
/// use holo_io::{Limits, MatWriter, read_mat_light_field};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scene_5d.mat");
/// let rig = Rig::builder(LightFieldShape::new(GridSize::new(2, 3), GridSize::new(6, 5))?)
///     .focal_length_m(0.05)
///     .sensor_size_m(0.036)
///     .baseline_m(1e-3)
///     .focus_distance_m(1.0)
///     .build()?;
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
    // Fields are dropped in order: dataset and file are closed before the temporary file is removed.
    rows: SampleRows<ColumnMajor>,
    file: File,
    target: AtomicPath,
    samples: PhantomData<T>,
}

/// A dataset with the axes of the array in memory reversed.
#[derive(Debug)]
struct ColumnMajor {
    dataset: Dataset,
    /// Lens columns that are reversed at a time.
    columns_at_a_time: usize,
}

impl RowDataset for ColumnMajor {
    const NEEDS_ROW_MAJOR: bool = false;

    fn write<T: Number>(&self, rows: Range<usize>, values: ArrayViewD<'_, T>) -> ::hdf5::Result<()> {
        let columns = values.len_of(Axis(1));
        for start in (0..columns).step_by(self.columns_at_a_time) {
            let end = columns.min(start + self.columns_at_a_time);
            let part = values.slice_axis(Axis(1), Slice::from(start..end));
            let mut reversed = Vec::with_capacity(part.len());
            let gathered = column_major(&part, <[T]>::to_vec, |slab| {
                reversed.extend(slab);
                Ok::<_, Infallible>(())
            });
            let Ok(()) = gathered;
            let shape: Vec<usize> = part.shape().iter().rev().copied().collect();
            let mut slices: Vec<SliceOrIndex> = shape[..3].iter().map(|&count| (0..count).into()).collect();
            slices.extend([start..end, rows.clone()].map(SliceOrIndex::from));
            let reversed = ArrayD::from_shape_vec(shape, reversed).map_err(|error| error.to_string())?;
            self.dataset.write_slice(reversed.view(), Hyperslab::from(slices))?;
        }
        Ok(())
    }
}

impl<T: Sample> MatWriter<T> {
    /// Starts a file with samples of `channels` channels.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if `channels` is 0; [`Error::Io`] if the file cannot be written.
    pub fn create(path: impl AsRef<Path>, rig: &Rig, channels: usize, is_compressed: bool) -> Result<Self, Error> {
        let path = path.as_ref();
        if channels == 0 {
            return Err(Error::bad_input(path, "a light field without channels"));
        }
        let values = RigValues::from(rig);
        let (target, file) = v73::begin(&path)?;
        let failed = |error| Failure { path, is_writing: true }.error(error);
        let counts = [rig.shape().views(), rig.shape().lenses()].map(|size| [size.rows as f64, size.columns as f64]);
        for variable in metadata(MatOrder::Lenses, &counts, Some(&values)) {
            v73::variable(&file, &variable, false).map_err(failed)?;
        }
        let shape = rig.shape().array_shape(channels);
        let class = match T::KIND {
            SampleKind::U8 => MatClass::U8,
            SampleKind::U16 => MatClass::U16,
            SampleKind::F32 => MatClass::F32,
            SampleKind::F64 => MatClass::F64,
        };
        let (dataset, chunk_rows) = with_sample_type!(T::KIND, S => {
            create_dataset::<S>(&file, &shape, class, is_compressed)
        })
        .map_err(failed)?;
        let rows = SampleRows::new(T::KIND, dataset, &shape, chunk_rows);
        Ok(Self { rows, file, target, samples: PhantomData })
    }

    /// Writes the next lens rows.
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
        self.rows.push(DynLightFieldRef::from(rows), path)
    }

    /// Completes the file and renames it to its path.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if lens rows are missing; [`Error::Io`] if the file cannot be written.
    pub fn finish(self) -> Result<FileDigest, Error> {
        let Self { rows, file, target, .. } = self;
        rows.check_complete(MatOrder::Lenses.name(), target.path())?;
        drop(rows);
        v73::end(target, file)
    }
}

/// Creates the dataset of the samples, and returns it with the number of lens rows of a chunk. `shape` is (v, u, t, s,
/// c).
fn create_dataset<T: Number>(
    file: &File,
    shape: &[usize; 5],
    class: MatClass,
    is_compressed: bool,
) -> ::hdf5::Result<(ColumnMajor, usize)> {
    let chunk = Hdf5Options::default().chunk_of(shape, size_of::<T>());
    let reversed = |sides: &[usize]| sides.iter().rev().copied().collect::<Vec<_>>();
    let name = MatOrder::Lenses.name();
    let dataset = v73::chunked::<T>(file, name, &reversed(shape), reversed(&chunk), class, is_compressed)?;
    Ok((ColumnMajor { dataset, columns_at_a_time: chunk[1] * CHUNKS_AT_A_TIME }, chunk[0]))
}
