//! Klems matrices: one value for each pair of patches. [K94], [WKB14 §2.4]

mod by_patch;
mod klems;
mod many;
#[expect(clippy::module_inception, reason = "the type is the matrix of this representation")]
mod matrix;
mod numbering;
mod reversed;
mod sample;

pub(crate) use by_patch::{BothSides, OneSide};
pub use klems::{KlemsBasis, Ring};
pub use matrix::KlemsMatrix;
