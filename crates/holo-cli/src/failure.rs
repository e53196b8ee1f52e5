//! Why a command did not do its work.

use std::fmt;

/// An error with the exit code it deserves.
#[derive(Debug)]
pub enum Failure {
    /// The command line asks for something that cannot be: exit code 2.
    Usage(String),
    /// The work failed: exit code 1.
    Failed(String),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Usage(message) => write!(f, "{message}\nTry 'holo --help'."),
            Self::Failed(message) => f.write_str(message),
        }
    }
}

impl From<holo_render::Error> for Failure {
    fn from(error: holo_render::Error) -> Self {
        match error {
            holo_render::Error::BadSetting(message) => Self::Usage(message),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<holo_io::Error> for Failure {
    fn from(error: holo_io::Error) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<holo_core::Error> for Failure {
    fn from(error: holo_core::Error) -> Self {
        Self::Usage(error.to_string())
    }
}
