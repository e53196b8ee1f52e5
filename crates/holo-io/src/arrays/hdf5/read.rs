//! The reader of a file: its contents, and parts of its samples and maps.

use std::path::{Path, PathBuf};

use ::hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use ::hdf5::{Dataset, File, H5Type, Hyperslab, SliceOrIndex};
use holo_core::{DynImage, DynLightField, GridSize, LightField, LightFieldShape, Rig, SampleKind};
use ndarray::{Array2, Array4, Array5, ArrayD, Axis, Dimension, Ix3};

use super::library::{Failure, open};
use super::storage::{check_values, find};
use super::{FORMAT, Hdf5Map, Number, attributes, with_sample_type};
use crate::arrays::rig_values::{self, FoundRig};
use crate::{Error, Limits};

/// An HDF5 light field, opened for reading.
///
/// Every read first compares the size of its result and of a chunk with the limits.
#[derive(Debug)]
pub struct Hdf5LightField {
    samples: Dataset,
    file: File,
    path: PathBuf,
    limits: Limits,
    /// Lengths of the axes (v, u, t, s, c).
    dimensions: [usize; 5],
    shape: LightFieldShape,
    kind: SampleKind,
    rig: FoundRig,
}

/// Whether an HDF5 file contains a light field: a dataset `/H` of five axes.
///
/// # Errors
///
/// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is not an HDF5 file.
pub fn is_light_field_hdf5(path: impl AsRef<Path>) -> Result<bool, Error> {
    let path = path.as_ref();
    let file = open(path)?;
    Ok(find(&file, path, "H")?.is_some_and(|samples| samples.ndim() == 5))
}

impl Hdf5LightField {
    /// Opens a file and reads its shape, sample type and rig.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the file cannot be read; [`Error::Broken`] if it is not an HDF5 file, has no `/H` of five axes,
    /// or contradicts itself; [`Error::Unsupported`] if its samples are not uint8, uint16, float32 or float64, its axes
    /// are in another order, or it is the file of a sequence.
    pub fn open(path: impl AsRef<Path>, limits: &Limits) -> Result<Self, Error> {
        let path = path.as_ref();
        let failed = |error| Failure { path, is_writing: false }.error(error);
        let broken = |what: String| Error::broken(path, FORMAT, what);
        let file = open(path)?;
        let samples = find(&file, path, "H")?.ok_or_else(|| broken("there is no dataset /H".into()))?;
        if samples.ndim() == 6 {
            let what = format!("a sequence of {} frames; read the file of one of them", samples.shape()[0]);
            return Err(Error::unsupported(path, what));
        }
        let dimensions: [usize; 5] =
            samples.get_shape().map_err(failed)?.try_into().map_err(|dimensions: Vec<usize>| {
                broken(format!("/H has {} axes instead of five", dimensions.len()))
            })?;
        let [v, u, t, s, channels] = dimensions;
        let (views, lenses) = (GridSize::new(t, s), GridSize::new(v, u));
        let shape = LightFieldShape::new(views, lenses).map_err(|error| Error::core(path, error))?;
        if channels == 0 {
            return Err(broken("/H has no channels".into()));
        }
        let kind = sample_kind(&samples)
            .map_err(failed)?
            .ok_or_else(|| Error::unsupported(path, "/H is neither uint8 nor uint16, float32 or float64"))?;
        match attributes::read_word(&file, "axes").map_err(failed)?.as_deref() {
            None | Some("vutsc") => {}
            Some(other) => {
                return Err(Error::unsupported(path, format!("the axes of /H are '{other}'; 'vutsc' can be read")));
            }
        }
        let numbers = |name| attributes::read_numbers(&file, name).map_err(failed);
        for (name, found) in [("views", views), ("lenses", lenses)] {
            if let Some(counts) = numbers(name)?
                && counts != [found.rows as f64, found.columns as f64]
            {
                return Err(broken(format!("`{name}` is {counts:?}, but /H has {} x {}", found.rows, found.columns)));
            }
        }
        let lengths = [numbers("focal_length_mm")?, numbers("sensor_size_mm")?, numbers("focus_distance_m")?];
        let projection = attributes::read_word(&file, "projection").map_err(failed)?;
        let rig = rig_values::rig(path, shape, numbers("baseline_m")?, lengths, projection.as_deref())?;
        Ok(Self { samples, file, path: path.to_owned(), limits: *limits, dimensions, shape, kind, rig })
    }

    /// Returns the numbers of views and microlenses.
    #[must_use]
    pub const fn shape(&self) -> LightFieldShape {
        self.shape
    }

