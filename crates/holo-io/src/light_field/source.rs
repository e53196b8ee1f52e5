//! The sources of samples, by format.

use std::path::{Path, PathBuf};

use holo_core::{ColorEncoding, DynLightField, LightFieldShape, Rig};
use ndarray::Array2;

use super::{LightFieldFormat, LightFieldReader, ReadOptions, parameters_path};
use crate::{Error, FileFormat, Limits, ParametersCfg, detect_format};

#[cfg(feature = "hdf5")]
use crate::{
    Hdf5LightField, Hdf5Map,
    hdf5::{OldHciFile, is_old_hci},
};
#[cfg(feature = "png")]
use {
    super::archives::{self, MitFolder},
    super::{list_images, sizes},
    crate::dataset::DatasetFolder,
    crate::views::read_views,
    crate::{
        FileInfo, GantryFolder, HciFolder, HciQuantity, HciResolution,
        image_file::{read_image, read_image_info},
        layout_of_file_name,
    },
    holo_core::{GridSize, Layout, ViewOrder},
};

/// A ground truth map of the central view.
#[derive(Debug, Clone, Copy)]
pub(super) enum Map {
    Depth,
    Disparity,
}

/// The open folder or file that samples are read from.
#[derive(Debug)]
pub(super) enum Source {
    #[cfg(feature = "png")]
    Dataset(Box<DatasetFolder>),
    #[cfg(feature = "png")]
    Hci(Box<HciFolder>),
    #[cfg(feature = "png")]
    Gantry(Box<GantryFolder>),
    /// One file a view, in natural order.
    #[cfg(feature = "png")]
    Images { files: Vec<PathBuf>, order: ViewOrder },
    /// The same, of which the rows are counted from below.
    #[cfg(feature = "png")]
    Mit(Vec<PathBuf>),
    #[cfg(feature = "png")]
    RawImage { file: PathBuf, layout: Layout },
    #[cfg(feature = "png")]
    Eslf(PathBuf),
    #[cfg(feature = "mat")]
    Mat,
    #[cfg(feature = "hdf5")]
    Hdf5(Box<Hdf5LightField>),
    #[cfg(feature = "hdf5")]
    OldHci(Box<OldHciFile>),
}

impl Source {
    pub(super) fn raw_image(&self) -> Option<PathBuf> {
        match self {
            #[cfg(feature = "png")]
            Self::Dataset(folder) => folder.raw_image().map(|(file, _)| file),
            #[cfg(feature = "png")]
            Self::RawImage { file, .. } => Some(file.clone()),
            #[allow(unreachable_patterns, reason = "with one feature alone there is no other variant")]
            _ => None,
        }
    }

    #[allow(unused_variables, reason = "with one feature alone some are unused")]
    pub(super) fn central_map(&self, map: Map, limits: &Limits) -> Result<Option<Array2<f32>>, Error> {
        match (self, map) {
            #[cfg(feature = "png")]
            (Self::Dataset(folder), Map::Depth) => folder.depth_m(limits),
            #[cfg(feature = "png")]
            (Self::Dataset(folder), Map::Disparity) => folder.disparity_px(limits),
            #[cfg(feature = "png")]
            (Self::Hci(folder), Map::Depth) => folder.central_truth(HciQuantity::Depth, HciResolution::Low, limits),
            #[cfg(feature = "png")]
            (Self::Hci(folder), Map::Disparity) => {
                folder.central_truth(HciQuantity::Disparity, HciResolution::Low, limits)
            }
            #[cfg(feature = "hdf5")]
            (Self::Hdf5(file), map) => {
                let map = hdf5_map(map);
                let (all, central) = file.maps();
                let exists = all.contains(&map) || central.contains(&map);
                exists.then(|| file.read_central_map(map)).transpose()
            }
            #[cfg(feature = "hdf5")]
            (Self::OldHci(file), map) => file.central_map(hdf5_map(map)),
            #[allow(unreachable_patterns, reason = "with one feature alone there is no other variant")]
            _ => Ok(None),
        }
    }

