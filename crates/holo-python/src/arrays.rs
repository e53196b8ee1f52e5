//! Arrays of Python as those of the libraries, without copies.

use holo_core::{DynImage, DynImageRef, DynLightField, DynLightFieldRef, LightField, for_each_sample};
use holo_dataset::NamedQuantity;
use numpy::{PyArray, PyReadonlyArray3, PyReadonlyArray5};
use pyo3::prelude::*;
use pyo3::types::PyString;

use crate::failure::Failure;

/// A light field of any sample type, axes (v, u, t, s, c).
#[derive(FromPyObject)]
pub enum Field<'py> {
    U8(PyReadonlyArray5<'py, u8>),
    U16(PyReadonlyArray5<'py, u16>),
    F32(PyReadonlyArray5<'py, f32>),
    F64(PyReadonlyArray5<'py, f64>),
}

/// An image of any sample type, axes (row, column, channel).
#[derive(FromPyObject)]
pub enum Image<'py> {
    U8(PyReadonlyArray3<'py, u8>),
    U16(PyReadonlyArray3<'py, u16>),
    F32(PyReadonlyArray3<'py, f32>),
    F64(PyReadonlyArray3<'py, f64>),
}

impl Field<'_> {
    /// Borrows the samples.
    pub fn borrow(&self) -> Result<DynLightFieldRef<'_>, Failure> {
        Ok(match self {
            Self::U8(array) => DynLightFieldRef::U8(LightField::new(array.as_array())?),
            Self::U16(array) => DynLightFieldRef::U16(LightField::new(array.as_array())?),
            Self::F32(array) => DynLightFieldRef::F32(LightField::new(array.as_array())?),
            Self::F64(array) => DynLightFieldRef::F64(LightField::new(array.as_array())?),
        })
    }
}

impl Image<'_> {
    /// Borrows the samples.
    pub fn borrow(&self) -> DynImageRef<'_> {
        match self {
            Self::U8(array) => DynImageRef::U8(array.as_array()),
            Self::U16(array) => DynImageRef::U16(array.as_array()),
            Self::F32(array) => DynImageRef::F32(array.as_array()),
            Self::F64(array) => DynImageRef::F64(array.as_array()),
        }
    }
}

/// Gives the memory of an array to Python.
pub fn give<'py, T: numpy::Element, D: ndarray::Dimension>(
    py: Python<'py>,
    array: ndarray::Array<T, D>,
) -> Bound<'py, PyAny> {
    PyArray::from_owned_array(py, array).into_any()
}

/// Gives an image to Python.
pub fn give_image(py: Python<'_>, image: DynImage) -> Bound<'_, PyAny> {
    for_each_sample!(DynImage, image, array => give(py, array))
}

/// Gives a light field to Python.
pub fn give_field(py: Python<'_>, field: DynLightField) -> Bound<'_, PyAny> {
    for_each_sample!(DynLightField, field, field => give(py, field.into_samples()))
}

/// Named quantities as a dict.
pub fn give_quantities(py: Python<'_>, rows: Vec<NamedQuantity>) -> Result<Bound<'_, PyAny>, Failure> {
    let pair = |row: NamedQuantity| -> (String, serde_json::Value) {
        let value = serde_json::from_str(&row.value.to_json()).unwrap_or_default();
        (row.key, value)
    };
    give_json(py, &rows.into_iter().map(pair).collect())
}

/// Gives numbers and names to Python: objects become dictionaries.
pub fn give_json<'py>(py: Python<'py>, value: &serde_json::Value) -> Result<Bound<'py, PyAny>, Failure> {
    let text = PyString::new(py, &value.to_string());
    Ok(py.import("json")?.call_method1("loads", (text,))?)
}
