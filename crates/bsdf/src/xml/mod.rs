//! The XML files of WINDOW and Radiance: Klems matrices and tensor trees.
//!
//! Differs from: Radiance: text is trimmed, entities never expand, faults are errors with a
//! place instead of silence, and blocks that are not understood survive a round trip.

mod angle_bases;
mod blocks;
mod decode;
mod document;
mod limits;
mod material;
mod numbers;
mod orientation;
mod read;
mod report;
mod scattering;
mod text;
mod write;

pub use limits::Limits;
pub use read::{from_bytes, read, read_with};
pub use report::Warning;
pub use write::{WriteOptions, write, write_to};
