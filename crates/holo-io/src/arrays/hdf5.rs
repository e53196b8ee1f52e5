//! HDF5 light fields with ground truth, of which one view or one elemental image can be read alone.
//!
//! Through `hdf5-metno`, with the C library built in. Light fields are written lens row by lens row, so they need not
//! fit into memory.
//!
//! # Layout
//!
//! | what | axes | type |
//! |---|---|---|
//! | `/H` | (v, u, t, s, c) | linear float32; uint8, uint16 and float64 are written and read as well |
//! | `/depth_m`, `/ray_length_m`, `/disparity_px` | (v, u, t, s) | float32, of all views |
//! | `/central/depth_m`, `/central/ray_length_m`, `/central/disparity_px` | (v, u) | float32, of the central view |
//!
//! Attributes of the file: `format`, `axes` (`vutsc`), `views` = \[T S\], `lenses` = \[V U\], and of the rig
//! `baseline_m` = \[y x\], `focal_length_mm`, `sensor_size_mm`, `focus_distance_m`, `projection`. Every dataset has
//! `axes` and `units`. Compression is shuffle and gzip, which every reader supports.
//!
//! `/v`, `/u`, `/t`, `/s`, `/c` are dimension scales, the indices from 0, attached to the dimensions of every dataset. So
//! `xarray.open_dataset("scene_5d.h5", engine="netcdf4")`, or `"h5netcdf"`, names the dimensions, and
//! `dataset.H.sel(t=2, s=3)` is a view; `dims[0].label` in h5py is the letter too.
//!
//! # Sequences
//!
//! `sequence_5d.h5` in the folder of a sequence has the same arrays with the frame as their first axis: `/H` is (f, v, u,
//! t, s, c), `/depth_m` (f, v, u, t, s), `/central/depth_m` (f, v, u). They are virtual datasets, which read
//! `frame_NNNN/scene_5d.h5` beside it. The coordinates of `/f` are the numbers of the frames. The attributes are those of the
//! first frame; of every frame are
//!
//! | what | axes | type |
//! |---|---|---|
//! | `/time_s`, `/focal_length_mm` | (f) | float64 |
//! | `/baseline_m` | (f, j) | float64, y before x: with the f-number of a lens that zooms, it changes |
//! | `/camera_position_m`, `/camera_rotation_rad` | (f, i) | float64: `center_cam` of `parameters.cfg`, in Blender's world |
//!
//! Everything that reads virtual datasets, which came with HDF5 1.10 in 2016, reads it as if it were one array.
//!
//! # Chunks
//!
//! Chunks of one elemental image make reading a view slow, and chunks of one view make reading an elemental image slow.
//! The default is a compromise: 4 x 4 microlenses, 10 x 10 views and all channels. Reading one elemental image then
//! inflates 16 times its size, reading one view 100 times. `cargo bench -p holo-bench --bench files --features hdf5 --
//! --chunks` measures alternatives. On 2 cores of an AMD EPYC, with 100 x 100 views of 79 x 53 px, float32, gzip level
//! 1:
//!
//! | lens rows, columns, view rows, columns | write, s | MB | one view, ms | one elemental image, ms |
//! |---|---|---|---|---|
//! | 1, 1, 100, 100: an elemental image | 3.7 | 266 | 1061 | 0.3 |
//! | 53, 79, 1, 1: a view | 4.2 | 420 | 0.8 | 1345 |
//! | 2, 2, 10, 10 | 4.3 | 354 | 32 | 1.6 |
//! | **4, 4, 10, 10** | 3.2 | 342 | 18 | 5 |
//! | 4, 4, 20, 20 | 3.1 | 317 | 52 | 4 |
//! | 8, 8, 10, 10 | 3.3 | 335 | 14 | 18 |
//!
//! h5py 3.16 reads `H[:, :, 50, 50]`, a view, of such a file of `holo render --sensor 8k --views 100 --write h5` in 19 ms,
//! `H[26, 40]`, an elemental image, in 6 ms, and `H[20]`, a row of them, in 134 ms (processor time, file in memory).
//!
//! The library deflates with zlib-ng, through the feature of `libz-sys`: twice as fast as zlib, for 6 % more bytes at
//! level 1. The bytes do not depend on the processor: the portable code of zlib-ng and that for AVX-512 give the same.
//!
//! # Safety
//!
//! Nothing outside of the file is read: external storage, external and symbolic links, virtual datasets and filters that
//! would have to be loaded are refused before the library asks for values. The virtual datasets of a sequence are read frame
//! by frame.
//!
//! The C library does not check all that it reads: a malicious file may crash the process. Shapes, types and chunks are
//! compared with the memory limit before samples are read, but not what the library allocates while it parses the
//! structure of the file. Read files from sources you trust only.

mod arrays;
mod attributes;
mod library;
mod old_hci;
mod options;
mod read;
mod rows;
mod scales;
mod sequence;
mod storage;
mod write;

use std::path::Path;

use holo_core::{LightField, Rig, Sample};
use ndarray::{ArrayView2, ArrayView4, Axis, Data, Slice};

use crate::files::folder::Destination;
use crate::{Error, FileDigest};

pub use arrays::Hdf5Arrays;
pub(crate) use library::{Failure, create, open, read_text};
pub(crate) use old_hci::{OldHciFile, is_old_hci};
pub use options::{Hdf5Map, Hdf5Options};
pub(crate) use read::check_chunk;
pub use read::{Hdf5LightField, is_light_field_hdf5};
pub(crate) use rows::{RowDataset, SampleRows};
pub use sequence::write_hdf5_sequence;
pub(crate) use storage::{check_values, find, members};
pub use write::Hdf5Writer;

/// The name of the format in messages.
const FORMAT: &str = "HDF5";

