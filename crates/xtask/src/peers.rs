//! Other programs' own readers under `target/python`: what the formats are tested against.
//!
//! A file format is right when those who use it can read it. SciPy, h5py, OpenCV and others come from PyPI, into a folder of
//! the build that is named to Python by `PYTHONPATH`: a bare Debian has no venv.

use std::ffi::OsString;
use std::path::PathBuf;

use crate::{Result, pip, process, target};

/// What reads and writes our formats elsewhere.
const PACKAGES: [&str; 9] = [
    "numpy>=1.26",
    "scipy>=1.11",
    "h5py>=3.10",
    "hdf5storage>=0.1.19",
    "mat73>=0.63",
    "OpenEXR>=3.3",
    "opencv-python-headless>=4.8",
    "Pillow>=10",
    "scikit-image>=0.22",
];

/// Fetches them if they are not there.
pub fn ensure() -> Result {
    if fetched() {
        return Ok(());
    }
    let python = process::python()?;
    eprintln!("xtask: fetching SciPy, h5py, OpenCV and others from PyPI, to test against (about 170 MB)");
    pip::install(python, &PACKAGES, &folder())
}

/// The environment in which the tests find Python with these packages.
pub fn environment() -> Vec<(&'static str, OsString)> {
    if std::env::var_os("HOLO_PYTHON").is_some() || !fetched() {
        return Vec::new();
    }
    let Ok(python) = process::python() else { return Vec::new() };
    vec![("HOLO_PYTHON", python.into()), ("PYTHONPATH", folder().into_os_string())]
}

/// Whether the tests have them: fetched here, or by a Python that the user named.
pub fn is_there() -> bool {
    std::env::var_os("HOLO_PYTHON").is_some() || fetched()
}

fn folder() -> PathBuf {
    target().join("python")
}

fn fetched() -> bool {
    // The last of the list, in the order in which pip puts them in place.
    folder().join("skimage").is_dir() && folder().join("mat73").is_dir()
}
