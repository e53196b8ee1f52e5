//! MAT files: the arrays of MATLAB, Octave and SciPy.
//!
//! Version 5 (written by `save -v6` and `-v7`) is written and parsed by code of this crate; the crate `matfile` decodes
//! its numbers. Version 7.3 is an HDF5 file with a MATLAB header in front, and needs the feature `hdf5`. [`write_mat`]
//! uses version 5 as long as every variable is smaller than 2 GiB, the limit of MATLAB.
//!
//! # Model
//!
//! - **Shape**: indices are those of MATLAB minus one. Trailing dimensions of length 1 are lost in files, as in MATLAB;
//!   a light field that is read has five axes again.
//! - **Order**: the first index runs fastest in the file. Nothing is transposed in memory: arrays are written from any
//!   strides slab by slab, and those that are read have the strides of the file.
//! - **Read**: all integer and float classes, `logical` (as `uint8`), one row of `char`; either byte order, compressed
//!   or not. Structures, cells, sparse and complex arrays and objects are listed; reading one is an error.
//! - **Checked first**: lengths against the file, dimensions against lengths, sizes against the memory limit. The size
//!   that a compressed variable announces is checked before it is inflated, and no more is inflated.
//!
//! # A light field
//!
//! | variable | class | value |
//! |---|---|---|
//! | `H` | `uint8`, `uint16`, `single` or `double` | `[V U T S C]` |
//! | or `LF` | the same | `[T S V U C]`, the order of the Light Field Toolbox |
//! | `axis_order` | `char` | `vutsc` or `tsvuc`, a letter a dimension; `axes` before 0.2, which is still read |
//! | `views`, `lenses` | `double` | `[T S]` and `[V U]`, rows first |
//! | `baseline_m` | `double` | `[y x]` |
//! | `focal_length_mm`, `sensor_size_mm`, `focus_distance_m` | `double` | numbers; the focus may be `Inf` |
//! | `projection` | `char` | `perspective` or `orthographic` |
//!
//! `squeeze(H(i,j,:,:,:))` is an elemental image and `squeeze(H(:,:,k,l,:))` a viewpoint image, both upright.
//!
//! # Source
//!
//! *MAT-File Format*, The MathWorks, 2019.

mod file;
mod light_field;
mod order;
#[cfg(feature = "hdf5")]
mod stream;
mod v5;
#[cfg(feature = "hdf5")]
mod v73;
mod value;

use std::io::{Read, Write};
use std::path::Path;

use crate::files::folder::Destination;
use crate::files::stream::read_to_end;
use crate::{Error, FileDigest, Limits};

pub(crate) use light_field::read_light_field_header;
pub use light_field::{MatLightField, MatOrder, read_mat_light_field, write_mat_light_field};
#[cfg(feature = "hdf5")]
pub use stream::MatWriter;
pub use value::{MatArray, MatClass, MatValue};

/// The name of the format in messages.
const FORMAT_V5: &str = "MAT";

/// A variable that is to be written.
#[derive(Debug, Clone)]
pub struct MatVariable<'a> {
    /// Its name: a letter, and up to 62 letters, digits and `_`.
    pub name: &'a str,
    /// Its value.
    pub value: MatValue<'a>,
}

/// Name, class and size of a variable, without its numbers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MatInfo {
    /// Its name.
    pub name: String,
    /// Its class.
    pub class: MatClass,
    /// Whether its numbers are complex; complex variables are not read.
    pub is_complex: bool,
    /// Its size as MATLAB shows it, at least two dimensions; empty for objects without a size.
    pub size: Vec<usize>,
}

/// The version of a MAT file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub enum MatVersion {
    /// Version 5 if every variable is smaller than 2 GiB, else 7.3.
    #[default]
    Auto,
    /// Version 5, which every program reads.
    V5,
    /// Version 7.3, an HDF5 file; needs the feature `hdf5`.
    V73,
}

/// Options of writing a MAT file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[non_exhaustive]
pub struct MatOptions {
    /// The version of the file.
    pub version: MatVersion,
    /// Whether variables are compressed (zlib): smaller, but slower to write and to read.
    pub is_compressed: bool,
}

impl MatOptions {
    /// The version that the variables need, uncompressed.
    #[must_use]
    pub const fn new() -> Self {
        Self { version: MatVersion::Auto, is_compressed: false }
    }

    /// Sets the version of the file.
    #[must_use]
    pub const fn version(mut self, version: MatVersion) -> Self {
        self.version = version;
        self
    }

