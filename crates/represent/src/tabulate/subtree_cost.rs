//! What becomes of a node of a tree, by what it costs and what it loses.

use super::distortion::Distortion;

/// Bytes in the XML of one value inside a grid, of a leaf with its braces, and of a branch's
/// braces. Estimates for five significant digits; only their ratios steer pruning.
pub(super) const VALUE_BYTES: f64 = 7.5;
pub(super) const LEAF_BYTES: f64 = 9.5;
pub(super) const BRANCH_BYTES: f64 = 3.0;

/// What becomes of a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Shape {
    #[default]
    Leaf,
    /// A branch of leaves, whatever its children would be by themselves.
    Grid,
    Branch,
}

/// What a subtree costs when it is pruned at best.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SubtreeCost {
    pub(super) distortion: f64,
    pub(super) bytes: f64,
    pub(super) error: f64,
    pub(super) values: usize,
    pub(super) shape: Shape,
}

impl SubtreeCost {
    pub(super) fn leaf(cost: Distortion) -> Self {
        Self {
            distortion: cost.weighted.into(),
            bytes: LEAF_BYTES,
            error: cost.error.into(),
            values: 1,
            shape: Shape::Leaf,
        }
    }

    pub(super) fn lagrangian(&self, lambda: f64) -> f64 {
        self.distortion + lambda * self.bytes
    }

    /// The best of a leaf, of a grid of leaves and of a branch of `children`, each given by its
    /// distortion as a leaf and its own best. The grid is a case of its own: its values cost less
    /// than leaves, so that it may be best where one child alone would rather split.
    pub(super) fn best(leaf: Distortion, children: &[(Distortion, Self)], lambda: f64) -> Self {
        let sum = |part: &dyn Fn(&(Distortion, Self)) -> Self, shape| {
            let none = Self { shape, bytes: BRANCH_BYTES, ..Self::default() };
            children.iter().map(part).fold(none, |sum, c| Self {
                distortion: sum.distortion + c.distortion,
                bytes: sum.bytes + c.bytes,
                error: sum.error + c.error,
                values: sum.values + c.values,
                shape,
            })
        };
        let value = |c: &(Distortion, Self)| Self { bytes: VALUE_BYTES, ..Self::leaf(c.0) };
        let mut best = Self::leaf(leaf);
        for other in [sum(&value, Shape::Grid), sum(&|c| c.1, Shape::Branch)] {
            if other.lagrangian(lambda) < best.lagrangian(lambda) {
                best = other;
            }
        }
        best
    }
}
