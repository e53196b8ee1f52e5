//! Why a command did not do its work.

use std::fmt;

use holo_dataset::settings::spelled;

/// An error with the exit code it deserves.
///
/// Wrong use is what another command line puts right, whatever the files: an option that is missing, malformed or
/// contradicts another one, or that asks for what the input does not have, such as a view beyond the last. All that is
/// wrong with files is a failure, although another path may be meant.
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

impl Failure {
    /// A message of the libraries with the options of the command line in it.
    pub fn spelled(message: &str) -> String {
        spelled(message, |key, value| match value.is_empty() {
            true => format!("--{key}"),
            false => format!("--{key}{value}"),
        })
    }
}

impl From<holo_render::Error> for Failure {
    fn from(error: holo_render::Error) -> Self {
        match error {
            holo_render::Error::BadSetting(message) => Self::Usage(Self::spelled(&message)),
            // The only impossible rig that no scene file can cause.
            holo_render::Error::Core(why @ holo_core::Error::OrthographicFocus { .. }) => Self::Usage(why.to_string()),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<holo_dataset::Error> for Failure {
    fn from(error: holo_dataset::Error) -> Self {
        match error {
            holo_dataset::Error::BadRequest(message) | holo_dataset::Error::OutOfMemory(message) => {
                Self::Usage(Self::spelled(&message))
            }
            holo_dataset::Error::Render(error) => error.into(),
            // The sizes of a render are those of the command line.
            holo_dataset::Error::Core(error) => Self::Usage(message(&error)),
            other => Self::Failed(Self::spelled(&other.to_string())),
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
            // One of the command line: that of a file is broken.
            holo_io::Error::Camera(what) => Self::Usage(what),
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<holo_core::Error> for Failure {
    fn from(error: holo_core::Error) -> Self {
        use holo_core::Error;
        match error {
            Error::OutOfRange { .. }
            | Error::BadRange { .. }
            | Error::NotDivisible { .. }
            | Error::SensorTooSmall { .. }
            | Error::OrthographicFocus { .. }
            | Error::ImpossibleRange { .. }
            | Error::TooManyPlanes { .. } => Self::Usage(message(&error)),
            other => Self::Failed(message(&other)),
        }
    }
}

/// The error of a number of the command line that the library checks: wrong use.
pub fn wrong_option(error: holo_core::Error) -> Failure {
    match error {
        holo_core::Error::BadNumber { .. } | holo_core::Error::FinerThanLightField { .. } => {
            Failure::Usage(message(&error))
        }
        other => other.into(),
    }
}

/// The library counts rows first, the command line columns.
fn message(error: &holo_core::Error) -> String {
    match error {
        holo_core::Error::SensorTooSmall { sensor, views } => format!(
            "a sensor of {} x {} pixels is too small for {} x {} views: every view needs at least one pixel",
            sensor.columns, sensor.rows, views.columns, views.rows
        ),
        other => other.to_string(),
    }
}
