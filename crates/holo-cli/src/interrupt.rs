//! Ctrl-C and SIGTERM: stop within a second, leave no partial file.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

static STOPPED: AtomicBool = AtomicBool::new(false);

/// A render asks this often and ends by itself; a writer in the middle of a large file is not waited for.
const PATIENCE: Duration = Duration::from_millis(600);

/// Begins to listen.
pub fn install() {
    let listening = ctrlc::set_handler(|| {
        STOPPED.store(true, Ordering::SeqCst);
        // This is a thread of its own.
        std::thread::sleep(PATIENCE);
        eprintln!("holo: stopped");
        holo_io::remove_temporary_files();
        std::process::exit(1);
    });
    if let Err(why) = listening {
        eprintln!("holo: Ctrl-C will not clean up: {why}");
    }
}

/// Whether somebody asked to stop.
pub fn requested() -> bool {
    STOPPED.load(Ordering::SeqCst)
}
