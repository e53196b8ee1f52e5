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

impl Failure {
    /// What went wrong, without advice on the command line.
    pub fn message(&self) -> String {
        match self {
            Self::Usage(message) | Self::Failed(message) => message.clone(),
        }
    }
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
            // The only impossible rig that no scene file can cause.
            holo_render::Error::Core(why @ holo_core::Error::OrthographicFocus { .. }) => Self::Usage(why.to_string()),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<holo_dataset::Error> for Failure {
    fn from(error: holo_dataset::Error) -> Self {
        match error {
            holo_dataset::Error::BadRequest(message) => Self::Usage(message),
            holo_dataset::Error::Render(error) => error.into(),
            holo_dataset::Error::Core(error) => error.into(),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<holo_scene::Error> for Failure {
    fn from(error: holo_scene::Error) -> Self {
        Self::Failed(error.to_string())
    }
}

impl From<holo_io::Error> for Failure {
    fn from(error: holo_io::Error) -> Self {
        match error {
            holo_io::Error::MissingOption { path, option, what } => {
                let flag = if option == "layout" { "from" } else { option };
                Self::Usage(format!("{}: {what}; give --{flag}", path.display()))
            }
            error @ holo_io::Error::NoLightField { .. } => Self::Usage(error.to_string()),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<holo_core::Error> for Failure {
    fn from(error: holo_core::Error) -> Self {
        match error {
            // The library counts rows first, the command line columns.
            holo_core::Error::SensorTooSmall { sensor, views } => Self::Usage(format!(
                "a sensor of {} x {} pixels is too small for {} x {} views: every view needs at least one pixel",
                sensor.columns, sensor.rows, views.columns, views.rows
            )),
            other => Self::Usage(other.to_string()),
        }
    }
}
