//! Arrays of bytes in the layout of another program, part by part.

use ::hdf5::{File, Hyperslab, SliceOrIndex};
use ndarray::ArrayViewD;

use super::library::{Failure, create};
use crate::files::atomic::AtomicPath;
use crate::files::folder::Destination;
use crate::{Error, FileDigest};

/// A writer of arrays of 8-bit integers. The caller chooses their names and axes. Nothing is compressed.
///
/// Parts along the first axis are written in any order; those that are not are 0. The file appears when
/// [`finish`](Self::finish) succeeds.
///
/// # Errors
///
/// Every method: [`Error::Io`] if the file cannot be written, for example on a full disk. After an error the writer can only
/// be dropped, which leaves no file.
///
/// # Examples
///
/// ```
/// use holo_io::Hdf5Arrays;
/// use ndarray::Array2;
///
/// # let folder = tempfile::tempdir()?;
/// let file = Hdf5Arrays::create(folder.path().join("two.h5"))?;
/// file.add("images", &[2, 3, 4])?;
/// file.write_part("images", 1, Array2::<u8>::ones((3, 4)).view().into_dyn())?;
/// file.finish()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Hdf5Arrays {
    // The file is closed before the temporary file is removed.
    file: File,
    target: AtomicPath,
}

impl Hdf5Arrays {
    /// Starts a file without arrays.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if it cannot be created.
    pub fn create(path: impl Destination) -> Result<Self, Error> {
        let target = AtomicPath::create(path)?;
        let failed = |error| Failure { path: target.path(), is_writing: true }.error(error);
        let file = create(target.temporary_path(), 0, false).map_err(failed)?;
        Ok(Self { file, target })
    }

    /// Adds an array of zeros with this name.
    ///
    /// # Errors
    ///
    /// Those of [`Hdf5Arrays`]; also if there is an array of this name.
    pub fn add(&self, name: &str, shape: &[usize]) -> Result<(), Error> {
        // No clock in the file.
        let builder = self.file.new_dataset::<u8>().shape(shape).obj_track_times(false);
        builder.create(name).map(drop).map_err(|error| self.failed(error))
    }

    /// Writes a part of an array: that of an index of the first axis, of the shape of the other axes.
    ///
    /// # Errors
    ///
    /// Those of [`Hdf5Arrays`]; also if there is no such array or part.
    pub fn write_part(&self, name: &str, index: usize, part: ArrayViewD<'_, u8>) -> Result<(), Error> {
        let others = part.shape().iter().map(|&count| SliceOrIndex::from(0..count));
        let slab: Vec<SliceOrIndex> = std::iter::once(SliceOrIndex::from(index)).chain(others).collect();
        let dataset = self.file.dataset(name).map_err(|error| self.failed(error))?;
        dataset.write_slice(part.as_standard_layout().view(), Hyperslab::from(slab)).map_err(|error| self.failed(error))
    }

    /// Completes the file and renames it to its path.
    ///
    /// # Errors
    ///
    /// Those of [`Hdf5Arrays`].
    pub fn finish(self) -> Result<FileDigest, Error> {
        let Self { file, target } = self;
        let failed = |error| Failure { path: target.path(), is_writing: true }.error(error);
        // Explicitly, because closing reports no errors.
        file.flush().map_err(failed)?;
        file.close().map_err(failed)?;
        target.commit()
    }

    fn failed(&self, error: ::hdf5::Error) -> Error {
        Failure { path: self.target.path(), is_writing: true }.error(error)
    }
}
