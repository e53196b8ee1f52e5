//! Reading and writing files of either version.

use std::collections::HashSet;
use std::fs::File;
use std::io::{BufReader, BufWriter, Cursor, Read, Seek, Write};
use std::path::Path;

use super::v5::read::Reader;
use super::v5::{self, MAX_VARIABLE_BYTES, VARIABLE_HEAD_BYTES};
use super::{FORMAT_V5, MatArray, MatInfo, MatOptions, MatVariable, MatVersion};
use crate::error::STREAM;
use crate::files::atomic::AtomicPath;
use crate::files::folder::Destination;
use crate::files::stream::write_bytes;
use crate::{AtomicFile, Error, FileDigest, Limits};

/// Bytes read or written at a time.
const BUFFER_BYTES: usize = 1 << 18;

/// MATLAB's `namelengthmax`.
const MAX_NAME_CHARACTERS: usize = 63;

/// Checks names and sizes, and returns whether the file must be of version 7.3.
fn check(variables: &[MatVariable<'_>], version: MatVersion, path: &Path) -> Result<bool, Error> {
    let mut names = HashSet::new();
    let mut largest = (0, "");
    for variable in variables {
        let name = variable.name;
        let mut characters = name.bytes();
        let is_name = characters.next().is_some_and(|first| first.is_ascii_alphabetic())
            && characters.all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
            && name.len() <= MAX_NAME_CHARACTERS;
        if !is_name {
            return Err(Error::bad_input(
                path,
                format!(
                    "'{name}' is not a valid name of a MATLAB variable: a letter, and up to 62 letters, digits and _"
                ),
            ));
        }
        if !names.insert(name) {
            return Err(Error::bad_input(path, format!("two variables are called '{name}'")));
        }
        let element = variable.value.class().element_bytes().unwrap_or(1);
        let elements =
            variable.value.size().iter().try_fold(element as u64, |product, &count| product.checked_mul(count as u64));
        largest = largest.max((elements.unwrap_or(u64::MAX), name));
    }
    let (bytes, name) = largest;
    let fits = bytes.saturating_add(VARIABLE_HEAD_BYTES) < MAX_VARIABLE_BYTES;
    match version {
        MatVersion::V73 => Ok(true),
        MatVersion::V5 if !fits => Err(Error::bad_input(
            path,
            format!(
                "'{name}' has {bytes} bytes, but variables of a MAT file of version 5 are smaller than 2 GiB; use \
                 version 7.3"
            ),
        )),
        MatVersion::Auto if !fits && cfg!(not(feature = "hdf5")) => Err(Error::bad_input(
            path,
            format!(
                "'{name}' has {bytes} bytes, and from 2 GiB on a MAT file must be of version 7.3, which this build \
                 cannot write; build with the feature `hdf5`"
            ),
        )),
        _ => Ok(!fits),
    }
}

pub(super) fn write(
    path: &dyn Destination,
    variables: &[MatVariable<'_>],
    options: MatOptions,
) -> Result<FileDigest, Error> {
    if check(variables, options.version, path.path())? {
        return write_v73(path, variables, options);
    }
    if options.is_compressed {
        let target = AtomicPath::create(path)?;
        let mut out = BufWriter::with_capacity(BUFFER_BYTES, target.file());
        write_v5(&mut out, variables, v5::write::compressed)
            .and_then(|()| out.flush())
            .map_err(|error| Error::io("write", target.path(), error))?;
        drop(out);
        return target.commit();
    }
    let mut file = AtomicFile::create(path)?;
    match write_v5(&mut file, variables, v5::write::plain) {
        Ok(()) => file.commit(),
        Err(error) => Err(file.error(error)),
    }
}

#[cfg(feature = "hdf5")]
fn write_v73(path: &dyn Destination, variables: &[MatVariable<'_>], options: MatOptions) -> Result<FileDigest, Error> {
    super::v73::write(path, variables, options.is_compressed)
}

#[cfg(not(feature = "hdf5"))]
fn write_v73(path: &dyn Destination, _: &[MatVariable<'_>], _: MatOptions) -> Result<FileDigest, Error> {
    Err(Error::bad_input(
        path.path(),
        "this build cannot write a MAT file of version 7.3, which is an HDF5 file; build with the feature `hdf5`",
    ))
}

fn write_v5<W: Write>(
    out: &mut W,
    variables: &[MatVariable<'_>],
    write: impl Fn(&mut W, &str, &super::MatValue<'_>) -> std::io::Result<()>,
) -> std::io::Result<()> {
    out.write_all(&v5::write::header())?;
    variables.iter().try_for_each(|variable| write(out, variable.name, &variable.value))
}

pub(super) fn encode(mut out: impl Write, variables: &[MatVariable<'_>], options: MatOptions) -> Result<(), Error> {
    let path = Path::new(STREAM);
    if check(variables, options.version, path)? {
        return Err(Error::bad_input(path, "a MAT file of version 7.3 cannot be written into a stream"));
    }
    let failed = |error| Error::io("write", path, error);
    if options.is_compressed {
        let mut bytes = Cursor::new(Vec::new());
        write_v5(&mut bytes, variables, v5::write::compressed).map_err(failed)?;
        return write_bytes(out, bytes.get_ref());
    }
    write_v5(&mut out, variables, v5::write::plain).and_then(|()| out.flush()).map_err(failed)
}

/// An open MAT file of version 5 or 7.3 whose variables are known.
pub(super) enum MatReader<'a> {
    V5(Reader<'a, BufReader<File>>),
    #[cfg(feature = "hdf5")]
    V73(super::v73::Reader<'a>),
}

impl<'a> MatReader<'a> {
    pub(super) fn open(path: &'a Path, limits: Limits) -> Result<Self, Error> {
        let failed = |source| Error::io("read", path, source);
        let mut file = File::open(path).map_err(failed)?;
        let length = file.metadata().map_err(failed)?.len();
        let mut head = Vec::new();
        Read::by_ref(&mut file).take(128).read_to_end(&mut head).map_err(failed)?;
        if is_v73(&head) {
            return Self::open_v73(path, limits);
        }
        file.rewind().map_err(failed)?;
        Ok(Self::V5(Reader::new(BufReader::with_capacity(BUFFER_BYTES, file), length, path, limits)?))
    }

    #[cfg(feature = "hdf5")]
    fn open_v73(path: &'a Path, limits: Limits) -> Result<Self, Error> {
        Ok(Self::V73(super::v73::Reader::open(path, limits)?))
    }

    #[cfg(not(feature = "hdf5"))]
    fn open_v73(path: &'a Path, _: Limits) -> Result<Self, Error> {
        Err(Error::unsupported(
            path,
            "a MAT file of version 7.3, which is an HDF5 file; this build does not have the feature `hdf5`: save the \
             file with -v7, or use a build that has the feature",
        ))
    }

    pub(super) fn infos(&self) -> Vec<MatInfo> {
        match self {
            Self::V5(reader) => infos(reader),
            #[cfg(feature = "hdf5")]
            Self::V73(reader) => reader.infos(),
        }
    }

    pub(super) fn value(&mut self, index: usize) -> Result<MatArray, Error> {
        match self {
            Self::V5(reader) => reader.value(index),
            #[cfg(feature = "hdf5")]
            Self::V73(reader) => reader.value(index),
        }
    }

    pub(super) fn all(&mut self) -> Result<Vec<(String, MatArray)>, Error> {
        let infos = self.infos();
        infos.into_iter().enumerate().map(|(index, info)| Ok((info.name, self.value(index)?))).collect()
    }
}

/// Whether the first bytes are those of version 7.3.
pub(super) fn is_v73(head: &[u8]) -> bool {
    matches!(head.get(124..128), Some([0x00, 0x02, b'I', b'M'] | [0x02, 0x00, b'M', b'I']))
}

fn infos<R: Read + Seek>(reader: &Reader<'_, R>) -> Vec<MatInfo> {
    let info = |entry: &v5::read::Entry| MatInfo {
        name: entry.head.name.clone(),
        class: entry.head.class,
        is_complex: entry.head.complex,
        size: entry.head.size.clone(),
    };
    reader.entries.iter().map(info).collect()
}

pub(super) fn decode(bytes: &[u8], limits: Limits) -> Result<Vec<(String, MatArray)>, Error> {
    let path = Path::new(STREAM);
    if is_v73(bytes) {
        return Err(Error::unsupported(
            path,
            format!("a {FORMAT_V5} file of version 7.3, which cannot be read from a stream"),
        ));
    }
    let mut reader = Reader::new(Cursor::new(bytes), bytes.len() as u64, path, limits)?;
    let infos = infos(&reader);
    infos.into_iter().enumerate().map(|(index, info)| Ok((info.name, reader.value(index)?))).collect()
}

/// The message that a variable is missing, with the names of the others.
pub(super) fn missing(name: &str, infos: &[MatInfo]) -> String {
    const SHOWN: usize = 12;
    let mut names: Vec<&str> = infos.iter().take(SHOWN).map(|info| info.name.as_str()).collect();
    if infos.len() > SHOWN {
        names.push("...");
    }
    format!("no variable is called '{name}'; there are: {}", names.join(", "))
}
