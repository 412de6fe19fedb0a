//! Rate against distortion: the λ whose tree is small or good enough.

use bsdfkit::Result;
use bsdfkit::tree::TensorTree;
use rayon::prelude::*;

use super::distortion::Distortion;
use super::fine::Fine;
use super::marks::Marks;
use super::measured::Measured;
use super::subtree_cost::{Shape, SubtreeCost};

/// A pruned tree and what it costs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pruned {
    pub(super) lambda: f64,
    pub(super) error: f64,
    pub(super) values: usize,
    pub(super) bytes: f64,
}

/// A finest tabulation whose nodes are measured, ready to be pruned at any λ.
pub(super) struct Pruner<'a> {
    measured: Measured<'a>,
    /// Deepest level of leaves.
    deepest: u32,
}

impl<'a> Pruner<'a> {
    /// `emphasis` as in [`Measured::of`].
    pub(super) fn new(fine: &'a Fine, deepest: u32, emphasis: &[f64]) -> Self {
        Self { measured: Measured::of(fine, emphasis), deepest }
    }

    /// Prunes one subtree below `at`; notes what becomes of each node.
    fn prune(
        &self,
        k: usize,
        at: usize,
        level: u32,
        lambda: f64,
        shapes: &mut [Shape],
    ) -> SubtreeCost {
        let (node, leaf) = (self.measured.fine.subtrees[k].nodes[at], self.measured.below[k][at]);
        let mut choice = SubtreeCost::leaf(leaf);
        if node.first != 0 && level < self.deepest {
            let mut children = [(Distortion::default(), SubtreeCost::default()); 16];
            let children = &mut children[..4 * self.measured.fine.layout.incident_children()];
            for (child, to) in (node.first as usize..).zip(children.iter_mut()) {
                *to = (
                    self.measured.below[k][child],
                    self.prune(k, child, level + 1, lambda, shapes),
                );
            }
            choice = SubtreeCost::best(leaf, children, lambda);
        }
        shapes[at] = choice.shape;
        choice
    }

    /// Prunes the whole tree.
    fn prune_all(&self, lambda: f64) -> (SubtreeCost, Marks) {
        let top = self.measured.fine.levels.top;
        let (mut choices, below): (Vec<SubtreeCost>, Vec<Vec<Shape>>) =
            (0..self.measured.fine.subtrees.len())
                .into_par_iter()
                .map(|k| {
                    let mut shapes = vec![Shape::Leaf; self.measured.fine.subtrees[k].nodes.len()];
                    (self.prune(k, 0, top, lambda, &mut shapes), shapes)
                })
                .unzip();
        let parts = self.measured.fine.layout.incident_children();
        let mut above = Vec::new();
        for level in (0..top).rev() {
            let scattered = 1usize << (2 * level);
            let used = self.measured.fine.layout.incident_cells(level + 1)
                / self.measured.fine.layout.incident_cells(level);
            let child = |z: usize, s: usize, c: usize| match c % parts {
                part if part < used => {
                    let at = (z * parts + part) * 4 * scattered + 4 * s + c / parts;
                    (self.measured.as_leaf(level + 1, at), choices[at])
                }
                _ => (Distortion::default(), SubtreeCost::leaf(Distortion::default())),
            };
            choices = (0..self.measured.above[level as usize].len())
                .map(|k| {
                    let children: Vec<_> =
                        (0..4 * parts).map(|c| child(k / scattered, k % scattered, c)).collect();
                    let leaf = self.measured.as_leaf(level, k);
                    match level < self.deepest {
                        true => SubtreeCost::best(leaf, &children, lambda),
                        false => SubtreeCost::leaf(leaf),
                    }
                })
                .collect();
            above.push(choices.iter().map(|c| c.shape).collect());
        }
        above.reverse();
        (choices[0], Marks { above, below })
    }

    /// The smallest tree of at most `max_error` and `max_values`; when none has both, the one of
    /// least error within `max_values`.
    pub(super) fn search(&self, max_error: f64, max_values: usize) -> Pruned {
        let at = |exponent: f64| {
            let lambda = exponent.exp2();
            let choice = self.prune_all(lambda).0;
            Pruned { lambda, error: choice.error, values: choice.values, bytes: choice.bytes }
        };
        // How much larger a tree should be: less than 0 where it is too large, or better than asked
        // for. Both limits are aimed at from inside.
        let room = |tree: &Pruned| {
            let [values, most] = [tree.values, max_values].map(|v| v as f64);
            let (size, error) = ((most / values).ln(), (tree.error / max_error).ln());
            (size - 0.5 * CLOSE).min(error + 0.5 * CLOSE)
        };
        // From "every value that changes anything" to "one leaf": L1 per byte.
        let (mut fine, mut coarse) = ((-46.0f64, f64::NAN), (4.0f64, f64::NAN));
        let (mut best, mut last) = (at(coarse.0), None);
        for _ in 0..STEPS {
            // Room is nearly linear in the exponent.
            let straight = fine.0 + (coarse.0 - fine.0) * fine.1 / (fine.1 - coarse.1);
            let inside = straight > fine.0 && straight < coarse.0;
            let next = if inside { straight } else { 0.5 * (fine.0 + coarse.0) };
            let tree = at(next);
            let (fits, room) = (tree.values <= max_values, room(&tree));
            if fits && (tree.error <= max_error || best.error > max_error) {
                best = tree;
            }
            let coarser = fits && tree.error > max_error;
            // An end that is kept twice counts half, so that it is not kept for ever. [DJ71]
            let (moved, kept) =
                if coarser { (&mut coarse, &mut fine) } else { (&mut fine, &mut coarse) };
            *moved = (next, room);
            if last.replace(coarser) == Some(coarser) {
                kept.1 *= 0.5;
            }
            if fits && room.abs() < 0.5 * CLOSE || coarse.0 - fine.0 < CLOSE {
                break;
            }
        }
        best
    }

