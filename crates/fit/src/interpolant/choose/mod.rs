//! Which hypotheses hold, by leaving incidences out.

pub(crate) mod build;
pub(crate) mod detector_shadow;
pub(crate) mod grooves;
mod left_out;
mod rim;
pub(crate) mod select;
