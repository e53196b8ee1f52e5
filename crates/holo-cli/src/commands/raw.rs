//! Light fields from files and folders of every kind, in the type of their file.

use std::path::Path;

use holo_core::{DynLightField, GridSize, Layout, LightField, LightFieldOwned, LightFieldShape};
use holo_io::{FileInfo, FileKind, Limits, ParametersCfg, dataset};

use super::picture::Picture;
use crate::arguments::{InputOptions, LayoutArgument};
use crate::failure::Failure;

/// A light field in the type of its file.
pub enum Raw {
    U8(LightFieldOwned<u8>),
    U16(LightFieldOwned<u16>),
    Float(LightFieldOwned<f32>),
}

impl Raw {
    /// Views and lenses.
    pub fn shape(&self) -> LightFieldShape {
        match self {
            Self::U8(field) => field.shape(),
            Self::U16(field) => field.shape(),
            Self::Float(field) => field.shape(),
        }
    }
}

/// Calls a method of whichever light field it is, and makes a [`Picture`] of the result.
macro_rules! picture {
    ($raw:expr, $field:ident => $cut:expr) => {
        Ok(match $raw {
            Raw::U8($field) => Picture::U8($cut?),
            Raw::U16($field) => Picture::U16($cut?),
            Raw::Float($field) => Picture::Float($cut?),
        })
    };
}

/// Pieces, borrowed.
impl Raw {
    pub fn view(&self, t: usize, s: usize) -> Result<Picture<'_>, Failure> {
        picture!(self, field => field.view(t, s))
    }

    pub fn elemental(&self, v: usize, u: usize) -> Result<Picture<'_>, Failure> {
        picture!(self, field => field.elemental_image(v, u))
    }

    pub fn epi_row(&self, v: usize, t: usize) -> Result<Picture<'_>, Failure> {
        picture!(self, field => field.epi_row(v, t))
    }

    pub fn epi_column(&self, u: usize, s: usize) -> Result<Picture<'_>, Failure> {
        picture!(self, field => field.epi_column(u, s))
    }
}

impl TryFrom<DynLightField> for Raw {
    type Error = Failure;

    fn try_from(field: DynLightField) -> Result<Self, Failure> {
        Ok(match field {
            DynLightField::U8(field) => Self::U8(field),
            DynLightField::U16(field) => Self::U16(field),
            DynLightField::F32(field) => Self::Float(field),
            DynLightField::F64(field) => Self::Float(LightField::new(field.samples().mapv(|x| x as f32))?),
        })
    }
}

/// Reads what the command line names.
pub fn read_input(input: &InputOptions) -> Result<(Raw, Option<Layout>), Failure> {
    read(&input.input, input.from, input.views)
}

/// Reads a raw PNG, a `.mat`, an `.h5`, or a folder: a dataset's, one of HCI's layout, a gantry's. Also tells which grid it
/// is, if it is one.
pub fn read(
    path: &Path,
    from: Option<LayoutArgument>,
    views: Option<GridSize>,
) -> Result<(Raw, Option<Layout>), Failure> {
    let limits = Limits::default();
    let (raw, layout) = if path.is_dir() {
        read_folder(path, &limits)?
    } else {
        match holo_io::recognise(path)? {
            FileKind::Mat5 | FileKind::Mat73 => {
                (holo_io::read_mat_light_field(path, &limits)?.light_field.try_into()?, None)
            }
            FileKind::Hdf5 => (read_hdf5(path, &limits)?, None),
            _ => return read_png(path, from, views).map(|(raw, layout)| (raw, Some(layout))),
        }
    };
    if let Some(views) = views.filter(|views| *views != raw.shape().views()) {
        let own = raw.shape().views();
        return Err(Failure::Usage(format!(
            "{} has {} x {} views, not the {} x {} of --views",
            path.display(),
            own.columns,
            own.rows,
            views.columns,
            views.rows
        )));
    }
    Ok((raw, layout))
}

