//! A light field in a folder.

use std::path::{Path, PathBuf};

use holo_core::{GridSize, Layout, LightFieldShape};

use super::archives::MitFolder;
use super::file;
use super::grid_of_names::grid_of_names;
use super::natural_order::list_images;
use super::options::ReadOptions;
use super::plenoptic;
use super::reader::{LightFieldFormat, LightFieldReader, encoding, parameters_path};
use super::source::Source;
use crate::files::folder::Folder;
use crate::files::names::{LIGHT_FIELD_HDF5, MANIFEST_JSON, PARAMETERS_CFG, is_regular};
use crate::images::image_file::read_image_info;
use crate::records::dataset::PlenopticFolder;
use crate::records::dataset::{DatasetFolder, Representation};
use crate::{Error, FileInfo, GantryFolder, HciFolder};

/// The name of the format in messages.
const FORMAT: &str = "dataset folder";

/// What a folder holds a light field in, of which one is read.
///
/// - A dataset folder: what its manifest lists, and what is there, of [`Representation::OF_DATASET`] in that order.
/// - A folder of a plenoptic camera: its raw image, `raw.exr` before `raw_linear.png`.
/// - Images of single views (of the HCI benchmark, the Stanford gantry, the MIT archive, or under any other names).
/// - Files of a dataset folder without a manifest. `scene_5d.h5`, `scene_5d.mat` and `hci/` state the number of views
///   themselves; arrays of elemental images or of views need `parameters.cfg`, or come after images of single views.
///
/// # Examples
///
/// ```
/// use holo_core::{GridSize, Layout, LightField, LightFieldShape};
/// use holo_io::dataset::Representation;
/// use holo_io::{ColorEncoding, Compression, LightFieldFolder, ReadOptions, write_png};
///
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path();
/// let shape = LightFieldShape::new(GridSize::new(3, 3), GridSize::new(4, 5))?;
/// let light_field = LightField::filled(shape, 3, Layout::ElementalGrid, 7_u8)?;
/// let image = light_field.to_elemental_grid()?;
/// write_png(path.join("scene_el.png"), image.view(), ColorEncoding::Srgb, Compression::Fast)?;
///
/// let found = LightFieldFolder::open(path)?;
/// assert_eq!(found.representations(), [Representation::ElementalPng]);
/// let reader = found.into_reader(&ReadOptions::default().views(GridSize::new(3, 3)))?;
/// assert_eq!(reader.read()?.light_field, light_field.into());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct LightFieldFolder {
    path: PathBuf,
    contents: Contents,
    representations: Vec<Representation>,
}

/// What else a folder is.
#[derive(Debug)]
enum Contents {
    Dataset(Box<DatasetFolder>),
    Plenoptic(Box<PlenopticFolder>),
    Hci(Box<HciFolder>),
    Gantry(Box<GantryFolder>),
    /// Images that are none of this project's, in natural order.
    Images(Vec<PathBuf>),
}

