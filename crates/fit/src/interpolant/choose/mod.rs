//! Which hypotheses hold, by leaving incidences out.

pub(crate) mod build;
pub(crate) mod detector_shadow;
pub(crate) mod select;
