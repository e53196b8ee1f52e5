//! Other renderers under `target/peers`, for `cargo xtask report --peers`: Mitsuba 3 and Blender as Python modules.
//!
//! Fetched only on request: a gigabyte. A wheel of Blender fits one version of Python, so every Python of the machine
//! is tried. The report names a renderer that is missing and goes on without it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::setup::pip::{self, Availability, Requirements};
use crate::{Result, target};

/// What Mitsuba and its script of `holo-bench/peers` need.
const MITSUBA: Requirements = Requirements {
    name: "mitsuba",
    pythons: 10..=12,
    platforms: &[("linux", "x86_64"), ("linux", "aarch64"), ("macos", "aarch64"), ("windows", "x86_64")],
};

/// The same for Blender.
pub(crate) const BLENDER: Requirements = Requirements {
    name: "blender",
    pythons: 11..=11,
    platforms: &[("linux", "x86_64"), ("macos", "aarch64"), ("windows", "x86_64")],
};

/// The oldest Blender that the extension supports.
pub(crate) const BLENDER_LTS: Requirements = Requirements {
    name: "blender_lts",
    pythons: 11..=11,
    platforms: &[("linux", "x86_64"), ("macos", "aarch64"), ("windows", "x86_64")],
};

/// Fetches what is missing; returns the environment in which the report finds it.
///
/// # Errors
///
/// If pip fails.
pub fn ensure() -> Result<Vec<(&'static str, OsString)>> {
    for requirements in [&MITSUBA, &BLENDER] {
        if let Availability::Missing(why) = pip::install(requirements, &folder().join(requirements.name))? {
            eprintln!("xtask: no {}: {why}", requirements.name);
        }
    }
    let mut environment = vec![("HOLO_PEERS", folder().into_os_string())];
    if std::env::var_os("DRJIT_LIBLLVM_PATH").is_none() {
        match llvm() {
            Some(path) => environment.push(("DRJIT_LIBLLVM_PATH", path.into_os_string())),
            None => eprintln!(
                "xtask: Mitsuba's LLVM variants need LLVM 16 or newer: on Debian `apt-get install libllvm19`; \
                 DRJIT_LIBLLVM_PATH names a library elsewhere"
            ),
        }
    }
    Ok(environment)
}

fn folder() -> PathBuf {
    target().join("peers")
}

/// Fetches a renderer as a module, if this machine can have it; returns the Python that it is for and the folder for
/// `PYTHONPATH`.
///
/// # Errors
///
/// If pip fails.
pub(crate) fn module(requirements: &Requirements) -> Result<Option<(String, PathBuf)>> {
    let home = folder().join(requirements.name);
    if let Availability::Missing(why) = pip::install(requirements, &home)? {
        eprintln!("xtask: no {}: {why}", requirements.name);
    }
    Ok(pip::installed(requirements, &home).map(|python| (python, home)))
}

/// The newest LLVM of the system from 16 on (14 and 15 fail on machines with AVX-512), or else that of the Rust compiler.
fn llvm() -> Option<PathBuf> {
    let folders = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib"];
    let files = |version: u32| {
        let names = [format!("libLLVM-{version}.so"), format!("libLLVM.so.{version}.1")];
        folders.iter().flat_map(move |folder| names.clone().map(|name| Path::new(folder).join(name)))
    };
    (16..=30).rev().flat_map(files).find(|path| path.exists()).or_else(llvm_of_rust)
}

/// The LLVM of the Rust compiler, where that is a library of its own.
fn llvm_of_rust() -> Option<PathBuf> {
    let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output().ok()?.stdout;
    let library = Path::new(std::str::from_utf8(&sysroot).ok()?.trim()).join("lib");
    let files = std::fs::read_dir(library).ok()?.filter_map(|entry| Some(entry.ok()?.path()));
    files.into_iter().find(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with("libLLVM")))
}
