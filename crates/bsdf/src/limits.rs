//! What readers of untrusted files refuse to exceed, whatever the format.
//!
//! | what | at most | where |
//! |---|---|---|
//! | bytes of a container | 4 GiB | [`CONTAINER_BYTES`] |
//! | bytes of its header | 16 MiB | [`HEADER_BYTES`] |
//! | bytes of a file of others that is read whole (RGL, MERL, Zemax, …) | 512 MiB | [`MEASURED_BYTES`] |
//! | bytes of a line of text | 64 KiB | [`LINE_BYTES`] |
//! | magnitude of a number of a function | 10³⁰ | [`MAGNITUDE`] |
//! | bytes, elements, depths and counts of XML | as its fields say | [`xml::Limits`](crate::xml::Limits) |
//! | bytes of a Radiance interpolant | 256 MiB | `bsdfkit_represent::sir::SirLimits` |
//! | points of a measurement that are held at once | 2 GB; a fit: `--memory` | `bsdfkit_measure::ReadOptions` |
//! | incident directions and columns of a table | 20,000 and 2,000 | `bsdfkit_measure` |
//! | bytes of a record, of a catalogue's index, of a download | 64 KiB, 64 MiB, 1 GiB | `bsdfkit_catalog` |
//!
//! Memory is in proportion to bytes already read: a size that a file declares is held against its length first. What
//! goes past is an error that names the limit, of class [`Limit`](crate::ErrorClass::Limit) where the file could be sound
//! and of class [`Format`](crate::ErrorClass::Format) where it cannot. Only a regular file is opened by its path, for a
//! pipe or a device may never end ([`open_file`]).

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::{Error, Result};

/// Bytes of a container: a compiled BSDF, an interpolant.
pub const CONTAINER_BYTES: u64 = 4 << 30;

/// Bytes of a container's header; ours take kilobytes.
pub const HEADER_BYTES: u64 = 1 << 24;

/// Bytes of a measurement or a function of others that is read whole: five times the largest that are published.
pub const MEASURED_BYTES: u64 = 1 << 29;

/// Bytes of a line of a measurement: a binary file without a line end must not fill memory.
pub const LINE_BYTES: usize = 1 << 16;

/// Magnitude of numbers of which functions are made. No surface comes near: a peak a millionth of a degree wide has
/// f of 10¹⁵. Products of ten such numbers are finite.
pub const MAGNITUDE: f64 = 1e30;

/// Whether a number may be part of a function: none of more than [`MAGNITUDE`], no NaN.
pub fn is_plausible(x: f64) -> bool {
    x.abs() <= MAGNITUDE
}

/// Opens a regular file.
///
/// Errors: io: missing, unreadable, a directory; argument: a pipe, a device or a socket, which may never end.
pub fn open_file(path: impl AsRef<Path>) -> Result<File> {
    let path = path.as_ref();
    let io = |e: std::io::Error| Error::io(name_of(path), &e);
    // Before it is opened, which would wait for whoever writes to a pipe.
    let found = path.metadata().map_err(io)?;
    if found.is_dir() {
        return Err(io(std::io::ErrorKind::IsADirectory.into()));
    }
    if !found.is_file() {
        let text = "expected a regular file, found a pipe or a device: save its content to a file";
        return Err(Error::argument(text).context(name_of(path)));
    }
    File::open(path).map_err(io)
}

/// All bytes of a regular file, of which there may be `most`, whatever size it is said to have.
///
/// Errors: as [`open_file`]; limit.
pub fn read_file(path: impl AsRef<Path>, most: u64) -> Result<Vec<u8>> {
    let path = path.as_ref();
    let io = |e: std::io::Error| Error::io(name_of(path), &e);
    let file = open_file(path)?;
    let said = file.metadata().map_err(io)?.len();
    let mut bytes = Vec::with_capacity(said.min(most) as usize);
    // One byte more than allowed tells a file that is too long.
    file.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > most {
        let text = format!("expected at most {most} bytes, found more");
        return Err(Error::limit(text).context(name_of(path)));
    }
    Ok(bytes)
}

/// The last 200 characters of a path: enough to know the file by.
pub(crate) fn name_of(path: &Path) -> String {
    let name = path.display().to_string();
    let start = name.char_indices().rev().nth(199).map_or(0, |(at, _)| at);
    name[start..].to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ErrorClass;

    #[test]
    fn files_are_read_up_to_the_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        std::fs::write(&path, b"12345").unwrap();
        assert_eq!(read_file(&path, 5).unwrap(), b"12345");
        let error = read_file(&path, 4).unwrap_err();
        assert_eq!(error.class(), ErrorClass::Limit);
        assert!(error.to_string().ends_with("a: expected at most 4 bytes, found more"), "{error}");
        assert_eq!(read_file(folder.path(), 4).unwrap_err().class(), ErrorClass::Io);
    }

    /// A file that says that it is empty and is not.
    #[cfg(target_os = "linux")]
    #[test]
    fn the_size_that_is_said_is_not_believed() {
        let path = "/proc/self/status";
        assert_eq!(std::fs::metadata(path).unwrap().len(), 0);
        assert!(read_file(path, 1 << 16).unwrap().starts_with(b"Name:"));
        assert_eq!(read_file(path, 10).unwrap_err().class(), ErrorClass::Limit);
    }

    #[cfg(unix)]
    #[test]
    fn what_may_never_end_is_refused_at_once() {
        let error = read_file("/dev/zero", 4).unwrap_err();
        assert_eq!(error.class(), ErrorClass::Argument);
        assert!(error.to_string().contains("expected a regular file"), "{error}");
    }
}
