//! What is this? A file or folder of any kind, told by its contents.

use std::fmt;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use holo_core::GridSize;

use crate::dataset::{self, DatasetEntry, DatasetFolder, MANIFEST_JSON, PARAMETERS_CFG};
use crate::{
    Error, FileKind, GantryFolder, HciFolder, Manifest, ParametersCfg, PfmInfo, PngInfo, read_pfm_info, read_png_info,
    recognise,
};

/// How many bytes of an unknown file are shown.
const SHOWN_BYTES: u64 = 16;

/// What a path leads to. Prints as one line.
///
/// Headers, parameters and lists of files have been read; pixels have not.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum FileInfo {
    /// A PNG image.
    Png(PngInfo),
    /// A PFM float image.
    Pfm(PfmInfo),
    /// An OpenEXR image.
    Exr {
        /// Rows and columns.
        size: GridSize,
        /// The names of its channels.
        channels: Vec<String>,
    },
    /// A Radiance HDR image.
    Hdr {
        /// Rows and columns.
        size: GridSize,
    },
    /// Camera parameters.
    ParametersCfg(Box<ParametersCfg>),
    /// The manifest of a dataset folder.
    Manifest(Box<Manifest>),
    /// A file of another kind that [`recognise`] knows, such as a glTF scene, into which nothing was read.
    Other(FileKind),
    /// A file of no known kind.
    Unknown {
        /// Its first bytes, 16 at most.
        first_bytes: Vec<u8>,
        /// Its size.
        bytes: u64,
    },
    /// A folder that `holo render` wrote.
    DatasetFolder(Box<DatasetFolder>),
    /// A folder with datasets in `<scene>/<S>x<T>/`.
    Datasets(Vec<DatasetEntry>),
    /// A folder with the layout of the HCI benchmark.
    HciFolder(Box<HciFolder>),
    /// A folder of the Stanford Lego gantry.
    GantryFolder(Box<GantryFolder>),
    /// A folder of no known kind.
    UnknownFolder {
        /// How many files and folders are in it.
        entries: usize,
    },
}

/// Tells what a file or a folder is from its contents, and reads what describes it.
///
/// A folder is, in this order: a dataset if it has a `manifest.json`; an HCI folder if it has a `parameters.cfg` and a
/// view `input_Cam*.png`; a gantry folder if it has a view `out_ROW_COLUMN_Y_X.png`; a folder of datasets if it has some.
///
/// # Errors
///
/// [`Error::Io`] if the path cannot be read. A file or folder that is recognised but damaged or incomplete gives the
/// error of its own reader, such as [`HciFolder::open`], and not [`FileInfo::Unknown`].
///
/// # Examples
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("picture");
/// let image = ndarray::Array3::<u8>::zeros((2, 3, 3));
/// holo_io::write_png(&path, image.view(), holo_io::ColorEncoding::Srgb, holo_io::Compression::Fast)?;
/// assert_eq!(holo_io::open(&path)?.to_string(), "PNG image, 3 x 2 pixels, 3 channels of 8 bits");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn open(path: impl AsRef<Path>) -> Result<FileInfo, Error> {
    let path = path.as_ref();
    let metadata = fs::metadata(path).map_err(|source| Error::io("read", path, source))?;
    if metadata.is_dir() { open_folder(path) } else { open_file(path, metadata.len()) }
}

fn open_file(path: &Path, bytes: u64) -> Result<FileInfo, Error> {
    Ok(match recognise(path)? {
        FileKind::Png => FileInfo::Png(read_png_info(path)?),
        FileKind::Pfm => FileInfo::Pfm(read_pfm_info(path)?),
        #[cfg(feature = "exr")]
        FileKind::Exr => {
            let info = crate::read_exr_info(path)?;
            FileInfo::Exr { size: info.size, channels: info.channels }
        }
        #[cfg(feature = "hdr")]
        FileKind::Hdr => FileInfo::Hdr { size: crate::read_hdr_info(path)?.size },
        FileKind::ParametersCfg => FileInfo::ParametersCfg(Box::new(ParametersCfg::read(path)?)),
        FileKind::Manifest => FileInfo::Manifest(Box::new(Manifest::read(path)?)),
        FileKind::Unknown => {
            let failed = |source| Error::io("read", path, source);
            let mut first_bytes = Vec::new();
            File::open(path).map_err(failed)?.take(SHOWN_BYTES).read_to_end(&mut first_bytes).map_err(failed)?;
            FileInfo::Unknown { first_bytes, bytes }
        }
        other => FileInfo::Other(other),
    })
}