    #[allow(unused_variables, reason = "with one feature alone some are unused")]
    pub(super) fn read(self, path: &Path, shape: LightFieldShape, limits: &Limits) -> Result<DynLightField, Error> {
        match self {
            #[cfg(feature = "png")]
            Self::Dataset(folder) => folder.read(limits),
            #[cfg(feature = "png")]
            Self::Hci(folder) => folder.read(limits),
            #[cfg(feature = "png")]
            Self::Gantry(folder) => {
                let (first, last) = (folder.position(0, 0), folder.position(0, folder.views().columns - 1));
                let falls = first.zip(last).is_some_and(|(first, last)| first.x > last.x);
                archives::reversed(folder.read(limits)?, true, falls).map_err(|error| Error::core(path, error))
            }
            #[cfg(feature = "png")]
            Self::Mit(files) => {
                let field = read_views(&files, shape.views(), ViewOrder::RowMajor, limits)?;
                archives::reversed(field, true, false).map_err(|error| Error::core(path, error))
            }
            #[cfg(feature = "png")]
            Self::Eslf(file) => {
                archives::eslf(read_image(&file, limits)?, shape).map_err(|error| Error::core(path, error))
            }
            #[cfg(feature = "png")]
            Self::Images { files, order } => read_views(&files, shape.views(), order, limits),
            #[cfg(feature = "png")]
            Self::RawImage { file, layout } => DynLightField::from_grid(read_image(&file, limits)?, layout, shape)
                .map_err(|error| Error::core(path, error)),
            #[cfg(feature = "mat")]
            Self::Mat => Ok(crate::read_mat_light_field(path, limits)?.light_field),
            #[cfg(feature = "hdf5")]
            Self::Hdf5(file) => file.read(),
            #[cfg(feature = "hdf5")]
            Self::OldHci(file) => file.read(),
        }
    }
}

#[cfg(feature = "hdf5")]
fn hdf5_map(map: Map) -> Hdf5Map {
    match map {
        Map::Depth => Hdf5Map::Depth,
        Map::Disparity => Hdf5Map::Disparity,
    }
}

/// A reader of `source` without rig, layout and disparity range.
fn reader(
    path: &Path,
    options: &ReadOptions,
    format: LightFieldFormat,
    shape: LightFieldShape,
    source: Source,
) -> LightFieldReader {
    LightFieldReader {
        path: path.to_owned(),
        source,
        format,
        shape,
        layout: None,
        rig: None,
        color_encoding: ColorEncoding::Srgb,
        disparity_range_px: None,
        warnings: Vec::new(),
        limits: options.limits,
    }
}

/// Opens a folder or file that contains a light field.
pub(super) fn open(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    if path.is_dir() {
        return open_folder(path, options);
    }
    match detect_format(path)? {
        FileFormat::Png | FileFormat::Tiff => open_raw_image(path, options),
        FileFormat::Mat5 | FileFormat::Mat73 => open_mat(path, options),
        FileFormat::Hdf5 => open_hdf5(path, options),
        _ => Err(Error::NoLightField {
            path: path.to_owned(),
            what: "it is neither a PNG, TIFF, MAT or HDF5 file nor a folder of a known kind".to_owned(),
        }),
    }
}

#[cfg(feature = "png")]
fn open_folder(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let parameters_path = parameters_path(path);
    Ok(match crate::probe(path)? {
        FileInfo::DatasetFolder(folder) => {
            let parameters = folder.parameters().cloned();
            let (rig, range) = (*folder.rig(), folder.manifest().disparity_px);
            let layout = folder.raw_image().map(|(_, layout)| layout);
            let mut reader =
                reader(path, options, LightFieldFormat::DatasetFolder, folder.shape(), Source::Dataset(folder));
            (reader.rig, reader.layout) = (Some(rig), layout);
            if let Some(parameters) = parameters {
                reader = reader.complete(&parameters, &parameters_path);
            }
            reader.disparity_range_px = reader.disparity_range_px.or(range);
            reader
        }
        FileInfo::HciFolder(folder) => {
            let parameters = folder.parameters().clone();
            reader(path, options, LightFieldFormat::HciFolder, folder.shape(), Source::Hci(folder))
                .complete(&parameters, &parameters_path)
        }
        FileInfo::GantryFolder(folder) => {
            let shape = shape_of_views(path, folder.views(), folder.file(0, 0))?;
            reader(path, options, LightFieldFormat::GantryFolder, shape, Source::Gantry(folder))
        }
        FileInfo::UnknownFolder { .. } => return open_images(path, options),
        other => {
            return Err(Error::NoLightField {
                path: path.to_owned(),
                what: format!("it is a {other}; choose one of them"),
            });
        }
    })
}

