//! What is wrong with a file, which program that breaks and how, and what can be mended.
//!
//! [`examine`] looks at the text and at what it says; each [`Finding`] has a place and a [`Kind`], one of
//! [`KINDS`]. [`mend`] writes the file anew without what can be mended.
//!
//! ```
//! use bsdfkit::xml::{Limits, doctor};
//!
//! # fn main() -> bsdfkit::Result<()> {
//! let file = std::fs::read("../../tests/golden/badxml/55_padded_wavelength.xml").unwrap();
//! let limits = Limits::default();
//! let found = doctor::examine(&file, &limits).findings;
//! let padded = found.iter().find(|f| f.kind.code == "padded-label").unwrap();
//! assert!(padded.kind.harm(doctor::Program::Radiance).is_some());
//!
//! let mended = doctor::mend(&file, &[], &limits)?;
//! let left = doctor::examine(&mended.bytes, &limits).findings;
//! assert!(left.iter().all(|f| f.kind.code != "padded-label"));
//! # Ok(())
//! # }
//! ```
//!
//! Source: what the programs do was measured on valid input; versions in the guide, `docs/guide/check.md`.

mod blocks;
mod catalogue;
mod description;
mod examine;
mod file;
mod form;
mod kind;
mod light;
mod mend;
mod program;
mod remedy;
mod words;

pub use catalogue::{KINDS, kind};
pub use examine::{Examination, Finding, examine};
pub use kind::{Harm, How, Kind, Mends};
pub use light::{ENERGY_TOLERANCE, Total, largest_total};
pub use mend::{Mended, mend};
pub use program::Program;
