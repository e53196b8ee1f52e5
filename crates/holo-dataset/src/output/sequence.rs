//! `sequence_5d.h5` in the folder of the frames of a pose: one array of all of them.

use std::path::Path;

use holo_io::Folder;
use holo_io::dataset::{SEQUENCE_HDF5, SequenceFolder};

use crate::Error;

/// How HDF5 files begin (HDF5 File Format Specification, superblock).
const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";

/// The attribute that tells the layout, which stands in the file as it is.
const LAYOUT: &[u8] = b"holo light field sequence 1";

/// The largest size of such a file: it has some kilobytes, because the samples stay in the folders of the frames.
const MAX_BYTES: u64 = 64 << 20;

/// Writes the file of frames that have HDF5 files.
#[cfg(feature = "hdf5")]
pub(crate) fn write(root: &Path, frames: &[u32]) -> Result<(), Error> {
    holo_io::write_hdf5_sequence(&SequenceFolder::open(root)?, frames)?;
    Ok(())
}

#[cfg(not(feature = "hdf5"))]
pub(crate) fn write(root: &Path, _: &[u32]) -> Result<(), Error> {
    SequenceFolder::open(root)?;
    Err(super::without_hdf5())
}

/// Checks that a file which will be replaced is one of this kind.
pub(crate) fn check(folder: &Folder) -> Result<(), Error> {
    match folder.kind(SEQUENCE_HDF5)?.is_none() || is_own(folder) {
        true => Ok(()),
        false => Err(Error::BadRequest(format!(
            "{}: a file of this name will be written, and this one came from elsewhere; give another `out`",
            folder.path_of(SEQUENCE_HDF5).display()
        ))),
    }
}

/// Removes the file, if it is one of this kind: one of the frames may get another shape.
pub(crate) fn forget(folder: &Folder) -> Result<(), Error> {
    if is_own(folder) { Ok(folder.remove_file(SEQUENCE_HDF5)?) } else { Ok(()) }
}

/// Whether the contents are what [`write`] writes.
fn is_own(folder: &Folder) -> bool {
    let contents = folder.read(SEQUENCE_HDF5, MAX_BYTES).unwrap_or_default();
    contents.starts_with(SIGNATURE) && contents.windows(LAYOUT.len()).any(|part| part == LAYOUT)
}