    /// The tree pruned at `lambda`.
    pub(super) fn build(&self, lambda: f64) -> Result<TensorTree> {
        self.prune_all(lambda).1.tree(&self.measured)
    }
}

/// Steps toward λ over 50 powers of two, every other of which halves what is left: 0.01 powers at
/// worst.
const STEPS: usize = 24;

/// Natural logarithm of a tree's size, and powers of two of λ, that are close enough: 1 % of the
/// size.
const CLOSE: f64 = 0.01;

#[cfg(test)]
mod tests {
    use bsdfkit::tree::Rank;
    use proptest::prelude::*;

    use super::super::subtree_cost::{BRANCH_BYTES, LEAF_BYTES, VALUE_BYTES};
    use super::*;
    use crate::tabulate::fine::{Levels, Node, Subtree};
    use crate::tabulate::layout::Layout;

    /// Rank 3, four subtrees; the first has eight children, of which the first `split` have eight
    /// each, the others are one value. Values in 1/sr, the finest first.
    fn small(values: &[f32], split: usize) -> Fine {
        let mut values = values.iter().copied();
        let mut nodes = vec![Node::terminal(0.0, 0.0); 9 + 8 * split];
        for node in &mut nodes[1 + split..] {
            node.value = values.next().unwrap();
        }
        for k in (1..=split).chain([0]) {
            let first = if k == 0 { 1 } else { 9 + 8 * (k - 1) };
            nodes[k].first = first as u32;
            nodes[k].value = nodes[first..first + 8].iter().map(|n| n.value).sum::<f32>() / 8.0;
        }
        let mut subtrees = vec![Subtree { nodes }];
        subtrees.extend((0..3).map(|_| Subtree { nodes: vec![Node::terminal(0.5, 0.0)] }));
        let levels = Levels { top: 1, group: 2, start: 1 };
        Fine { layout: Layout(Rank::Three), levels, subtrees }
    }

    /// D + λR of the first subtree whose nodes split as `keep` says, from the definitions.
    fn cost(pruner: &Pruner<'_>, keep: &dyn Fn(usize) -> bool, lambda: f64) -> f64 {
        let leaf = |at: usize| f64::from(pruner.measured.below[0][at].weighted);
        let nodes = &pruner.measured.fine.subtrees[0].nodes;
        let splits = |at: usize| nodes[at].first != 0 && keep(at);
        if !splits(0) {
            return leaf(0) + lambda * LEAF_BYTES;
        }
        let grid = |at: usize| {
            let first = nodes[at].first as usize;
            let sum = (first..first + 8).map(leaf).sum::<f64>();
            sum + lambda * (BRANCH_BYTES + 8.0 * VALUE_BYTES)
        };
        if !(1..9).any(splits) {
            return grid(0);
        }
        let below = |at: usize| if splits(at) { grid(at) } else { leaf(at) + lambda * LEAF_BYTES };
        lambda * BRANCH_BYTES + (1..9).map(below).sum::<f64>()
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(200) })]

        /// Against every subtree that there is.
        #[test]
        fn pruning_is_optimal(
            values in prop::collection::vec(0.0f32..1.0, 72),
            split in 0usize..6,
            exponent in -16.0f64..-2.0,
        ) {
            let fine = small(&values, split);
            let pruner = Pruner::new(&fine, 8, &fine.alike());
            let lambda = exponent.exp2();
            let mut shapes = vec![Shape::Leaf; fine.subtrees[0].nodes.len()];
            let best = pruner.prune(0, 0, 1, lambda, &mut shapes);
            let least = (0..2usize << split)
                .map(|set| cost(&pruner, &|at| set >> at & 1 == 1, lambda))
                .fold(f64::INFINITY, f64::min);
            prop_assert!((best.lagrangian(lambda) - least).abs() <= 1e-9 * least);
            // What it states is what the tree has.
            let tree = pruner.build(lambda).unwrap();
            prop_assert_eq!(tree.leaf_count(), pruner.prune_all(lambda).0.values);
        }

        /// The largest tree of at most so many values, among those that some λ makes.
        #[test]
        fn budgets_are_honoured(values in prop::collection::vec(0.0f32..1.0, 72), most in 1usize..70) {
            let fine = small(&values, 5);
            let pruner = Pruner::new(&fine, 8, &fine.alike());
            let found = pruner.search(0.0, most);
            prop_assert!(found.values <= most);
            for k in -40..0 {
                let other = pruner.prune_all(f64::from(k).exp2()).0;
                prop_assert!(other.values > most || other.values <= found.values);
            }
        }
    }
}
