//! Warnings and notes on the way to an image: what a scene has that is left out, which ray tracing backend stands in for
//! another.

/// What a diagnostic is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The scene, or the image of it.
    Scene,
    /// The backend or the sensor, whatever the scene.
    Setup,
}

/// Receives warnings and notes. `()` drops them.
pub trait Diagnostics {
    /// Takes one line, which begins with `warning:` or `note:`.
    fn report(&self, about: About, line: &str);
}

impl Diagnostics for () {
    fn report(&self, _: About, _: &str) {}
}
