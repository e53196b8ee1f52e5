//! The list of the folders `<scene>/<S>x<T>/` and `<scene>/<camera>/` of a dataset.

use std::fs;
use std::path::{Path, PathBuf};

use holo_core::GridSize;

use super::{CAMERA_TOML, MANIFEST_JSON, is_camera_name, views_name};
use crate::Error;
use crate::files::names::is_regular;

/// A folder of a dataset and what its path states.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DatasetEntry {
    /// The name of the scene's folder.
    pub scene: String,
    /// The name of the folder in it: views as columns x rows, or the name of a plenoptic camera.
    pub camera: String,
    /// The path of the folder.
    pub path: PathBuf,
}

impl DatasetEntry {
    /// Returns the number of views, T rows and S columns; `None` for a plenoptic camera.
    #[must_use]
    pub fn views(&self) -> Option<GridSize> {
        views_of(&self.camera)
    }
}

/// Lists the folders of a dataset, sorted by scene, then by view columns, then by view rows; behind them those of
/// plenoptic cameras, sorted by name.
///
/// Only folders with a manifest are listed, because unfinished ones have none; the manifest is not read. The folder of a
/// plenoptic camera has a `camera.toml` too. Other files and folders are ignored: a folder without datasets gives an
/// empty list.
///
/// # Errors
///
/// [`Error::Io`] if the folder or a scene in it cannot be listed.
pub fn list(path: impl AsRef<Path>) -> Result<Vec<DatasetEntry>, Error> {
    let mut entries = Vec::new();
    for (scene, scene_path) in folders(path.as_ref())? {
        for (camera, path) in folders(&scene_path)? {
            let has = |name: &str| path.join(name).is_file();
            let is_camera = || is_camera_name(&camera) && is_regular(&path.join(CAMERA_TOML));
            if has(MANIFEST_JSON) && (views_of(&camera).is_some() || is_camera()) {
                entries.push(DatasetEntry { scene: scene.clone(), camera, path });
            }
        }
    }
    entries.sort_by(|a, b| a.scene.cmp(&b.scene).then_with(|| order(&a.camera).cmp(&order(&b.camera))));
    Ok(entries)
}

/// What the folders of a scene are sorted by.
fn order(camera: &str) -> (bool, usize, usize, &str) {
    match views_of(camera) {
        Some(views) => (false, views.columns, views.rows, camera),
        None => (true, 0, 0, camera),
    }
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
pub(super) fn views_of(name: &str) -> Option<GridSize> {
    let (columns, rows) = name.split_once('x')?;
    let views = GridSize::new(rows.parse().ok()?, columns.parse().ok()?);
    // Only the spelling that `folder` writes: no sign, no leading zero, no count of 0.
    (views.count() > 0 && views_name(views) == name).then_some(views)
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
