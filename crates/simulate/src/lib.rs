//! Analytic materials and a virtual goniophotometer: known truth for tests, demo and benches.
//!
//! ```
//! use bsdfkit_simulate::{Goniophotometer, Material, material::Fabric};
//!
//! let fabric = Fabric::default();
//! let scan = Goniophotometer::default().scan(&fabric, 45.0, 90.0);
//! let (wo, value) = (scan.wo[100], scan.values[100]);
//! assert!((value / fabric.eval(scan.wi, wo) - 1.0).abs() < 1e-9);
//! ```

pub mod gonio;
pub mod material;
pub mod random;
pub mod write;

pub use gonio::{Goniophotometer, Scan};
pub use material::{Material, SymmetryHint, every, registry, six, with_peaks};
pub use write::{Summary, write_measurements};
