//! Klems bases, and how directions are numbered by them. [K94]

mod basis;
mod numbering;

pub(crate) use basis::Patch;
pub use basis::{KlemsBasis, Ring};
pub(crate) use numbering::{CHUNK, Chunk, NO_PATCH, SmallTable};
