//! Embree 4 under `target/embree`: the libraries inside a PyPI wheel, for systems that have none.
//!
//! Debian 12 and older distributions have no Embree 4. The wheel of `embreex` contains `libembree4` with the TBB that
//! it needs; only these libraries are unpacked.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::setup::pip::{self, Availability, Requirements};
use crate::setup::process;
use crate::{Result, target};

const REQUIREMENTS: Requirements = Requirements {
    name: "embree",
    pythons: 10..=14,
    platforms: &[("linux", "x86_64"), ("macos", "x86_64"), ("macos", "aarch64"), ("windows", "x86_64")],
};

/// Names under which the dynamic loader finds an Embree of the system.
const SYSTEM_NAMES: &[&str] = &["libembree4.so.4", "libembree4.so", "libembree4.4.dylib", "embree4.dll"];

/// Folders of system libraries.
const SYSTEM_FOLDERS: &[&str] = &[
    "/usr/lib",
    "/usr/lib64",
    "/usr/local/lib",
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/opt/homebrew/lib",
];

/// Fetches Embree unless the system has one or `HOLO_EMBREE_LIB` names one.
///
/// # Errors
///
/// If pip fails.
pub fn ensure() -> Result<Availability> {
    if let Some(library) = std::env::var_os("HOLO_EMBREE_LIB") {
        let is_present = Path::new(&library).is_file();
        let missing =
            || Availability::Missing(format!("HOLO_EMBREE_LIB names {}, which is no file", library.display()));
        return Ok(if is_present { Availability::Present } else { missing() });
    }
    if is_installed() { Ok(Availability::Present) } else { fetch() }
}

/// Fetches Embree from PyPI unless it is in `target/embree`.
///
/// # Errors
///
/// If pip fails.
pub fn fetch() -> Result<Availability> {
    if pip::is_current(&REQUIREMENTS, &folder()) && !library_files(&folder()).is_empty() {
        mark()?;
        return Ok(Availability::Present);
    }
    let python = match REQUIREMENTS.python() {
        Ok(python) => python,
        Err(why) => return Ok(Availability::Missing(why)),
    };
    eprintln!("xtask: fetching Embree 4.4 (a wheel from PyPI, 14 MB)");
    let download = target().join("download").join("embree");
    pip::download(&REQUIREMENTS, python, &download)?;
    let wheel = only_wheel(&download)?;
    // Unpacked elsewhere and then renamed: an interrupted run leaves no incomplete folder behind.
    let fresh = target().join("embree.part");
    let _ = std::fs::remove_dir_all(&fresh);
    process::run(Command::new(python).args(["-c", UNPACK]).arg(&wheel).arg(&fresh))?;
    if library_files(&fresh).is_empty() {
        return Err(format!("{} holds no libembree4", wheel.display()));
    }
    pip::finish(&REQUIREMENTS, &fresh, &folder())?;
    mark()?;
    Ok(Availability::Present)
}

/// Marks the target folder as one, as cargo does where it made the folder itself: programs load libraries from no
/// other.
fn mark() -> Result {
    let tag = target().join("CACHEDIR.TAG");
    if tag.is_file() {
        return Ok(());
    }
    let text = "Signature: 8a477f597d28d172789f06886806bc55\n\
                # What cargo and xtask build and fetch; see https://bford.info/cachedir/\n";
    std::fs::write(&tag, text).map_err(|why| format!("{}: {why}", tag.display()))
}

/// A wheel is a zip archive; the libraries are in a folder `*.libs` or `*.dylibs`, the license in
/// `*.dist-info/licenses`.
const UNPACK: &str = "
import os, sys, zipfile
os.makedirs(os.path.join(sys.argv[2], 'licenses'))
archive = zipfile.ZipFile(sys.argv[1])
for name in archive.namelist():
    folder, _, file = name.rpartition('/')
    if file and folder.endswith(('.libs', '.dylibs')):
        place = file
    elif file and folder.endswith('.dist-info/licenses'):
        place = os.path.join('licenses', file)
    else:
        continue
    with open(os.path.join(sys.argv[2], place), 'wb') as out:
        out.write(archive.read(name))
";

/// Where the program looks for it (see `holo-render`'s `accel/embree.rs`).
pub fn folder() -> PathBuf {
    target().join("embree")
}

fn only_wheel(folder: &Path) -> Result<PathBuf> {
    let entries = std::fs::read_dir(folder).map_err(|why| format!("{}: {why}", folder.display()))?;
    let mut wheels = entries.filter_map(|entry| Some(entry.ok()?.path())).filter(|path| is_wheel(path));
    match (wheels.next(), wheels.next()) {
        (Some(wheel), None) => Ok(wheel),
        _ => Err(format!("pip was to leave one wheel in {}", folder.display())),
    }
}

fn is_wheel(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension == "whl")
}

/// The files of `folder` that are Embree itself.
pub fn library_files(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let is_embree = |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().contains("embree4"));
    entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_embree).collect()
}

/// The library that other programs are told to load by `HOLO_EMBREE_LIB`: what the user named there, or what was fetched.
pub fn environment() -> Option<(&'static str, PathBuf)> {
    let named = std::env::var_os("HOLO_EMBREE_LIB").map(PathBuf::from);
    named.or_else(|| library_files(&folder()).pop()).map(|library| ("HOLO_EMBREE_LIB", library))
}

/// Every library that the wheel holds: Embree and those that it needs.
pub fn all_libraries(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let is_library = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        [".so", ".dylib", ".dll"].iter().any(|ending| name.contains(ending))
    };
    entries.filter_map(|entry| Some(entry.ok()?.path())).filter(is_library).collect()
}

/// The version of Embree that is pinned: that of the wheel.
pub fn version() -> Result<String> {
    let file = REQUIREMENTS.file();
    let text = std::fs::read_to_string(&file).map_err(|why| format!("{}: {why}", file.display()))?;
    let version = text.lines().find_map(|line| line.strip_prefix("embreex==")?.split_whitespace().next());
    version.map(str::to_owned).ok_or_else(|| format!("{} does not name embreex", file.display()))
}

fn is_installed() -> bool {
    SYSTEM_FOLDERS.iter().any(|folder| SYSTEM_NAMES.iter().any(|name| Path::new(folder).join(name).exists()))
}
