//! Measured BSDFs for renderers: tensor trees, Klems matrices, queries and files. [WKB14 §2.3–2.4]

pub mod error;

pub use bsdfkit_sphere::{DVec2, DVec3, Side};
pub use error::{Error, ErrorClass, Result};
