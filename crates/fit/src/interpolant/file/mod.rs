//! The container: named arrays.

pub(crate) mod arrays;
pub(crate) mod container;
pub(crate) mod pyramid;
pub(crate) mod spectra;
