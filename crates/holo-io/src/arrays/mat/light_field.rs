//! A light field and its rig as variables of a MAT file.

use std::path::Path;

use holo_core::{DynLightField, DynLightFieldRef, GridSize, LightField, LightFieldShape, Rig, Sample};
use ndarray::{Array5, ArrayD, ArrayView5, ArrayViewD, Data, Ix5, IxDyn, aview0, aview1};

use super::file::{MatReader, missing};
use super::{MatArray, MatClass, MatInfo, MatOptions, MatValue, MatVariable, write_mat};
use crate::arrays::rig_values::{self, RigValues};
use crate::files::folder::Destination;
use crate::{Error, FileDigest, Limits};

/// The variable with the order of the axes.
const AXIS_ORDER: &str = "axis_order";

/// Its name in files of version 0.1, where it hid a function of MATLAB.
const OLD_AXIS_ORDER: &str = "axes";

/// The order of the dimensions of a light field in a MAT file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum MatOrder {
    /// `H` of size `[V U T S C]`: microlenses first.
    #[default]
    Lenses,
    /// `LF` of size `[T S V U C]`: views first, as in the Light Field Toolbox.
    LightFieldToolbox,
}

impl MatOrder {
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Lenses => "H",
            Self::LightFieldToolbox => "LF",
        }
    }

    const fn letters(self) -> &'static str {
        match self {
            Self::Lenses => "vutsc",
            Self::LightFieldToolbox => "tsvuc",
        }
    }

    /// The axis of `(v, u, t, s, c)` of each dimension.
    const fn axes(self) -> [usize; 5] {
        match self {
            Self::Lenses => [0, 1, 2, 3, 4],
            Self::LightFieldToolbox => [2, 3, 0, 1, 4],
        }
    }
}

/// A light field that was read from a MAT file.
#[derive(Debug, Clone, PartialEq)]
pub struct MatLightField {
    /// The samples `(v, u, t, s, c)`, with the strides of the file.
    pub light_field: DynLightField,
    /// The rig, if the file contains all of its numbers and they are valid.
    pub rig: Option<Rig>,
    /// Why the numbers in the file make no rig, if they are invalid.
    pub rig_error: Option<holo_core::Error>,
}

/// The samples as the value of a variable, with dimensions in the order of `axes`.
pub(super) fn value<'a>(samples: DynLightFieldRef<'a>, axes: &[usize; 5]) -> MatValue<'a> {
    fn ordered<'a, T>(samples: ArrayView5<'a, T>, axes: &[usize; 5]) -> ArrayViewD<'a, T> {
        samples.into_dyn().permuted_axes(IxDyn(axes))
    }
    match samples {
        DynLightFieldRef::U8(field) => MatValue::U8(ordered(field.into_samples(), axes)),
        DynLightFieldRef::U16(field) => MatValue::U16(ordered(field.into_samples(), axes)),
        DynLightFieldRef::F32(field) => MatValue::F32(ordered(field.into_samples(), axes)),
        DynLightFieldRef::F64(field) => MatValue::F64(ordered(field.into_samples(), axes)),
    }
}

/// Writes a light field, and its rig if there is one, into a MAT file.
///
/// The samples are not copied as a whole, whatever their strides.
///
/// | variable | class | value |
/// |---|---|---|
/// | `H` | `uint8`, `uint16`, `single` or `double` | the samples, `[V U T S C]` |
/// | or `LF` | the same | the samples, `[T S V U C]` |
/// | `axis_order` | `char` | `vutsc` or `tsvuc`, a letter a dimension |
/// | `views`, `lenses` | `double` | `[T S]` and `[V U]`, rows first |
/// | `baseline_m` | `double` | `[y x]` |
/// | `focal_length_mm`, `sensor_size_mm`, `focus_distance_m` | `double` | numbers; the focus may be `Inf` |
/// | `projection` | `char` | `perspective` or `orthographic` |
///
/// # Shape
///
/// `(v, u, t, s, c)`; in MATLAB `H(v+1, u+1, t+1, s+1, c+1)`.
///
/// # Errors
///
/// Those of [`write_mat`], and [`Error::BadInput`] if the rig has other numbers of views or microlenses.
pub fn write_mat_light_field<S>(
    path: impl Destination,
    light_field: &LightField<S>,
    rig: Option<&Rig>,
    order: MatOrder,
    options: &MatOptions,
) -> Result<FileDigest, Error>
where
    S: Data,
    S::Elem: Sample,
{
    let shape = light_field.shape();
    rig_values::check_split(path.path(), rig, &shape)?;
    let counts = [shape.views(), shape.lenses()].map(|size| [size.rows as f64, size.columns as f64]);
    let values = rig.map(RigValues::from);
    let samples = value(light_field.as_light_field_ref().into(), &order.axes());
    let mut variables = vec![MatVariable { name: order.name(), value: samples }];
    variables.extend(metadata(order, &counts, values.as_ref()));
    write_mat(path, &variables, options)
}

