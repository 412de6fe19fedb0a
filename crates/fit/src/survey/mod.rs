//! What to measure next: the incident directions that take away most of the error to expect.

mod domain;
mod proposal;
mod scan;
mod state;

pub use proposal::{Limits, Proposal, Subject, propose};
pub use scan::ScanRegion;
