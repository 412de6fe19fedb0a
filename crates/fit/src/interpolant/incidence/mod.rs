//! One measured incidence as floor, lobes and detail.

pub(crate) mod fitted;
pub(crate) mod hues;
pub(crate) mod spectra;
