//! What a path leads to: the format of a file or folder, from its contents, and its headers.

use std::fmt;
use std::fs::{self, File};
use std::io::Read;
use std::path::Path;

use holo_core::GridSize;

use crate::error::in_words;
use crate::files::names::{TRANSFORMS_JSON, is_regular};
use crate::records::dataset::PlenopticFolder;
use crate::records::dataset::{self, DatasetEntry, DatasetFolder, MANIFEST_JSON, PARAMETERS_CFG, SequenceFolder};
use crate::{
    CameraArray, DngInfo, Error, FileFormat, Folder, GantryFolder, HciFolder, Manifest, ParametersCfg, PfmInfo,
    PngInfo, WorldUp, files::detect_format, read_dng_info, read_pfm_info, read_png_info,
};

/// Number of bytes of an unknown file that are shown.
const SHOWN_BYTES: u64 = 16;

/// The format and the headers of a file or folder, without its pixels. Its [`Display`](fmt::Display) is one line.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum FileInfo {
    /// A PNG image.
    Png(PngInfo),
    /// A TIFF image.
    Tiff(crate::TiffInfo),
    /// The codes of an image sensor as DNG.
    Dng(DngInfo),
    /// A PFM float image.
    Pfm(PfmInfo),
    /// An OpenEXR image.
    Exr {
        /// Rows and columns of the display window.
        size: GridSize,
        /// Full names of its channels.
        channels: Vec<String>,
    },
    /// A Radiance HDR image.
    Hdr {
        /// Rows and columns of the upright image.
        size: GridSize,
    },
    /// Camera parameters.
    ParametersCfg(Box<ParametersCfg>),
    /// The manifest of a dataset folder.
    Manifest(Box<Manifest>),
    /// A file of another format that [`detect_format`] finds, such as a glTF scene; nothing of it was read.
    Other(FileFormat),
    /// A file of an unknown format.
    Unknown {
        /// Its first bytes, at most 16.
        first_bytes: Vec<u8>,
        /// Its size in bytes.
        bytes: u64,
    },
    /// A folder that `holo render` wrote.
    DatasetFolder(Box<DatasetFolder>),
    /// A folder of a plenoptic camera.
    PlenopticFolder(Box<PlenopticFolder>),
    /// A folder with the images of cameras anywhere, or with a light field at each of their poses: see `ArrayFolder`.
    Cameras {
        /// Their number.
        count: usize,
        /// The manifest of the folder; light fields have their own.
        manifest: Option<Box<Manifest>>,
    },
    /// A folder with the frames of a sequence in it.
    Sequence(SequenceFolder),
    /// A folder with dataset folders `<scene>/<S>x<T>/` or `<scene>/<camera>/` in it.
    Datasets(Vec<DatasetEntry>),
    /// A folder with the layout of the HCI benchmark.
    HciFolder(Box<HciFolder>),
    /// A folder of the Stanford Lego gantry.
    GantryFolder(Box<GantryFolder>),
    /// A folder of an unknown kind.
    UnknownFolder {
        /// Number of files and folders in it.
        entries: usize,
    },
}

/// Detects the format of a file or folder from its contents, and reads its headers, parameters and list of files.
///
/// A folder is the first that applies of: a folder of a plenoptic camera if its `manifest.json` lists a `camera.toml` and
/// has no rig; one of cameras anywhere if it lists a `transforms.json` and has no rig; a dataset folder if it has a `manifest.json`; an HCI folder if it has a `parameters.cfg` and a view
/// `input_Cam*.png`; a gantry folder if it has a view `out_ROW_COLUMN_Y_X.png`; a folder of a plenoptic camera if it has a
/// `camera.toml` and a `raw.exr` or `raw_linear.png`; a sequence if it has frames `frame_NNNN/` in it; a folder of datasets
/// if it has dataset folders in it.
///
/// # Errors
///
/// [`Error::Io`] if the path cannot be read. A file or folder of a known format that is damaged or incomplete gives the
/// error of its reader, such as [`HciFolder::open`], and not [`FileInfo::Unknown`].
///
/// # Examples
///
/// ```
/// # let folder = tempfile::tempdir()?;
/// let path = folder.path().join("image");
/// let image = ndarray::Array3::<u8>::zeros((2, 3, 3));
/// holo_io::write_png(&path, image.view(), holo_io::ColorEncoding::Srgb, holo_io::Compression::Fast)?;
/// assert_eq!(holo_io::probe(&path)?.to_string(), "PNG image, 3 x 2 pixels, 3 channels of 8 bits");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn probe(path: impl AsRef<Path>) -> Result<FileInfo, Error> {
    let path = path.as_ref();
    let metadata = fs::metadata(path).map_err(|source| Error::io("read", path, source))?;
    if metadata.is_dir() { probe_folder(path) } else { probe_file(path, metadata.len()) }
}

