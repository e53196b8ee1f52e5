//! MAT files of version 7.3: HDF5 files with a user block of 512 bytes that contains the header of MATLAB.
//!
//! A variable is a dataset in the root group, with its dimensions in reverse order and its class in an attribute.
//! Structures and cells are groups and references; they are listed, but not read. Files are written with the oldest
//! structures of HDF5, because the library in MATLAB is old.

use std::io::Write;
use std::path::Path;

use ::hdf5::types::{FixedAscii, TypeDescriptor};
use ::hdf5::{Dataset, File, H5Type, Hyperslab, SliceOrIndex};
use ndarray::{ArrayD, ArrayViewD, Axis, IxDyn, ShapeBuilder};

use super::order::Plan;
use super::v5::write::header_of;
use super::value::{Element, for_each_array};
use super::{MatArray, MatClass, MatInfo, MatValue, MatVariable, unreadable};
use crate::arrays::hdf5::{Failure, check_chunk, check_values, create, find, members, open, read_text};
use crate::files::atomic::AtomicPath;
use crate::files::folder::Destination;
use crate::{Error, FileDigest, Limits};

/// The descriptive text at the beginning of the file. MATLAB requires the first words.
const TEXT: &str = "MATLAB 7.3 MAT-file, written by holo, HDF5 schema 1.00 .";

/// The smallest user block of HDF5.
const BLOCK_BYTES: usize = 512;

/// Maximum size of a chunk in bytes.
const CHUNK_BYTES: usize = 1 << 20;

/// Level of gzip after shuffle.
const GZIP_LEVEL: u8 = 3;

const CLASS: &str = "MATLAB_class";
const EMPTY: &str = "MATLAB_empty";
const DECODE: &str = "MATLAB_int_decode";

fn header() -> Vec<u8> {
    let mut bytes = header_of(TEXT, 0x0200);
    bytes.resize(BLOCK_BYTES, 0);
    bytes
}

