//! Jobs and their folders, in one test program: building many takes longer than running them.

mod checkpoints;
mod matrix;
mod recipes;
mod settings;

use std::collections::BTreeMap;
use std::sync::{LazyLock, Mutex};

use holo_dataset::SceneSource;

/// A scene of the gallery. It is made once: its textures take longer than a small image.
fn gallery(name: &'static str) -> SceneSource {
    static MADE: LazyLock<Mutex<BTreeMap<&str, SceneSource>>> = LazyLock::new(Mutex::default);
    let mut made = MADE.lock().expect("no test panics in here");
    made.entry(name).or_insert_with(|| SceneSource::gallery(name).expect("a scene")).clone()
}
