//! Attributes: the rig, axes, units and labels.

use ::hdf5::types::{VarLenAscii, VarLenUnicode};
use ::hdf5::{H5Type, Location};
use ndarray::{aview0, aview1};

use super::library::read_text;
use crate::arrays::rig_values::RigValues;

/// The version of the layout of a light field.
pub(super) const LAYOUT: &str = "holo light field 1";

/// The version of the layout of a sequence.
pub(super) const SEQUENCE_LAYOUT: &str = "holo light field sequence 1";

/// Maximum number of numbers of an attribute that is read.
const MAX_NUMBERS: usize = 16;

fn text(at: &Location, name: &str, text: &str) -> ::hdf5::Result<()> {
    let value: VarLenUnicode = text.parse().map_err(|_| ::hdf5::Error::from("text with a NUL in it"))?;
    at.new_attr::<VarLenUnicode>().create(name)?.write_scalar(&value)
}

fn numbers<T: H5Type>(at: &Location, name: &str, values: &[T]) -> ::hdf5::Result<()> {
    at.new_attr_builder().with_data(aview1(values)).create(name).map(|_| ())
}

fn number(at: &Location, name: &str, value: f64) -> ::hdf5::Result<()> {
    at.new_attr_builder().with_data(aview0(&value)).create(name).map(|_| ())
}

/// Writes the attributes of the file: layout, axes of the samples, counts and rig.
pub(super) fn write_rig(file: &Location, layout: &str, axes: &str, rig: &holo_core::Rig) -> ::hdf5::Result<()> {
    let values = RigValues::from(rig);
    let (views, lenses) = (rig.shape().views(), rig.shape().lenses());
    text(file, "format", layout)?;
    text(file, "axes", axes)?;
    numbers(file, "views", &[views.rows as u64, views.columns as u64])?;
    numbers(file, "lenses", &[lenses.rows as u64, lenses.columns as u64])?;
    numbers(file, "baseline_m", &values.baseline_m)?;
    number(file, "focal_length_mm", values.focal_length_mm)?;
    number(file, "sensor_size_mm", values.sensor_size_mm)?;
    number(file, "focus_distance_m", values.focus_distance_m)?;
    text(file, "projection", values.projection)
}

/// Writes axes, unit and dimension labels of a dataset.
///
/// The labels are those that `H5DSset_label` of the high-level library writes, which the binding does not have.
pub(super) fn write_axes(dataset: &Location, axes: &str, units: &str) -> ::hdf5::Result<()> {
    text(dataset, "axes", axes)?;
    text(dataset, "units", units)?;
    let label = |letter: char| VarLenAscii::from_ascii(&[letter as u8]).map_err(|_| ::hdf5::Error::from("not ASCII"));
    let labels: Vec<VarLenAscii> = axes.chars().map(label).collect::<Result<_, _>>()?;
    numbers(dataset, "DIMENSION_LABELS", &labels)
}

/// Reads a text attribute; `None` if there is none.
pub(super) fn read_word(at: &Location, name: &str) -> ::hdf5::Result<Option<String>> {
    if !at.attr_names()?.iter().any(|own| own == name) {
        return Ok(None);
    }
    let attribute = at.attr(name)?;
    read_text(&attribute)
}

/// Reads the numbers of an attribute of any number type; `None` if there is none.
pub(super) fn read_numbers(at: &Location, name: &str) -> ::hdf5::Result<Option<Vec<f64>>> {
    if !at.attr_names()?.iter().any(|own| own == name) {
        return Ok(None);
    }
    let attribute = at.attr(name)?;
    if attribute.size() > MAX_NUMBERS {
        return Err(format!("the attribute '{name}' has {} numbers", attribute.size()).into());
    }
    attribute
        .as_reader()
        .conversion(::hdf5::Conversion::Hard)
        .read_raw::<f64>()
        .or_else(|_| attribute.read_raw())
        .map(Some)
}