#[cfg(not(feature = "png"))]
fn open_folder(path: &Path, _: &ReadOptions) -> Result<LightFieldReader, Error> {
    Err(needs_feature(path, "png", "a folder"))
}

#[cfg(feature = "png")]
fn open_images(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let files = list_images(path)?;
    let Some(first) = files.first() else {
        let what = "it is a folder of no known kind and has no PNG or TIFF image".to_owned();
        return Err(Error::NoLightField { path: path.to_owned(), what });
    };
    let missing = |what| Error::MissingOption { path: path.to_owned(), option: "views", what };
    if let Some(mit) = MitFolder::of(path).filter(|mit| mit.has(&files)) {
        let shape = shape_of_views(path, mit.views, first)?;
        let rig = mit.rig(shape);
        let mut reader = reader(path, options, LightFieldFormat::MitFolder, shape, Source::Mit(files));
        reader.rig = rig;
        return Ok(reader);
    }
    let views =
        options.views.ok_or_else(|| missing(format!("it does not specify the grid of its {} views", files.len())))?;
    if files.len() != views.count() {
        return Err(missing(format!("it has {} images, but {views} views need {}", files.len(), views.count())));
    }
    let shape = shape_of_views(path, views, first)?;
    let is_float = read_image_info(first)?.kind.is_float();
    let source = Source::Images { files, order: options.order };
    let mut reader = reader(path, options, LightFieldFormat::ImageFolder, shape, source);
    reader.color_encoding = encoding(is_float);
    Ok(reader.complete_from(&parameters_path(path)))
}

/// The shape of a light field whose views have the size of `file`.
#[cfg(feature = "png")]
fn shape_of_views(path: &Path, views: GridSize, file: &Path) -> Result<LightFieldShape, Error> {
    LightFieldShape::new(views, read_image_info(file)?.size).map_err(|error| Error::core(path, error))
}

#[cfg(feature = "png")]
fn open_raw_image(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let missing = |option, what| Error::MissingOption { path: path.to_owned(), option, what };
    if options.layout.is_none() && archives::is_eslf(path) {
        return open_eslf(path, options);
    }
    let layout = options.layout.or_else(|| layout_of_file_name(path)).ok_or_else(|| {
        let what = "its name (_el, _vpi) does not specify whether it is an array of elemental images or of views";
        missing("layout", what.to_owned())
    })?;
    let parameters_path = parameters_path(path);
    // Without the option the sidecar must be right; with it, it may belong to another image.
    let (views, parameters) = match options.views {
        Some(views) => (views, None),
        None => match ParametersCfg::read(&parameters_path) {
            Ok(parameters) => (parameters.num_cams, Some(parameters)),
            Err(error) => {
                let what = format!("{} does not specify the number of views: {error}", parameters_path.display());
                return Err(missing("views", what));
            }
        },
    };
    let info = read_image_info(path)?;
    let size = info.size;
    if views.count() == 0 || size.rows % views.rows != 0 || size.columns % views.columns != 0 {
        return Err(missing("views", format!("{size} pixels do not divide into {views} views")));
    }
    let lenses = GridSize::new(size.rows / views.rows, size.columns / views.columns);
    let shape = LightFieldShape::new(views, lenses).map_err(|error| Error::core(path, error))?;
    let source = Source::RawImage { file: path.to_owned(), layout };
    let mut reader = reader(path, options, LightFieldFormat::RawImage, shape, source);
    reader.layout = Some(layout);
    reader.color_encoding = encoding(info.kind.is_float());
    let Some(parameters) = parameters else { return Ok(reader.complete_from(&parameters_path)) };
    if (parameters.num_cams, parameters.image_resolution_px) != sizes(shape) {
        let what = format!(
            "its {size} pixels are not the {views} views of {} px that {} contains, which may belong to another image",
            parameters.image_resolution_px,
            parameters_path.display()
        );
        return Err(missing("views", what));
    }
    Ok(reader.complete(&parameters, &parameters_path))
}

