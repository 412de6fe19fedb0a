//! Catalogues of BSDFs: records beside files, search, sites for any web host, verified downloads.
//!
//! A [`Library`] is a folder of files, each with a [`Record`] beside it (who made the specimen, who measured it, under
//! which licence). It answers searches by words and by [`Look`], and [`site::build`] makes a
//! static site of it, from which [`get`](mod@get) fetches files and verifies them.
//!
//! ```
//! use bsdfkit_catalog::Record;
//!
//! # fn main() -> bsdfkit::Result<()> {
//! let record = Record::from_toml(r#"
//!     name = "Brushed aluminium"
//!     maker = "Example Metals"
//!     licence = "CC-BY-4.0"
//!     date = 2026-11-30
//! "#)?;
//! assert_eq!(record.date, "2026-11-30");
//! assert!(Record::from_toml(r#"licence = "free for all""#).is_err());
//! # Ok(())
//! # }
//! ```

mod entry;
pub mod exchange;
mod facts;
pub mod get;
mod hash;
mod index;
mod library;
mod look;
mod name;
mod picture;
mod query;
mod record;
mod scan;
pub mod site;

pub use entry::{Entry, StoredFile};
pub use facts::Facts;
pub use hash::Sha256;
pub use library::{Fault, Library};
pub use look::Look;
pub use picture::sphere;
pub use query::{Found, Query};
pub use record::Record;
