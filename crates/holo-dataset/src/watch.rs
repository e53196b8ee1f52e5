//! What a caller sees of a render while it runs: warnings and notes, and the progress of parts.

use std::cell::RefCell;
use std::collections::BTreeSet;

use holo_render::Progress;

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

impl<F: Fn(About, &str)> Diagnostics for F {
    fn report(&self, about: About, line: &str) {
        self(about, line);
    }
}

/// The diagnostics of many renders, each line once: what was reported of a scene is not repeated for its other view
/// counts, nor is a note on the set-up repeated for other scenes.
pub struct Deduplicated<F> {
    print: F,
    reported: RefCell<BTreeSet<String>>,
}

impl<F: Fn(&str)> Deduplicated<F> {
    /// Hands every new line to `print`.
    pub fn new(print: F) -> Self {
        Self { print, reported: RefCell::default() }
    }

    /// Receives the diagnostics of one scene, whose lines get its name.
    pub fn of_scene<'a>(&'a self, scene: &'a str) -> impl Diagnostics + 'a {
        OfScene { all: self, scene }
    }

    fn line(&self, line: String) {
        if !self.reported.borrow().contains(&line) {
            (self.print)(&line);
            self.reported.borrow_mut().insert(line);
        }
    }
}

impl<F: Fn(&str)> Diagnostics for Deduplicated<F> {
    fn report(&self, _: About, line: &str) {
        self.line(line.to_owned());
    }
}

struct OfScene<'a, F> {
    all: &'a Deduplicated<F>,
    scene: &'a str,
}

impl<F: Fn(&str)> Diagnostics for OfScene<'_, F> {
    fn report(&self, about: About, line: &str) {
        self.all.line(match about {
            About::Scene => format!("{}: {line}", self.scene),
            About::Setup => line.to_owned(),
        });
    }
}

/// Passes cancellation on, and reports nothing: for a step that is not counted.
#[derive(Clone, Copy)]
pub(crate) struct CancelOnly<'a>(pub &'a dyn Progress);

impl Progress for CancelOnly<'_> {
    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

/// The progress of one of several images of the same size, as that of all of them.
#[derive(Clone, Copy)]
pub(crate) struct PartProgress<'a> {
    /// The progress of all.
    pub inner: &'a dyn Progress,
    /// The number of the image, from 0.
    pub k: usize,
    /// The number of images.
    pub of: usize,
}

impl Progress for PartProgress<'_> {
    fn advance(&self, done: u64, total: u64) {
        self.inner.advance(self.k as u64 * total + done, self.of as u64 * total);
    }

    fn cancelled(&self) -> bool {
        self.inner.cancelled()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_is_reported_once_and_those_of_scenes_by_their_name() {
        let lines = RefCell::new(Vec::new());
        let all = Deduplicated::new(|line: &str| lines.borrow_mut().push(line.to_owned()));
        for scene in ["a", "b", "a"] {
            let of_scene = all.of_scene(scene);
            of_scene.report(About::Scene, "warning: dark");
            of_scene.report(About::Setup, "note: no Embree");
        }
        all.report(About::Setup, "note: no Embree");
        assert_eq!(*lines.borrow(), ["a: warning: dark", "note: no Embree", "b: warning: dark"]);
    }
}
