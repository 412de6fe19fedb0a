//! Tabulation: a continuous BSDF to tensor trees and Klems matrices. [WKB14 §2.3]
//!
//! Both are sampled by the same adaptive quadtree over scattered directions, four neighbouring
//! incidences at a time, and hold means over incident and scattered cell. What is stored already,
//! as a tree or a matrix, is a step function: its means over other cells are sums, and exact.

mod cells;
mod component;
mod distortion;
mod energy;
mod exchange;
mod fine;
mod klems;
mod layout;
mod marks;
mod measured;
mod missed;
mod mosaic;
mod overlap;
mod patches;
mod prune;
mod reciprocity;
mod recut;
mod regroup;
mod render;
mod reversed;
mod steps;
mod stored;
mod subtree_cost;
mod tree;
mod tree_hues;
mod tree_sampling;
mod tree_settings;
mod trend;

pub use component::{Form, Report, Tabulated, component};
pub use klems::{KlemsSettings, MatrixReport, klems_matrix};
pub use missed::{Limit, Missed};
pub use reciprocity::{AUTO_DISAGREEMENT, Reciprocity, disagreement};
pub use render::{RenderReport, RenderSettings, render_table};
pub use reversed::{reversed, stored_reversed};
pub use stored::{is_isotropic, reciprocal, stored};
pub use tree::tensor_tree;
pub use tree_settings::{TreeReport, TreeSettings};
