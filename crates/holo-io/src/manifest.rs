//! `manifest.json`: what a dataset folder was made with, and the digest of every file in it.

mod json;
mod setting;
mod verify;

use std::collections::BTreeMap;
use std::path::Path;

use holo_core::Rig;

use crate::error::MEMORY;
use crate::limits::read_small_file;
use crate::{Error, FileDigest, write_file};

pub use setting::Setting;
pub use verify::{Mismatch, MismatchKind};

/// The value of the key `format`, by which the file is known.
pub(crate) const FORMAT: &str = "holo manifest 1";

/// What the value begins with in any version.
pub(crate) const FORMAT_FAMILY: &str = "holo manifest ";

/// A whole manifest is at most this long: room for the digests of some 100,000 files, and little enough that no crafted
/// one fills the memory.
const MAX_BYTES: u64 = 16 << 20;

/// What a dataset folder was made with.
///
/// It holds no time and no path outside its folder, and its keys always come in the same order, so equal inputs give
/// equal bytes. In JSON a size is `{"columns": .., "rows": ..}`, and a number that is not finite is the text `"inf"`,
/// `"-inf"` or `"nan"`.
///
/// # Examples
///
/// ```
/// use holo_io::{Manifest, Setting, write_file};
///
/// # let folder = tempfile::tempdir()?;
/// let written = write_file(folder.path().join("scene_el.png"), b"pixels")?;
/// let mut manifest = Manifest { seed: 7, exposure_ev: Some(-0.5), ..Manifest::default() };
/// manifest.versions.insert("holo".into(), "0.1.0".into());
/// manifest.settings.insert("integrator".into(), Setting::from("path"));
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
    /// What made the files: `holo` and its engines, each with its version.
    pub versions: BTreeMap<String, String>,
    /// The seed of all random numbers.
    pub seed: u64,
    /// Every other setting, by its name on the command line.
    pub settings: BTreeMap<String, Setting>,
    /// The views, the lenses and the cameras, in the units of the files.
    pub rig: Option<Rig>,
    /// The smallest and largest finite disparity of the central view, which are black and white in
    /// `scene_disparity.png`.
    pub disparity_px: Option<(f64, f64)>,
    /// The exposure of the 8- and 16-bit images, in steps of a factor of two.
    pub exposure_ev: Option<f64>,
    /// The files by their name relative to the folder, with `/` between folders.
    pub files: BTreeMap<String, FileDigest>,
}

impl Manifest {
    /// Returns the manifest as JSON, ending in a line feed.
    ///
    /// # Errors
    ///
    /// [`Error::BadInput`] if a file name is not one inside the folder.
    pub fn to_json(&self) -> Result<String, Error> {
        json::write(self, Path::new(MEMORY))
    }

    /// Reads a manifest from JSON. Keys that this version does not know are passed over.
    ///
    /// # Errors
    ///
    /// [`Error::Broken`] if it is not JSON, a value has the wrong type or a file name leads outside the folder;
    /// [`Error::Unsupported`] if it is a manifest of another version.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        json::read(text.as_bytes(), Path::new(MEMORY))
    }

    /// Writes the manifest to a file, usually `manifest.json`.
    ///
    /// # Errors
    ///
    /// Those of [`Manifest::to_json`], and [`Error::Io`] if the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<FileDigest, Error> {
        let path = path.as_ref();
        write_file(path, json::write(self, path)?.as_bytes())
    }

    /// Reads a manifest from a file.
    ///
    /// # Errors
    ///
    /// Those of [`Manifest::from_json`]; [`Error::Io`] if the file cannot be read; [`Error::TooLarge`] if it has more
    /// than 16 MiB.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        json::read(&read_small_file(path, MAX_BYTES)?, path)
    }

    /// Reads every listed file and returns what is wrong, in the order of their names; nothing if all is well.
    ///
    /// Files that the manifest does not list are not looked at.
    #[must_use]
    pub fn verify(&self, folder: impl AsRef<Path>) -> Vec<Mismatch> {
        verify::verify(self, folder.as_ref())
    }
}
