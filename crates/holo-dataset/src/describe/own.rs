//! Which files in the root of a dataset are the dataset's own.
//!
//! The root may be any folder: one that came from a stranger, or the one where a user keeps lists of other things. So
//! neither a name nor an index found there gives the right to replace or remove a file: only its contents do, which say
//! that it is what this module wrote.
//!
//! | file | is the dataset's own if |
//! |---|---|
//! | `dataset.json` | it is an index |
//! | `DATASET.md` | it begins with the title of one |
//! | `transforms.json` | the index has poses, and it is in every byte as they are written |
//! | `croissant.json` | it is a description with the name that all of them have |
//! | `light_fields.csv` | it begins with the first names of the table |
//! | `train.txt`, `test.txt` | every line is a folder of the index |
//! | `contact_sheet_<camera>.png` | it has the size of that of this camera and as many scenes |

use std::collections::BTreeSet;
use std::io::BufReader;

use holo_io::dataset::{DATASET_JSON, DATASET_MD, DatasetCamera, DatasetIndex};
use holo_io::{EntryKind, Folder};
use serde_json::Value;

use super::catalog::{contact_sheet, croissant, record};
use crate::Error;
use crate::output::{TRANSFORMS, poses};

/// The description in the vocabulary of Croissant.
pub(crate) const CROISSANT_JSON: &str = "croissant.json";

/// The records as a table.
pub(crate) const LIGHT_FIELDS_CSV: &str = "light_fields.csv";

/// The folders for training, and those for tests.
pub(super) const SPLITS: [&str; 2] = ["train.txt", "test.txt"];

/// The title of every `DATASET.md`.
pub(super) const TITLE: &str = "# A dataset of raw holoscopic images";

/// The largest size of a file of text that is read to find out whose it is.
const MAX_BYTES: u64 = 1 << 30;

/// The files of a root.
pub(super) struct Own<'a> {
    root: &'a Folder,
    /// The index that lies there, if there is one.
    index: Option<DatasetIndex>,
}

impl<'a> Own<'a> {
    pub fn new(root: &'a Folder) -> Self {
        Self { root, index: DatasetIndex::read_in(root).ok() }
    }

    /// Whether the index that lies there is this one.
    pub fn is(&self, index: &DatasetIndex) -> bool {
        self.index.as_ref() == Some(index)
    }

    /// Checks that files which will be replaced are the dataset's own: those that a dataset of this index writes.
    pub fn check(&self, index: &DatasetIndex) -> Result<(), Error> {
        let fixed = [DATASET_JSON, DATASET_MD, CROISSANT_JSON, LIGHT_FIELDS_CSV];
        let names = fixed.into_iter().chain(SPLITS).map(str::to_owned).chain(sheets(index));
        for name in names.chain(index.poses.iter().map(|_| TRANSFORMS.to_owned())) {
            if self.root.kind(&name)?.is_some() && !self.has(&name) {
                return Err(Error::Failed(format!(
                    "{}: the dataset writes a file of this name, and did not write this one; move it elsewhere",
                    self.root.path_of(&name).display()
                )));
            }
        }
        Ok(())
    }

    /// Removes the catalog and the poses of the index that lies there.
    pub fn remove_catalog(&self) -> Result<(), Error> {
        let Some(index) = &self.index else { return Ok(()) };
        let names = [CROISSANT_JSON, LIGHT_FIELDS_CSV].into_iter().chain(SPLITS).map(str::to_owned);
        let poses = index.poses.iter().map(|_| TRANSFORMS.to_owned());
        names.chain(sheets(index)).chain(poses).try_for_each(|name| self.remove(&name))
    }

    /// Removes a file, if it is the dataset's own.
    pub fn remove(&self, name: &str) -> Result<(), Error> {
        if self.has(name) { Ok(self.root.remove_file(name)?) } else { Ok(()) }
    }

    /// Whether a file is the dataset's own.
    fn has(&self, name: &str) -> bool {
        matches!(self.root.kind(name), Ok(Some(EntryKind::File))) && self.is_own(name).unwrap_or(false)
    }

    fn is_own(&self, name: &str) -> Option<bool> {
        let text = || String::from_utf8(self.root.read(name, MAX_BYTES).ok()?).ok();
        Some(match name {
            DATASET_JSON => self.index.is_some(),
            DATASET_MD => text()?.starts_with(TITLE),
            CROISSANT_JSON => {
                let document: Value = serde_json::from_str(&text()?).ok()?;
                document["name"] == croissant::NAME && document["conformsTo"] == croissant::CONFORMS_TO
            }
            LIGHT_FIELDS_CSV => text()?.starts_with(&record::first_names()),
            TRANSFORMS => self.index.as_ref()?.poses.is_some() && poses::is_own(self.root),
            name if SPLITS.contains(&name) => {
                let (text, folders) = (text()?, self.folders());
                text.lines().all(|line| folders.contains(line))
            }
            name => {
                let index = self.index.as_ref()?;
                let camera = index.cameras.iter().find(|camera| contact_sheet::file_name(camera) == name)?;
                let file = BufReader::new(self.root.open_regular(name, u64::MAX).ok()?);
                let image = image::ImageReader::with_format(file, image::ImageFormat::Png);
                image.into_dimensions().ok()? == contact_sheet::size(camera, index.scenes.len())
            }
        })
    }

    /// The folders of the index, as lists have them.
    fn folders(&self) -> BTreeSet<String> {
        let of_index = |index: &DatasetIndex| {
            let of_scene = |name: &str| index.cameras.iter().map(|camera| folder(name, camera)).collect::<Vec<_>>();
            index.scenes.iter().flat_map(|scene| of_scene(&scene.name)).collect()
        };
        self.index.as_ref().map(of_index).unwrap_or_default()
    }
}

/// The names of the contact sheets of an index.
fn sheets(index: &DatasetIndex) -> impl Iterator<Item = String> {
    index.cameras.iter().map(contact_sheet::file_name)
}

/// The folder of a scene and a camera, with `/` on every system.
pub(super) fn folder(scene: &str, camera: &DatasetCamera) -> String {
    format!("{scene}/{}", camera.name())
}
