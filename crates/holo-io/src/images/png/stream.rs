//! A writer of PNG band by band, for images that do not fit into memory.

use std::path::PathBuf;

use holo_core::{ColorEncoding, DynImageRef, GridSize, SampleKind};

use super::Compression;
use super::encode::{Encoder, Layout};
use crate::files::folder::Destination;
use crate::{AtomicFile, Error, FileDigest};

/// A writer of a PNG of 8 or 16 bits a channel, from top to bottom, a band of rows at a time.
///
/// It needs a few times 64 MiB of memory (or a few rows, if those are more), whatever the size of the image; with
/// [`Compression::Fast`] only one row. The bytes of the file depend neither on the bands nor on the number of threads.
///
/// The file appears when [`finish`](Self::finish) succeeds; a writer that is dropped leaves no file.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, SampleKind};
/// use holo_io::{Compression, ColorEncoding, PngWriter};
/// use ndarray::Array3;
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("raw.png");
/// let size = GridSize::new(40, 30);
/// let mut png = PngWriter::create(&path, size, 3, SampleKind::U8, ColorEncoding::Srgb, Compression::Best)?;
/// for band in 0..4 {
///     png.write_rows(Array3::<u8>::from_elem((10, 30, 3), band * 60).view())?;
/// }
/// assert!(!path.exists());
/// let written = png.finish()?;
/// assert_eq!(written, holo_io::hash_file(&path)?);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PngWriter {
    path: PathBuf,
    encoder: Encoder<AtomicFile>,
    layout: Layout,
    rows: usize,
    has_failed: bool,
}

impl std::fmt::Debug for PngWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PngWriter").field("path", &self.path).field("rows", &self.rows).finish_non_exhaustive()
    }
}

impl PngWriter {
    /// Starts an image of `size` with 1 (gray), 2 (gray, alpha), 3 (RGB) or 4 (RGB, alpha) channels of 8 or 16 bits.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if the samples are floats, if the image is empty, has another number of channels or more
    /// than 2^31 - 1 rows or columns; [`Error::Io`] if the file cannot be written.
    pub fn create(
        path: impl Destination,
        size: GridSize,
        channels: usize,
        kind: SampleKind,
        encoding: ColorEncoding,
        compression: Compression,
    ) -> Result<Self, Error> {
        let layout = Layout::new(size, channels, kind, path.path())?;
        Self::described(path, layout, encoding, None, compression)
    }

    /// Starts an image with a text that says what it shows.
    pub(super) fn described(
        path: impl Destination,
        layout: Layout,
        encoding: ColorEncoding,
        description: Option<&str>,
        compression: Compression,
    ) -> Result<Self, Error> {
        let file = AtomicFile::create(&path as &dyn Destination)?;
        let encoder = Encoder::new(file, layout, encoding, description, compression)?;
        Ok(Self { path: path.path().to_owned(), encoder, layout, rows: 0, has_failed: false })
    }

    /// Writes the next rows, any number of them.
    ///
    /// # Shape
    ///
    /// `(rows, columns, channels)`; any strides.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if columns, channels or sample type are not those of the image, or if there are more rows
    /// than the image has left; [`Error::Io`] if the file cannot be written. After an error the file cannot be
    /// finished.
    pub fn write_rows<'a>(&mut self, rows: impl Into<DynImageRef<'a>>) -> Result<(), Error> {
        let rows = rows.into();
        let bad = |what: String| Err(Error::bad_input(&self.path, what));
        if self.has_failed {
            return bad("an earlier band of rows could not be written".into());
        }
        let (GridSize { rows: count, columns }, channels) = (rows.size(), rows.channels());
        if rows.kind() != self.layout.kind {
            self.has_failed = true;
            return bad(format!(
                "rows of {} were given where {} are needed",
                rows.kind().name(),
                self.layout.kind.name()
            ));
        }
        let left = self.layout.size.rows - self.rows;
        if (columns, channels) != (self.layout.size.columns, self.layout.channels) {
            self.has_failed = true;
            return bad(format!(
                "rows of {columns} pixels and {channels} channels were given where {} and {} are needed",
                self.layout.size.columns, self.layout.channels
            ));
        }
        if count > left {
            self.has_failed = true;
            return bad(format!("{count} rows were given, but of {} only {left} are missing", self.layout.size.rows));
        }
        self.rows += count;
        self.encoder.write_rows(rows).inspect_err(|_| self.has_failed = true)
    }

    /// Completes the file and renames it to its path.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if rows are missing; [`Error::Io`] if the file cannot be written. No file of that name
    /// appears then, and an older one stays.
    pub fn finish(self) -> Result<FileDigest, Error> {
        let path = &self.path;
        if self.has_failed || self.rows != self.layout.size.rows {
            let (rows, of) = (self.rows, self.layout.size.rows);
            let what = match self.has_failed {
                true => "the image is not complete: a band of rows could not be written".to_owned(),
                false => format!("the image is not complete: {rows} of {of} rows were written"),
            };
            return Err(Error::bad_input(path, what));
        }
        self.encoder.finish()?.commit()
    }
}
