//! The transportation problem: exact plans by network simplex. Knows no optics.
//!
//! [`network_simplex::solve`] moves all mass at least cost; [`partial::solve`] only what finds a
//! place near enough.

pub mod network_simplex;
pub mod partial;
pub mod plan;
pub mod problem;

pub use plan::{Flow, TransportPlan};
pub use problem::{Invalid, Problem};
