//! Remarks on the way to a picture: what a scene has that is left out, which engine stands in for another.

use std::cell::RefCell;
use std::collections::BTreeSet;

use crate::console::say;
use crate::progress::Overall;

/// What a remark is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// The scene, or the picture of it.
    Scene,
    /// The engine or the sensor, whatever the scene.
    SetUp,
}

/// Takes remarks; each is a line that begins with `warning:` or `note:`.
pub trait Remarks {
    fn remark(&self, about: About, line: &str);
}

/// Of one render: every remark goes to standard error, or none.
pub struct Plain {
    pub quiet: bool,
}

impl Remarks for Plain {
    fn remark(&self, _: About, line: &str) {
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

    /// Takes the remarks of one scene.
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

impl Remarks for OnceEach<'_> {
    fn remark(&self, _: About, line: &str) {
        self.line(line.to_owned());
    }
}

/// Names the scene in what is said of it.
pub struct OfScene<'a> {
    all: &'a OnceEach<'a>,
    scene: &'a str,
}

impl Remarks for OfScene<'_> {
    fn remark(&self, about: About, line: &str) {
        self.all.line(match about {
            About::Scene => format!("{}: {line}", self.scene),
            About::SetUp => line.to_owned(),
        });
    }
}
