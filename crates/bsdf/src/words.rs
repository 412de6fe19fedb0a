//! Arrays of u32 in memory of their own or in a mapped file.
#![allow(unsafe_code)] // Mapping a file, and reading it in place: copying took 24 of 25 ms.

use std::fmt;
use std::fs::File;
use std::ops::{Deref, Range};
use std::sync::Arc;

use memmap2::Mmap;

/// A file in memory, shared by all arrays that lie in it.
pub(crate) fn map(file: &File) -> std::io::Result<Arc<Mmap>> {
    // SAFETY: the map is read-only and private to this process, and all that is read of it is
    // bytes and u32, valid whatever they are, each index being checked as it is used. A file that
    // another process overwrites meanwhile gives wrong values, one that it cuts short ends this process
    // by a signal: `container::open` says so. This library replaces files by renaming.
    unsafe { Mmap::map(file) }.map(Arc::new)
}

/// An immutable array of u32.
#[derive(Clone)]
pub(crate) enum Words {
    Owned(Vec<u32>),
    /// Little-endian and aligned bytes of a file.
    Mapped(Arc<Mmap>, Range<usize>),
}

impl Words {
    /// The bytes of a file in that range, in place if this machine can read them there.
    pub(crate) fn mapped(file: &Arc<Mmap>, range: Range<usize>) -> Self {
        let bytes = file.get(range.clone()).unwrap_or_default();
        if cfg!(target_endian = "little") && bytes.as_ptr().cast::<u32>().is_aligned() {
            Self::Mapped(file.clone(), range)
        } else {
            let words = bytes.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b));
            Self::Owned(words.collect())
        }
    }
}

impl Deref for Words {
    type Target = [u32];

    #[inline]
    fn deref(&self) -> &[u32] {
        match self {
            Self::Owned(words) => words,
            Self::Mapped(file, range) => {
                let bytes = file.get(range.clone()).unwrap_or_default();
                // SAFETY: any four bytes are a u32. The bytes are aligned: `mapped` has looked.
                unsafe { bytes.align_to().1 }
            }
        }
    }
}

impl From<Vec<u32>> for Words {
    fn from(words: Vec<u32>) -> Self {
        Self::Owned(words)
    }
}

impl PartialEq for Words {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl fmt::Debug for Words {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} words", self.len())
    }
}
