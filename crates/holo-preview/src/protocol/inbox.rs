//! The newest look of a page, and the scene that was dropped on it. Older looks are forgotten.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use holo_dataset::SceneSource;
use holo_render::Progress;

use crate::protocol::Look;

/// What the studio has to do next.
#[derive(Debug)]
pub(crate) enum Task {
    Look(Look),
    Gallery,
}

#[derive(Debug, Default)]
struct Waiting {
    look: Option<Look>,
    gallery: bool,
    /// The scene that was dropped last, and how many were.
    dropped: Option<(SceneSource, u64)>,
    closed: bool,
}

/// What one page has sent.
#[derive(Debug, Default)]
pub(crate) struct Inbox {
    waiting: Mutex<Waiting>,
    changed: Condvar,
    /// Counts what arrives, so that work for older looks ends.
    version: AtomicU64,
}

impl Inbox {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn put(&self, change: impl FnOnce(&mut Waiting)) {
        let mut waiting = self.lock();
        change(&mut waiting);
        self.version.fetch_add(1, Ordering::SeqCst);
        self.changed.notify_all();
    }

    pub fn look(&self, look: Look) {
        self.put(|waiting| waiting.look = Some(look));
    }

    pub fn gallery(&self) {
        self.put(|waiting| waiting.gallery = true);
    }

    pub fn drop_scene(&self, name: String, bytes: Arc<[u8]>) {
        self.put(|waiting| {
            let count = waiting.dropped.as_ref().map_or(0, |(_, count)| *count);
            waiting.dropped = Some((SceneSource::Memory(name, bytes), count + 1));
        });
    }

    /// The page is gone.
    pub fn close(&self) {
        self.put(|waiting| waiting.closed = true);
    }

    /// The scene that was dropped last, and its number from 1.
    pub fn dropped(&self) -> Option<(SceneSource, u64)> {
        self.lock().dropped.clone()
    }

    /// Waits for the next task, which something newer cancels; `None` once the page is gone.
    pub fn next(&self) -> Option<(Task, Newest<'_>)> {
        let mut waiting = self.lock();
        loop {
            if waiting.closed {
                return None;
            }
            if let Some(look) = waiting.look.take() {
                return Some((Task::Look(look), self.watch()));
            }
            if std::mem::take(&mut waiting.gallery) {
                return Some((Task::Gallery, self.watch()));
            }
            waiting = self.changed.wait(waiting).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Puts a look back, unless there is a newer one.
    pub fn put_back(&self, look: Look) {
        let mut waiting = self.lock();
        waiting.look.get_or_insert(look);
    }

    /// Puts the gallery back, after looks.
    pub fn put_gallery_back(&self) {
        self.lock().gallery = true;
    }

    /// What arrives from now on cancels.
    fn watch(&self) -> Newest<'_> {
        Newest { inbox: self, version: self.version.load(Ordering::SeqCst) }
    }
}

/// Cancels work as soon as something newer arrives.
#[derive(Clone, Copy)]
pub(crate) struct Newest<'a> {
    inbox: &'a Inbox,
    version: u64,
}

impl Progress for Newest<'_> {
    fn cancelled(&self) -> bool {
        self.inbox.version.load(Ordering::SeqCst) != self.version
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(task: Option<(Task, Newest)>) -> u64 {
        match task {
            Some((Task::Look(look), _)) => look.number,
            _ => panic!("no look"),
        }
    }

    #[test]
    fn the_newest_look_wins_and_ends_older_work() {
        let inbox = Inbox::default();
        let look = |number| Look { number, ..Look::default() };
        inbox.look(look(1));
        let (_, newest) = inbox.next().unwrap();
        assert!(!newest.cancelled());
        inbox.look(look(2));
        assert!(newest.cancelled());
        assert_eq!(number(inbox.next()), 2);
        inbox.put_back(look(3));
        inbox.put_back(look(4));
        assert_eq!(number(inbox.next()), 3);
        inbox.gallery();
        let Some((Task::Gallery, newest)) = inbox.next() else { panic!("no gallery") };
        // A look comes first, and the gallery is not forgotten for it.
        inbox.look(look(5));
        assert!(newest.cancelled());
        inbox.put_gallery_back();
        assert_eq!(number(inbox.next()), 5);
        assert!(matches!(inbox.next(), Some((Task::Gallery, _))));
        inbox.close();
        assert!(inbox.next().is_none());
    }
}