impl LightFieldFolder {
    /// Looks what a folder holds: reads its manifest and its parameters, and lists its files.
    ///
    /// # Errors
    ///
    /// Those of [`probe`](crate::probe); [`Error::NoLightField`] if the folder has other folders with light fields in it,
    /// or the path leads to a file. A folder without a light field is no error yet.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let (contents, representations) = match crate::probe(path)? {
            FileInfo::DatasetFolder(folder) => {
                let found = of_dataset(&folder);
                (Contents::Dataset(folder), found)
            }
            FileInfo::PlenopticFolder(folder) => {
                let found = folder.representations();
                (Contents::Plenoptic(folder), found)
            }
            FileInfo::HciFolder(folder) => (Contents::Hci(folder), beside_views(path)),
            FileInfo::GantryFolder(folder) => (Contents::Gantry(folder), beside_views(path)),
            FileInfo::UnknownFolder { .. } => {
                let images = list_images(path)?;
                let found = without_manifest(path, !images.is_empty());
                (Contents::Images(images), found)
            }
            cameras @ FileInfo::Cameras { .. } => {
                let what = format!("it is a {cameras}, which are no grid of views; of light fields name one");
                return Err(Error::NoLightField { path: path.to_owned(), what });
            }
            other => {
                let is_folder = matches!(other, FileInfo::Sequence(_) | FileInfo::Datasets(_));
                let what = if is_folder {
                    format!("it is a {other}; choose one of them")
                } else {
                    format!("no folder: {other}")
                };
                return Err(Error::NoLightField { path: path.to_owned(), what });
            }
        };
        Ok(Self { path: path.to_owned(), contents, representations })
    }

    /// Returns the path of the folder.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns what the folder holds the light field in, in the order of preference, with what this build cannot read.
    #[must_use]
    pub fn representations(&self) -> &[Representation] {
        &self.representations
    }

    /// Returns what is read: the first that this build can read.
    #[must_use]
    pub fn preferred(&self) -> Option<Representation> {
        self.representations.iter().copied().find(|found| missing_feature(*found).is_none())
    }

    /// Opens the preferred one. The reader has the rig and the maps of the folder.
    ///
    /// Of a dataset folder that has maps alone, the reader has these, and reading its samples is an error.
    ///
    /// # Errors
    ///
    /// As [`LightFieldReader::open`].
    pub fn into_reader(self, options: &ReadOptions) -> Result<LightFieldReader, Error> {
        let Some(preferred) = self.preferred() else { return self.into_reader_of_maps(options) };
        let Self { path, contents, representations } = self;
        let mut reader = match (contents, preferred) {
            (Contents::Dataset(folder), _) => open_dataset(folder, preferred, options)?,
            (Contents::Plenoptic(folder), _) => {
                plenoptic::open(&file_of(&path, preferred), folder.camera().clone(), options)?
            }
            (Contents::Hci(folder), Representation::Views) => open_hci(folder, options),
            (Contents::Gantry(folder), Representation::Views) => open_gantry(folder, options)?,
            (Contents::Images(files), Representation::Views) => open_images(&path, files, options)?,
            _ => open_own_file(&path, preferred, options)?,
        };
        reader.representation = Some(preferred);
        reader.representations = representations;
        Ok(reader)
    }

    /// The dataset folder that this folder is.
    pub(super) fn dataset(&self) -> Option<&DatasetFolder> {
        match &self.contents {
            Contents::Dataset(folder) => Some(folder.as_ref()),
            _ => None,
        }
    }

    /// The reader of a folder without samples that this build can read.
    fn into_reader_of_maps(self, options: &ReadOptions) -> Result<LightFieldReader, Error> {
        let error = self.nothing();
        let Contents::Dataset(folder) = self.contents else { return Err(error) };
        let (format, source) = (LightFieldFormat::DatasetFolder, Source::Nothing(Box::new(error)));
        let reader = LightFieldReader::new(&self.path, options, format, folder.shape(), source);
        let mut reader = in_dataset(reader, folder);
        reader.representations = self.representations;
        Ok(reader)
    }

    /// Why there is nothing to read.
    fn nothing(&self) -> Error {
        let unreadable = self.representations.first().and_then(|found| Some((found, missing_feature(*found)?)));
        if let Some((found, feature)) = unreadable {
            return file::needs_feature(&self.path, feature, &format!("the light field, which is in {found}"));
        }
        let names =
            |all: &[Representation]| all.iter().filter_map(|found| found.file_name()).collect::<Vec<_>>().join(", ");
        let what = match self.contents {
            Contents::Dataset(_) => {
                let names = names(&Representation::OF_DATASET);
                format!("there is no raw image: {MANIFEST_JSON} lists none of {names} with all views")
            }
            Contents::Plenoptic(_) => {
                format!("it is of a plenoptic camera, but has none of {}", names(&Representation::OF_PLENOPTIC))
            }
            _ => "it is a folder of no known kind and has no PNG or TIFF image of a view".to_owned(),
        };
        Error::NoLightField { path: self.path.clone(), what }
    }
}

