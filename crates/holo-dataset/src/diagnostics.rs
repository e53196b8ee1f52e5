//! Warnings and notes about a render, such as unsupported parts of a scene, or another ray tracing backend than
//! requested.

/// The subject of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The scene or its image.
    Scene,
    /// The backend or the sensor, independent of the scene.
    Setup,
}

/// A receiver of warnings and notes. `()` ignores them.
pub trait Diagnostics {
    /// Receives one line, which begins with `warning:` or `note:`.
    fn report(&self, about: About, line: &str);
}

impl Diagnostics for () {
    fn report(&self, _: About, _: &str) {}
}
