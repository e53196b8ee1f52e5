//! Readers and writers of other projects under `target/python`, which the tests of the file formats compare with.
//!
//! SciPy, h5py, OpenCV, OpenEXR and others come from PyPI. Python finds them by `PYTHONPATH`.

use std::ffi::OsString;
use std::path::PathBuf;

use crate::setup::pip::{self, Availability, Requirements};
use crate::{Result, target};

const REQUIREMENTS: Requirements = Requirements { name: "peers", pythons: 10..=14, platforms: pip::COMMON_PLATFORMS };

/// Fetches them (about 170 MB) unless they are there or the user named a Python that has them in `HOLO_PYTHON`.
///
/// # Errors
///
/// If pip fails.
pub fn ensure() -> Result<Availability> {
    if std::env::var_os("HOLO_PYTHON").is_some() {
        return Ok(Availability::Present);
    }
    pip::install(&REQUIREMENTS, &folder())
}

/// The environment in which the tests find Python with these packages.
pub fn environment() -> Vec<(&'static str, OsString)> {
    if std::env::var_os("HOLO_PYTHON").is_some() {
        return Vec::new();
    }
    let Some(python) = pip::installed(&REQUIREMENTS, &folder()) else { return Vec::new() };
    vec![("HOLO_PYTHON", python.into()), ("PYTHONPATH", folder().into_os_string())]
}

/// The user's `HOLO_PYTHON`, or the Python that these packages were installed for, or `python3`.
pub fn python() -> OsString {
    let installed = || pip::installed(&REQUIREMENTS, &folder()).map(OsString::from);
    std::env::var_os("HOLO_PYTHON").or_else(installed).unwrap_or_else(|| "python3".into())
}

fn folder() -> PathBuf {
    target().join("python")
}
