//! Ctrl-C and the signals that ask a process to end: a batch stops so that it can go on.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use bsdfkit::{Error, Result};

static STOPPED: AtomicBool = AtomicBool::new(false);

/// From now on [`stopped`] tells whether the process was asked to end.
///
/// Errors: io, where signals cannot be caught.
pub(crate) fn listen() -> Result<()> {
    static ONCE: OnceLock<std::result::Result<(), String>> = OnceLock::new();
    let set =
        || ctrlc::set_handler(|| STOPPED.store(true, Ordering::SeqCst)).map_err(|e| e.to_string());
    let heard = ONCE.get_or_init(set);
    heard.clone().map_err(|e| Error::io("signals", &std::io::Error::other(e)))
}

/// Whether somebody asked for the end.
pub(crate) fn stopped() -> bool {
    STOPPED.load(Ordering::SeqCst)
}
