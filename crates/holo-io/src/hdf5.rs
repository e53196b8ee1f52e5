//! HDF5: the light field with its ground truth, in pieces that can be read alone.
//!
//! Through `hdf5-metno`, with the C library built in. Light fields are written lens row by lens row, so that one that does
//! not fit the memory can be written, and a view or a lens is read without the rest.
//!
//! # Layout
//!
//! | what | axes | type |
//! |---|---|---|
//! | `/H` | (v, u, t, s, c) | linear float32; uint8, uint16 and float64 are written and read as well |
//! | `/depth_m`, `/ray_length_m`, `/disparity_px` | (v, u, t, s) | float32, of all views |
//! | `/central/depth_m`, `/central/ray_length_m`, `/central/disparity_px` | (v, u) | float32, of the central view |
//!
//! Attributes of the file: `format`, `axes` (`vutsc`), `views` = \[T S\], `lenses` = \[V U\], and of the rig `baseline_m` =
//! \[y x\], `focal_length_mm`, `sensor_size_mm`, `focus_distance_m`, `projection`. Every dataset has `axes` and `units`, and
//! labels its dimensions the way of HDF5's dimension scales (`dims[0].label` in h5py). Compression is shuffle and gzip, the
//! filters that every reader has.
//!
//! # Chunks
//!
//! A file is read by lens and by view, and each wants other neighbours side by side. A chunk of 4 x 4 lenses, 10 x 10 views
//! and all channels lies between: one lens inflates 16 times what it returns, one view 100 times. Measured with 100 x 100
//! views of 79 x 53 px, float32, gzip 1, on 2 cores of an AMD EPYC (`cargo bench -p holo-bench --bench files --features hdf5
//! -- --chunks` makes such a table):
//!
//! | lens rows, columns, view rows, columns | write, s | MB | one view, ms | one lens, ms |
//! |---|---|---|---|---|
//! | 1, 1, 100, 100: an elemental image | 3.7 | 266 | 1061 | 0.3 |
//! | 53, 79, 1, 1: a view | 4.2 | 420 | 0.8 | 1345 |
//! | 2, 2, 10, 10 | 4.3 | 354 | 32 | 1.6 |
//! | **4, 4, 10, 10** | 3.2 | 342 | 18 | 5 |
//! | 4, 4, 20, 20 | 3.1 | 317 | 52 | 4 |
//! | 8, 8, 10, 10 | 3.3 | 335 | 14 | 18 |
//!
//! The library deflates with zlib-ng, through the feature of `libz-sys`: 3.1 s where h5py with zlib takes 7.0 s, for 6 % more
//! bytes at level 1 (342 MB against 322 MB). Its bytes do not depend on the processor: its plain code and that for AVX-512 gave
//! the same for 189 streams at levels 1 to 9.
//!
//! # What is not safe here
//!
//! The C library checks much of what it reads, but not all: a file made to do harm may end the process inside it. Before
//! the library allocates for this crate, shapes, types and chunks are compared with the budget; what happens while it parses
//! the file's structure is in its hands. Read only files that come from somebody you trust.

mod attributes;
mod library;
mod options;
mod read;
mod write;

use std::path::Path;

use holo_core::{LightField, Rig, Sample};
use ndarray::{ArrayView2, ArrayView4, Axis, Data, Slice};

use crate::{Error, FileDigest};

#[cfg(feature = "mat")]
pub(crate) use library::{Failure, create, open, read_text};
pub use options::{Hdf5Map, Hdf5Options};
#[cfg(feature = "mat")]
pub(crate) use read::check_chunk;
pub use read::{Hdf5LightField, is_light_field_hdf5};
pub use write::Hdf5Writer;

/// The format's name in messages.
const FORMAT: &str = "HDF5";

/// A sample as the HDF5 library knows it.
pub(crate) trait Number: Sample + ::hdf5::H5Type {}

impl Number for u8 {}
impl Number for u16 {}
impl Number for f32 {}
impl Number for f64 {}

/// Writes a light field that is in memory, the ground truth of all views, and that of the central view.
///
/// # Shape
///
/// Samples `(v, u, t, s, c)`; maps of all views `(v, u, t, s)`; maps of the central view `(v, u)`. Any strides; a few lens
/// rows are copied at a time.
///
/// # Errors
///
/// Those of [`Hdf5Writer`].
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, LightField, LightFieldShape, Rig};
/// use holo_io::{Hdf5LightField, Hdf5Map, Hdf5Options, Limits, write_hdf5};
/// use ndarray::{Array2, Array5};
///
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("scene_5d.h5");
/// let shape = LightFieldShape::new(GridSize::new(2, 3), GridSize::new(4, 5))?;
/// let rig = Rig::builder(shape).focal_length_m(0.05).sensor_size_m(0.036).baseline_m(1e-3).focus_distance_m(2.0).build()?;
/// let light_field = LightField::new(Array5::<f32>::ones(shape.array_shape(3)))?;
/// let depth_m = Array2::from_elem((4, 5), 2.5);
/// write_hdf5(&path, &light_field, &rig, &[], &[(Hdf5Map::Depth, depth_m.view())], &Hdf5Options::default())?;
/// let file = Hdf5LightField::open(&path, &Limits::default())?;
/// assert_eq!(file.rig(), Some(&rig));
/// assert_eq!(file.read_view(1, 2)?.dim(), (4, 5, 3));
/// assert_eq!(file.read_central_map(Hdf5Map::Depth)?, depth_m);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_hdf5<S>(
    path: impl AsRef<Path>,
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
    let path = path.as_ref();
    let kinds: Vec<Hdf5Map> = maps.iter().map(|&(kind, _)| kind).collect();
    crate::rig_values::check_split(path, Some(rig), &light_field.shape())?;
    let mut writer = Hdf5Writer::<S::Elem>::create(path, rig, light_field.channels(), &kinds, options)?;
    let rows = writer.lens_rows_at_a_time();
    let samples = light_field.samples();
    for start in (0..rig.shape().lenses().rows).step_by(rows) {
        let range = Slice::from(start..rig.shape().lenses().rows.min(start + rows));
        writer.write_lens_rows(samples.slice_axis(Axis(0), range))?;
        for (kind, map) in maps {
            if map.len_of(Axis(0)) != rig.shape().lenses().rows {
                return Err(Error::bad_input(path, format!("the map {} has shape {:?}", kind.name(), map.shape())));
            }
            writer.write_map_lens_rows(*kind, map.slice_axis(Axis(0), range))?;
        }
    }
    for (kind, map) in central {
        writer.write_central_map(*kind, *map)?;
    }
    writer.finish()
}