fn probe_file(path: &Path, bytes: u64) -> Result<FileInfo, Error> {
    Ok(match detect_format(path)? {
        FileFormat::Png => FileInfo::Png(read_png_info(path)?),
        FileFormat::Tiff => FileInfo::Tiff(crate::read_tiff_info(path)?),
        FileFormat::Dng => FileInfo::Dng(read_dng_info(path)?),
        FileFormat::Pfm => FileInfo::Pfm(read_pfm_info(path)?),
        FileFormat::Exr => {
            let info = crate::read_exr_info(path)?;
            FileInfo::Exr { size: info.size, channels: info.channels }
        }
        FileFormat::Hdr => FileInfo::Hdr { size: crate::read_hdr_info(path)?.size },
        FileFormat::ParametersCfg => FileInfo::ParametersCfg(Box::new(ParametersCfg::read(path)?)),
        FileFormat::Manifest => FileInfo::Manifest(Box::new(Manifest::read(path)?)),
        FileFormat::Unknown => {
            let failed = |source| Error::io("read", path, source);
            let mut first_bytes = Vec::new();
            File::open(path).map_err(failed)?.take(SHOWN_BYTES).read_to_end(&mut first_bytes).map_err(failed)?;
            FileInfo::Unknown { first_bytes, bytes }
        }
        other => FileInfo::Other(other),
    })
}

/// How many cameras a folder has, which does not depend on the axis that points up.
fn cameras_of(path: &Path) -> Result<usize, Error> {
    Ok(CameraArray::read_in(&Folder::open(path)?, TRANSFORMS_JSON, WorldUp::default(), None)?.cameras.len())
}

