//! What `bsdf` does: one file a verb.

pub(crate) mod batch;
pub(crate) mod catalog;
pub(crate) mod check;
pub(crate) mod compile;
pub(crate) mod convert;
pub(crate) mod eval;
pub(crate) mod export;
pub(crate) mod fit;
pub(crate) mod hemispherical;
pub(crate) mod info;
pub(crate) mod panels;
pub(crate) mod pdf;
pub(crate) mod plan;
pub(crate) mod plot;
pub(crate) mod report;
pub(crate) mod sample;
pub(crate) mod simulate;
pub(crate) mod solid_angle;
pub(crate) mod validate;
pub(crate) mod view;