pub(super) fn write(
    path: &dyn Destination,
    variables: &[MatVariable<'_>],
    is_compressed: bool,
) -> Result<FileDigest, Error> {
    let (target, file) = begin(path)?;
    for one in variables {
        let failed = |error| Failure { path: path.path(), is_writing: true }.error(error);
        variable(&file, one, is_compressed).map_err(failed)?;
    }
    end(target, file)
}

/// Starts a file.
pub(super) fn begin(path: &dyn Destination) -> Result<(AtomicPath, File), Error> {
    let target = AtomicPath::create(path)?;
    let file = create(target.temporary_path(), BLOCK_BYTES as u64, true)
        .map_err(|error| Failure { path: path.path(), is_writing: true }.error(error))?;
    Ok((target, file))
}

/// Completes a file and renames it to its path.
pub(super) fn end(target: AtomicPath, file: File) -> Result<FileDigest, Error> {
    let failed = |error| Failure { path: target.path(), is_writing: true }.error(error);
    // Explicitly, because closing reports no errors.
    file.flush().map_err(failed)?;
    file.close().map_err(failed)?;
    target.file().write_all(&header()).map_err(|error| Error::io("write", target.path(), error))?;
    target.commit()
}

/// Writes one variable.
pub(super) fn variable(file: &File, variable: &MatVariable<'_>, is_compressed: bool) -> ::hdf5::Result<()> {
    let MatVariable { name, value } = variable;
    for_each_array!(MatValue, value, array => numbers(file, name, array, value, is_compressed), text => {
        let units: Vec<u16> = text.encode_utf16().collect();
        numbers(file, name, &ndarray::aview1(&units).into_dyn(), value, false)
    })
}

/// Creates the chunked dataset of a variable; `shape` is the reverse of that in MATLAB.
pub(super) fn chunked<T: H5Type>(
    file: &File,
    name: &str,
    shape: &[usize],
    chunk: Vec<usize>,
    class: MatClass,
    is_compressed: bool,
) -> ::hdf5::Result<Dataset> {
    let builder = file.new_dataset::<T>().shape(shape).chunk(chunk).obj_track_times(false);
    let mut builder = builder.fill_time(::hdf5::dataset::FillTime::Never);
    if is_compressed {
        builder = builder.shuffle().deflate(GZIP_LEVEL);
    }
    let dataset = builder.create(name)?;
    describe(&dataset, class)?;
    Ok(dataset)
}

/// Writes a variable slab by slab.
fn numbers<T: Element + H5Type>(
    file: &File,
    name: &str,
    array: &ArrayViewD<'_, T>,
    value: &MatValue<'_>,
    is_compressed: bool,
) -> ::hdf5::Result<()> {
    let size = value.size();
    if array.is_empty() {
        // The dataset of an empty variable contains its dimensions.
        let counts: Vec<u64> = size.iter().map(|&count| count as u64).collect();
        let dataset = file.new_dataset::<u64>().obj_track_times(false).shape([counts.len()]).create(name)?;
        dataset.write(ndarray::aview1(&counts))?;
        describe(&dataset, value.class())?;
        return dataset.new_attr::<u8>().create(EMPTY)?.write_scalar(&1);
    }
    let mut reversed = array.view();
    while reversed.ndim() < size.len() {
        reversed = reversed.insert_axis(Axis(0));
    }
    while reversed.ndim() > size.len() {
        let last = Axis(reversed.ndim() - 1);
        reversed = reversed.remove_axis(last);
    }
    let reversed = reversed.reversed_axes();
    let shape = reversed.shape().to_vec();
    let mut plan = Plan::new(&shape, reversed.strides(), size_of::<T>());
    let dataset = if is_compressed {
        // Slabs consist of whole chunks, so that none is compressed twice.
        let mut chunk = vec![1; shape.len()];
        let mut room = CHUNK_BYTES / size_of::<T>();
        for axis in (plan.axis..shape.len()).rev() {
            let most = if axis == plan.axis { plan.step } else { shape[axis] };
            chunk[axis] = room.clamp(1, most);
            room /= chunk[axis];
        }
        plan.step -= plan.step % chunk[plan.axis];
        chunked::<T>(file, name, &shape, chunk, value.class(), true)?
    } else {
        let builder = file.new_dataset::<T>().shape(&shape).obj_track_times(false);
        let dataset = builder.fill_time(::hdf5::dataset::FillTime::Never).create(name)?;
        describe(&dataset, value.class())?;
        dataset
    };
    plan.run(&reversed, <[T]>::to_vec, |slab, values: Vec<T>| {
        let mut slices: Vec<SliceOrIndex> = slab.outer.iter().map(|&index| (index..index + 1).into()).collect();
        slices.push((slab.start..slab.end).into());
        slices.extend(shape[slices.len()..].iter().map(|&count| SliceOrIndex::from(0..count)));
        let mut part = vec![1; slab.outer.len()];
        part.push(slab.end - slab.start);
        part.extend(&shape[part.len()..]);
        let values = ArrayD::from_shape_vec(IxDyn(&part), values).map_err(|error| error.to_string())?;
        dataset.write_slice(values.view(), Hyperslab::from(slices))
    })
}

/// Writes the attributes that make a dataset a variable: text of fixed length, as MATLAB writes it.
fn describe(dataset: &Dataset, class: MatClass) -> ::hdf5::Result<()> {
    fn write<const N: usize>(dataset: &Dataset, name: &str) -> ::hdf5::Result<()> {
        let text = FixedAscii::<N>::from_ascii(name).map_err(|error| error.to_string())?;
        dataset.new_attr::<FixedAscii<N>>().create(CLASS)?.write_scalar(&text)
    }
    let name = class.name();
    match name.len() {
        4 => write::<4>(dataset, name)?,
        5 => write::<5>(dataset, name)?,
        _ => write::<6>(dataset, name)?,
    }
    if class == MatClass::Text {
        dataset.new_attr::<i32>().create(DECODE)?.write_scalar(&2)?;
    }
    Ok(())
}

/// An open file whose variables are known.
pub(super) struct Reader<'a> {
    file: File,
    path: &'a Path,
    limits: Limits,
    infos: Vec<MatInfo>,
}

