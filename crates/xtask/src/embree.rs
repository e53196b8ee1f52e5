//! Embree 4 under `target/embree`: the system's if it has one, else the one inside a PyPI wheel.
//!
//! Debian 12 and older distributions have no Embree 4. The wheel of `embreex` carries `libembree4` with the TBB that it
//! needs; only these two files are unpacked.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Result, process, target};

const PACKAGE: &str = "embreex==4.4.0";

/// Names under which the dynamic loader finds an Embree of the system.
const SYSTEM_NAMES: &[&str] = &["libembree4.so.4", "libembree4.so", "libembree4.4.dylib", "embree4.dll"];

/// Where system libraries lie, as far as a file name can tell.
const SYSTEM_FOLDERS: &[&str] = &[
    "/usr/lib",
    "/usr/lib64",
    "/usr/local/lib",
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/opt/homebrew/lib",
];

/// Fetches Embree unless there is one.
pub fn ensure() -> Result {
    if std::env::var_os("HOLO_EMBREE_LIB").is_some() || system_has_one() {
        return Ok(());
    }
    if library_files(&folder()).is_empty() { fetch() } else { mark() }
}

/// Fetches Embree from PyPI.
pub fn fetch() -> Result {
    let python = process::python()?;
    eprintln!("xtask: fetching Embree 4.4 (the PyPI wheel {PACKAGE}, 14 MB)");
    let download = target().join("download");
    std::fs::create_dir_all(&download).map_err(|why| format!("{}: {why}", download.display()))?;
    process::run(
        Command::new(python)
            .args(["-m", "pip", "download", "--quiet", "--disable-pip-version-check", "--no-deps"])
            .args(["--only-binary=:all:", "--dest"])
            .arg(&download)
            .arg(PACKAGE),
    )?;
    let wheel = newest_wheel(&download)?;
    // Unpacked beside its place and then moved there: a killed run leaves no half library behind.
    let fresh = target().join("embree.part");
    let _ = std::fs::remove_dir_all(&fresh);
    process::run(Command::new(python).args(["-c", UNPACK]).arg(&wheel).arg(&fresh))?;
    if library_files(&fresh).is_empty() {
        return Err(format!("{} holds no libembree4", wheel.display()));
    }
    let _ = std::fs::remove_dir_all(folder());
    std::fs::rename(&fresh, folder()).map_err(|why| format!("{}: {why}", folder().display()))?;
    mark()
}

/// Programs take libraries only from a target folder that is marked as one. Cargo marks those that it makes itself, not one that
/// was there before.
fn mark() -> Result {
    let tag = target().join("CACHEDIR.TAG");
    if tag.is_file() {
        return Ok(());
    }
    let text = "Signature: 8a477f597d28d172789f06886806bc55\n# What cargo and xtask build and fetch; see https://bford.info/cachedir/\n";
    std::fs::write(&tag, text).map_err(|why| format!("{}: {why}", tag.display()))
}

/// A wheel is a zip archive; the libraries lie in a folder `*.libs`.
const UNPACK: &str = "
import os, sys, zipfile
os.makedirs(sys.argv[2])
archive = zipfile.ZipFile(sys.argv[1])
for name in archive.namelist():
    folder, _, file = name.rpartition('/')
    if file and (folder.endswith('.libs') or folder.endswith('.dylibs')):
        with open(os.path.join(sys.argv[2], file), 'wb') as out:
            out.write(archive.read(name))
";

/// Where the program looks for it (see `holo-render`'s Embree seam).
pub fn folder() -> PathBuf {
    target().join("embree")
}

fn newest_wheel(folder: &Path) -> Result<PathBuf> {
    let wheels = std::fs::read_dir(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    wheels
        .filter_map(|entry| Some(entry.ok()?.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "whl"))
        .max()
        .ok_or_else(|| format!("pip left no wheel in {}", folder.display()))
}

pub fn library_files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let is_embree = |path: &PathBuf| path.file_name().is_some_and(|n| n.to_string_lossy().contains("embree4"));
    entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_embree).collect()
}

fn system_has_one() -> bool {
    SYSTEM_FOLDERS.iter().any(|folder| SYSTEM_NAMES.iter().any(|name| Path::new(folder).join(name).exists()))
}
