//! Full renders of what a page looks at, into new folders.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use holo_dataset::settings::Preset;
use holo_dataset::{RenderJob, RunOptions};
use holo_render::Progress;
use serde_json::{Value, json};

use crate::Preview;
use crate::job::{self, told};
use crate::protocol::inbox::Inbox;
use crate::protocol::{Event, Look, Opened, Reply};

/// How often the page hears of progress.
const INTERVAL: Duration = Duration::from_millis(100);

/// The preset of a draft, which comes first.
const DRAFT: &str = "draft";

/// What connections share.
#[derive(Clone, Copy)]
pub(crate) struct Shared<'a> {
    pub preview: &'a Preview,
    /// The folders of finished renders.
    pub rendered: &'a Mutex<Vec<PathBuf>>,
    pub stop: &'a AtomicBool,
    /// The first page, before it is opened.
    pub ahead: &'a Mutex<Option<Opened>>,
}

impl Shared<'_> {
    /// Registers the folder of a finished render; returns its path on this server.
    pub fn add(&self, folder: PathBuf) -> String {
        let mut rendered = self.rendered.lock().unwrap_or_else(PoisonError::into_inner);
        rendered.push(folder);
        format!("/view/{}", rendered.len() - 1)
    }

    /// The folder of a finished render.
    pub fn folder(&self, number: usize) -> Option<PathBuf> {
        self.rendered.lock().unwrap_or_else(PoisonError::into_inner).get(number).cloned()
    }
}

/// The renders of one page: one at a time.
#[derive(Debug, Default)]
pub(crate) struct Renders {
    running: Mutex<()>,
    stop: AtomicBool,
}

impl Renders {
    /// Ends the render that runs.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::SeqCst);
    }

    /// Renders a look into a new folder: a draft first, then all of it.
    pub fn run(&self, look: &Look, shared: &Shared, inbox: &Inbox, events: &Sender<Event>) {
        let send = |header: Value| drop(events.send(Event::Send(Reply::new(header))));
        let Ok(_running) = self.running.try_lock() else {
            return send(
                json!({"kind": "error", "number": look.number, "text": "a render runs already; stop it first"}),
            );
        };
        self.stop.store(false, Ordering::SeqCst);
        if let Err(why) = self.both(look, shared, inbox, &send) {
            send(json!({"kind": "ended", "text": why}));
        }
    }

    fn both(&self, look: &Look, shared: &Shared, inbox: &Inbox, send: &dyn Fn(Value)) -> Result<(), String> {
        let out =
            shared.preview.out.as_ref().ok_or("this preview may not write; start it with a folder for renders")?;
        let (source, _) = job::scene(look, shared.preview, inbox)?;
        let job = job::of(look, source.clone(), shared.preview)?;
        let folder = new_folder(out, &holo_core::visible(&source.name()))?;
        if let Some(preset) = Preset::by_name(DRAFT) {
            let mut draft = look.clone();
            draft.settings.remove("target-error");
            draft.settings.extend(preset.given().iter().map(|(key, text)| (key.to_owned(), text.to_owned())));
            let job = job::of(&draft, source, shared.preview)?;
            self.one(&job, &folder.join("draft"), ("draft", look, shared), send)?;
        }
        self.one(&job, &folder.join("full"), ("full", look, shared), send)
    }

    /// Renders one job, and tells the page where its result is.
    fn one(
        &self,
        job: &RenderJob,
        folder: &Path,
        (stage, look, shared): (&str, &Look, &Shared),
        send: &dyn Fn(Value),
    ) -> Result<(), String> {
        let start = Instant::now();
        std::thread::scope(|scope| {
            let (progress, reports) = Reported::new(self, shared.stop);
            let running = scope.spawn(|| {
                let progress = progress;
                job.run(folder, &RunOptions::new().progress(&progress).rollback(&shared.preview.rollback))
            });
            for (done, total) in reports {
                send(json!({"kind": "progress", "stage": stage, "done": done, "total": total}));
            }
            match running.join() {
                Ok(Ok(_)) => {
                    // Of a sequence its first frame.
                    let first = job.shots().first().map(|shot| shot.folder()).unwrap_or_default();
                    let path = shared.add(folder.join(first));
                    let seconds = start.elapsed().as_secs_f64();
                    send(json!({
                        "kind": "rendered",
                        "number": look.number,
                        "stage": stage,
                        "folder": folder.display().to_string(),
                        "path": path,
                        "seconds": seconds,
                    }));
                    Ok(())
                }
                Ok(Err(_)) if self.stop.load(Ordering::SeqCst) => Err("stopped".into()),
                Ok(Err(why)) => Err(told(why)),
                Err(_) => Err("the render ended by an error of the program".into()),
            }
        })
    }
}

/// Hands progress on, now and then.
struct Reported<'a> {
    renders: &'a Renders,
    stop: &'a AtomicBool,
    last: Mutex<Option<Instant>>,
    reports: Sender<(u64, u64)>,
}

impl<'a> Reported<'a> {
    fn new(renders: &'a Renders, stop: &'a AtomicBool) -> (Self, std::sync::mpsc::Receiver<(u64, u64)>) {
        let (reports, received) = std::sync::mpsc::channel();
        (Self { renders, stop, last: Mutex::default(), reports }, received)
    }
}

impl Progress for Reported<'_> {
    fn advance(&self, done: u64, total: u64) {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if last.is_none_or(|last| last.elapsed() >= INTERVAL) || done == total {
            *last = Some(Instant::now());
            let _ = self.reports.send((done, total));
        }
    }

    fn cancelled(&self) -> bool {
        self.renders.stop.load(Ordering::SeqCst) || self.stop.load(Ordering::SeqCst)
    }
}

/// Creates the next folder of a scene below `out`.
fn new_folder(out: &Path, scene: &str) -> Result<PathBuf, String> {
    let plain: String = scene.chars().map(|c| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' }).collect();
    let failed = |why: std::io::Error| format!("cannot make a folder in {}: {why}", out.display());
    std::fs::create_dir_all(out).map_err(failed)?;
    for number in 1..10_000 {
        let folder = out.join(format!("{plain}_{number:03}"));
        match std::fs::create_dir(&folder) {
            Ok(()) => return Ok(folder),
            Err(why) if why.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(why) => return Err(failed(why)),
        }
    }
    Err(format!("{} has ten thousand renders of this scene; move some", out.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_render_has_a_folder_of_its_own() {
        let out = tempfile::tempdir().unwrap();
        let first = new_folder(out.path(), "../garden").unwrap();
        let second = new_folder(out.path(), "../garden").unwrap();
        assert_eq!(first, out.path().join("___garden_001"));
        assert_eq!(second, out.path().join("___garden_002"));
    }
}
