//! `manifest.json`: the settings of a render, and the digest of every file in its folder.

mod json;
mod value;
mod verify;

use std::collections::BTreeMap;
use std::path::Path;

use holo_core::Rig;

use crate::error::STREAM;
use crate::files::folder::{Destination, Folder, read_beside};
use crate::files::names::MANIFEST_JSON;
use crate::{Error, FileDigest, write_file};

pub use value::ManifestValue;
pub use verify::{Mismatch, MismatchKind};

/// The value of the key `format`.
pub(crate) const FORMAT: &str = "holo manifest 2";

/// The formats that are read: 1 is that of versions 0.1 and 0.2, whose settings are the texts of a command line.
pub(crate) const FORMATS: [&str; 2] = ["holo manifest 1", FORMAT];

/// Maximum size of a manifest in bytes: enough for the digests of some 100,000 files.
const MAX_BYTES: u64 = 16 << 20;

/// The settings of a render and the digests of its files.
///
/// It contains no time and no path outside its folder, and its keys are always in the same order, so equal inputs give
/// equal bytes. In JSON a size is `{"columns": .., "rows": ..}`, and a number that is not finite is the text `"inf"`,
/// `"-inf"` or `"nan"`.
///
/// # Examples
///
/// ```
/// use holo_io::{Manifest, ManifestValue, write_file};
///
/// # let folder = tempfile::tempdir()?;
/// let written = write_file(folder.path().join("scene_el.png"), b"pixels")?;
/// let mut manifest = Manifest { seed: 7, exposure_ev: Some(-0.5), ..Manifest::default() };
/// manifest.versions.insert("holo".into(), "0.1.0".into());
/// manifest.settings.insert("integrator".into(), ManifestValue::from("path"));
/// manifest.files.insert("scene_el.png".into(), written);
/// manifest.write(folder.path().join("manifest.json"))?;
///
/// let read = Manifest::read(folder.path().join("manifest.json"))?;
/// assert_eq!(read, manifest);
/// assert!(read.verify(folder.path()).is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Manifest {
    /// Versions of `holo` and of the ray tracing backend that made the files.
    pub versions: BTreeMap<String, String>,
    /// The libraries that were loaded to make the files, by the names of their files: not part of what identifies an image.
    pub libraries: BTreeMap<String, FileDigest>,
    /// Random seed.
    pub seed: u64,
    /// The other settings, by their names on the command line.
    pub settings: BTreeMap<String, ManifestValue>,
    /// The rig. The JSON contains it in millimeters and meters, as its keys state.
    pub rig: Option<Rig>,
    /// Smallest and largest finite disparity of the central view in pixels between adjacent views: black and white in
    /// `scene_disparity.png`.
    pub disparity_px: Option<(f64, f64)>,
    /// Exposure compensation of the 8- and 16-bit images in EV.
    pub exposure_ev: Option<f64>,
    /// The files by their names relative to the folder, with `/` between folders.
    pub files: BTreeMap<String, FileDigest>,
}

impl Manifest {
    /// Returns the manifest as JSON, ending in a line feed.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if a file name leads outside the folder.
    pub fn to_json(&self) -> Result<String, Error> {
        json::write(self, Path::new(STREAM))
    }

    /// Reads a manifest from JSON. Unknown keys are ignored.
    ///
    /// # Errors
    ///
    /// [`Error::Broken`] if it is not JSON, a value has the wrong type or a file name leads outside the folder;
    /// [`Error::Unsupported`] if it is a manifest of another version.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        json::read(text.as_bytes(), Path::new(STREAM))
    }

    /// Writes the manifest to a file, usually `manifest.json`.
    ///
    /// # Errors
    ///
    /// Those of [`Manifest::to_json`], and [`Error::Io`] if the file cannot be written.
    pub fn write(&self, path: impl Destination) -> Result<FileDigest, Error> {
        let text = json::write(self, path.path())?;
        write_file(path, text.as_bytes())
    }

    /// Reads a manifest from a file.
    ///
    /// # Errors
    ///
    /// Those of [`Manifest::from_json`]; [`Error::Io`] if the file cannot be read, or is a link, a pipe or a device;
    /// [`Error::TooLarge`] if it has more than 16 MiB.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        json::read(&read_beside(path, MAX_BYTES)?, path)
    }

    /// Reads `manifest.json` of an open folder.
    ///
    /// # Errors
    ///
    /// Those of [`Manifest::read`].
    pub fn read_in(folder: &Folder) -> Result<Self, Error> {
        json::read(&folder.read(MANIFEST_JSON, MAX_BYTES)?, &folder.path_of(MANIFEST_JSON))
    }

    /// Reads every listed file in parallel and returns those that differ from the manifest, in the order of their
    /// names.
    ///
    /// Files that the manifest does not list are ignored. Links in the folder are not followed.
    #[must_use]
    pub fn verify(&self, folder: impl AsRef<Path>) -> Vec<Mismatch> {
        match Folder::open(folder) {
            Ok(folder) => self.verify_in(&folder),
            Err(error) => verify::missing(self, &error),
        }
    }

    /// The same for an open folder.
    #[must_use]
    pub fn verify_in(&self, folder: &Folder) -> Vec<Mismatch> {
        verify::verify(self, folder)
    }
}
