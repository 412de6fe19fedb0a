//! A continuous BSDF from sparse incidences by displacement interpolation. [WKB14 §2.2]

mod arrays;
mod blend;
pub mod build;
mod carried;
mod cells;
mod cliff;
pub mod component;
mod coverage;
pub mod displace;
mod distribution;
mod ending;
pub mod energy;
mod facet;
pub mod file;
mod follow;
pub mod frame;
pub mod incidence;

pub mod mesh;
pub mod motion;
mod moved;
mod mover;
mod multiquadric;
mod parts;
pub mod plan;
mod pyramid;
mod row;
pub mod select;
pub mod sir;
mod tracks;
mod unseen;

pub use build::FitSettings;
pub use component::Component;
pub use coverage::{Coverage, Extent};
pub use distribution::Distribution;
pub use file::Encoding;
pub use frame::Frame;
pub use incidence::FittedIncidence;
pub use motion::Motion;
pub use parts::{Interpolant, Part, SirPart};
