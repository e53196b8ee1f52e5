//! The list of the dataset folders `<scene>/<S>x<T>/` in a folder.

use std::fs;
use std::path::{Path, PathBuf};

use holo_core::GridSize;

use super::MANIFEST_JSON;
use crate::Error;

/// A dataset folder and what its path states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DatasetEntry {
    /// The name of the scene's folder.
    pub scene: String,
    /// Number of views, T rows and S columns; the folder name has columns x rows.
    pub views: GridSize,
    /// The dataset's folder.
    pub path: PathBuf,
}

/// Lists the dataset folders `<scene>/<S>x<T>/` in a folder, sorted by scene, then by view columns, then by view rows.
///
/// Only folders with a manifest are listed, because unfinished ones have none; the manifest is not read. Other files
/// and folders are ignored: a folder without datasets gives an empty list.
///
/// # Errors
///
/// [`Error::Io`] if the folder or a scene in it cannot be listed.
pub fn list(path: impl AsRef<Path>) -> Result<Vec<DatasetEntry>, Error> {
    let mut entries = Vec::new();
    for (scene, scene_path) in folders(path.as_ref())? {
        for (name, path) in folders(&scene_path)? {
            if let Some(views) = views_of(&name).filter(|_| path.join(MANIFEST_JSON).is_file()) {
                entries.push(DatasetEntry { scene: scene.clone(), views, path });
            }
        }
    }
    entries.sort_by(|a, b| {
        let key = |entry: &DatasetEntry| (entry.views.columns, entry.views.rows);
        a.scene.cmp(&b.scene).then(key(a).cmp(&key(b)))
    });
    Ok(entries)
}

/// The subfolders of a folder whose names are UTF-8.
pub(super) fn folders(path: &Path) -> Result<Vec<(String, PathBuf)>, Error> {
    let failed = |source| Error::io("list", path, source);
    let mut folders = Vec::new();
    for entry in fs::read_dir(path).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        // False for links, which lead elsewhere.
        let is_folder = entry.file_type().is_ok_and(|kind| kind.is_dir());
        if let Some(name) = entry.file_name().to_str().filter(|_| is_folder) {
            folders.push((name.to_owned(), entry.path()));
        }
    }
    Ok(folders)
}

/// Reads `<S>x<T>` as [`folder`](super::folder) writes it.
fn views_of(name: &str) -> Option<GridSize> {
    let (columns, rows) = name.split_once('x')?;
    let views = GridSize::new(rows.parse().ok()?, columns.parse().ok()?);
    // Only the spelling that `folder` writes: no sign, no leading zero, no count of 0.
    (views.count() > 0 && format!("{}x{}", views.columns, views.rows) == name).then_some(views)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_columns_by_rows() {
        assert_eq!(views_of("40x20"), Some(GridSize::new(20, 40)));
        for name in ["", "x", "40x", "x20", "040x20", "+40x20", "40x20x3", "40X20", "0x5", "5x0", "hci"] {
            assert_eq!(views_of(name), None, "{name}");
        }
    }
}
