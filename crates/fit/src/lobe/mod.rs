//! Gaussian lobes fitted to each incidence. [WKB14 §2.2]

pub(crate) mod barycentre;
mod cells;
pub mod covariance;
pub mod detail;
pub(crate) mod exponential;
pub mod fit;
mod growth;
pub mod leaves;
pub mod lobe_set;
mod multilevel;
mod observed;
mod parameters;
mod refine;
mod sweeps;

pub use covariance::Covariance;
pub use lobe_set::{Lobe, LobeSet};
