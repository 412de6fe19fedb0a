//! Measured BSDFs for renderers: tensor trees, Klems matrices, queries and files. [WKB14 §2.3–2.4]
//!
//! [`xml::read`] and [`container::open`] give a [`Bsdf`]; it answers five verbs, alone or many
//! directions at a time ([`batch`]), from any number of threads. Values of f are in 1/sr, without
//! cosine; directions are unit vectors that point away from the surface, front is z > 0.
//!
//! ```
//! use bsdfkit::{Components, DVec3, xml};
//!
//! # fn main() -> bsdfkit::Result<()> {
//! let bsdf = xml::read("../../tests/golden/xml/t4_rf_rb_tf_tb.xml")?;
//! let wi = DVec3::new(6.0, -2.0, 3.0) / 7.0;
//!
//! let total = bsdf.directional_hemispherical(wi, Components::ALL);
//! let reflected = bsdf.directional_hemispherical(wi, Components::REFLECTION);
//! assert!(0.0 < reflected && reflected < total);
//!
//! // One number decides where light goes; the weight of a tree's samples is always the total.
//! let sample = bsdf.sample(wi, 0.3, Components::ALL).expect("light is scattered");
//! assert!((sample.weight - total).abs() < 1e-6);
//! let f = bsdf.eval(wi, sample.wo);
//! assert!((f * sample.wo.z.abs() / sample.pdf - sample.weight).abs() < 1e-5);
//! # Ok(())
//! # }
//! ```
//!
//! What is decided where (frames, sides, units, orders) is in the project's CONVENTIONS.md.

mod band;
pub mod batch;
pub mod bsdf;
mod canonical;
mod cell;
pub mod colour;
pub mod component;
pub mod container;
pub mod distribution;
pub mod encoding;
pub mod error;
pub mod foreign;
mod klems;
mod lanes;
pub mod limits;
pub mod matrix;
pub mod metadata;
pub mod open;
pub mod query;
pub mod reciprocity;
pub mod render;
mod replace;
pub mod spectrum;
pub mod specular;
pub mod tree;
mod unit;
mod words;
pub mod xml;

pub use band::Band;
pub use bsdf::{Bsdf, Lambertian};
pub use bsdfkit_sphere::{DVec2, DVec3, Side};
pub use cell::{Cell, OUTLINE};
pub use colour::Xyz;
pub use component::{Component, Components, Part, Scatter};
pub use distribution::{Distribution, NEGLIGIBLE_TOTAL, Prepared};
pub use error::{Error, ErrorClass, Result};
pub use lanes::{Lanes, Lookup, Sense};
pub use metadata::Metadata;
pub use open::Content;
pub use query::Sample;
pub use replace::replace_file;
pub use specular::{Specular, SpecularPeak};
