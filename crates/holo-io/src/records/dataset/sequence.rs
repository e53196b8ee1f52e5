//! The folder of a sequence: the frames of an animated scene, each in a dataset folder of its own.

use std::path::{Path, PathBuf};

use super::MANIFEST_JSON;
use super::list::folders;
use crate::Error;

/// What the name of a frame's folder begins with.
const PREFIX: &str = "frame_";

/// A folder with dataset folders `frame_0000/`, `frame_0001/` and so on in it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SequenceFolder {
    path: PathBuf,
    frames: Vec<u32>,
}

impl SequenceFolder {
    /// Returns the name of the folder of a frame, such as `frame_0012`.
    #[must_use]
    pub fn frame_name(frame: u32) -> String {
        format!("{PREFIX}{frame:04}")
    }

    /// Lists the frames in a folder, which may have none.
    ///
    /// Only folders with a manifest are frames, because unfinished ones have none; the manifest is not read. Other files
    /// and folders are ignored.
    ///
    /// # Errors
    ///
    /// [`Error::Io`] if the folder cannot be listed.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let complete = folders(path)?.into_iter().filter(|(_, folder)| folder.join(MANIFEST_JSON).is_file());
        let mut frames: Vec<u32> = complete.filter_map(|(name, _)| frame_of(&name)).collect();
        frames.sort_unstable();
        Ok(Self { path: path.to_owned(), frames })
    }

    /// Returns the folder of the sequence.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the numbers of the frames in ascending order. There may be gaps.
    #[must_use]
    pub fn frames(&self) -> &[u32] {
        &self.frames
    }

    /// Returns the dataset folder of a frame.
    #[must_use]
    pub fn frame_path(&self, frame: u32) -> PathBuf {
        self.path.join(Self::frame_name(frame))
    }
}

/// Reads `frame_0012` as [`SequenceFolder::frame_name`] writes it.
pub(super) fn frame_of(name: &str) -> Option<u32> {
    let frame = name.strip_prefix(PREFIX)?.parse().ok()?;
    (SequenceFolder::frame_name(frame) == name).then_some(frame)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_the_folders_with_a_manifest() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["frame_0010", "frame_0002", "frame_12345", "frame_2", "frame_+001", "frame_", "other"] {
            std::fs::create_dir(folder.path().join(name)).unwrap();
            std::fs::write(folder.path().join(name).join(MANIFEST_JSON), "{}").unwrap();
        }
        std::fs::create_dir(folder.path().join("frame_0003")).unwrap();
        let sequence = SequenceFolder::open(folder.path()).unwrap();
        assert_eq!(sequence.frames(), [2, 10, 12345]);
        assert_eq!(sequence.frame_path(2), folder.path().join("frame_0002"));
    }
}
