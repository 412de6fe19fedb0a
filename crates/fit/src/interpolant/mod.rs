//! A continuous BSDF from sparse incidences by displacement interpolation. [WKB14 §2.2]

pub mod frame;
pub mod sir;