/// All variables but the samples; `counts` are the rows and columns of views and microlenses.
pub(super) fn metadata<'a>(
    order: MatOrder,
    counts: &'a [[f64; 2]; 2],
    values: Option<&'a RigValues>,
) -> Vec<MatVariable<'a>> {
    let numbers = |name, numbers| MatVariable { name, value: MatValue::F64(aview1(numbers).into_dyn()) };
    let number = |name, number| MatVariable { name, value: MatValue::F64(aview0(number).into_dyn()) };
    let text = |name, text| MatVariable { name, value: MatValue::Text(text) };
    let [views, lenses] = counts;
    let mut variables = vec![text(AXIS_ORDER, order.letters()), numbers("views", views), numbers("lenses", lenses)];
    if let Some(values) = values {
        variables.extend([
            numbers("baseline_m", &values.baseline_m),
            number("focal_length_mm", &values.focal_length_mm),
            number("sensor_size_mm", &values.sensor_size_mm),
            number("focus_distance_m", &values.focus_distance_m),
            text("projection", values.projection),
        ]);
    }
    variables
}

/// Reads a light field, and its rig if there is one, from a MAT file; the variables are those of
/// [`write_mat_light_field`].
///
/// Without `axis_order` (`axes` in files of version 0.1), the name `H` or `LF` specifies the order. Trailing dimensions of length 1, which MATLAB drops, are
/// restored. Nothing is copied to change the order: the strides differ.
///
/// # Errors
///
/// Those of [`read_mat_variable`](super::read_mat_variable); [`Error::BadInput`] if there is neither `H` nor `LF`;
/// [`Error::Broken`] if the variables contradict each other; [`Error::Unsupported`] if the samples are of another class
/// than `uint8`, `logical`, `uint16`, `single` or `double`.
pub fn read_mat_light_field(path: impl AsRef<Path>, limits: &Limits) -> Result<MatLightField, Error> {
    let path = path.as_ref();
    let mut reader = MatReader::open(path, *limits)?;
    let header = read_header(path, &mut reader)?;
    let light_field = match reader.value(header.index)? {
        MatArray::U8(array) => ordered(path, array, &header.letters),
        MatArray::U16(array) => ordered(path, array, &header.letters),
        MatArray::F32(array) => ordered(path, array, &header.letters),
        MatArray::F64(array) => ordered(path, array, &header.letters),
        _ => Err(unreadable(path, &header.info)),
    }?;
    let (rig, rig_error) = header.numbers.check(path, light_field.shape())?;
    Ok(MatLightField { light_field, rig, rig_error })
}

/// The contents of a light field file without the samples.
pub(crate) struct MatHeader {
    pub(crate) shape: LightFieldShape,
    pub(crate) is_float: bool,
    pub(crate) rig: Option<Rig>,
    pub(crate) rig_error: Option<holo_core::Error>,
}

/// Reads everything of a light field but its samples; errors as [`read_mat_light_field`].
pub(crate) fn read_light_field_header(path: &Path, limits: &Limits) -> Result<MatHeader, Error> {
    let header = read_header(path, &mut MatReader::open(path, *limits)?)?;
    let is_float = match header.info.class {
        MatClass::U8 | MatClass::Logical | MatClass::U16 => false,
        MatClass::F32 | MatClass::F64 => true,
        _ => return Err(unreadable(path, &header.info)),
    };
    let mut size = header.info.size.clone();
    if size.len() > 5 {
        return Err(contradiction(path, format!("the samples have {} dimensions instead of five", size.len())));
    }
    size.resize(5, 1);
    let [v, u, t, s, _] = axes_of(path, &header.letters)?.map(|axis| size[axis]);
    let shape =
        LightFieldShape::new(GridSize::new(t, s), GridSize::new(v, u)).map_err(|error| Error::core(path, error))?;
    let (rig, rig_error) = header.numbers.check(path, shape)?;
    Ok(MatHeader { shape, is_float, rig, rig_error })
}

/// The small variables, and which variable holds the samples.
struct Header {
    index: usize,
    info: MatInfo,
    letters: String,
    numbers: Numbers,
}

/// The numbers of a light field file that describe the samples.
struct Numbers {
    views: Option<Vec<f64>>,
    lenses: Option<Vec<f64>>,
    baseline_m: Option<Vec<f64>>,
    lengths: [Option<Vec<f64>>; 3],
    projection: Option<String>,
}