fn read_folder(path: &Path, limits: &Limits) -> Result<(Raw, Option<Layout>), Failure> {
    Ok(match holo_io::open(path)? {
        FileInfo::DatasetFolder(folder) => {
            let layout = folder.raw_image().map(|(_, layout)| layout);
            (folder.read(limits)?.try_into()?, layout)
        }
        FileInfo::HciFolder(folder) => (folder.read(limits)?.try_into()?, None),
        FileInfo::GantryFolder(folder) => (folder.read(limits)?.try_into()?, None),
        other => return Err(Failure::Usage(format!("{} holds no light field: {other}", path.display()))),
    })
}

#[cfg(feature = "hdf5")]
fn read_hdf5(path: &Path, limits: &Limits) -> Result<Raw, Failure> {
    holo_io::Hdf5LightField::open(path, limits)?.read()?.try_into()
}

#[cfg(not(feature = "hdf5"))]
fn read_hdf5(_: &Path, _: &Limits) -> Result<Raw, Failure> {
    Err(Failure::Usage(
        "this build of holo has no HDF5; `cargo xtask build` makes one that has, or cargo build --features hdf5".into(),
    ))
}

fn read_png(path: &Path, from: Option<LayoutArgument>, views: Option<GridSize>) -> Result<(Raw, Layout), Failure> {
    let (layout, split) = describe_png(path, from, views)?;
    let samples = holo_io::read_png(path, &Limits::default())?;
    Ok((DynLightField::from_grid(samples, layout, split)?.try_into()?, layout))
}

/// Tells which grid a raw PNG is, and of how many views and lenses, from its header.
///
/// Its layout comes from `from` or the file's name, its views from `views` or the `parameters.cfg` beside it.
pub fn describe_png(
    path: &Path,
    from: Option<LayoutArgument>,
    views: Option<GridSize>,
) -> Result<(Layout, LightFieldShape), Failure> {
    let layout = from.map(layout).or_else(|| holo_io::layout_of_file_name(path)).ok_or_else(|| {
        Failure::Usage(format!("{}: neither --from nor the name (_el, _vpi) says which grid this is", path.display()))
    })?;
    // Given views are believed; parameters must fit the image, or they are those of another one.
    let (views, lenses) = match views {
        Some(views) => (views, None),
        None => {
            let beside = path.with_file_name(dataset::PARAMETERS_CFG);
            let missing = |why: &dyn std::fmt::Display| {
                Failure::Usage(format!("how many views? give --views; {} does not tell: {why}", beside.display()))
            };
            let parameters = ParametersCfg::read(&beside).map_err(|e| missing(&e))?;
            (parameters.num_cams, Some(parameters.image_resolution_px))
        }
    };
    let GridSize { rows, columns } = holo_io::read_png_info(path)?.size;
    if views.rows == 0 || views.columns == 0 || rows % views.rows != 0 || columns % views.columns != 0 {
        return Err(Failure::Usage(format!(
            "{}: {columns} x {rows} pixels do not divide into {} x {} views",
            path.display(),
            views.columns,
            views.rows
        )));
    }
    let split = LightFieldShape::new(views, GridSize::new(rows / views.rows, columns / views.columns))?;
    if let Some(lenses) = lenses.filter(|lenses| *lenses != split.lenses()) {
        return Err(Failure::Usage(format!(
            "{}: {columns} x {rows} pixels are not the {} x {} views of {} x {} px that the {} beside it speaks of; if it \
             belongs to another image, give --views",
            path.display(),
            views.columns,
            views.rows,
            lenses.columns,
            lenses.rows,
            dataset::PARAMETERS_CFG
        )));
    }
    Ok((layout, split))
}

/// The layout that a word of the command line means.
pub fn layout(argument: LayoutArgument) -> Layout {
    match argument {
        LayoutArgument::El => Layout::ElementalGrid,
        LayoutArgument::Vpi => Layout::ViewpointGrid,
    }
}