/// The feature that this build lacks for reading one.
fn missing_feature(representation: Representation) -> Option<&'static str> {
    match representation {
        Representation::Hdf5 if !cfg!(feature = "hdf5") => Some("hdf5"),
        _ => None,
    }
}

fn file_of(folder: &Path, representation: Representation) -> PathBuf {
    folder.join(representation.file_name().unwrap_or_default())
}

fn is_there(folder: &Path, representation: Representation) -> bool {
    let path = file_of(folder, representation);
    match representation {
        Representation::Hci => {
            let is_folder = path.symlink_metadata().is_ok_and(|found| found.is_dir());
            is_folder && is_regular(&path.join(PARAMETERS_CFG)) && HciFolder::has_views(&path).unwrap_or(false)
        }
        _ => is_regular(&path),
    }
}

/// What a manifest lists and is there.
fn of_dataset(folder: &DatasetFolder) -> Vec<Representation> {
    let listed = folder.representations();
    let mut found: Vec<_> = listed.iter().copied().filter(|found| is_there(folder.path(), *found)).collect();
    if found.is_empty() {
        // The error of reading names the first that is missing.
        return listed;
    }
    if found.first() == Some(&Representation::Hdf5) && !has_samples(&folder.path().join(LIGHT_FIELD_HDF5)) {
        found.remove(0);
    }
    found
}

/// Whether a file has samples beside maps. A damaged file has the error of its reader.
#[cfg(feature = "hdf5")]
fn has_samples(path: &Path) -> bool {
    crate::is_light_field_hdf5(path).unwrap_or(true)
}

#[cfg(not(feature = "hdf5"))]
fn has_samples(_: &Path) -> bool {
    true
}

/// The files of this project in a folder without a manifest.
fn own_files(path: &Path) -> Vec<Representation> {
    Representation::OF_DATASET.into_iter().filter(|found| is_there(path, *found)).collect()
}

fn beside_views(path: &Path) -> Vec<Representation> {
    [vec![Representation::Views], own_files(path)].concat()
}

fn without_manifest(path: &Path, has_views: bool) -> Vec<Representation> {
    let has_parameters = is_regular(&path.join(PARAMETERS_CFG));
    let is_described = |found: &Representation| has_parameters || found.layout().is_none();
    let (described, others): (Vec<_>, Vec<_>) = own_files(path).into_iter().partition(is_described);
    described.into_iter().chain(has_views.then_some(Representation::Views)).chain(others).collect()
}

fn open_dataset(
    folder: Box<DatasetFolder>,
    representation: Representation,
    options: &ReadOptions,
) -> Result<LightFieldReader, Error> {
    let (root, name) = (Folder::open(folder.path())?, representation.file_name().unwrap_or_default());
    let path = match representation {
        Representation::Hci => root.sub(name)?.path().to_owned(),
        _ => root.regular_path(name)?,
    };
    let reader = match (representation, representation.layout()) {
        (_, Some(layout)) => open_grid(&folder, &path, layout, options)?,
        (Representation::Hdf5, _) => file::of_hdf5(&path, options)?,
        (Representation::Mat, _) => file::of_mat(&path, options)?,
        _ => open_hci(Box::new(HciFolder::open(&path)?), options),
    };
    if reader.shape != folder.shape() {
        let words = |shape: LightFieldShape| format!("{} views of {} pixels", shape.views(), shape.lenses());
        let what = format!("it has {}, but the rig of the folder has {}", words(reader.shape), words(folder.shape()));
        return Err(Error::broken(&path, FORMAT, what));
    }
    Ok(in_dataset(reader, folder))
}

/// A raw image of the size that the rig of a dataset folder states.
fn open_grid(
    folder: &DatasetFolder,
    path: &Path,
    layout: Layout,
    options: &ReadOptions,
) -> Result<LightFieldReader, Error> {
    let (shape, info) = (folder.shape(), read_image_info(path)?);
    folder.check_size(path, info.size, shape.raw_size())?;
    let source = Source::RawImage { file: path.to_owned(), layout };
    let mut reader = LightFieldReader::new(path, options, LightFieldFormat::RawImage, shape, source);
    reader.layout = Some(layout);
    reader.color_encoding = encoding(info.kind.is_float());
    Ok(reader)
}

