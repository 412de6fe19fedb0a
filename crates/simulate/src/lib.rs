//! Analytic materials and a virtual goniophotometer: known truth for tests, demo and benches.

pub mod gonio;
pub mod material;
pub mod random;

pub use gonio::{Goniophotometer, Scan, Summary, write_measurements};
pub use material::{Material, SymmetryHint, registry, six};
