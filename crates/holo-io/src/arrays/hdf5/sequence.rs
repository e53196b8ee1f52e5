//! The file of a sequence: the light fields of its frames as one array, which the files of the frames hold.

use std::path::Path;

use ::hdf5::{Dataset, File, H5Type, Hyperslab, SliceOrIndex};
use holo_core::{Rig, SampleKind};
use ndarray::{Array1, ArrayView, Dimension, aview1, aview2};

use super::library::{Failure, create, open};
use super::read::sample_kind;
use super::scales::{self, Scales};
use super::storage::find;
use super::{FORMAT, Hdf5Map, attributes};
use crate::arrays::rig_values::RigValues;
use crate::files::atomic::AtomicPath;
use crate::files::folder::Folder;
use crate::records::dataset::{LIGHT_FIELD_HDF5, MANIFEST_JSON, PARAMETERS_CFG, SEQUENCE_HDF5, SequenceFolder};
use crate::{CameraPose, Error, FileDigest, Manifest, ManifestValue, ParametersCfg};

/// An array that every frame has.
#[derive(Debug, Clone, PartialEq)]
struct Contents {
    /// Its path in the file.
    name: String,
    /// A letter for each axis.
    axes: &'static str,
    shape: Vec<usize>,
    kind: SampleKind,
    units: String,
}

/// A frame without its samples.
#[derive(Debug)]
struct Frame {
    time_s: Option<f64>,
    rig: Rig,
    pose: Option<CameraPose>,
    contents: Vec<Contents>,
}

/// Writes `sequence_5d.h5` into the folder of a sequence: the arrays of `scene_5d.h5` of these frames, with the frame as
/// their first axis.
///
/// The samples stay where they are: the arrays are virtual datasets, which read the files of the frames below the folder.
/// So the file has some kilobytes, and the folder can be moved as a whole. A frame whose file is missing reads as NaN, or as 0 in integers, and so does one beyond
/// the number of files that a process may open: a reader keeps those open that it has read.
///
/// # Errors
///
/// [`Error::BadInput`] if there are no frames, or they have not the same arrays in the same shapes; [`Error::Io`] and
/// [`Error::Broken`] if the manifest or the HDF5 file of a frame cannot be read, and [`Error::Io`] if the file cannot be
/// written.
pub fn write_hdf5_sequence(sequence: &SequenceFolder, frames: &[u32]) -> Result<FileDigest, Error> {
    let path = sequence.path().join(SEQUENCE_HDF5);
    let read = frames.iter().map(|&frame| read_frame(&sequence.frame_path(frame)));
    let read: Vec<Frame> = read.collect::<Result<_, _>>()?;
    let Some(first) = read.first() else { return Err(Error::bad_input(&path, "a sequence without frames")) };
    if first.contents.is_empty() {
        let file = sequence.frame_path(frames[0]).join(LIGHT_FIELD_HDF5);
        return Err(Error::broken(&file, FORMAT, "it has no array of a light field"));
    }
    if let Some(other) = read.iter().position(|frame| frame.contents != first.contents) {
        let what = format!("frame {} has other arrays than frame {}", frames[other], frames[0]);
        return Err(Error::bad_input(&path, what));
    }
    let target = AtomicPath::create(Folder::open(sequence.path())?.file(SEQUENCE_HDF5))?;
    write(&target, frames, &read).map_err(|error| match error {
        Problem::Library(error) => Failure { path: &path, is_writing: true }.error(error),
        Problem::Own(error) => error,
    })?;
    target.commit()
}

/// An error of the library or of this crate.
enum Problem {
    Library(::hdf5::Error),
    Own(Error),
}

impl From<::hdf5::Error> for Problem {
    fn from(error: ::hdf5::Error) -> Self {
        Self::Library(error)
    }
}

