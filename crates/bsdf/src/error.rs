//! One error type, four classes by who is to blame.

use std::fmt;

/// Who is to blame, and what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorClass {
    /// The operating system refused: missing file, no permission, full disk.
    Io,
    /// The file's content is wrong.
    Format,
    /// The caller's argument is wrong.
    Argument,
    /// Well-formed, but larger than a documented limit.
    Limit,
}

/// What went wrong; prints lowercase, outermost context first:
/// `fabric.xml: ScatteringData: expected 21025 values, found 21024`.
#[derive(Debug)]
pub struct Error {
    class: ErrorClass,
    message: String,
}

/// `Result` with this crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// An [`ErrorClass::Io`] error about `what`.
    pub fn io(what: impl fmt::Display, source: &std::io::Error) -> Self {
        Self { class: ErrorClass::Io, message: format!("{what}: {source}") }
    }

    /// An [`ErrorClass::Format`] error.
    pub fn format(message: impl Into<String>) -> Self {
        Self { class: ErrorClass::Format, message: message.into() }
    }

    /// An [`ErrorClass::Argument`] error.
    pub fn argument(message: impl Into<String>) -> Self {
        Self { class: ErrorClass::Argument, message: message.into() }
    }

    /// An [`ErrorClass::Limit`] error.
    pub fn limit(message: impl Into<String>) -> Self {
        Self { class: ErrorClass::Limit, message: message.into() }
    }

    /// The same error with `outer` (a file, a place in it) put before the message.
    #[must_use]
    pub fn context(mut self, outer: impl fmt::Display) -> Self {
        self.message = format!("{outer}: {}", self.message);
        self
    }

    /// Which of the four classes.
    pub fn class(&self) -> ErrorClass {
        self.class
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Error {}
