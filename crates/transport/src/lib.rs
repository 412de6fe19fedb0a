//! The transportation problem: exact plans by network simplex. Knows no optics.
//!
//! [`network_simplex::solve`] moves all mass at least cost; [`partial::solve`] only what finds a
//! place near enough.
//!
//! ```
//! use bsdfkit_transport::{Problem, network_simplex};
//!
//! // Two heaps, two holes; moving from heap i to hole j costs cost[2 i + j] a unit.
//! let cost = [0.0, 1.0, 1.0, 0.0];
//! let plan = network_simplex::solve(&Problem::new(&[0.5, 0.5], &[0.25, 0.75], &cost)?);
//! assert!(plan.is_optimal() && (plan.cost(&cost) - 0.25).abs() < 1e-12);
//! # Ok::<(), bsdfkit_transport::Invalid>(())
//! ```

pub mod network_simplex;
pub mod partial;
pub mod plan;
pub mod problem;

pub use plan::{Flow, TransportPlan};
pub use problem::{Invalid, Problem};
