//! Tensor trees: adaptive piecewise constant BSDFs over the squares of Shirley and Chiu.
//! [WKB14 §2.3]

mod build;
mod cumulative;
mod deposit;
mod descent;
mod distribution;
mod flat;
mod hues;
mod leaves;
mod lookup;
mod loops;
mod node;
mod read_as;
mod ring;
mod smooth;
mod walk;

pub use build::TreeBuilder;
pub(crate) use cumulative::{Slices, Tables};
pub(crate) use deposit::{Change, Deposits};
pub use distribution::TreeDistribution;
pub use flat::FlatTree;
pub use hues::{Leaf, TreeHues};
pub use node::{MAX_DEPTH, MAX_NODES, Rank, Slot, TensorTree, TreeVisitor};
pub(crate) use read_as::read_as;
