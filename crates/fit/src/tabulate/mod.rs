//! Tabulation: a continuous BSDF to tensor trees and Klems matrices. [WKB14 §2.3]
//!
//! Both are sampled by the same adaptive quadtree over scattered directions, four neighbouring
//! incidences at a time, and hold means over incident and scattered cell.

mod choice;
mod component;
mod distortion;
mod exchange;
mod fine;
mod klems;
mod layout;
mod mosaic;
mod patches;
mod prune;
mod reciprocity;
mod source;
mod tree;
mod trend;
mod watch;

pub use component::{Form, Tabulated, component};
pub use klems::{KlemsSettings, klems_matrix};
pub use reciprocity::{AUTO_DISAGREEMENT, Reciprocity, disagreement};
pub use source::{Peak, Slice, Source};
pub use tree::{TreeReport, TreeSettings, tensor_tree};
pub use watch::{Progress, Watch};