impl<'a> Reader<'a> {
    pub(super) fn open(path: &'a Path, limits: Limits) -> Result<Self, Error> {
        let failed = |error| Failure { path, is_writing: false }.error(error);
        let file = open(path)?;
        let mut infos = Vec::new();
        for (name, dataset) in members(&file, path)? {
            infos.push(info(&file, dataset, name, path).map_err(failed)??);
        }
        Ok(Self { file, path, limits, infos })
    }

    pub(super) fn infos(&self) -> Vec<MatInfo> {
        self.infos.clone()
    }

    /// Reads a variable, and subtracts its size from the memory limit.
    pub(super) fn value(&mut self, index: usize) -> Result<MatArray, Error> {
        let info = self.infos[index].clone();
        let path = self.path;
        let Some(bytes) = info.class.element_bytes().filter(|_| !info.is_complex) else {
            return Err(unreadable(path, &info.name, info.class, info.is_complex));
        };
        let elements = self.limits.elements(path, "variable", &info.size, bytes)?;
        let dataset = find(&self.file, path, &info.name)?;
        let dataset = dataset.ok_or_else(|| broken(path, &info.name, "is no dataset"))?;
        check_chunk(path, &dataset, self.limits)?;
        let value = match info.class {
            MatClass::U8 | MatClass::Logical => self.array::<u8>(&dataset, &info),
            MatClass::I8 => self.array::<i8>(&dataset, &info),
            MatClass::U16 => self.array::<u16>(&dataset, &info),
            MatClass::I16 => self.array::<i16>(&dataset, &info),
            MatClass::U32 => self.array::<u32>(&dataset, &info),
            MatClass::I32 => self.array::<i32>(&dataset, &info),
            MatClass::U64 => self.array::<u64>(&dataset, &info),
            MatClass::I64 => self.array::<i64>(&dataset, &info),
            MatClass::F32 => self.array::<f32>(&dataset, &info),
            MatClass::F64 => self.array::<f64>(&dataset, &info),
            MatClass::Text => self.text(&dataset, &info),
            class => Err(unreadable(path, &info.name, class, false)),
        }?;
        self.limits.max_bytes = self.limits.max_bytes.saturating_sub((elements * bytes) as u64);
        Ok(value)
    }

    fn failure(&self) -> Failure<'a> {
        Failure { path: self.path, is_writing: false }
    }

    fn values<T: Element + H5Type>(&self, dataset: &Dataset, info: &MatInfo) -> Result<Vec<T>, Error> {
        if info.size.contains(&0) {
            return Ok(Vec::new());
        }
        let count = info.size.iter().product();
        let mut values = Limits::room(self.path, "variable", count)?;
        values.resize(count, T::default());
        dataset.read_into_raw(&mut values).map_err(|error| self.failure().error(error))?;
        Ok(values)
    }

    fn array<T: Element + H5Type>(&self, dataset: &Dataset, info: &MatInfo) -> Result<MatArray, Error> {
        let array = ArrayD::from_shape_vec(IxDyn(&info.size).f(), self.values::<T>(dataset, info)?);
        array.map(T::array).map_err(|error| broken(self.path, &info.name, &error.to_string()))
    }

    fn text(&self, dataset: &Dataset, info: &MatInfo) -> Result<MatArray, Error> {
        if !info.size.contains(&0) && (info.size[0] != 1 || info.size.len() > 2) {
            let what = format!("'{}' has text of several rows; one row can be read", info.name);
            return Err(Error::unsupported(self.path, what));
        }
        let units = self.values::<u16>(dataset, info)?;
        let text = String::from_utf16(&units).map_err(|_| broken(self.path, &info.name, "is not text"))?;
        Ok(MatArray::Text(text))
    }
}

