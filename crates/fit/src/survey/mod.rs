//! What to measure next: the incident directions that take away most of the error to expect.

mod begin;
mod domain;
mod layout;
mod limits;
mod proposal;
mod rings;
mod scan_region;
mod state;

pub use begin::begin;
pub use limits::Limits;
pub use proposal::{Proposal, Subject, next, propose};
pub use scan_region::ScanRegion;
