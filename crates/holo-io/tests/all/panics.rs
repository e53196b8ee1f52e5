//! Panics of one thread, counted: the hook for panics belongs to the process, and so to all tests.

use std::cell::Cell;
use std::sync::Once;

/// Panics by whether the guard around decoders was to catch them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Panics {
    pub guarded: usize,
    pub unguarded: usize,
}

thread_local! {
    static COUNTED: Cell<Option<Panics>> = const { Cell::new(None) };
}

/// Runs `work` and counts the panics of this thread, caught ones too.
pub fn count(work: impl FnOnce()) -> Panics {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            if let Some(mut counted) = COUNTED.get() {
                let kind = if holo_io::is_guarding() { &mut counted.guarded } else { &mut counted.unguarded };
                *kind += 1;
                COUNTED.set(Some(counted));
            }
            before(info);
        }));
    });
    COUNTED.set(Some(Panics::default()));
    work();
    COUNTED.take().unwrap_or_default()
}
