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

/// The steps of the progress of one of several images, whose numbers of tiles may differ.
const STEPS: u64 = 1000;

/// The progress of one of several images, as that of all of them.
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
        let part = (STEPS * done / total.max(1)).min(STEPS);
        self.inner.advance(self.k as u64 * STEPS + part, self.of as u64 * STEPS);
    }

    fn cancelled(&self) -> bool {
        self.inner.cancelled()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_progress_of_images_of_any_size_never_goes_back() {
        struct Seen(std::sync::Mutex<Vec<(u64, u64)>>);
        impl Progress for Seen {
            fn advance(&self, done: u64, total: u64) {
                self.0.lock().unwrap().push((done, total));
            }
        }
        let seen = Seen(std::sync::Mutex::default());
        for (k, tiles) in [100, 3, 7].into_iter().enumerate() {
            let image = PartProgress { inner: &seen, k, of: 3 };
            (1..=tiles).for_each(|done| image.advance(done, tiles));
        }
        let seen = seen.0.into_inner().unwrap();
        assert!(seen.is_sorted() && seen.iter().all(|(_, total)| *total == 3 * STEPS), "{seen:?}");
        assert_eq!((seen[0].0, seen[99].0, seen[102].0, seen[109].0), (10, 1000, 2000, 3000));
    }

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
