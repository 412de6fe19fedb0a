//! Progress and cancellation of a long computation.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use bsdfkit::{Error, Result};

/// How far a computation has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Progress {
    /// Jobs finished.
    pub done: usize,
    /// Jobs in all.
    pub total: usize,
}

/// Who watches a computation: hears of progress, may cancel it.
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Called after each job, from any thread.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
    /// Set to true to stop.
    pub cancel: Option<&'a AtomicBool>,
}

impl Watch<'_> {
    /// Errors: limit, when cancelled.
    pub fn check(&self) -> Result<()> {
        match self.cancel {
            Some(flag) if flag.load(Ordering::Relaxed) => Err(Error::limit("cancelled")),
            _ => Ok(()),
        }
    }

    /// Counts a finished job.
    pub fn finished(&self, done: &AtomicUsize, total: usize) {
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        if let Some(progress) = self.progress {
            progress(Progress { done, total });
        }
    }
}
