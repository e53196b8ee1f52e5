//! A folder of datasets: `<scene>/<S>x<T>/`.

use std::fs;
use std::path::{Path, PathBuf};

use holo_core::GridSize;

use super::MANIFEST_JSON;
use crate::Error;

/// One dataset among others.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DatasetEntry {
    /// The name of the scene's folder.
    pub scene: String,
    /// The views that the name of the dataset's folder says: columns x rows.
    pub views: GridSize,
    /// The dataset's folder.
    pub path: PathBuf,
}

/// Lists the datasets in `<scene>/<S>x<T>/` under a folder, by scene and then by views, columns first.
///
/// Only finished ones are listed, which have a manifest; it is not read. Other files and folders do not matter, so a
/// folder without datasets is an empty list.
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

/// The folders in a folder whose names are text.
fn folders(path: &Path) -> Result<Vec<(String, PathBuf)>, Error> {
    let failed = |source| Error::io("list", path, source);
    let mut folders = Vec::new();
    for entry in fs::read_dir(path).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if let Some(name) = path.file_name().and_then(|name| name.to_str()).filter(|_| path.is_dir()) {
            folders.push((name.to_owned(), path));
        }
    }
    Ok(folders)
}

/// Reads `<S>x<T>` as [`folder`](super::folder) writes it.
fn views_of(name: &str) -> Option<GridSize> {
    let (columns, rows) = name.split_once('x')?;
    let views = GridSize::new(rows.parse().ok()?, columns.parse().ok()?);
    // No second spelling, such as a sign or a leading zero, and no grid of nothing.
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
