//! Errors as Python exceptions, with the messages of the command line.

use holo_dataset::settings::{Setting, spelled};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

/// Why a function did not do its work.
pub enum Failure {
    /// The arguments ask for something that cannot be: `holo.UsageError`.
    Usage(String),
    /// The work failed: `holo.Error`.
    Failed(String),
    /// There is not enough memory: `holo.OutOfMemoryError`.
    Memory(String),
    /// An exception of Python.
    Python(PyErr),
}

/// An exception of `holo.errors`.
fn exception(class: &str, message: String) -> PyErr {
    Python::attach(|py| {
        let made = py.import("holo.errors").and_then(|module| module.getattr(class)?.call1((message,)));
        made.map_or_else(|error| error, PyErr::from_value)
    })
}

impl From<Failure> for PyErr {
    fn from(failure: Failure) -> Self {
        match failure {
            Failure::Usage(message) => exception("UsageError", message),
            Failure::Failed(message) => exception("Error", message),
            Failure::Memory(message) => exception("OutOfMemoryError", message),
            Failure::Python(error) => error,
        }
    }
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Python(error)
    }
}

impl From<holo_dataset::Error> for Failure {
    fn from(error: holo_dataset::Error) -> Self {
        match error {
            holo_dataset::Error::Render(holo_render::Error::Cancelled) => {
                Self::Python(PyKeyboardInterrupt::new_err("stopped"))
            }
            error if error.is_out_of_memory() => Self::Memory(keywords(&error.to_string())),
            error if error.is_bad_request() => Self::Usage(keywords(&error.to_string())),
            error => Self::Failed(keywords(&error.to_string())),
        }
    }
}

/// A message of the libraries with keywords of Python in it.
pub fn keywords(message: &str) -> String {
    spelled(message, |key, value| {
        let keyword = Setting::by_key(key).map_or_else(|| key.replace('-', "_"), Setting::keyword);
        let (key, value) = (keyword, value.trim_start());
        if value.is_empty() || value.starts_with('=') { format!("{key}{value}") } else { format!("{key}={value}") }
    })
}

impl From<holo_io::Error> for Failure {
    fn from(error: holo_io::Error) -> Self {
        match error {
            holo_io::Error::MissingOption { path, option, what } => {
                Self::Usage(format!("{}: {what}; give {option}=", path.display()))
            }
            error @ holo_io::Error::OutOfMemory { .. } => Self::Memory(error.to_string()),
            error @ (holo_io::Error::BadInput { .. } | holo_io::Error::Camera(_)) => Self::Usage(error.to_string()),
            error => Self::Failed(error.to_string()),
        }
    }
}

impl From<holo_render::Error> for Failure {
    fn from(error: holo_render::Error) -> Self {
        holo_dataset::Error::from(error).into()
    }
}

impl From<holo_scene::Error> for Failure {
    fn from(error: holo_scene::Error) -> Self {
        Self::Failed(error.to_string())
    }
}

/// Indices, sizes and numbers come from the caller.
impl From<holo_core::Error> for Failure {
    fn from(error: holo_core::Error) -> Self {
        match error {
            error @ holo_core::Error::OutOfMemory { .. } => Self::Memory(error.to_string()),
            error => Self::Usage(error.to_string()),
        }
    }
}
