//! How far to trust an interpolant: every measured incidence predicted from the others.
//!
//! A left-out incidence is farther from its neighbours than any incident direction of the whole
//! mesh is from its own: what is found here is an upper bound of the usual error.

mod between;
mod error_model;
mod gap;
mod left_out;
mod peak;
mod validated;
mod validation;

pub use between::{TRUSTED, expected_between};
pub(crate) use error_model::POWER;
pub use error_model::{ErrorModel, Expected};
pub(crate) use gap::Gap;
pub use left_out::LeftOut;
pub use peak::PeakError;
pub(crate) use peak::{Peak, View};
pub use validated::Validated;
pub use validation::{Summary, Validation};
