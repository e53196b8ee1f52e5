//! A writer of EXR band by band, for images that do not fit into memory.

use holo_core::GridSize;
use ndarray::ArrayView2;

use super::write::Encoder;
use super::{ExrCompression, ExrSamples};
use crate::files::folder::Destination;
use crate::{AtomicFile, Error, FileDigest};

/// A writer of an EXR, from top to bottom, a band of rows at a time.
///
/// It needs a few times 64 MiB of memory (or a few blocks of lines, if those are more), whatever the size of the image.
/// The bytes of the file depend neither on the bands nor on the number of threads.
///
/// The file appears when [`finish`](Self::finish) succeeds; a writer that is dropped leaves no file. Where `path` is a
/// device or a pipe, in which the offset table cannot be written last, the compressed file stays in memory until then.
///
/// # Examples
///
/// ```
/// use holo_core::GridSize;
/// use holo_io::{ExrCompression, ExrSamples, ExrWriter};
/// use ndarray::{Array3, Axis};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("raw.exr");
/// let channels = ["R", "G", "B"].map(|name| (name, ExrSamples::Half));
/// let mut exr = ExrWriter::create(&path, GridSize::new(40, 30), &channels, ExrCompression::Zip)?;
/// for band in 0..4 {
///     let rows = Array3::from_elem((10, 30, 3), band as f32);
///     exr.write_rows(&[0, 1, 2].map(|channel| rows.index_axis(Axis(2), channel)))?;
/// }
/// assert!(!path.exists());
/// let written = exr.finish()?;
/// assert_eq!(written, holo_io::hash_file(&path)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct ExrWriter {
    file: AtomicFile,
    /// The file so far, where the output is a device or a pipe.
    whole: Option<Vec<u8>>,
    encoder: Encoder,
}

impl std::fmt::Debug for ExrWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("ExrWriter").field("file", &self.file).finish_non_exhaustive()
    }
}

impl ExrWriter {
    /// Starts an image of `size` with the given channels: full names, such as `ViewLayer.Combined.R`, and sample
    /// formats. The file contains them sorted by name, as the format requires.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if there is no channel or no pixel, if names repeat, are empty, longer than 255 bytes or
    /// contain a NUL, if a channel of identifiers is [`Half`](ExrSamples::Half), or if one block of lines would exceed
    /// 2 GiB; [`Error::Io`] if the file cannot be written.
    pub fn create(
        path: impl Destination,
        size: GridSize,
        channels: &[(&str, ExrSamples)],
        compression: ExrCompression,
    ) -> Result<Self, Error> {
        // Into memory first, so that invalid arguments create no file.
        let mut start = Vec::new();
        let encoder = Encoder::new(size, channels, compression, path.path(), &mut start)?;
        let mut file = AtomicFile::create(&path as &dyn Destination)?;
        let mut whole = None;
        if file.is_temporary() {
            // The offset table is known at the end only.
            file.hash_at_commit();
            std::io::Write::write_all(&mut file, &start).map_err(|error| Error::io("write", path.path(), error))?;
        } else {
            whole = Some(start);
        }
        Ok(Self { file, whole, encoder })
    }

    /// Writes the next rows, any number of them.
    ///
    /// # Shape
    ///
    /// One plane `(rows, columns)` a channel, in the order in which the channels were given; any strides.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if number or size of the planes are wrong, if there are more rows than the image has left,
    /// or if a finite value is too large for [`ExrSamples::Half`]; [`Error::Io`] if the file cannot be written. After
    /// an error the file cannot be finished.
    pub fn write_rows(&mut self, planes: &[ArrayView2<'_, f32>]) -> Result<(), Error> {
        let path = self.file.path().to_owned();
        match &mut self.whole {
            Some(whole) => self.encoder.write_rows(planes, &path, whole),
            None => self.encoder.write_rows(planes, &path, &mut self.file),
        }
    }

    /// Completes the file and renames it to its path. The file is read once for its digest.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if rows are missing; [`Error::Io`] if the file cannot be written. No file of that name
    /// appears then, and an older one stays.
    pub fn finish(self) -> Result<FileDigest, Error> {
        let Self { mut file, whole, encoder } = self;
        let path = file.path().to_owned();
        let failed = |error| Error::io("write", &path, error);
        match whole {
            Some(mut bytes) => {
                let (at, table) = encoder.finish(&path, &mut bytes)?;
                bytes[at..at + table.len()].copy_from_slice(&table);
                std::io::Write::write_all(&mut file, &bytes).map_err(failed)?;
            }
            None => {
                let (at, table) = encoder.finish(&path, &mut file)?;
                file.overwrite(at as u64, &table).map_err(failed)?;
            }
        }
        file.commit()
    }
}
