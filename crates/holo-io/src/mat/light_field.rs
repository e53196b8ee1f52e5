//! A light field and its rig as variables.

use std::path::Path;

use holo_core::{DynLightField, DynLightFieldRef, GridSize, LightField, Rig, Sample};
use ndarray::{Array5, ArrayD, ArrayView5, ArrayViewD, Data, Ix5, IxDyn, aview0, aview1};

use super::file::{MatReader, missing};
use super::{MatArray, MatOptions, MatValue, MatVariable, write_mat};
use crate::rig_values::{self, RigValues};
use crate::{Error, FileDigest, Limits};

/// The order of a light field's dimensions in a MAT file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum MatOrder {
    /// `H` of size `[V U T S C]`: lenses first.
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

    /// Which axis of `(v, u, t, s, c)` each dimension is.
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
    /// The samples, with the strides that the file has.
    pub light_field: DynLightField,
    /// The rig, if the file tells all of it and its numbers make one.
    pub rig: Option<Rig>,
    /// Why the numbers in the file make no rig, if they do not.
    pub rig_error: Option<holo_core::Error>,
}

/// The samples as MATLAB shall see them, in the order of `axes`.
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

/// Writes a light field and what is known of its rig.
///
/// The variables are those of the module's table. The samples are not copied as a whole, whatever their strides.
///
/// # Shape
///
/// `(v, u, t, s, c)`; in MATLAB `H(v+1, u+1, t+1, s+1, c+1)`.
///
/// # Errors
///
/// Those of [`write_mat`], and [`Error::BadInput`] if the rig is for other views or lenses.
pub fn write_mat_light_field<S>(
    path: impl AsRef<Path>,
    light_field: &LightField<S>,
    rig: Option<&Rig>,
    order: MatOrder,
    options: &MatOptions,
) -> Result<FileDigest, Error>
where
    S: Data,
    S::Elem: Sample,
{
    let path = path.as_ref();
    let split = light_field.shape();
    rig_values::check_split(path, rig, &split)?;
    let counts = [split.views(), split.lenses()].map(|size| [size.rows as f64, size.columns as f64]);
    let values = rig.map(RigValues::from);
    let samples = value(light_field.as_light_field_ref().into(), &order.axes());
    let mut variables = vec![MatVariable { name: order.name(), value: samples }];
    variables.extend(beside(order, &counts, values.as_ref()));
    write_mat(path, &variables, options)
}

/// The small variables beside the samples; `counts` are those of views and lenses.
pub(super) fn beside<'a>(
    order: MatOrder,
    counts: &'a [[f64; 2]; 2],
    values: Option<&'a RigValues>,
) -> Vec<MatVariable<'a>> {
    let numbers = |name, numbers| MatVariable { name, value: MatValue::F64(aview1(numbers).into_dyn()) };
    let number = |name, number| MatVariable { name, value: MatValue::F64(aview0(number).into_dyn()) };
    let text = |name, text| MatVariable { name, value: MatValue::Text(text) };
    let [views, lenses] = counts;
    let mut variables = vec![text("axes", order.letters()), numbers("views", views), numbers("lenses", lenses)];
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

/// Reads a light field from a MAT file: `H` or `LF`, and the rig beside it.
///
/// Without `axes`, the name tells the order. Dimensions of length 1 that the file lost are put back. Nothing is copied to
/// change the order: the strides differ.
///
/// # Errors
///
/// Those of [`read_mat_variable`](super::read_mat_variable); [`Error::BadInput`] if there is neither `H` nor `LF`;
/// [`Error::Broken`] if the variables contradict each other; [`Error::Unsupported`] if the samples have another class than
/// the table's.
pub fn read_mat_light_field(path: impl AsRef<Path>, limits: &Limits) -> Result<MatLightField, Error> {
    let path = path.as_ref();
    let mut opened = MatReader::open(path, *limits)?;
    let infos = opened.infos();
    let position = |name: &str| infos.iter().position(|info| info.name == name);
    let orders = [MatOrder::Lenses, MatOrder::LightFieldToolbox];
    let found = orders.into_iter().find_map(|order| Some((order, position(order.name())?)));
    let (order, index) = found.ok_or_else(|| Error::bad_input(path, missing("H", &infos)))?;

    let mut value = |name: &str| position(name).map(|index| opened.value(index)).transpose();
    let letters = match value("axes")? {
        Some(MatArray::Text(letters)) => letters,
        Some(_) => return Err(contradiction(path, "`axes` is not text")),
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

    let light_field = match opened.value(index)? {
        MatArray::U8(array) => ordered(path, array, &letters),
        MatArray::U16(array) => ordered(path, array, &letters),
        MatArray::F32(array) => ordered(path, array, &letters),
        MatArray::F64(array) => ordered(path, array, &letters),
        other => {
            let class = other.view().class().name();
            let what = format!("'{}' is of class {class}; uint8, uint16, single and double can be read", order.name());
            Err(Error::unsupported(path, what))
        }
    }?;
    let split = light_field.shape();
    check_counts(path, "views", views, split.views())?;
    check_counts(path, "lenses", lenses, split.lenses())?;
    let rig = rig_values::rig(path, split, baseline_m, lengths, projection.as_deref())?;
    let (rig, rig_error) = match rig {
        Some(Ok(rig)) => (Some(rig), None),
        Some(Err(error)) => (None, Some(error)),
        None => (None, None),
    };
    Ok(MatLightField { light_field, rig, rig_error })
}

fn contradiction(path: &Path, what: impl Into<String>) -> Error {
    Error::broken(path, "MAT light field", what)
}

/// Gives an array its five axes back and names them.
fn ordered<T: Sample>(path: &Path, array: ArrayD<T>, letters: &str) -> Result<DynLightField, Error> {
    let mut shape = array.shape().to_vec();
    if shape.len() > 5 {
        return Err(contradiction(path, format!("the samples have {} dimensions instead of five", shape.len())));
    }
    let axes: Option<Vec<usize>> = "vutsc".chars().map(|letter| letters.find(letter)).collect();
    let axes = axes.filter(|_| letters.len() == 5);
    let axes =
        axes.ok_or_else(|| contradiction(path, format!("`axes` is '{letters}' instead of an order of vutsc")))?;
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

/// Compares counts that stand beside the samples with the samples.
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
