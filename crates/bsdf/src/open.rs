//! A BSDF from any file that holds one, told apart by its content.

use std::io::Read;
use std::path::Path;

use crate::foreign::{self, Measured};
use crate::xml::{self, Limits};
use crate::{Bsdf, Error, Result, container, limits};

/// What the first bytes of a file look like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Markup: the XML of WINDOW and Radiance.
    Xml,
    /// A safetensors file: a compiled BSDF, or what [`container::kind`] says.
    Container,
    /// A measurement in a format of others.
    Measured(Measured),
    /// None of these.
    Other,
}

/// Bytes of a file that are looked at for what is read: markup may follow blank lines.
const HEAD: usize = 512;

impl Content {
    /// What the file at `path` holds; where its content tells nothing, what its suffix promises,
    /// so that the reader of that format says what is wrong.
    ///
    /// Errors: io; argument: no regular file; format: what [`foreign::recognise`] knows, named.
    pub fn of(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let mut head = Vec::new();
        let file = limits::open_file(path)?;
        file.take(foreign::HEAD)
            .read_to_end(&mut head)
            .map_err(|e| Error::io(path.display(), &e))?;
        if Self::of_bytes(&head) != Self::Container
            && let Some(found) = foreign::recognise(&head)
        {
            return match found.measured() {
                Some(measured) => Ok(Self::Measured(measured)),
                None => Err(found.refused().context(path.display())),
            };
        }
        let suffix = path.extension().unwrap_or_default();
        Ok(match Self::of_bytes(&head) {
            Self::Other if suffix.eq_ignore_ascii_case("xml") => Self::Xml,
            Self::Other if suffix.eq_ignore_ascii_case("safetensors") => Self::Container,
            content => content,
        })
    }

    /// What a file that starts with `head` holds.
    pub fn of_bytes(head: &[u8]) -> Self {
        // The length of a header, which no text has in place of its first bytes, and the header.
        if head.get(8) == Some(&b'{') && head[..8].contains(&0) {
            return Self::Container;
        }
        // Past a byte order mark, in one byte or two a character.
        let blank = |b: &u8| *b == 0 || b.is_ascii_whitespace() || *b >= 0x80;
        match head.iter().take(HEAD).find(|b| !blank(b)) {
            Some(b'<') => Self::Xml,
            _ => Self::Other,
        }
    }
}

impl Bsdf {
    /// Opens a regular file: a compiled BSDF or the XML of WINDOW and Radiance.
    ///
    /// A compiled BSDF stays in its file, which must not change meanwhile: [`container::open`].
    ///
    /// Errors: io; format and limit, as [`container::open`] and [`xml::read`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        match Content::of(path)? {
            Content::Container => container::open(path),
            Content::Measured(measured) => {
                Err(measured.foreign().refused().context(path.display()))
            }
            Content::Xml | Content::Other => xml::read(path),
        }
    }

    /// The same from the content of such a file.
    ///
    /// Errors: as [`Bsdf::open`], without io and without the file's name.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self> {
        match Content::of_bytes(bytes) {
            Content::Container => container::from_bytes(bytes),
            Content::Xml | Content::Measured(_) | Content::Other => {
                foreign::refuse(bytes)?;
                xml::from_bytes(bytes, &Limits::default()).map(|(bsdf, _)| bsdf)
            }
        }
    }
}
