//! A continuous BSDF from sparse incidences by displacement interpolation. [WKB14 §2.2]

pub mod build;
pub mod component;
pub mod displace;
pub mod energy;
pub mod file;
pub mod frame;
pub mod incidence;
mod interpolant;
pub mod mesh;
mod multiquadric;
pub mod plan;
pub mod select;
pub mod sir;

pub use build::FitSettings;
pub use component::Component;
pub use frame::Frame;
pub use incidence::FittedIncidence;
pub use interpolant::{Interpolant, Part, SirPart};
