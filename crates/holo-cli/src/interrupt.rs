//! Ctrl-C and SIGTERM: stop within a second, leave no partial file.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use holo_dataset::Rollback;

use crate::console::say;

static STOPPED: AtomicBool = AtomicBool::new(false);
static SAID: AtomicBool = AtomicBool::new(false);

/// A render asks this often and ends by itself; a writer in the middle of a large file is not waited for.
const PATIENCE: Duration = Duration::from_millis(500);

/// What the commands of this process have put where nothing was before.
pub fn rollback() -> &'static Rollback {
    static ROLLBACK: LazyLock<Rollback> = LazyLock::new(Rollback::default);
    &ROLLBACK
}

/// Begins to listen.
pub fn install() {
    let listening = ctrlc::set_handler(|| {
        STOPPED.store(true, Ordering::SeqCst);
        // This is a thread of its own.
        std::thread::sleep(PATIENCE);
        say_stopped();
        // In this order: without its temporary file no writer can give a file its name any more.
        let _held = holo_io::remove_temporary_files();
        rollback().stop();
        std::process::exit(1);
    });
    if let Err(why) = listening {
        say!("holo: Ctrl-C will not clean up: {why}");
    }
}

/// Whether somebody asked to stop.
pub fn requested() -> bool {
    STOPPED.load(Ordering::SeqCst)
}

/// Says so, once, whichever thread comes first.
pub fn say_stopped() {
    if !SAID.swap(true, Ordering::SeqCst) {
        say!("holo: stopped");
    }
}
