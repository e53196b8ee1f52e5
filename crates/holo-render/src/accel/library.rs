//! Where Embree's library may lie.
//!
//! Loading a library runs it. So a library that this program looks for itself is loaded only from an absolute path, and only
//! if the file and its folder belong to the administrator or to the user, and not everybody may write them. The library that
//! `HOLO_EMBREE_LIB` names is the user's own decision, and one of the system is found by the system's loader.

use std::env;
use std::path::{Path, PathBuf};

/// A path that is tried, or why it is not.
pub(super) struct Candidate {
    pub path: PathBuf,
    pub refused: Option<String>,
}

/// The candidates in order of preference: only `HOLO_EMBREE_LIB` if it is set; otherwise the library of the system, a folder
/// `embree` beside the running program or in the cargo target folder around it, the cache of the user.
pub(super) fn candidates() -> Vec<Candidate> {
    let trusted = |path: PathBuf| Candidate { path, refused: None };
    if let Some(path) = env::var_os("HOLO_EMBREE_LIB") {
        return vec![trusted(path.into())];
    }
    let mut found: Vec<Candidate> = of_system().into_iter().map(trusted).collect();
    let program = env::current_exe().ok();
    for folder in folders(program.as_deref(), cache_folder()) {
        let Ok(entries) = std::fs::read_dir(&folder) else { continue };
        let mut here: Vec<PathBuf> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|p| p.file_name().is_some_and(|n| n.to_string_lossy().contains("embree4")))
            .collect();
        here.sort();
        found.extend(here.into_iter().map(|path| Candidate { refused: distrust(&folder, &path).err(), path }));
    }
    found
}

/// The names by which the system's loader knows the library. That of Windows would look into the working folder too, so
/// there the absolute folders of `PATH` are searched here.
fn of_system() -> Vec<PathBuf> {
    if cfg!(windows) {
        let path = env::var_os("PATH").unwrap_or_default();
        let folders = env::split_paths(&path).filter(|folder| folder.is_absolute());
        return folders.map(|folder| folder.join("embree4.dll")).filter(|library| library.is_file()).collect();
    }
    let names: &[&str] = if cfg!(target_os = "macos") {
        &["libembree4.4.dylib", "libembree4.dylib", "/opt/homebrew/lib/libembree4.dylib"]
    } else {
        &["libembree4.so.4", "libembree4.so"]
    };
    names.iter().map(PathBuf::from).collect()
}

/// The folders that are searched: all absolute.
fn folders(program: Option<&Path>, cache: Option<PathBuf>) -> Vec<PathBuf> {
    // Folders above that of the program count only if they are cargo target folders.
    let above = program.into_iter().flat_map(|program| program.ancestors().skip(1).take(4).enumerate());
    let trusted = above.filter(|(up, folder)| *up == 0 || folder.join("CACHEDIR.TAG").is_file());
    let beside = trusted.map(|(_, folder)| folder.join("embree"));
    let all = beside.chain(cache.map(|cache| cache.join("embree")));
    all.filter(|folder| folder.is_absolute()).collect()
}

/// Returns the folder of `holo` in the cache of the user, which may not exist: where `XDG_CACHE_HOME` and `HOME` lead.
#[must_use]
pub fn cache_folder() -> Option<PathBuf> {
    cache_folder_by(env::var_os("XDG_CACHE_HOME").map(PathBuf::from), env::var_os("HOME").map(PathBuf::from))
}

/// The same by these values. An empty or relative one means nothing, as the XDG Base Directory Specification says: it would
/// be a folder below the working folder.
fn cache_folder_by(xdg: Option<PathBuf>, home: Option<PathBuf>) -> Option<PathBuf> {
    let absolute = |path: Option<PathBuf>| path.filter(|path| path.is_absolute());
    let cache = absolute(xdg).or_else(|| absolute(home).map(|home| home.join(".cache")));
    cache.map(|cache| cache.join("holo"))
}

/// Checks that nobody but the administrator and the user could have put a library there.
#[cfg(unix)]
fn distrust(folder: &Path, library: &Path) -> Result<(), String> {
    use std::os::unix::fs::MetadataExt;

    let user = rustix::process::geteuid().as_raw();
    // Where links lead, because that is what is loaded.
    let library = library.canonicalize().map_err(|why| why.to_string())?;
    for path in [folder, &library] {
        let found = path.metadata().map_err(|why| why.to_string())?;
        if ![0, user].contains(&found.uid()) {
            return Err(format!("not loaded, because {} belongs to another user", path.display()));
        }
        if found.mode() & 0o002 != 0 {
            return Err(format!("not loaded, because everybody may write {}", path.display()));
        }
    }
    Ok(())
}

/// The standard library does not say who owns a file here.
#[cfg(not(unix))]
fn distrust(_: &Path, _: &Path) -> Result<(), String> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_and_relative_variables_name_no_folder() {
        let cache =
            |xdg: Option<&str>, home: Option<&str>| cache_folder_by(xdg.map(PathBuf::from), home.map(PathBuf::from));
        let root = if cfg!(windows) { "C:\\" } else { "/" };
        let [a, b] = ["a", "b"].map(|name| format!("{root}{name}"));
        assert_eq!(cache(Some(&a), Some(&b)), Some(Path::new(&a).join("holo")));
        assert_eq!(cache(Some(""), Some(&b)), Some(Path::new(&b).join(".cache").join("holo")));
        assert_eq!(cache(Some("x"), Some(&b)), Some(Path::new(&b).join(".cache").join("holo")));
        for (xdg, home) in [(None, None), (Some(""), Some("")), (Some("x"), Some(".")), (None, Some(""))] {
            assert_eq!(cache(xdg, home), None, "{xdg:?} {home:?}");
        }
        assert!(folders(Some(Path::new("holo")), Some(PathBuf::from("cache"))).is_empty());
        let all = folders(Some(&Path::new(&a).join("holo")), Some(PathBuf::from(&b)));
        assert_eq!(all, [Path::new(&a).join("embree"), Path::new(&b).join("embree")]);
    }

    #[cfg(unix)]
    #[test]
    fn a_library_that_everybody_may_write_is_not_loaded() {
        use std::fs::{Permissions, set_permissions};
        use std::os::unix::fs::PermissionsExt;

        let folder = tempfile::tempdir().unwrap();
        let library = folder.path().join("libembree4.so.4");
        std::fs::write(&library, b"").unwrap();
        let set = |path: &Path, mode: u32| set_permissions(path, Permissions::from_mode(mode)).unwrap();
        set(&library, 0o755);
        assert_eq!(distrust(folder.path(), &library), Ok(()));
        set(&library, 0o666);
        assert!(distrust(folder.path(), &library).unwrap_err().contains("everybody may write"));
        set(&library, 0o644);
        set(folder.path(), 0o777);
        assert!(distrust(folder.path(), &library).unwrap_err().contains("everybody may write"));
        set(folder.path(), 0o700);
        std::os::unix::fs::symlink("/nowhere", folder.path().join("embree4")).unwrap();
        assert!(distrust(folder.path(), &folder.path().join("embree4")).is_err());
    }
}
