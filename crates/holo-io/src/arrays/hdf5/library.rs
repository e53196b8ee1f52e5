//! The interface to the C library: opening and creating files, converting errors.

use std::io;
use std::path::Path;

use ::hdf5::types::{FixedAscii, FixedUnicode, TypeDescriptor, VarLenAscii, VarLenUnicode};
use ::hdf5::{Container, File};

use super::FORMAT;
use crate::Error;

/// Maximum length of a text of fixed length that is read.
const MAX_TEXT: usize = 256;

/// The operation during which the library failed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Failure<'a> {
    pub(crate) path: &'a Path,
    pub(crate) is_writing: bool,
}

impl Failure<'_> {
    /// Converts an error of the library to one of the operating system or of the file.
    pub(crate) fn error(self, error: ::hdf5::Error) -> Error {
        let action = if self.is_writing { "write" } else { "read" };
        // The message of the innermost function contains the error number of the system.
        let frames = error.stack().map(|stack| stack.iter().map(|frame| frame.desc().to_owned()).collect::<Vec<_>>());
        let number = frames.iter().flatten().find_map(|text| system_error(text));
        if let Some(number) = number {
            return Error::io(action, self.path, io::Error::from_raw_os_error(number));
        }
        let what = error.to_string();
        if self.is_writing {
            return Error::io(action, self.path, io::Error::other(format!("error of the HDF5 library: {what}")));
        }
        Error::broken(self.path, FORMAT, what)
    }
}

/// Finds `errno = 28` in a message.
fn system_error(text: &str) -> Option<i32> {
    let (_, rest) = text.split_once("errno = ")?;
    let digits = rest.find(|character: char| !character.is_ascii_digit()).unwrap_or(rest.len());
    rest[..digits].parse().ok().filter(|&number| number > 0)
}

/// Creates a file at a path that exists already; the library truncates it.
///
/// The file begins with a user block of `user_block` bytes; with `oldest` it has the oldest structures, which MATLAB
/// reads.
pub(crate) fn create(path: &Path, user_block: u64, oldest: bool) -> ::hdf5::Result<File> {
    File::with_options()
        // The temporary file is locked by this process already.
        .with_fapl(|access| {
            access.file_locking(false);
            if oldest {
                access.libver_earliest();
            }
            access
        })
        // The root group would contain a time too.
        .with_fcpl(|creation| creation.userblock(user_block).obj_track_times(false))
        .create(path)
}

/// Opens a file for reading.
pub(crate) fn open(path: &Path) -> Result<File, Error> {
    // Before the library opens it: for the error of the system, if there is no such file, and because opening a pipe waits.
    let failed = |source| Error::io("read", path, source);
    let found = std::fs::metadata(path).map_err(failed)?;
    if found.is_dir() {
        return Err(failed(io::ErrorKind::IsADirectory.into()));
    }
    if !found.is_file() {
        return Err(failed(io::Error::other("it is a pipe, a socket or a device; HDF5 needs a file")));
    }
    drop(std::fs::File::open(path).map_err(failed)?);
    File::with_options()
        .with_fapl(|access| access.file_locking(false))
        .open(path)
        .map_err(|error| Failure { path, is_writing: false }.error(error))
}

/// Reads one text of any storage type; `None` if it is not one text or is too long.
pub(crate) fn read_text(container: &Container) -> ::hdf5::Result<Option<String>> {
    if container.size() != 1 {
        return Ok(None);
    }
    let first = |values: Vec<String>| values.into_iter().next();
    Ok(match container.dtype()?.to_descriptor()? {
        TypeDescriptor::VarLenUnicode => {
            first(container.read_raw::<VarLenUnicode>()?.iter().map(|text| text.as_str().to_owned()).collect())
        }
        TypeDescriptor::VarLenAscii => {
            first(container.read_raw::<VarLenAscii>()?.iter().map(|text| text.as_str().to_owned()).collect())
        }
        TypeDescriptor::FixedAscii(length) if length <= MAX_TEXT => {
            first(container.read_raw::<FixedAscii<MAX_TEXT>>()?.iter().map(|text| text.as_str().to_owned()).collect())
        }
        TypeDescriptor::FixedUnicode(length) if length <= MAX_TEXT => {
            first(container.read_raw::<FixedUnicode<MAX_TEXT>>()?.iter().map(|text| text.as_str().to_owned()).collect())
        }
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_number_is_found() {
        let text =
            "file write failed: time = Mon, filename = 'x', errno = 28, error message = 'No space left on device'";
        assert_eq!(system_error(text), Some(28));
        for other in ["", "errno = ", "errno = x", "errno = 0,", "errno = 99999999999"] {
            assert_eq!(system_error(other), None, "{other}");
        }
    }
}