    /// Sets whether variables are compressed.
    #[must_use]
    pub const fn compressed(mut self, is_compressed: bool) -> Self {
        self.is_compressed = is_compressed;
        self
    }
}

/// Writes variables into a MAT file.
///
/// Arrays are written slab by slab: a few megabytes a thread are needed in addition to them, whatever their strides,
/// compressed or not.
///
/// # Errors
///
/// [`Error::BadInput`] if a name is not a valid MATLAB name or occurs twice, if a variable is too large for the
/// version, or if version 7.3 is needed and the feature `hdf5` is off; [`Error::Io`] if the file cannot be written. No
/// file of that name appears then.
///
/// # Examples
///
/// ```
/// use holo_io::{Limits, MatArray, MatOptions, MatValue, MatVariable, read_mat, write_mat};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("some.mat");
/// let weights = ndarray::array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
/// write_mat(
///     &path,
///     &[
///         MatVariable { name: "weights", value: MatValue::F64(weights.view().into_dyn()) },
///         MatVariable { name: "unit", value: MatValue::Text("px") },
///     ],
///     &MatOptions::default(),
/// )?;
/// let variables = read_mat(&path, &Limits::default())?;
/// assert_eq!(variables[0], ("weights".to_owned(), MatArray::F64(weights.into_dyn())));
/// assert_eq!(variables[1].1, MatArray::Text("px".to_owned()));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_mat(
    path: impl Destination,
    variables: &[MatVariable<'_>],
    options: &MatOptions,
) -> Result<FileDigest, Error> {
    file::write(&path, variables, *options)
}

/// Encodes a MAT file of version 5 into a stream. With compression each file is encoded in memory first, because the
/// length of a variable precedes its data.
///
/// # Errors
///
/// [`Error::BadInput`] as in [`write_mat`], and if version 7.3 is requested or needed; [`Error::Io`] if `out` cannot be
/// written.
pub fn encode_mat(out: impl Write, variables: &[MatVariable<'_>], options: &MatOptions) -> Result<(), Error> {
    file::encode(out, variables, *options)
}

/// Lists the variables of a MAT file, in the order of the file (version 5) or of their names (version 7.3).
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is no MAT file, is truncated or damaged;
/// [`Error::Unsupported`] if it is of version 7.3 and the feature `hdf5` is off, or of another version.
pub fn read_mat_info(path: impl AsRef<Path>) -> Result<Vec<MatInfo>, Error> {
    Ok(file::MatReader::open(path.as_ref(), Limits::NONE)?.infos())
}

/// Reads one variable of a MAT file by its name; of several with the same name in a faulty file, the first.
///
/// # Errors
///
/// Those of [`read_mat_info`]; [`Error::BadInput`] if there is no such variable; [`Error::Unsupported`] if it is of a
/// class that is not read; [`Error::TooLarge`] if it exceeds the limits, before memory is allocated for it.
pub fn read_mat_variable(path: impl AsRef<Path>, name: &str, limits: &Limits) -> Result<MatArray, Error> {
    let path = path.as_ref();
    let mut reader = file::MatReader::open(path, *limits)?;
    let infos = reader.infos();
    let index = infos.iter().position(|info| info.name == name);
    let index = index.ok_or_else(|| Error::bad_input(path, file::missing(name, &infos)))?;
    reader.value(index)
}

/// Reads all variables of a MAT file.
///
/// # Errors
///
/// Those of [`read_mat_variable`]. A single variable of a class that is not read is an error; [`read_mat_variable`]
/// reads the others of such a file. The limits are for all variables together.
pub fn read_mat(path: impl AsRef<Path>, limits: &Limits) -> Result<Vec<(String, MatArray)>, Error> {
    file::MatReader::open(path.as_ref(), *limits)?.all()
}

/// Decodes all variables of a MAT file of version 5 from a stream, like [`read_mat`]. The encoded bytes are read into
/// memory first.
///
/// # Errors
///
/// Those of [`read_mat`].
pub fn decode_mat(source: impl Read, limits: &Limits) -> Result<Vec<(String, MatArray)>, Error> {
    file::decode(&read_to_end(source, *limits)?, *limits)
}

/// The error of a class that is not read.
fn unreadable(path: &Path, name: &str, class: MatClass, is_complex: bool) -> Error {
    let class = if is_complex { "complex" } else { class.name() };
    Error::unsupported(
        path,
        format!("the variable '{name}' is of class {class}; real numbers and one row of text can be read"),
    )
}