    /// Returns the number of channels.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.dimensions[4]
    }

    /// Returns the type of the samples.
    #[must_use]
    pub const fn sample_kind(&self) -> SampleKind {
        self.kind
    }

    /// Returns the rig, if the file contains all of its numbers and they are valid.
    #[must_use]
    pub fn rig(&self) -> Option<&Rig> {
        self.rig.as_ref()?.as_ref().ok()
    }

    /// Returns why the numbers in the file make no rig, if they are invalid.
    #[must_use]
    pub fn rig_error(&self) -> Option<&holo_core::Error> {
        self.rig.as_ref()?.as_ref().err()
    }

    /// Returns the maps of all views, and the maps of the central view alone, that the file contains.
    #[must_use]
    pub fn maps(&self) -> (Vec<Hdf5Map>, Vec<Hdf5Map>) {
        let exists = |name: &str| matches!(find(&self.file, &self.path, name), Ok(Some(_)));
        let all = Hdf5Map::ALL.into_iter().filter(|map| exists(map.name())).collect();
        (all, Hdf5Map::ALL.into_iter().filter(|map| exists(&format!("central/{}", map.name()))).collect())
    }

    /// Reads all samples.
    ///
    /// # Shape
    ///
    /// `(v, u, t, s, c)`.
    ///
    /// # Errors
    ///
    /// [`Error::TooLarge`] if they exceed the limits; [`Error::Broken`] if the library cannot read them.
    pub fn read(&self) -> Result<DynLightField, Error> {
        with_sample_type!(self.kind, T => self.light_field::<T>())
    }

    fn light_field<T: Number>(&self) -> Result<DynLightField, Error> {
        let whole = self.dimensions.map(|count| SliceOrIndex::from(0..count));
        let samples: Array5<T> = self.part(&self.samples, whole.to_vec())?;
        LightField::new(samples).map(DynLightField::from).map_err(|error| Error::core(&self.path, error))
    }

    fn image(&self, slices: Vec<SliceOrIndex>) -> Result<DynImage, Error> {
        with_sample_type!(self.kind, T => self.part::<T, Ix3>(&self.samples, slices).map(DynImage::from))
    }

    /// Reads the view `(t, s)`: only the chunks that contain it.
    ///
    /// # Shape
    ///
    /// `(v, u, c)`.
    ///
    /// # Errors
    ///
    /// Those of [`read`](Self::read); [`Error::BadInput`] if there is no such view.
    pub fn read_view(&self, t: usize, s: usize) -> Result<DynImage, Error> {
        let [v, u, .., c] = self.dimensions;
        self.check_index("view", (t, s), self.shape.views())?;
        self.image(vec![(0..v).into(), (0..u).into(), t.into(), s.into(), (0..c).into()])
    }

    /// Reads the elemental image of the microlens `(v, u)`: only the chunks that contain it.
    ///
    /// # Shape
    ///
    /// `(t, s, c)`.
    ///
    /// # Errors
    ///
    /// Those of [`read`](Self::read); [`Error::BadInput`] if there is no such microlens.
    pub fn read_lens(&self, v: usize, u: usize) -> Result<DynImage, Error> {
        let [_, _, t, s, c] = self.dimensions;
        self.check_index("lens", (v, u), self.shape.lenses())?;
        self.image(vec![v.into(), u.into(), (0..t).into(), (0..s).into(), (0..c).into()])
    }

    /// Reads a ground truth map of all views, in the unit of [`Hdf5Map::unit`].
    ///
    /// # Shape
    ///
    /// `(v, u, t, s)`.
    ///
    /// # Errors
    ///
    /// Those of [`read`](Self::read); [`Error::BadInput`] if the file has no such map; [`Error::Broken`] if it has
    /// another shape than the samples.
    pub fn read_map(&self, map: Hdf5Map) -> Result<Array4<f32>, Error> {
        let dataset = self.map_dataset(map.name(), &self.dimensions[..4])?;
        self.part(&dataset, self.dimensions[..4].iter().map(|&count| (0..count).into()).collect())
    }

    /// Reads the part of a ground truth map of all views for the view `(t, s)`, in the unit of [`Hdf5Map::unit`].
    ///
    /// # Shape
    ///
    /// `(v, u)`.
    ///
    /// # Errors
    ///
    /// Those of [`read_map`](Self::read_map), and [`Error::BadInput`] if there is no such view.
    pub fn read_map_of_view(&self, map: Hdf5Map, t: usize, s: usize) -> Result<Array2<f32>, Error> {
        self.check_index("view", (t, s), self.shape.views())?;
        let dataset = self.map_dataset(map.name(), &self.dimensions[..4])?;
        let [v, u, ..] = self.dimensions;
        self.part(&dataset, vec![(0..v).into(), (0..u).into(), t.into(), s.into()])
    }

    /// Reads a ground truth map of the central view, in the unit of [`Hdf5Map::unit`]: the map of the central view
    /// alone, else the part of the map of all views.
    ///
    /// # Shape
    ///
    /// `(v, u)`.
    ///
    /// # Errors
    ///
    /// Those of [`read_map`](Self::read_map).
    pub fn read_central_map(&self, map: Hdf5Map) -> Result<Array2<f32>, Error> {
        let name = format!("central/{}", map.name());
        if find(&self.file, &self.path, &name)?.is_none() {
            let (t, s) = self.shape.central_view();
            return self.read_map_of_view(map, t, s);
        }
        let dataset = self.map_dataset(&name, &self.dimensions[..2])?;
        self.part(&dataset, self.dimensions[..2].iter().map(|&count| (0..count).into()).collect())
    }

    fn map_dataset(&self, name: &str, shape: &[usize]) -> Result<Dataset, Error> {
        let dataset = find(&self.file, &self.path, name)?
            .ok_or_else(|| Error::bad_input(&self.path, format!("the file has no map /{name}")))?;
        if dataset.shape() != shape {
            let what = format!("/{name} has shape {:?} instead of {shape:?}", dataset.shape());
            return Err(Error::broken(&self.path, FORMAT, what));
        }
        Ok(dataset)
    }

    fn check_index(&self, what: &str, (row, column): (usize, usize), count: GridSize) -> Result<(), Error> {
        if row < count.rows && column < count.columns {
            return Ok(());
        }
        Err(Error::bad_input(
            &self.path,
            format!("there is no {what} at row {row}, column {column}; {} x {} are there", count.rows, count.columns),
        ))
    }

    /// Reads a part of a dataset.
    fn part<T: H5Type, D: Dimension>(
        &self,
        dataset: &Dataset,
        slices: Vec<SliceOrIndex>,
    ) -> Result<ndarray::Array<T, D>, Error> {
        let part = read_part::<T>(dataset, &slices, &self.path, self.limits)?;
        part.into_dimensionality().map_err(|error| Error::broken(&self.path, FORMAT, error.to_string()))
    }
}

