//! Families of peaks: lobes that follow a law of their own from incidence to incidence.

pub(crate) mod assign;
pub(crate) mod carried;
pub(crate) mod followed;
pub(crate) mod tracks;
