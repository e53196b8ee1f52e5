//! Datasets of an HDF5 file that are written lens row by lens row, in complete chunks.

use std::ops::Range;
use std::path::Path;

use holo_core::{DynLightFieldRef, SampleKind};
use ndarray::parallel::prelude::*;
use ndarray::{ArrayD, ArrayViewD, ArrayViewMutD, Axis, IxDyn, Slice};

use super::Number;
use super::library::Failure;
use crate::Error;

/// A dataset into which lens rows are written.
pub(crate) trait RowDataset {
    /// Whether rows must be contiguous in row-major order for [`write`](Self::write).
    const NEEDS_ROW_MAJOR: bool;

    /// Writes the lens rows `rows`; their first axis counts the rows.
    fn write<T: Number>(&self, rows: Range<usize>, values: ArrayViewD<'_, T>) -> ::hdf5::Result<()>;
}

/// A dataset that is written along its first axis, and the buffer of its incomplete chunks.
#[derive(Debug)]
pub(crate) struct Rows<T, D> {
    dataset: D,
    shape: Vec<usize>,
    /// Rows that do not fill a chunk yet: as many as a chunk has.
    band: ArrayD<T>,
    /// Number of rows that were pushed.
    count: usize,
}

impl<T: Number, D: RowDataset> Rows<T, D> {
    /// Starts a dataset of this shape, whose chunks have `chunk_rows` rows.
    pub(crate) fn new(dataset: D, shape: &[usize], chunk_rows: usize) -> Self {
        let mut band = shape.to_vec();
        band[0] = chunk_rows;
        Self { dataset, shape: shape.to_vec(), band: ArrayD::default(IxDyn(&band)), count: 0 }
    }

    /// Number of rows of a chunk.
    pub(crate) fn chunk_rows(&self) -> usize {
        self.band.len_of(Axis(0))
    }

    /// Takes the next rows, of any strides, and writes complete chunks.
    pub(crate) fn push(&mut self, rows: ArrayViewD<'_, T>, path: &Path) -> Result<(), Error> {
        let left = self.shape[0] - self.count;
        if rows.shape()[1..] != self.shape[1..] || rows.shape()[0] > left {
            let what =
                format!("rows of shape {:?} do not fit {:?}, of which {left} rows are left", rows.shape(), self.shape);
            return Err(Error::bad_input(path, what));
        }
        let failed = |error| Failure { path, is_writing: true }.error(error);
        let height = self.chunk_rows();
        let mut taken = 0;
        while taken < rows.shape()[0] {
            let filled = self.count % height;
            let count = (height - filled).min(rows.shape()[0] - taken);
            let source = rows.slice_axis(Axis(0), Slice::from(taken..taken + count));
            let start = self.count - filled;
            let end = self.count + count;
            let is_full = end.is_multiple_of(height) || end == self.shape[0];
            if filled == 0 && is_full && (!D::NEEDS_ROW_MAJOR || source.is_standard_layout()) {
                self.dataset.write(start..end, source).map_err(failed)?;
            } else {
                copy(source, self.band.slice_axis_mut(Axis(0), Slice::from(filled..filled + count)));
                if is_full {
                    let band = self.band.slice_axis(Axis(0), Slice::from(..end - start));
                    self.dataset.write(start..end, band).map_err(failed)?;
                }
            }
            taken += count;
            self.count += count;
        }
        Ok(())
    }

    /// Checks that all rows were pushed.
    pub(crate) fn check_complete(&self, name: &str, path: &Path) -> Result<(), Error> {
        if self.count < self.shape[0] {
            let what = format!("only {} of {} lens rows of '{name}' were written", self.count, self.shape[0]);
            return Err(Error::bad_input(path, what));
        }
        Ok(())
    }
}

/// Copies rows of any strides, in parallel.
fn copy<T: Copy + Send + Sync>(source: ArrayViewD<'_, T>, mut target: ArrayViewMutD<'_, T>) {
    let (source, target) = (source.axis_iter(Axis(1)), target.axis_iter_mut(Axis(1)));
    target.into_par_iter().zip(source.into_par_iter()).for_each(|(mut target, source)| target.assign(&source));
}

/// The lens rows of a light field of any sample type.
#[derive(Debug)]
pub(crate) enum SampleRows<D> {
    U8(Rows<u8, D>),
    U16(Rows<u16, D>),
    F32(Rows<f32, D>),
    F64(Rows<f64, D>),
}

/// Evaluates an expression with the rows of whichever sample type.
macro_rules! for_each_rows {
    ($rows:expr, $name:ident => $body:expr) => {
        match $rows {
            SampleRows::U8($name) => $body,
            SampleRows::U16($name) => $body,
            SampleRows::F32($name) => $body,
            SampleRows::F64($name) => $body,
        }
    };
}

impl<D: RowDataset> SampleRows<D> {
    /// Starts a dataset of samples; see [`Rows::new`].
    pub(crate) fn new(kind: SampleKind, dataset: D, shape: &[usize], chunk_rows: usize) -> Self {
        match kind {
            SampleKind::U8 => Self::U8(Rows::new(dataset, shape, chunk_rows)),
            SampleKind::U16 => Self::U16(Rows::new(dataset, shape, chunk_rows)),
            SampleKind::F32 => Self::F32(Rows::new(dataset, shape, chunk_rows)),
            SampleKind::F64 => Self::F64(Rows::new(dataset, shape, chunk_rows)),
        }
    }

    /// Number of rows of a chunk.
    pub(crate) fn chunk_rows(&self) -> usize {
        for_each_rows!(self, rows => rows.chunk_rows())
    }

    /// Takes the next lens rows, and writes complete chunks.
    pub(crate) fn push(&mut self, rows: DynLightFieldRef<'_>, path: &Path) -> Result<(), Error> {
        match (self, rows) {
            (Self::U8(out), DynLightFieldRef::U8(rows)) => out.push(rows.into_samples().into_dyn(), path),
            (Self::U16(out), DynLightFieldRef::U16(rows)) => out.push(rows.into_samples().into_dyn(), path),
            (Self::F32(out), DynLightFieldRef::F32(rows)) => out.push(rows.into_samples().into_dyn(), path),
            (Self::F64(out), DynLightFieldRef::F64(rows)) => out.push(rows.into_samples().into_dyn(), path),
            _ => Err(Error::bad_input(path, "rows of another sample type")),
        }
    }

    /// Checks that all lens rows were pushed.
    pub(crate) fn check_complete(&self, name: &str, path: &Path) -> Result<(), Error> {
        for_each_rows!(self, rows => rows.check_complete(name, path))
    }
}
