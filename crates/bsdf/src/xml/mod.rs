//! The XML files of WINDOW and Radiance: Klems matrices and tensor trees.
//!
//! Differs from: Radiance: text is trimmed, entities never expand, faults are errors with a
//! place instead of silence, bands other than Visible are read, and blocks that are not understood
//! survive a round trip. With a dummy block beside it a transmission is reversed with its constant part.
//!
//! ```
//! use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
//! use bsdfkit::xml::{Limits, WriteOptions, from_bytes, write_to};
//! use bsdfkit::{Bsdf, Component, Components, DVec3, Lambertian, Metadata, Side};
//!
//! # fn main() -> bsdfkit::Result<()> {
//! let basis = KlemsBasis::quarter();
//! let matrix = KlemsMatrix::new(basis.clone(), basis, vec![0.1; 41 * 41])?;
//! let shade = Component::new(Side::Front, Side::Back, matrix);
//! let bsdf = Bsdf::new(Metadata::default(), vec![shade], Lambertian::default());
//! let mut file = Vec::new();
//! write_to(&bsdf, &mut file, &WriteOptions::default())?;
//!
//! let (read, warnings) = from_bytes(&file, &Limits::default())?;
//! assert!(warnings.is_empty());
//! let total = read.directional_hemispherical(DVec3::Z, Components::TRANSMISSION);
//! assert!((total - 0.1 * std::f64::consts::PI).abs() < 1e-6);
//! # Ok(())
//! # }
//! ```

mod angle_bases;
mod assemble;
mod blocks;
mod content;
mod decimal;
mod decode;
mod description;
pub mod doctor;
mod document;
mod kept;
mod limits;
mod material;
mod numbers;
mod orientation;
mod placeholders;
mod read;
mod report;
mod scattering;
mod specular;
mod text;
mod write;

pub use limits::Limits;
pub use placeholders::{placeholder, placeholders, set_property};
pub use read::{bytes_of, from_bytes, read, read_with};
pub use report::Warning;
pub use write::{WriteOptions, write, write_to};