/// A sample type that the HDF5 library supports.
pub(crate) trait Number: Sample + ::hdf5::H5Type {}

impl Number for u8 {}
impl Number for u16 {}
impl Number for f32 {}
impl Number for f64 {}

/// Evaluates an expression with the type of a [`SampleKind`](holo_core::SampleKind).
macro_rules! with_sample_type {
    ($kind:expr, $type:ident => $body:expr) => {
        match $kind {
            holo_core::SampleKind::U8 => {
                type $type = u8;
                $body
            }
            holo_core::SampleKind::U16 => {
                type $type = u16;
                $body
            }
            holo_core::SampleKind::F32 => {
                type $type = f32;
                $body
            }
            holo_core::SampleKind::F64 => {
                type $type = f64;
                $body
            }
        }
    };
}
pub(crate) use with_sample_type;

/// Writes a light field, ground truth maps of all views, and ground truth maps of the central view.
///
/// Chunks and compression are those of `options`; [`Hdf5Writer`] writes light fields that do not fit into memory.
///
/// # Shape
///
/// Samples `(v, u, t, s, c)`; maps of all views `(v, u, t, s)`; maps of the central view `(v, u)`. Any strides; a few
/// lens rows are copied at a time.
///
/// # Errors
///
/// Those of [`Hdf5Writer`].
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightField, Rig, LightFieldShape};
/// use holo_io::{Hdf5LightField, Hdf5Map, Hdf5Options, Limits, write_hdf5};
/// use ndarray::{Array2, Array5};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scene_5d.h5");
/// let split = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5))?;
/// let rig = Rig::builder(split)
///     .focal_length_m(0.05)
///     .sensor_size_m(0.036)
///     .baseline_m(1e-3)
///     .focus_distance_m(2.0)
///     .build()?;
/// let light_field = LightField::new(Array5::<f32>::ones(split.array_shape(3)))?;
/// let depth_m = Array2::from_elem((4, 5), 2.5);
/// write_hdf5(&path, &light_field, &rig, &[], &[(Hdf5Map::Depth, depth_m.view())], &Hdf5Options::default())?;
/// let file = Hdf5LightField::open(&path, &Limits::default())?;
/// assert_eq!(file.rig(), Some(&rig));
/// assert_eq!(file.read_view(1, 2)?.dim(), (4, 5, 3));
/// assert_eq!(file.read_central_map(Hdf5Map::Depth)?, depth_m);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_hdf5<S>(
    path: impl Destination,
    light_field: &LightField<S>,
    rig: &Rig,
    maps: &[(Hdf5Map, ArrayView4<'_, f32>)],
    central: &[(Hdf5Map, ArrayView2<'_, f32>)],
    options: &Hdf5Options,
) -> Result<FileDigest, Error>
where
    S: Data,
    S::Elem: Sample,
{
    let names: Vec<Hdf5Map> = maps.iter().map(|&(name, _)| name).collect();
    crate::arrays::rig_values::check_split(path.path(), Some(rig), &light_field.shape())?;
    let mut writer =
        Hdf5Writer::<S::Elem>::create(&path as &dyn Destination, rig, light_field.channels(), &names, options)?;
    let samples = light_field.samples();
    for range in lens_rows(rig, writer.lens_rows_at_a_time()) {
        writer.write_lens_rows(samples.slice_axis(Axis(0), range))?;
        write_rows_of_maps(&mut writer, path.path(), rig, maps, range)?;
    }
    finish(writer, central)
}

/// Writes ground truth maps without a light field: the file of [`write_hdf5`] without `/H`. [`Hdf5LightField`] does not
/// open it; h5py and xarray do.
///
/// # Shape
///
/// As in [`write_hdf5`].
///
/// # Errors
///
/// Those of [`Hdf5Writer`].
pub fn write_hdf5_maps(
    path: impl Destination,
    rig: &Rig,
    maps: &[(Hdf5Map, ArrayView4<'_, f32>)],
    central: &[(Hdf5Map, ArrayView2<'_, f32>)],
    options: &Hdf5Options,
) -> Result<FileDigest, Error> {
    let names: Vec<Hdf5Map> = maps.iter().map(|&(name, _)| name).collect();
    let mut writer = Hdf5Writer::<f32>::start(&path, rig, None, &names, options)?;
    for range in lens_rows(rig, writer.lens_rows_at_a_time()) {
        write_rows_of_maps(&mut writer, path.path(), rig, maps, range)?;
    }
    finish(writer, central)
}

/// All lens rows in groups of `rows`.
fn lens_rows(rig: &Rig, rows: usize) -> impl Iterator<Item = Slice> {
    let count = rig.shape().lenses().rows;
    (0..count).step_by(rows).map(move |start| Slice::from(start..count.min(start + rows)))
}

fn write_rows_of_maps<T: Sample>(
    writer: &mut Hdf5Writer<T>,
    path: &Path,
    rig: &Rig,
    maps: &[(Hdf5Map, ArrayView4<'_, f32>)],
    range: Slice,
) -> Result<(), Error> {
    for (kind, map) in maps {
        if map.len_of(Axis(0)) != rig.shape().lenses().rows {
            return Err(Error::bad_input(path, format!("the map {} has shape {:?}", kind.name(), map.shape())));
        }
        writer.write_map_lens_rows(*kind, map.slice_axis(Axis(0), range))?;
    }
    Ok(())
}

fn finish<T: Sample>(
    mut writer: Hdf5Writer<T>,
    central: &[(Hdf5Map, ArrayView2<'_, f32>)],
) -> Result<FileDigest, Error> {
    for (kind, map) in central {
        writer.write_central_map(*kind, *map)?;
    }
    writer.finish()
}
