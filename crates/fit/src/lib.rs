//! From goniophotometer measurement to BSDF: lobes, transport, interpolant, tabulation. [WKB14 §2.1–2.2]

pub mod deliver;
pub mod energyplus;
pub mod interpolant;
pub mod lobe;
pub mod measurement;
pub mod open;
pub mod rgl;
pub mod sir;
mod source;
pub mod survey;
pub mod tabulate;
pub mod validate;
mod watch;

pub use source::{Peak, Slice, Source};
pub use watch::{Progress, Watch};
