//! Measured BSDFs for renderers: tensor trees, Klems matrices, queries and files. [WKB14 §2.3–2.4]

mod band;
pub mod batch;
pub mod bsdf;
mod canonical;
pub mod colour;
pub mod component;
pub mod container;
pub mod distribution;
pub mod encoding;
pub mod error;
pub mod foreign;
pub mod matrix;
pub mod metadata;
pub mod open;
pub mod query;
pub mod reciprocity;
pub mod render;
mod replace;
pub mod tree;
mod words;
pub mod xml;

pub use band::Band;
pub use bsdf::{Bsdf, Lambertian};
pub use bsdfkit_sphere::{DVec2, DVec3, Side};
pub use colour::Xyz;
pub use component::{Component, Components, Part};
pub use distribution::{Distribution, Lanes, Lookup, NEGLIGIBLE_TOTAL, Prepared, Sense};
pub use error::{Error, ErrorClass, Result};
pub use metadata::Metadata;
pub use open::Content;
pub use query::Sample;
pub use replace::replace_file;