/// Writes the file of at least one frame.
fn write(target: &AtomicPath, frames: &[u32], read: &[Frame]) -> Result<(), Problem> {
    let first = &read[0];
    let text = scales::text_type(target.temporary_path(), target.path()).map_err(Problem::Own)?;
    let file = create(target.temporary_path(), 0, false)?;
    attributes::write_rig(&file, attributes::SEQUENCE_LAYOUT, "fvutsc", &first.rig)?;
    let longest = first.contents.iter().max_by_key(|contents| contents.axes.len()).unwrap_or(&first.contents[0]);
    let numbers = Array1::from_iter(frames.iter().map(|&frame| frame.cast_signed()));
    let mut axes = vec![('f', numbers)];
    axes.extend(longest.axes.chars().zip(longest.shape.iter().map(|&count| scales::indices(count))));
    // The coordinates of positions and rotations.
    axes.push(('i', scales::indices(3)));
    // Vertical and horizontal.
    axes.push(('j', scales::indices(2)));
    let mut scales = Scales::create(&file, axes, &text)?;
    let times: Option<Vec<f64>> = read.iter().map(|frame| frame.time_s).collect();
    if let Some(times) = times {
        store(&file, &mut scales, "time_s", ("f", "s"), aview1(&times))?;
    }
    let baselines: Vec<[f64; 2]> = read.iter().map(|frame| RigValues::from(&frame.rig).baseline_m).collect();
    store(&file, &mut scales, "baseline_m", ("fj", "m"), aview2(&baselines))?;
    let focal_lengths: Vec<f64> = read.iter().map(|frame| RigValues::from(&frame.rig).focal_length_mm).collect();
    store(&file, &mut scales, "focal_length_mm", ("f", "mm"), aview1(&focal_lengths))?;
    let poses: Option<Vec<CameraPose>> = read.iter().map(|frame| frame.pose).collect();
    if let Some(poses) = poses {
        let positions: Vec<[f64; 3]> = poses.iter().map(|pose| pose.position_m).collect();
        let rotations: Vec<[f64; 3]> = poses.iter().map(|pose| pose.rotation_rad).collect();
        store(&file, &mut scales, "camera_position_m", ("fi", "m"), aview2(&positions))?;
        store(&file, &mut scales, "camera_rotation_rad", ("fi", "rad"), aview2(&rotations))?;
    }
    if first.contents.iter().any(|contents| contents.name.starts_with("central/")) {
        file.create_group_builder().obj_track_times(false).create("central")?;
    }
    for contents in &first.contents {
        let dataset = match contents.kind {
            SampleKind::U8 => link(&file, contents, frames, 0_u8),
            SampleKind::U16 => link(&file, contents, frames, 0_u16),
            SampleKind::F32 => link(&file, contents, frames, f32::NAN),
            SampleKind::F64 => link(&file, contents, frames, f64::NAN),
        }?;
        let axes = format!("f{}", contents.axes);
        attributes::write_axes(&dataset, &axes, &contents.units)?;
        scales.attach(&file, &contents.name, &axes)?;
    }
    scales.finish(&file)?;
    file.flush()?;
    file.close()?;
    Ok(())
}

/// Writes numbers of every frame. `axes` has a letter for each axis.
fn store<D: Dimension>(
    file: &File,
    scales: &mut Scales,
    name: &str,
    (axes, units): (&str, &str),
    values: ArrayView<'_, f64, D>,
) -> ::hdf5::Result<()> {
    // No clock in the file.
    let dataset = file.new_dataset_builder().with_data(values).obj_track_times(false).create(name)?;
    attributes::write_axes(&dataset, axes, units)?;
    scales.attach(file, name, axes)
}

/// Creates a dataset whose parts are the datasets of the same name in the files of the frames.
fn link<T: H5Type>(file: &File, contents: &Contents, frames: &[u32], missing: T) -> ::hdf5::Result<Dataset> {
    let whole: Vec<SliceOrIndex> = contents.shape.iter().map(|&count| (0..count).into()).collect();
    let shape: Vec<usize> = std::iter::once(frames.len()).chain(contents.shape.iter().copied()).collect();
    let mut builder = file.new_dataset::<T>().shape(&shape).obj_track_times(false).fill_value(missing);
    for (place, &frame) in frames.iter().enumerate() {
        let source = format!("{}/{LIGHT_FIELD_HDF5}", SequenceFolder::frame_name(frame));
        let part: Vec<SliceOrIndex> = std::iter::once(place.into()).chain(whole.iter().cloned()).collect();
        let name = format!("/{}", contents.name);
        builder = builder.virtual_map(
            source,
            name,
            &contents.shape,
            Hyperslab::from(whole.clone()),
            &shape,
            Hyperslab::from(part),
        );
    }
    builder.create(contents.name.as_str())
}

/// Reads what the file of a sequence says of a frame.
fn read_frame(folder: &Path) -> Result<Frame, Error> {
    let manifest_path = folder.join(MANIFEST_JSON);
    let manifest = Manifest::read(&manifest_path)?;
    let time_s = manifest.settings.get("time_s").and_then(ManifestValue::as_number);
    let rig = manifest.rig.ok_or_else(|| Error::broken(&manifest_path, "manifest", "it has no rig"))?;
    let listed = manifest.files.contains_key(PARAMETERS_CFG);
    let parameters = listed.then(|| ParametersCfg::read(folder.join(PARAMETERS_CFG))).transpose()?;
    let path = folder.join(LIGHT_FIELD_HDF5);
    let failed = |error| Failure { path: &path, is_writing: false }.error(error);
    let file = open(&path)?;
    let mut contents = Vec::new();
    let maps = Hdf5Map::ALL.map(|map| (map.name().to_owned(), "vuts"));
    let central = Hdf5Map::ALL.map(|map| (format!("central/{}", map.name()), "vu"));
    for (name, axes) in std::iter::once(("H".to_owned(), "vutsc")).chain(maps).chain(central) {
        let Some(dataset) = find(&file, &path, &name)? else { continue };
        let shape = dataset.get_shape().map_err(failed)?;
        let kind = sample_kind(&dataset).map_err(failed)?;
        let Some(kind) = kind.filter(|_| shape.len() == axes.len()) else {
            return Err(Error::broken(&path, FORMAT, format!("/{name} is no array with the axes {axes}")));
        };
        let units = attributes::read_word(&dataset, "units").map_err(failed)?.unwrap_or_default();
        contents.push(Contents { name, axes, shape, kind, units });
    }
    Ok(Frame { time_s, rig, pose: parameters.and_then(|parameters| parameters.center_cam), contents })
}
