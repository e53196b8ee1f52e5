//! CMake and Ninja under `target/build-tools`: what the HDF5 library is built with.
//!
//! HDF5 comes as C source inside a crate. Where CMake, or Make for CMake to call, is missing, both come from PyPI.

use std::ffi::OsString;
use std::path::PathBuf;

use crate::{Result, pip, process, target};

const PACKAGES: [&str; 2] = ["cmake>=3.20", "ninja"];

/// Fetches what is missing.
pub fn ensure() -> Result {
    if !process::exists("cc") && std::env::var_os("CC").is_none() {
        return Err("there is no C compiler".into());
    }
    if system_has_it() || fetched() {
        return Ok(());
    }
    let python = process::python()?;
    eprintln!("xtask: fetching CMake and Ninja from PyPI (30 MB)");
    pip::install(python, &PACKAGES, &folder())?;
    if fetched() { Ok(()) } else { Err(format!("{} holds no cmake", folder().display())) }
}

/// Whether HDF5 can be built.
pub fn is_there() -> bool {
    system_has_it() || fetched()
}

/// The environment with which cargo finds the tools.
pub fn environment() -> Vec<(&'static str, OsString)> {
    if system_has_it() || !fetched() {
        return Vec::new();
    }
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = own_folders().into_iter().chain(std::env::split_paths(&path));
    let Ok(path) = std::env::join_paths(folders) else { return Vec::new() };
    vec![("PATH", path), ("CMAKE_GENERATOR", "Ninja".into())]
}

fn system_has_it() -> bool {
    process::exists("cmake") && process::exists("make")
}

fn folder() -> PathBuf {
    target().join("build-tools")
}

/// The programs themselves; what pip puts into `bin` for CMake is a script that would need a path of its own.
fn own_folders() -> [PathBuf; 2] {
    [folder().join("cmake").join("data").join("bin"), folder().join("bin")]
}

fn fetched() -> bool {
    let [cmake, ninja] = own_folders();
    cmake.join("cmake").is_file() && ninja.join("ninja").is_file()
}