fn open_folder(path: &Path) -> Result<FileInfo, Error> {
    let is = |name: &str, kind| {
        let file = path.join(name);
        Ok::<_, Error>(file.is_file() && recognise(&file)? == kind)
    };
    if is(MANIFEST_JSON, FileKind::Manifest)? {
        return Ok(FileInfo::DatasetFolder(Box::new(DatasetFolder::open(path)?)));
    }
    if is(PARAMETERS_CFG, FileKind::ParametersCfg)? && HciFolder::has_views(path)? {
        return Ok(FileInfo::HciFolder(Box::new(HciFolder::open(path)?)));
    }
    if GantryFolder::has_views(path)? {
        return Ok(FileInfo::GantryFolder(Box::new(GantryFolder::open(path)?)));
    }
    let datasets = dataset::list(path)?;
    if !datasets.is_empty() {
        return Ok(FileInfo::Datasets(datasets));
    }
    let entries = fs::read_dir(path).map_err(|source| Error::io("list", path, source))?;
    Ok(FileInfo::UnknownFolder { entries: entries.count() })
}

impl fmt::Display for FileInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Png(info) => {
                let (PngInfo { size, channels, bits }, s) = (info, plural(info.channels));
                write!(f, "PNG image, {}, {channels} channel{s} of {bits} bits", pixels(*size))
            }
            Self::Pfm(info) => {
                let kind = if info.channels == 1 { "grey" } else { "colour" };
                write!(f, "PFM float image, {}, {kind}", pixels(info.size))
            }
            Self::Exr { size, channels } => {
                write!(f, "OpenEXR image, {}, {} channel{}", pixels(*size), channels.len(), plural(channels.len()))
            }
            Self::Hdr { size } => write!(f, "Radiance HDR image, {}", pixels(*size)),
            Self::ParametersCfg(parameters) => {
                write!(f, "camera parameters of {}", grid(parameters.num_cams, parameters.image_resolution_px))
            }
            Self::Manifest(manifest) => {
                write!(f, "manifest of {} file{}", manifest.files.len(), plural(manifest.files.len()))
            }
            Self::Other(kind) => write!(f, "{}", name_of(*kind)),
            Self::Unknown { first_bytes, .. } if first_bytes.is_empty() => write!(f, "empty file"),
            Self::Unknown { first_bytes, bytes } => {
                write!(f, "unknown file of {bytes} bytes that begins with")?;
                first_bytes.iter().try_for_each(|byte| write!(f, " {byte:02x}"))?;
                write!(f, " ({})", first_bytes.escape_ascii())
            }
            Self::DatasetFolder(folder) => {
                let shape = folder.shape();
                let no_picture = if folder.raw_image().is_none() { ", no picture" } else { "" };
                write!(f, "dataset folder, {}{no_picture}", grid(shape.views(), shape.lenses()))
            }
            Self::Datasets(datasets) => write!(f, "folder of {} dataset{}", datasets.len(), plural(datasets.len())),
            Self::HciFolder(folder) => {
                let shape = folder.shape();
                write!(f, "HCI folder, {}", grid(shape.views(), shape.lenses()))
            }
            Self::GantryFolder(folder) => {
                let views = folder.views();
                write!(f, "Stanford gantry folder, {} x {} views", views.columns, views.rows)
            }
            Self::UnknownFolder { entries } => {
                let y = if *entries == 1 { "y" } else { "ies" };
                write!(f, "folder of no known kind, {entries} entr{y}")
            }
        }
    }
}

/// What a kind of file is called.
fn name_of(kind: FileKind) -> String {
    match kind {
        FileKind::GltfBinary => "glTF scene, binary (.glb)".to_owned(),
        FileKind::GltfJson => "glTF scene, JSON (.gltf)".to_owned(),
        other => format!("{other:?} file"),
    }
}

fn pixels(size: GridSize) -> String {
    format!("{} x {} pixels", size.columns, size.rows)
}

fn grid(views: GridSize, lenses: GridSize) -> String {
    format!("{} x {} views of {}", views.columns, views.rows, pixels(lenses))
}

/// The ending of a word for this many things.
fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}
