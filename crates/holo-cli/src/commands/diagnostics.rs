//! Warnings and notes on standard error.

use std::cell::RefCell;
use std::collections::BTreeSet;

use holo_dataset::{About, Diagnostics};

use crate::console::say;
use crate::progress::Overall;

/// Of one render: every diagnostic goes to standard error, or none.
pub struct Plain {
    pub quiet: bool,
}

impl Diagnostics for Plain {
    fn report(&self, _: About, line: &str) {
        if !self.quiet {
            say!("{line}");
        }
    }
}

/// Of many renders: what was said of a scene is not said again of its other splits, nor of a set-up for other scenes.
pub struct OnceEach<'a> {
    bar: &'a Overall,
    quiet: bool,
    said: RefCell<BTreeSet<String>>,
}

impl<'a> OnceEach<'a> {
    /// Writes above the bar.
    pub fn above(bar: &'a Overall, quiet: bool) -> Self {
        Self { bar, quiet, said: RefCell::default() }
    }

    /// Takes the diagnostics of one scene.
    pub fn of_scene<'b>(&'b self, scene: &'b str) -> OfScene<'b> {
        OfScene { all: self, scene }
    }

    fn line(&self, line: String) {
        if !self.quiet && !self.said.borrow().contains(&line) {
            self.bar.above(|| say!("{line}"));
            self.said.borrow_mut().insert(line);
        }
    }
}

impl Diagnostics for OnceEach<'_> {
    fn report(&self, _: About, line: &str) {
        self.line(line.to_owned());
    }
}

/// Names the scene in what is said of it.
pub struct OfScene<'a> {
    all: &'a OnceEach<'a>,
    scene: &'a str,
}

impl Diagnostics for OfScene<'_> {
    fn report(&self, about: About, line: &str) {
        self.all.line(match about {
            About::Scene => format!("{}: {line}", self.scene),
            About::Setup => line.to_owned(),
        });
    }
}
