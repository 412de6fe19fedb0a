//! Tensor trees: adaptive piecewise constant BSDFs over the squares of Shirley and Chiu.
//! [WKB14 §2.3]

mod build;
mod cumulative;
mod descent;
mod distribution;
mod flat;
mod lookup;
mod node;
mod ring;
mod smooth;
mod walk;

pub use build::{MAX_NODES, TreeBuilder};
pub(crate) use cumulative::{Slices, Tables};
pub use distribution::TreeDistribution;
pub use flat::FlatTree;
pub use node::{MAX_DEPTH, Rank, Slot, TensorTree, TreeVisitor};