#[cfg(feature = "png")]
fn open_eslf(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let views = options.views.unwrap_or(GridSize::new(archives::ESLF_VIEWS, archives::ESLF_VIEWS));
    let shape = archives::eslf_shape(read_image_info(path)?.size, views).map_err(|error| Error::core(path, error))?;
    let mut reader = reader(path, options, LightFieldFormat::Eslf, shape, Source::Eslf(path.to_owned()));
    (reader.layout, reader.color_encoding) = (Some(Layout::ElementalGrid), ColorEncoding::Linear);
    Ok(reader.complete_from(&parameters_path(path)))
}

#[cfg(not(feature = "png"))]
fn open_raw_image(path: &Path, _: &ReadOptions) -> Result<LightFieldReader, Error> {
    Err(needs_feature(path, "png", "a PNG image"))
}

#[cfg(feature = "mat")]
fn open_mat(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let header = crate::mat::read_light_field_header(path, &options.limits)?;
    let mut reader = reader(path, options, LightFieldFormat::Mat, header.shape, Source::Mat);
    reader.color_encoding = encoding(header.is_float);
    reader.rig = header.rig;
    reader.warnings.extend(header.rig_error.map(|error| Error::core(path, error).to_string()));
    Ok(reader.complete_from(&parameters_path(path)))
}

#[cfg(not(feature = "mat"))]
fn open_mat(path: &Path, _: &ReadOptions) -> Result<LightFieldReader, Error> {
    Err(needs_feature(path, "mat", "a MAT file"))
}

#[cfg(feature = "hdf5")]
fn open_hdf5(path: &Path, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    if is_old_hci(path)? {
        let file = OldHciFile::open(path, &options.limits)?;
        let rig = file.rig();
        let mut reader = reader(path, options, LightFieldFormat::OldHci, file.shape(), Source::OldHci(Box::new(file)));
        reader.rig = rig;
        return Ok(reader);
    }
    let file = Hdf5LightField::open(path, &options.limits)?;
    let (rig, error) = (file.rig().copied(), file.rig_error().map(|error| format!("{}: {error}", path.display())));
    let is_float = file.sample_kind().is_float();
    let mut reader = reader(path, options, LightFieldFormat::Hdf5, file.shape(), Source::Hdf5(Box::new(file)));
    reader.color_encoding = encoding(is_float);
    reader.rig = rig;
    reader.warnings.extend(error);
    Ok(reader.complete_from(&parameters_path(path)))
}

#[cfg(not(feature = "hdf5"))]
fn open_hdf5(path: &Path, _: &ReadOptions) -> Result<LightFieldReader, Error> {
    Err(needs_feature(path, "hdf5", "an HDF5 file"))
}

fn encoding(is_float: bool) -> ColorEncoding {
    if is_float { ColorEncoding::Linear } else { ColorEncoding::Srgb }
}

#[cfg(not(all(feature = "png", feature = "mat", feature = "hdf5")))]
fn needs_feature(path: &Path, feature: &str, what: &str) -> Error {
    Error::unsupported(path, format!("this build does not have the feature `{feature}` and cannot read {what}"))
}

/// The rig of a path; see [`read_rig`](super::read_rig).
pub(super) fn rig_of(path: &Path, limits: &Limits) -> Result<Option<Rig>, Error> {
    let options = ReadOptions::default().limits(*limits);
    let own = if path.is_dir() {
        match open_folder(path, &options) {
            Ok(reader) => reader.rig,
            Err(Error::NoLightField { .. } | Error::MissingOption { .. }) => None,
            Err(error) => return Err(error),
        }
    } else {
        match detect_format(path)? {
            FileFormat::Manifest => return Ok(crate::Manifest::read(path)?.rig),
            FileFormat::Mat5 | FileFormat::Mat73 => open_mat(path, &options)?.rig,
            FileFormat::Hdf5 => open_hdf5(path, &options)?.rig,
            _ => None,
        }
    };
    let parameters_path = match is_parameters_cfg(path)? {
        true => path.to_owned(),
        false => parameters_path(path),
    };
    if own.is_some() || !parameters_path.is_file() {
        return Ok(own);
    }
    let parameters = ParametersCfg::read(&parameters_path)?;
    parameters.rig().map(Some).map_err(|error| error.about(&parameters_path))
}

fn is_parameters_cfg(path: &Path) -> Result<bool, Error> {
    Ok(!path.is_dir() && detect_format(path)? == FileFormat::ParametersCfg)
}
