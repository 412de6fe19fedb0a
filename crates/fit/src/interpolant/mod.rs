//! A continuous BSDF from sparse incidences by displacement interpolation. [WKB14 §2.2]
//!
//! The paper's steps: `incidence` (a measured incidence as lobes), `mesh` (who is whose neighbour), `motion` (plans along
//! edges, lobes that travel inside a cell), `answer` (f of one incident direction). Beside the paper: `field` (energy as a smooth
//! function), `facet` (peaks of prisms, and where peaks end), `choose` (which hypotheses hold), `component` (all put together),
//! `file` (the container).

mod answer;
mod choose;
pub mod component;
mod facet;
mod family;
mod field;
pub(crate) mod file;
mod incidence;
pub mod mesh;
pub mod motion;
mod whole;

pub use answer::continuous::Continuous;
pub use answer::distribution::Distribution;
pub use choose::build::{FitSettings, build};
pub use component::component::Component;
pub use component::coverage::{Coverage, Extent};
pub use component::fitted::Fitted;
pub use file::container::Encoding;
pub use incidence::fitted::FittedIncidence;
pub use mesh::chart::Chart;
pub use motion::hypothesis::Motion;
pub use whole::{DensePart, Interpolant, Part, SirPart};

pub use bsdfkit_measure::frame::Frame;

pub(crate) use field::multiquadric::Multiquadric;
