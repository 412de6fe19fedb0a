//! Measurements in the formats of others: one file a format, one line in [`FORMATS`].
//!
//! How a file is known stands in [`bsdfkit::foreign`]; here is how it is read. Each reader gets the file whole, so that
//! sizes that it declares are held against what there is before memory is taken.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use bsdfkit::foreign::Measured;
use bsdfkit::{Error, Result};

use super::block::{Budget, FileContent, Remark};
use super::line::Lines;

mod alta;
mod cornell;
mod fred;

/// A format and its reader.
#[derive(Debug)]
pub(crate) struct Format {
    kind: Measured,
    read: fn(&Whole<'_>) -> Result<FileContent>,
}

/// All of them.
const FORMATS: &[Format] = &[
    Format { kind: Measured::Fred, read: fred::read },
    Format { kind: Measured::Cornell, read: cornell::read },
    Format { kind: Measured::Alta, read: alta::read },
];

impl Format {
    /// The format that was recognised.
    pub(crate) fn of(kind: Measured) -> Option<&'static Self> {
        FORMATS.iter().find(|f| f.kind == kind)
    }

    /// Reads a file of it, and tells what it was taken for.
    pub(super) fn read(&self, path: &Path, budget: &Budget) -> Result<FileContent> {
        let bytes = whole(path)?;
        let mut content = (self.read)(&Whole { path, bytes: &bytes, budget })?;
        let text = format!("read as {}", self.kind.foreign().name);
        content.remarks.insert(0, Remark::of_file(text));
        Ok(content)
    }
}

/// Thirty times the largest that are published.
const MOST_BYTES: u64 = 1 << 30;

/// The bytes of the file at `path`.
///
/// Errors: io; limit above [`MOST_BYTES`].
fn whole(path: &Path) -> Result<Vec<u8>> {
    let io = |e: std::io::Error| Error::io(path.display(), &e);
    let mut bytes = Vec::new();
    File::open(path).map_err(io)?.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > MOST_BYTES {
        let text = format!("expected at most {MOST_BYTES} bytes, found more");
        return Err(Error::limit(text).context(path.display()));
    }
    Ok(bytes)
}

/// A file, whole.
pub(crate) struct Whole<'a> {
    pub(crate) path: &'a Path,
    pub(crate) bytes: &'a [u8],
    pub(super) budget: &'a Budget,
}

impl<'a> Whole<'a> {
    /// Its lines.
    fn lines(&self) -> Lines<'a> {
        Lines::of(self.path, self.bytes)
    }

    /// A format error about the file as a whole.
    pub(crate) fn error(&self, message: impl Into<String>) -> Error {
        Error::format(message).context(self.path.display())
    }
}
