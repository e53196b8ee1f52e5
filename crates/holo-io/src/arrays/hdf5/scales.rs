//! Dimension scales: the axes as datasets of one letter, such as `/v`, with the coordinates, attached to every dataset.
//! xarray and netCDF take them for named dimensions with coordinates.
//!
//! The attributes are those of the specification *HDF5 Dimension Scale*, which the high-level library writes and the
//! binding does not have.

use std::path::Path;

use ::hdf5::types::{FixedAscii, VarLenArray};
use ::hdf5::{Dataset, Datatype, File, H5Type, ObjectReference1};
use ndarray::{Array1, aview0, aview1};

use super::library::Failure;
use crate::Error;

/// The library takes a dataset for a scale only if the text of its class ends in NUL and has 16 bytes. The binding has no
/// such type, but reads it from this file (`tests/data/make_nul_terminated_text.py`).
const NUL_TERMINATED_TEXT: &[u8] = include_bytes!("nul_terminated_text.h5");

/// One use of a scale, as the scale lists it.
#[derive(Debug, Clone, Copy, H5Type)]
#[repr(C)]
struct ScaleUse {
    dataset: ObjectReference1,
    dimension: i32,
}

/// The type of 16 bytes of text that end in NUL. `scratch` is an empty file, which is overwritten; `path` is for errors.
pub(super) fn text_type(scratch: &Path, path: &Path) -> Result<Datatype, Error> {
    std::fs::write(scratch, NUL_TERMINATED_TEXT).map_err(|error| Error::io("write", path, error))?;
    let read = || {
        let file = File::with_options().with_fapl(|access| access.file_locking(false)).open(scratch)?;
        file.attr("CLASS")?.dtype()
    };
    read().map_err(|error| Failure { path, is_writing: true }.error(error))
}

/// The scales of a file, and the datasets that use each.
#[derive(Debug)]
pub(super) struct Scales {
    uses: Vec<(char, Vec<ScaleUse>)>,
}

/// The indices of an axis.
pub(super) fn indices(count: usize) -> Array1<i32> {
    (0..count).map(|index| index as i32).collect()
}

impl Scales {
    /// Creates the scales of these axes, each with its coordinates.
    pub(super) fn create(file: &File, axes: Vec<(char, Array1<i32>)>, text: &Datatype) -> ::hdf5::Result<Self> {
        let mut uses = Vec::with_capacity(axes.len());
        for (axis, coordinates) in axes {
            let name = axis.to_string();
            let scale =
                file.new_dataset_builder().with_data(&coordinates).obj_track_times(false).create(name.as_str())?;
            write_text(&scale, text, "CLASS", "DIMENSION_SCALE")?;
            write_text(&scale, text, "NAME", &name)?;
            uses.push((axis, Vec::new()));
        }
        Ok(Self { uses })
    }

    /// Attaches the scales to a dataset; `axes` has a letter for each dimension.
    pub(super) fn attach(&mut self, file: &File, name: &str, axes: &str) -> ::hdf5::Result<()> {
        let dataset = file.reference::<ObjectReference1>(name)?;
        let mut list = Vec::with_capacity(axes.len());
        for (dimension, axis) in axes.chars().enumerate() {
            let scale = file.reference::<ObjectReference1>(&axis.to_string())?;
            list.push(VarLenArray::from_slice(&[scale]));
            let own = self.uses.iter_mut().find(|(own, _)| *own == axis).ok_or("an axis without a scale")?;
            own.1.push(ScaleUse { dataset, dimension: dimension as i32 });
        }
        let list = Array1::from_vec(list);
        file.dataset(name)?.new_attr_builder().with_data(&list).create("DIMENSION_LIST").map(|_| ())
    }

    /// Writes into every scale which datasets use it.
    pub(super) fn finish(&self, file: &File) -> ::hdf5::Result<()> {
        for (axis, uses) in self.uses.iter().filter(|(_, uses)| !uses.is_empty()) {
            let scale = file.dataset(&axis.to_string())?;
            scale.new_attr_builder().with_data(aview1(uses)).create("REFERENCE_LIST")?;
        }
        Ok(())
    }
}

fn write_text(scale: &Dataset, text: &Datatype, name: &str, value: &str) -> ::hdf5::Result<()> {
    let value = FixedAscii::<16>::from_ascii(value).map_err(|_| ::hdf5::Error::from("not ASCII"))?;
    let attribute = scale.new_attr_builder().empty_as(text).shape(()).create(name)?;
    attribute.as_writer().write(aview0(&value))
}
