//! Long jobs: in a thread of their own, while this one hears of Ctrl-C and shows progress.

use std::panic::resume_unwind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use bsdfkit::Result;
use bsdfkit_represent::{Progress, Watch};
use pyo3::prelude::*;

use crate::error::raised;

/// Between two looks at signals and progress. Doubled, Ctrl-C begins to feel slow.
const TICK: Duration = Duration::from_millis(50);

/// Runs `job` with the GIL released; a signal's exception cancels it and is raised once it stopped.
///
/// `progress` is what the caller gave for the argument of that name, `what` the title of a bar.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    progress: Option<&Bound<'_, PyAny>>,
    what: &str,
    job: impl FnOnce(&Watch<'_>) -> Result<T> + Send,
) -> PyResult<T> {
    let reporter =
        py.import("bsdfkit._progress")?.call_method1("reporter", (progress, what))?.unbind();
    let (latest, cancel) = (Mutex::new(None), AtomicBool::new(false));
    let remember = |p: Progress| *latest.lock().unwrap_or_else(PoisonError::into_inner) = Some(p);
    // A false report or a signal: its exception.
    let look = || {
        Python::attach(|py| {
            py.check_signals()?;
            let last: Option<Progress> =
                latest.lock().unwrap_or_else(PoisonError::into_inner).take();
            match last {
                Some(p) => reporter.call_method1(py, "report", (p.done, p.total)).map(drop),
                None => Ok(()),
            }
        })
    };
    let mut stopped = None;
    let result = py.detach(|| {
        thread::scope(|scope| {
            let (done, is_done) = channel();
            let (remember, cancel) = (&remember, &cancel);
            let worker = scope.spawn(move || {
                let result = job(&Watch { progress: Some(remember), cancel: Some(cancel) });
                drop(done);
                result
            });
            let wait = || is_done.recv_timeout(TICK) == Err::<(), _>(RecvTimeoutError::Timeout);
            while stopped.is_none() && wait() {
                stopped = look().err();
            }
            cancel.store(stopped.is_some(), Ordering::Relaxed);
            worker.join().unwrap_or_else(|panic| resume_unwind(panic))
        })
    });
    let last = if stopped.is_none() { look().err() } else { None };
    reporter.call_method0(py, "close")?;
    match stopped.or(last) {
        Some(exception) => Err(exception),
        None => result.map_err(|e| raised(&e)),
    }
}