/// Reads a part of a dataset; an axis with an index is left out, as in ndarray.
///
/// The library reads such an axis with its length of 1: where memory has fewer axes than the file, it finds the place of every
/// value by itself, which takes forty times as long.
pub(super) fn read_part<T: H5Type>(
    dataset: &Dataset,
    slices: &[SliceOrIndex],
    path: &Path,
    limits: Limits,
) -> Result<ArrayD<T>, Error> {
    let ranges: Vec<SliceOrIndex> = slices
        .iter()
        .map(|slice| match *slice {
            SliceOrIndex::Index(index) => (index..index + 1).into(),
            other => other,
        })
        .collect();
    let counts: Vec<usize> = ranges
        .iter()
        .map(|slice| match *slice {
            SliceOrIndex::SliceTo { start, end, .. } => end - start,
            _ => 1,
        })
        .collect();
    limits.elements(path, "part of the light field", &counts, size_of::<T>())?;
    check_chunk(path, dataset, limits)?;
    let read = dataset.read_slice(Hyperslab::from(ranges));
    let mut part: ArrayD<T> = read.map_err(|error| Failure { path, is_writing: false }.error(error))?;
    for (axis, slice) in slices.iter().enumerate().rev() {
        if matches!(slice, SliceOrIndex::Index(_)) {
            part = part.index_axis_move(Axis(axis), 0);
        }
    }
    Ok(part)
}

/// Checks that the values of a dataset lie in the file, and the size of a chunk, which the library reads as a whole, against
/// the limit.
pub(crate) fn check_chunk(path: &Path, dataset: &Dataset, limits: Limits) -> Result<(), Error> {
    check_values(dataset, path)?;
    let bytes = dataset.dtype().map_or(1, |dtype| dtype.size());
    let chunk = dataset.chunk().unwrap_or_default();
    limits.elements(path, "chunk", &chunk, bytes).map(|_| ())
}

/// The sample type of a dataset; `None` if light fields cannot have it.
pub(super) fn sample_kind(dataset: &Dataset) -> ::hdf5::Result<Option<SampleKind>> {
    Ok(match dataset.dtype()?.to_descriptor()? {
        TypeDescriptor::Unsigned(IntSize::U1) => Some(SampleKind::U8),
        TypeDescriptor::Unsigned(IntSize::U2) => Some(SampleKind::U16),
        TypeDescriptor::Float(FloatSize::U4) => Some(SampleKind::F32),
        TypeDescriptor::Float(FloatSize::U8) => Some(SampleKind::F64),
        _ => None,
    })
}