fn broken(path: &Path, name: &str, what: &str) -> Error {
    Error::broken(path, "MAT 7.3", format!("'{name}' {what}"))
}

/// Reads name, class and size of a member of the root group.
fn info(file: &File, dataset: Option<Dataset>, name: String, path: &Path) -> ::hdf5::Result<Result<MatInfo, Error>> {
    let Some(dataset) = dataset else {
        // A group: a structure, a sparse matrix or an object.
        let group = file.group(&name)?;
        let is_sparse = group.attr_names()?.iter().any(|own| own == "MATLAB_sparse");
        let class = if is_sparse { MatClass::Sparse } else { MatClass::Struct };
        return Ok(Ok(MatInfo { name, class, is_complex: false, size: Vec::new() }));
    };
    let attributes = dataset.attr_names()?;
    let has = |name: &str| attributes.iter().any(|own| own == name);
    let class = if has(CLASS) { Some(dataset.attr(CLASS)?) } else { None };
    let class = class.map(|attribute| read_text(&attribute)).transpose()?.flatten();
    let class = match class.as_deref() {
        Some("uint8") => MatClass::U8,
        Some("int8") => MatClass::I8,
        Some("uint16") => MatClass::U16,
        Some("int16") => MatClass::I16,
        Some("uint32") => MatClass::U32,
        Some("int32") => MatClass::I32,
        Some("uint64") => MatClass::U64,
        Some("int64") => MatClass::I64,
        Some("single") => MatClass::F32,
        Some("double") => MatClass::F64,
        Some("logical") => MatClass::Logical,
        Some("char") => MatClass::Text,
        Some("cell") => MatClass::Cell,
        Some("struct") => MatClass::Struct,
        Some(_) => MatClass::Object,
        None => return Ok(Err(broken(path, &name, "has no attribute MATLAB_class"))),
    };
    let mut size = dataset.get_shape()?;
    size.reverse();
    let mut is_complex = false;
    if has(EMPTY) {
        // The maximum number of dimensions of HDF5.
        if let Err(elsewhere) = check_values(&dataset, path) {
            return Ok(Err(elsewhere));
        }
        if dataset.size() > 32 {
            return Ok(Err(broken(path, &name, "is empty in more than 32 dimensions")));
        }
        let counts = dataset.read_raw::<u64>()?;
        if !counts.contains(&0) {
            return Ok(Err(broken(path, &name, "is marked as empty, but its size is not")));
        }
        size = counts.into_iter().map(|count| usize::try_from(count).unwrap_or(usize::MAX)).collect();
    } else if class.element_bytes().is_some() {
        is_complex = matches!(dataset.dtype()?.to_descriptor()?, TypeDescriptor::Compound(_));
    }
    while size.len() < 2 {
        size.push(1);
    }
    while size.len() > 2 && size.last() == Some(&1) {
        size.pop();
    }
    Ok(Ok(MatInfo { name, class, is_complex, size }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chunks of compressed variables are of a mebibyte at most, and not much less where the variable is larger.
    #[test]
    fn chunks_are_as_large_as_promised() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x.mat");
        let (bytes, numbers) =
            (ArrayD::<u8>::zeros(IxDyn(&[1500, 1700])), ArrayD::<f64>::zeros(IxDyn(&[300, 1000, 2])));
        let variables = [
            MatVariable { name: "bytes", value: MatValue::U8(bytes.view()) },
            MatVariable { name: "numbers", value: MatValue::F64(numbers.view()) },
        ];
        write(&path.as_path(), &variables, true).unwrap();
        let file = File::open(&path).unwrap();
        for (name, bytes) in [("bytes", 1), ("numbers", 8)] {
            let chunk = file.dataset(name).unwrap().chunk().unwrap();
            let size = bytes * chunk.iter().product::<usize>();
            assert!((CHUNK_BYTES / 3..=CHUNK_BYTES).contains(&size), "{name}: {chunk:?}");
        }
    }
}
