//! Finished stages of a fit, kept in a folder: what was killed goes on where it was.
//!
//! A stage is known by what it is made of: the measured points, the settings and the version of this library. Whatever is kept came from
//! the same computation, to the bit; so does what is made of it.

mod kept;
mod stage;
mod store;

pub(crate) use kept::{KeptComponent, KeptIncidence};
pub(crate) use stage::Stage;
pub use store::Cache;