/// The reader of a file of a dataset folder, with the rig and the maps of the folder.
fn in_dataset(mut reader: LightFieldReader, folder: Box<DatasetFolder>) -> LightFieldReader {
    reader.format = LightFieldFormat::DatasetFolder;
    reader.rig = Some(*folder.rig());
    let range = folder.parameters().and_then(|parameters| parameters.disp_min.zip(parameters.disp_max));
    reader.disparity_range_px = range.or(folder.manifest().disparity_px);
    reader.dataset = Some(folder);
    reader
}

/// A file of this project in a folder without a manifest.
fn open_own_file(
    folder: &Path,
    representation: Representation,
    options: &ReadOptions,
) -> Result<LightFieldReader, Error> {
    let path = file_of(folder, representation);
    let mut reader = match representation {
        Representation::Hci => open_hci(Box::new(HciFolder::open(&path)?), options),
        _ => file::open(&path, options)?,
    };
    reader.format = LightFieldFormat::DatasetFolder;
    Ok(reader)
}

fn open_hci(folder: Box<HciFolder>, options: &ReadOptions) -> LightFieldReader {
    let (path, parameters, shape) = (folder.path().to_owned(), folder.parameters().clone(), folder.shape());
    LightFieldReader::new(&path, options, LightFieldFormat::HciFolder, shape, Source::Hci(folder))
        .complete(&parameters, &parameters_path(&path))
}

fn open_gantry(folder: Box<GantryFolder>, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let path = folder.path().to_owned();
    let shape = LightFieldShape::new(folder.views(), read_image_info(folder.file(0, 0))?.size)
        .map_err(|error| Error::core(&path, error))?;
    Ok(LightFieldReader::new(&path, options, LightFieldFormat::GantryFolder, shape, Source::Gantry(folder)))
}

/// One image a view, in natural order.
fn open_images(path: &Path, files: Vec<PathBuf>, options: &ReadOptions) -> Result<LightFieldReader, Error> {
    let missing = |what| Error::MissingOption { path: path.to_owned(), option: "views", what };
    let Some(first) = files.first() else { return Err(missing("it has no images".to_owned())) };
    let info = read_image_info(first)?;
    let shape = |views| LightFieldShape::new(views, info.size).map_err(|error| Error::core(path, error));
    if let Some(mit) = MitFolder::of(path).filter(|mit| mit.has(&files)) {
        let shape = shape(mit.views)?;
        let mut reader = LightFieldReader::new(path, options, LightFieldFormat::MitFolder, shape, Source::Mit(files));
        reader.rig = mit.rig(shape);
        return Ok(reader);
    }
    let (views, files, note) = match (options.views, grid_of_names(&files)) {
        (Some(views), _) => (views, files, None),
        (None, Some((grid, files))) => {
            let views = if options.order.is_by_columns() { GridSize::new(grid.columns, grid.rows) } else { grid };
            let what = format!(
                "{}: its {} images are taken for {views} views in the order {}, by their names; choose `views` and \
                 `order` if they are others",
                path.display(),
                files.len(),
                options.order.name()
            );
            (views, files, Some(what))
        }
        (None, None) => return Err(missing(format!("it does not specify the grid of its {} views", files.len()))),
    };
    if files.len() != views.count() {
        return Err(missing(format!("it has {} images, but {views} views need {}", files.len(), views.count())));
    }
    let source = Source::Images { files, order: options.order };
    let mut reader = LightFieldReader::new(path, options, LightFieldFormat::ImageFolder, shape(views)?, source);
    reader.color_encoding = encoding(info.kind.is_float());
    reader.warnings.extend(note);
    Ok(reader.complete_from(&parameters_path(path)))
}
