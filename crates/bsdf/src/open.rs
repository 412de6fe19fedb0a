//! A BSDF from any file that holds one, told apart by its content.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::xml::{self, Limits};
use crate::{Bsdf, Error, Result, container};

/// A container starts with the length of its header, 8 bytes, and the header with this.
const HEADER: (usize, u8) = (8, b'{');

impl Bsdf {
    /// Opens a regular file: a compiled BSDF or the XML of WINDOW and Radiance.
    ///
    /// A compiled BSDF stays in its file, which must not change meanwhile: [`container::open`].
    ///
    /// Errors: io; format and limit, as [`container::open`] and [`xml::read`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let mut head = Vec::new();
        File::open(path)
            .and_then(|file| file.take(HEADER.0 as u64 + 1).read_to_end(&mut head))
            .map_err(|e| Error::io(path.display(), &e))?;
        if is_container(&head) { container::open(path) } else { xml::read(path) }
    }

    /// The same from the content of such a file.
    ///
    /// Errors: as [`Bsdf::open`], without io and without the file's name.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        if is_container(bytes) {
            container::from_bytes(bytes)
        } else {
            xml::from_bytes(bytes, &Limits::default()).map(|(bsdf, _)| bsdf)
        }
    }
}

/// XML has no zero byte before its ninth byte if that is a brace.
fn is_container(head: &[u8]) -> bool {
    head.get(HEADER.0) == Some(&HEADER.1) && head[..HEADER.0].contains(&0)
}
