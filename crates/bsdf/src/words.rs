//! Arrays of u32, f32, half floats or bytes in memory of their own or in the bytes of a file.
#![allow(unsafe_code)] // Mapping a file, and reading it in place: copying took 24 of 25 ms.

use std::fmt;
use std::fs::File;
use std::io::Read;
use std::ops::{Deref, Range};
use std::sync::Arc;

use memmap2::Mmap;

/// The bytes of a file, shared by all arrays that lie in them.
#[derive(Debug)]
pub(crate) enum Bytes {
    Mapped(Mmap),
    Read(Vec<u8>),
}

/// Files up to this size are read: quicker than to map them, look at them and give them back (84 kB: 6
/// against 12 µs).
const SMALL: u64 = 1 << 18;

impl Bytes {
    /// All of a regular file.
    pub(crate) fn of(mut file: File) -> std::io::Result<Arc<Self>> {
        let length = file.metadata()?.len();
        if length <= SMALL {
            // To the end, it would take four more calls of the system.
            let mut bytes = vec![0; length as usize];
            file.read_exact(&mut bytes)?;
            return Ok(Arc::new(Self::Read(bytes)));
        }
        // SAFETY: the map is read-only and private to this process, and all that is read of it is
        // bytes, u32, f32 and half floats, valid whatever they are, each index being checked as it is used. A file that
        // another process overwrites meanwhile gives wrong values, one that it cuts short ends this process
        // by a signal: `container::open` says so. This library replaces files by renaming.
        unsafe { Mmap::map(&file) }.map(|map| Arc::new(Self::Mapped(map)))
    }
}

impl Deref for Bytes {
    type Target = [u8];

    #[inline]
    fn deref(&self) -> &[u8] {
        match self {
            Self::Mapped(map) => map,
            Self::Read(bytes) => bytes,
        }
    }
}

/// What so many little-endian bytes may be, whatever their bits.
pub(crate) trait Word: Copy {
    const BYTES: usize;

    /// Of as many bytes.
    fn from_bytes(bytes: &[u8]) -> Self;

    /// Appends its bytes.
    fn put(self, bytes: &mut Vec<u8>);
}

impl Word for u32 {
    const BYTES: usize = 4;

    fn from_bytes(bytes: &[u8]) -> Self {
        bytes.first_chunk().map_or(Self::default(), |b| Self::from_le_bytes(*b))
    }

    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Word for f32 {
    const BYTES: usize = 4;

    fn from_bytes(bytes: &[u8]) -> Self {
        bytes.first_chunk().map_or(Self::default(), |b| Self::from_le_bytes(*b))
    }

    fn put(self, bytes: &mut Vec<u8>) {
        bytes.extend(self.to_le_bytes());
    }
}

impl Word for u8 {
    const BYTES: usize = 1;

    fn from_bytes(bytes: &[u8]) -> Self {
        bytes.first().copied().unwrap_or_default()
    }

    fn put(self, bytes: &mut Vec<u8>) {
        bytes.push(self);
    }
}

/// An immutable array.
#[derive(Clone)]
pub(crate) enum Words<T: Word = u32> {
    Owned(Vec<T>),
    /// Little-endian and aligned bytes of a file.
    InPlace(Arc<Bytes>, Range<usize>),
}

impl<T: Word> Words<T> {
    /// The bytes of a file in that range, in place if this machine can read them there.
    pub(crate) fn in_place(file: &Arc<Bytes>, range: Range<usize>) -> Self {
        let bytes = file.get(range.clone()).unwrap_or_default();
        if cfg!(target_endian = "little") && bytes.as_ptr().cast::<T>().is_aligned() {
            Self::InPlace(file.clone(), range)
        } else {
            Self::copied(bytes)
        }
    }

    /// Memory of its own with what these bytes say.
    pub(crate) fn copied(bytes: &[u8]) -> Self {
        Self::Owned(bytes.chunks_exact(T::BYTES).map(T::from_bytes).collect())
    }
}

impl<T: Word> Deref for Words<T> {
    type Target = [T];

    #[inline]
    fn deref(&self) -> &[T] {
        match self {
            Self::Owned(words) => words,
            Self::InPlace(file, range) => {
                let bytes = file.get(range.clone()).unwrap_or_default();
                // SAFETY: any `BYTES` bytes, the size of the type, are a `Word`. These are aligned: `in_place` has looked.
                unsafe { std::slice::from_raw_parts(bytes.as_ptr().cast(), bytes.len() / T::BYTES) }
            }
        }
    }
}

impl<T: Word> From<Vec<T>> for Words<T> {
    fn from(words: Vec<T>) -> Self {
        Self::Owned(words)
    }
}

impl<T: Word + PartialEq> PartialEq for Words<T> {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
}

impl<T: Word> fmt::Debug for Words<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} words", self.len())
    }
}
