//! Long work that reports its progress and that Ctrl-C stops.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use holo_render::Progress;
use pyo3::prelude::*;

use crate::failure::Failure;

/// How often signals are handled and progress is told.
const INTERVAL: Duration = Duration::from_millis(50);

/// The steps of the progress of one of several shots.
const STEPS: u64 = 1000;

/// Progress of the work, and whether to stop it.
#[derive(Default)]
pub struct Watch {
    done: AtomicU64,
    total: AtomicU64,
    /// Shots that are over.
    over: AtomicU64,
    /// All shots; 0 where there is only one, whose tiles are counted.
    shots: AtomicU64,
    stop: AtomicBool,
}

impl Watch {
    /// `over` shots of so many are over: progress is that of all of them, and does not begin again with each.
    pub fn shots(&self, over: usize, of: usize) {
        if of > 1 {
            self.shots.store(of as u64, Ordering::Relaxed);
            self.over.store(over as u64, Ordering::Relaxed);
            self.advance(0, 1);
        }
    }
}

impl Progress for Watch {
    fn advance(&self, done: u64, total: u64) {
        let (done, total) = match self.shots.load(Ordering::Relaxed) {
            0 => (done, total),
            shots => {
                let part = (STEPS * done / total.max(1)).min(STEPS);
                (self.over.load(Ordering::Relaxed) * STEPS + part, shots * STEPS)
            }
        };
        self.total.store(total, Ordering::Relaxed);
        self.done.fetch_max(done, Ordering::Relaxed);
    }

    fn cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

/// Does `work` on a thread of its own while this one handles signals and calls `progress(done, total)`. An exception of
/// either stops the work and is returned.
pub fn run<T: Send, E: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Watch) -> Result<T, E> + Send,
) -> Result<T, Failure>
where
    Failure: From<E>,
{
    let watch = Watch::default();
    std::thread::scope(|scope| {
        let waiting = std::thread::current();
        let watched = &watch;
        let spawned = std::thread::Builder::new().spawn_scoped(scope, move || {
            let result = work(watched);
            waiting.unpark();
            result
        });
        let worker = spawned.map_err(|why| Failure::Memory(format!("a thread cannot be started: {why}")))?;
        let (mut told, mut exception) = ((0, 0), None);
        while !worker.is_finished() {
            py.detach(|| std::thread::park_timeout(INTERVAL));
            let now = (watch.done.load(Ordering::Relaxed), watch.total.load(Ordering::Relaxed));
            let mut heard = py.check_signals();
            if let (Ok(()), Some(progress)) = (&heard, progress)
                && now != told
                && exception.is_none()
            {
                heard = progress.call1(now).map(drop);
                told = now;
            }
            if let (Err(error), None) = (heard, &exception) {
                watch.stop.store(true, Ordering::Relaxed);
                exception = Some(error);
            }
        }
        let result = worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
        match exception {
            Some(error) => Err(Failure::Python(error)),
            None => Ok(result?),
        }
    })
}
