//! Why a verb ends early, and the exit status that says so.

use std::io::{self, Write};
use std::process::ExitCode;

use bsdfkit::{Error, ErrorClass};

/// What the verbs return.
pub(crate) type Outcome<T = Verdict> = Result<T, Stop>;

/// What a verb that ran to its end found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Nothing wrong.
    Good,
    /// `check` found faults; a material of a `batch` failed.
    Bad,
}

/// Why a verb ends early.
#[derive(Debug)]
pub(crate) enum Stop {
    /// Something is wrong; whose fault it is decides the exit status.
    Error(Error),
    /// Whoever read standard output has had enough: no fault.
    Closed,
    /// A program that was run in our place said what is wrong, and ended with this status.
    Status(u8),
}

/// The exit statuses, as `--help` lists them.
pub(crate) const STATUSES: &str = "\
Exit status:
  0  done
  1  check: the verdict is negative; batch: a material failed
  2  argument: the command line asks for something impossible
  3  io: a file is missing, unreadable or cannot be written
  4  format: a file's content is wrong
  5  limit: well-formed, but larger than a documented limit
130  batch: stopped by Ctrl-C or a signal; the same command goes on";

impl From<Error> for Stop {
    fn from(error: Error) -> Self {
        Self::Error(error)
    }
}

impl From<io::Error> for Stop {
    /// Of writing to standard output, where alone the verbs use `?` on such an error.
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Self::Closed,
            _ => Self::Error(Error::io("standard output", &error)),
        }
    }
}

/// Prints what went wrong, and the status of [`STATUSES`] for it.
pub(crate) fn exit(outcome: Outcome) -> ExitCode {
    ExitCode::from(match outcome {
        Ok(Verdict::Good) | Err(Stop::Closed) => 0,
        Ok(Verdict::Bad) => 1,
        Err(Stop::Status(status)) => status,
        Err(Stop::Error(error)) => {
            complain(&error);
            match error.class() {
                ErrorClass::Argument => 2,
                ErrorClass::Io => 3,
                ErrorClass::Format => 4,
                ErrorClass::Limit => 5,
            }
        }
    })
}

/// An error on standard error, if anybody reads that.
pub(crate) fn complain(error: &Error) {
    let _ = writeln!(io::stderr(), "bsdf: {error}");
}

/// Remarks on standard error: the first few, and how many more.
pub(crate) fn remark<T: std::fmt::Display>(what: &str, notes: &[T]) {
    const MOST: usize = 8;
    let mut err = io::stderr().lock();
    for note in notes.iter().take(MOST) {
        let _ = writeln!(err, "{what}: {note}");
    }
    if notes.len() > MOST {
        let _ = writeln!(err, "{what}: and {} more", notes.len() - MOST);
    }
}
