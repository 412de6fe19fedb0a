//! Progress bars, drawn on a terminal only.

use bsdfkit_represent::Progress;
use indicatif::{ProgressBar, ProgressStyle};

/// A bar on standard error that goes when it is dropped.
pub(crate) struct Bar(ProgressBar);

impl Bar {
    /// A bar named `what`; nothing is drawn before the first report.
    pub(crate) fn new(what: impl Into<String>) -> Self {
        let style =
            ProgressStyle::with_template("{msg:>24} {wide_bar} {pos}/{len} {elapsed}, {eta} left")
                .expect("the template is valid");
        Self(ProgressBar::new(0).with_style(style).with_message(what.into()))
    }

    /// How far the job has come; from any thread.
    pub(crate) fn report(&self, progress: Progress) {
        self.0.set_length(progress.total as u64);
        self.0.set_position(progress.done as u64);
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
