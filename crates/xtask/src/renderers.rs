//! Other renderers under `target/peers`, for `cargo xtask report --peers`: Mitsuba 3 and Blender as Python modules.
//!
//! Fetched only when they are asked for: a gigabyte, and as root also the LLVM that Mitsuba compiles with (apt-get). A wheel of
//! Blender fits one version of Python alone, so the Pythons of the machine are tried in turn. What cannot be had is said, and the
//! report goes without it.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::{Result, pip, process, target};

/// What a renderer and its script of `holo-bench/peers` need.
const RENDERERS: [(&str, &[&str]); 2] =
    [("mitsuba", &["mitsuba==3.9.1", "numpy<2", "pillow"]), ("blender", &["bpy==5.0.1", "numpy<2", "OpenEXR>=3.3"])];

const PYTHONS: [&str; 2] = ["python3", "python3.11"];

/// Fetches what is missing; returns the environment in which the report finds it.
pub fn ensure() -> Vec<(&'static str, OsString)> {
    for (name, packages) in RENDERERS {
        if let Err(why) = fetch(name, packages) {
            eprintln!("xtask: no {name}: {why}");
        }
    }
    let mut environment = vec![("HOLO_PEERS", folder().into_os_string())];
    if std::env::var_os("DRJIT_LIBLLVM_PATH").is_none() {
        match llvm() {
            Ok(path) => environment.push(("DRJIT_LIBLLVM_PATH", path.into_os_string())),
            Err(why) => eprintln!("xtask: Mitsuba will not run: {why}"),
        }
    }
    environment
}

fn folder() -> PathBuf {
    target().join("peers")
}

fn fetch(name: &str, packages: &[&str]) -> Result {
    // Written last: the Python that it was installed for.
    let done = folder().join(name).with_extension("python");
    if done.is_file() {
        return Ok(());
    }
    eprintln!("xtask: fetching {} from PyPI", packages.join(", "));
    let mut failure = String::from("there is no Python 3");
    for python in PYTHONS.into_iter().filter(|python| process::exists(python)) {
        match pip::install(python, packages, &folder().join(name)) {
            Ok(()) => return std::fs::write(&done, python).map_err(|why| format!("{}: {why}", done.display())),
            Err(why) => failure = why,
        }
    }
    Err(failure)
}

/// The LLVM that Mitsuba compiles with: 16 or newer (14 and 15 fail on machines with AVX-512).
fn llvm() -> Result<PathBuf> {
    if let Some(found) = installed_llvm() {
        return Ok(found);
    }
    if process::exists("apt-get") && crate::test::is_root() {
        eprintln!("xtask: installing libllvm19 for Mitsuba");
        // A fresh machine knows of no packages yet; with an old list the next step may still do.
        let _ = process::run(Command::new("apt-get").args(["update", "-q"]));
        process::run(
            Command::new("apt-get")
                .args(["install", "-y", "-q", "--no-install-recommends", "libllvm19"])
                .env("DEBIAN_FRONTEND", "noninteractive"),
        )?;
    }
    installed_llvm().ok_or_else(|| "needs LLVM 16 or newer (Debian's package libllvm19)".into())
}

fn installed_llvm() -> Option<PathBuf> {
    let folders = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib"];
    let named = |version: u32| {
        let names = [format!("libLLVM-{version}.so"), format!("libLLVM.so.{version}.1")];
        folders.iter().flat_map(move |folder| names.clone().map(|name| Path::new(folder).join(name)))
    };
    (16..=30).rev().flat_map(named).find(|path| path.exists())
}