fn probe_folder(path: &Path) -> Result<FileInfo, Error> {
    let is = |name: &str, format| {
        let file = path.join(name);
        Ok::<_, Error>(is_regular(&file) && detect_format(&file)? == format)
    };
    if is(MANIFEST_JSON, FileFormat::Manifest)? {
        let manifest = Manifest::read(path.join(MANIFEST_JSON))?;
        if PlenopticFolder::is_described_by(&manifest) {
            return Ok(FileInfo::PlenopticFolder(Box::new(PlenopticFolder::with_manifest(path, Some(manifest))?)));
        }
        if manifest.rig.is_none() && manifest.files.contains_key(TRANSFORMS_JSON) {
            return Ok(FileInfo::Cameras { count: cameras_of(path)?, manifest: Some(Box::new(manifest)) });
        }
        return Ok(FileInfo::DatasetFolder(Box::new(DatasetFolder::with_manifest(path, manifest)?)));
    }
    if is_regular(&path.join(TRANSFORMS_JSON)) {
        return Ok(FileInfo::Cameras { count: cameras_of(path)?, manifest: None });
    }
    if is(PARAMETERS_CFG, FileFormat::ParametersCfg)? && HciFolder::has_views(path)? {
        return Ok(FileInfo::HciFolder(Box::new(HciFolder::open(path)?)));
    }
    if GantryFolder::has_views(path)? {
        return Ok(FileInfo::GantryFolder(Box::new(GantryFolder::open(path)?)));
    }
    if PlenopticFolder::has_files(path) {
        return Ok(FileInfo::PlenopticFolder(Box::new(PlenopticFolder::with_manifest(path, None)?)));
    }
    let sequence = SequenceFolder::open(path)?;
    if !sequence.frames().is_empty() {
        return Ok(FileInfo::Sequence(sequence));
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
                let (PngInfo { size, channels, bits, .. }, s) = (info, plural(info.channels));
                write!(f, "PNG image, {}, {channels} channel{s} of {bits} bits", pixels(*size))
            }
            Self::Tiff(info) => {
                let (crate::TiffInfo { size, channels, kind }, s) = (info, plural(info.channels));
                write!(f, "TIFF image, {}, {channels} channel{s} of {}", pixels(*size), kind.name())
            }
            Self::Dng(info) => {
                write!(f, "DNG raw image, {}, {} bits", pixels(info.size), info.bits)?;
                info.white.map_or(Ok(()), |white| write!(f, ", largest code {white}"))?;
                match &info.filter {
                    Some(filter) => write!(f, ", color filter {filter}"),
                    None => write!(f, ", no color filter of 2 x 2 pixels"),
                }
            }
            Self::Pfm(info) => {
                let kind = if info.channels == 1 { "gray" } else { "color" };
                write!(f, "PFM float image, {}, {kind}", pixels(info.size))
            }
            Self::Exr { size, channels } => {
                write!(f, "OpenEXR image, {}, {} channel{}", pixels(*size), channels.len(), plural(channels.len()))
            }
            Self::Hdr { size } => write!(f, "Radiance HDR image, {}", pixels(*size)),
            Self::ParametersCfg(parameters) => {
                write!(f, "camera parameters of {}", in_words((parameters.num_cams, parameters.image_resolution_px)))
            }
            Self::Manifest(manifest) => {
                write!(f, "manifest of {} file{}", manifest.files.len(), plural(manifest.files.len()))
            }
            Self::Other(format) => write!(f, "{}", name_of(*format)),
            Self::Unknown { first_bytes, .. } if first_bytes.is_empty() => write!(f, "empty file"),
            Self::Unknown { first_bytes, bytes } => {
                write!(f, "unknown file of {bytes} bytes that begins with")?;
                first_bytes.iter().try_for_each(|byte| write!(f, " {byte:02x}"))?;
                write!(f, " ({})", first_bytes.escape_ascii())
            }
            Self::DatasetFolder(folder) => {
                let shape = folder.shape();
                let nothing = if folder.representations().is_empty() { ", no light field" } else { "" };
                write!(f, "dataset folder, {}{nothing}", in_words((shape.views(), shape.lenses())))
            }
            Self::PlenopticFolder(folder) => {
                let camera = folder.camera();
                let (size, count) = (camera.camera.sensor().size, camera.camera.lens_count());
                let nothing = if folder.representations().is_empty() { ", no raw image" } else { "" };
                write!(
                    f,
                    "folder of the plenoptic camera '{}', {}, {count} micro-image{}{nothing}",
                    crate::shown(&camera.name),
                    pixels(size),
                    plural(count)
                )
            }
            Self::Cameras { count, manifest } => write!(f, "{}", cameras_in_words(*count, manifest.is_some())),
            Self::Sequence(sequence) => {
                let frames = sequence.frames();
                write!(f, "sequence of {} frame{}", frames.len(), plural(frames.len()))
            }
            Self::Datasets(datasets) => write!(f, "folder of {} dataset{}", datasets.len(), plural(datasets.len())),
            Self::HciFolder(folder) => {
                let shape = folder.shape();
                write!(f, "HCI folder, {}", in_words((shape.views(), shape.lenses())))
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

/// Cameras with images of their own, whose folder has a manifest, or whatever stands at poses.
fn cameras_in_words(count: usize, has_manifest: bool) -> String {
    let s = plural(count);
    if has_manifest {
        format!("folder with the images of {count} camera{s} anywhere")
    } else {
        format!("folder of {count} camera{s} or light field{s} at poses")
    }
}

/// The name of a format in messages.
fn name_of(format: FileFormat) -> String {
    match format {
        FileFormat::GltfBinary => "glTF scene, binary (.glb)".to_owned(),
        FileFormat::GltfJson => "glTF scene, JSON (.gltf)".to_owned(),
        FileFormat::Sgi => "SGI image (.rgb)".to_owned(),
        FileFormat::LightPack => "light field of LightPack (.lid)".to_owned(),
        FileFormat::Lytro => "container of a Lytro camera; `holo decode` reads its raw image".to_owned(),
        other => format!("{other:?} file"),
    }
}

fn pixels(size: GridSize) -> String {
    format!("{} x {} pixels", size.columns, size.rows)
}

/// The plural `s` of a word after this count.
fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}
