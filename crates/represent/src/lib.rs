//! What a continuous BSDF becomes: trees, matrices, the render form, tables of others. [WKB14 §2.3]
//!
//! A [`Source`] answers one incident direction at a time; [`tabulate`] stores it in the forms of
//! [`bsdfkit`]. [`rgl`] writes and reads the tables of Mitsuba's `measured`, [`energyplus`] whole
//! windows, [`sir`] reads Radiance's interpolants.

pub mod dense;
pub mod energyplus;
pub mod rgl;
pub mod sir;
mod source;
pub mod tabulate;
mod watch;

pub use dense::Dense;
pub use source::{Extent, Followed, Peak, Slice, Source};
pub use watch::{Progress, Watch};