impl Numbers {
    /// Compares them with the shape of the samples and builds the rig.
    fn check(self, path: &Path, shape: LightFieldShape) -> Result<(Option<Rig>, Option<holo_core::Error>), Error> {
        check_counts(path, "views", self.views, shape.views())?;
        check_counts(path, "lenses", self.lenses, shape.lenses())?;
        Ok(match rig_values::rig(path, shape, self.baseline_m, self.lengths, self.projection.as_deref())? {
            Some(Ok(rig)) => (Some(rig), None),
            Some(Err(error)) => (None, Some(error)),
            None => (None, None),
        })
    }
}

fn read_header(path: &Path, reader: &mut MatReader<'_>) -> Result<Header, Error> {
    let infos = reader.infos();
    let position = |name: &str| infos.iter().position(|info| info.name == name);
    let orders = [MatOrder::Lenses, MatOrder::LightFieldToolbox];
    let found = orders.into_iter().find_map(|order| Some((order, position(order.name())?)));
    let (order, index) = found.ok_or_else(|| Error::bad_input(path, missing("H", &infos)))?;

    let mut value = |name: &str| position(name).map(|index| reader.value(index)).transpose();
    let name = if position(AXIS_ORDER).is_some() { AXIS_ORDER } else { OLD_AXIS_ORDER };
    let letters = match value(name)? {
        Some(MatArray::Text(letters)) => letters,
        Some(_) => return Err(contradiction(path, format!("`{name}` is not text"))),
        None => order.letters().to_owned(),
    };
    let mut numbers = |name: &str| Ok::<_, Error>(value(name)?.map(|value| value.to_f64().unwrap_or_default()));
    let (views, lenses) = (numbers("views")?, numbers("lenses")?);
    let baseline_m = numbers("baseline_m")?;
    let lengths = [numbers("focal_length_mm")?, numbers("sensor_size_mm")?, numbers("focus_distance_m")?];
    let projection = match value("projection")? {
        Some(MatArray::Text(projection)) => Some(projection),
        Some(_) => return Err(contradiction(path, "`projection` is not text")),
        None => None,
    };
    let numbers = Numbers { views, lenses, baseline_m, lengths, projection };
    Ok(Header { index, info: infos[index].clone(), letters, numbers })
}

fn unreadable(path: &Path, info: &MatInfo) -> Error {
    let class = info.class.name();
    Error::unsupported(
        path,
        format!("'{}' is of class {class}; uint8, uint16, single and double can be read", info.name),
    )
}

fn contradiction(path: &Path, what: impl Into<String>) -> Error {
    Error::broken(path, "MAT light field", what)
}

/// The dimension in the file of each axis of `(v, u, t, s, c)`.
fn axes_of(path: &Path, letters: &str) -> Result<[usize; 5], Error> {
    let contradiction =
        || contradiction(path, format!("the order of the axes is '{letters}' instead of an order of vutsc"));
    if letters.len() != 5 {
        return Err(contradiction());
    }
    let mut axes = [0; 5];
    for (axis, letter) in axes.iter_mut().zip("vutsc".chars()) {
        *axis = letters.find(letter).ok_or_else(contradiction)?;
    }
    Ok(axes)
}

/// Restores the five axes of an array and their order `(v, u, t, s, c)`.
fn ordered<T: Sample>(path: &Path, array: ArrayD<T>, letters: &str) -> Result<DynLightField, Error> {
    let mut shape = array.shape().to_vec();
    if shape.len() > 5 {
        return Err(contradiction(path, format!("the samples have {} dimensions instead of five", shape.len())));
    }
    let axes = axes_of(path, letters)?;
    let mut array = array;
    while shape.len() < 5 {
        array = array.insert_axis(ndarray::Axis(shape.len()));
        shape.push(1);
    }
    let array: Array5<T> = array
        .permuted_axes(IxDyn(&axes))
        .into_dimensionality::<Ix5>()
        .map_err(|error| contradiction(path, error.to_string()))?;
    LightField::new(array).map(DynLightField::from).map_err(|error| Error::core(path, error))
}

/// Compares counts in the file with those of the samples.
fn check_counts(path: &Path, name: &str, counts: Option<Vec<f64>>, found: GridSize) -> Result<(), Error> {
    match counts.as_deref() {
        None => Ok(()),
        Some(&[rows, columns]) if rows == found.rows as f64 && columns == found.columns as f64 => Ok(()),
        Some(counts) => Err(contradiction(
            path,
            format!(
                "`{name}` is {counts:?}, but the samples have {} rows and {} columns of them",
                found.rows, found.columns
            ),
        )),
    }
}
