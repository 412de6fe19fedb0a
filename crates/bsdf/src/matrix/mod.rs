//! Klems matrices: one value for each pair of patches. [K94], [WKB14 §2.4]

mod by_patch;
mod deposit;
mod distribution;
mod loops;
#[expect(clippy::module_inception, reason = "the type is the matrix of this representation")]
mod matrix;
mod patches;
mod reversed;
mod sample;

pub use crate::klems::{KlemsBasis, Ring};
pub(crate) use by_patch::{BothSides, OneSide};
pub(crate) use deposit::deposits;
pub use matrix::KlemsMatrix;
