//! Rate against distortion: which nodes of the finest tabulation a tree keeps.

use bsdfkit::Result;
use bsdfkit::tree::{TensorTree, TreeBuilder};
use rayon::prelude::*;

use super::choice::{Choice, Shape};
use super::distortion::{Cell, Distortion, Terminal, distortion};
use super::fine::{Fine, Node, Subtree};
use super::trend::Trend;

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
    fine: &'a Fine,
    /// Deepest level of leaves.
    deepest: u32,
    /// 1 / flux by level and incident cell, Z order.
    inverse: Vec<Vec<f64>>,
    /// By subtree and node.
    measured: Vec<Vec<Distortion>>,
    /// Nodes above the subtrees by level, incident cell and scattered cell.
    above: Vec<Vec<(f64, Distortion)>>,
}

impl<'a> Pruner<'a> {
    pub(super) fn new(fine: &'a Fine, deepest: u32) -> Self {
        let mut pruner = Self {
            fine,
            deepest,
            inverse: inverse_flux(fine),
            measured: Vec::new(),
            above: Vec::new(),
        };
        let scattered = 1usize << (2 * fine.levels.top);
        pruner.measured = fine
            .subtrees
            .par_iter()
            .enumerate()
            .map(|(k, subtree)| {
                let mut measured = vec![Distortion::default(); subtree.nodes.len()];
                let mut terminals = Vec::new();
                pruner.measure(
                    subtree,
                    0,
                    Cell::WHOLE,
                    fine.levels.top,
                    k / scattered,
                    &mut measured,
                    &mut terminals,
                );
                measured
            })
            .collect();
        pruner.measure_above();
        pruner
    }

    /// Share of all incidences times projected solid angle that a cell of `level` has.
    fn measure_of(&self, level: u32) -> f64 {
        let incident = self.fine.layout.incident_cells(level) as f64;
        std::f64::consts::PI / (f64::from(1u32 << (2 * level)) * incident)
    }

    fn measure(
        &self,
        subtree: &Subtree,
        at: usize,
        cell: Cell,
        level: u32,
        z: usize,
        measured: &mut [Distortion],
        terminals: &mut Vec<Terminal>,
    ) {
        let node = subtree.nodes[at];
        let before = terminals.len();
        let trend = if node.first == 0 {
            terminals.push(Terminal {
                value: node.value.into(),
                spread: node.spread.into(),
                measure: self.measure_of(level),
                inverse: self.inverse[level as usize][z],
                centre: cell.centre,
            });
            Trend::even(node.value.into())
        } else {
            let parts = self.fine.layout.incident_children();
            let children = &subtree.nodes[node.first as usize..][..4 * parts];
            for c in 0..4 * parts {
                let (child, z) = (node.first as usize + c, z * parts + c % parts);
                self.measure(subtree, child, cell.child(c), level + 1, z, measured, terminals);
            }
            let mut means = [0.0; 16];
            for (mean, child) in means.iter_mut().zip(children) {
                *mean = child.value;
            }
            Trend::of_children(&means[..4 * parts])
        };
        measured[at] = distortion(&terminals[before..], cell, node.value.into(), &trend);
    }

    /// Nodes above the subtrees from their children: distortions of parts are not looked into,
    /// only how far their means differ; such nodes become leaves only where f is all but constant.
    fn measure_above(&mut self) {
        let (layout, top) = (self.fine.layout, self.fine.levels.top);
        let parts = layout.incident_children();
        let mut below: Vec<(f64, Distortion)> = self
            .fine
            .subtrees
            .iter()
            .zip(&self.measured)
            .map(|(subtree, measured)| (subtree.nodes[0].value.into(), measured[0]))
            .collect();
        let mut levels = Vec::new();
        for level in (0..top).rev() {
            let (incident, scattered) = (layout.incident_cells(level), 1usize << (2 * level));
            let used = layout.incident_cells(level + 1) / incident;
            let nodes: Vec<(f64, Distortion)> = (0..incident * scattered)
                .map(|k| {
                    let (z, s) = (k / scattered, k % scattered);
                    let children: Vec<_> = (0..4 * used)
                        .map(|c| (z * parts + c % used, 4 * s + c / used))
                        .map(|(cz, cs)| (cz, below[cz * 4 * scattered + cs]))
                        .collect();
                    let mean = children.iter().map(|c| c.1.0).sum::<f64>() / children.len() as f64;
                    let mut sum = Distortion::default();
                    for (cz, (value, d)) in children {
                        let own = Terminal {
                            value,
                            spread: 0.0,
                            centre: [0.0; 4],
                            measure: self.measure_of(level + 1),
                            inverse: self.inverse[level as usize + 1][cz],
                        };
                        let (error, glare) = own.distortion(mean, mean);
                        sum.error += d.error.max(error as f32);
                        sum.glare += d.glare.max(glare as f32);
                    }
                    (mean, sum)
                })
                .collect();
            levels.push(std::mem::replace(&mut below, nodes.clone()));
            if level == 0 {
                levels.push(nodes);
            }
        }
        levels.reverse();
        levels.truncate(top as usize);
        self.above = levels;
    }

    /// Prunes one subtree below `at`; notes what becomes of each node.
    fn prune(&self, k: usize, at: usize, level: u32, lambda: f64, shapes: &mut [Shape]) -> Choice {
        let (node, leaf) = (self.fine.subtrees[k].nodes[at], self.measured[k][at]);
        let mut choice = Choice::leaf(leaf);
        if node.first != 0 && level < self.deepest {
            let mut children = [(Distortion::default(), Choice::default()); 16];
            let children = &mut children[..4 * self.fine.layout.incident_children()];
            for (child, to) in (node.first as usize..).zip(children.iter_mut()) {
                *to = (self.measured[k][child], self.prune(k, child, level + 1, lambda, shapes));
            }
            choice = Choice::best(leaf, children, lambda);
        }
        shapes[at] = choice.shape;
        choice
    }

    /// Prunes the whole tree.
    fn prune_all(&self, lambda: f64) -> (Choice, Marks) {
        let top = self.fine.levels.top;
        let (mut choices, below): (Vec<Choice>, Vec<Vec<Shape>>) = (0..self.fine.subtrees.len())
            .into_par_iter()
            .map(|k| {
                let mut shapes = vec![Shape::Leaf; self.fine.subtrees[k].nodes.len()];
                (self.prune(k, 0, top, lambda, &mut shapes), shapes)
            })
            .unzip();
        let parts = self.fine.layout.incident_children();
        let mut above = Vec::new();
        for level in (0..top).rev() {
            let scattered = 1usize << (2 * level);
            let used =
                self.fine.layout.incident_cells(level + 1) / self.fine.layout.incident_cells(level);
            let child = |z: usize, s: usize, c: usize| match c % parts {
                part if part < used => {
                    let at = (z * parts + part) * 4 * scattered + 4 * s + c / parts;
                    (self.as_leaf(level + 1, at), choices[at])
                }
                _ => (Distortion::default(), Choice::leaf(Distortion::default())),
            };
            choices = (0..self.above[level as usize].len())
                .map(|k| {
                    let children: Vec<_> =
                        (0..4 * parts).map(|c| child(k / scattered, k % scattered, c)).collect();
                    let leaf = self.as_leaf(level, k);
                    match level < self.deepest {
                        true => Choice::best(leaf, &children, lambda),
                        false => Choice::leaf(leaf),
                    }
                })
                .collect();
            above.push(choices.iter().map(|c| c.shape).collect());
        }
        above.reverse();
        (choices[0], Marks { above, below })
    }

    /// What node `k` of `level`, at most the top one, costs as a leaf.
    fn as_leaf(&self, level: u32, k: usize) -> Distortion {
        match self.above.get(level as usize) {
            Some(nodes) => nodes[k].1,
            None => self.measured[k][0],
        }
    }

    /// Mean f over node `k` of `level`, at most the top one.
    fn mean(&self, level: u32, k: usize) -> f32 {
        match self.above.get(level as usize) {
            Some(nodes) => nodes[k].0 as f32,
            None => self.fine.subtrees[k].nodes[0].value,
        }
    }

    /// The smallest tree of at most `max_error` and `max_values`; when none has both, the one of
    /// least error within `max_values`.
    pub(super) fn search(&self, max_error: f64, max_values: usize) -> Pruned {
        let at = |exponent: f64| {
            let lambda = exponent.exp2();
            let choice = self.prune_all(lambda).0;
            Pruned { lambda, error: choice.error, values: choice.values, bytes: choice.bytes }
        };
        // How much larger a tree should be: less than 0 where it is too large, or better than asked for. Both
        // limits are aimed at from inside.
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
        let (_, marks) = self.prune_all(lambda);
        let mut builder = TreeBuilder::new(self.fine.layout.0);
        self.emit(&marks, 0, 0, 0, &mut builder)?;
        builder.finish()
    }

    fn emit(
        &self,
        marks: &Marks,
        level: u32,
        z: usize,
        s: usize,
        to: &mut TreeBuilder,
    ) -> Result<()> {
        let scattered = 1usize << (2 * level);
        let k = z * scattered + s;
        if level == self.fine.levels.top {
            let nodes = &self.fine.subtrees[k].nodes;
            return emit_node(nodes, &marks.below[k], 0, self.fine.layout.0.children(), to);
        }
        let shape = marks.above[level as usize][k];
        if shape == Shape::Leaf {
            return to.leaf(self.mean(level, k));
        }
        to.open_branch()?;
        let parts = self.fine.layout.incident_children();
        for c in 0..4 * parts {
            let (cz, cs) = (z * parts + c % parts, 4 * s + c / parts);
            if cz >= self.fine.layout.incident_cells(level + 1) {
                to.leaf(0.0)?;
            } else if shape == Shape::Grid {
                to.leaf(self.mean(level + 1, cz * 4 * scattered + cs))?;
            } else {
                self.emit(marks, level + 1, cz, cs, to)?;
            }
        }
        to.close_branch()
    }
}

/// Steps toward λ over 50 powers of two, every other of which halves what is left: 0.01 powers at worst.
const STEPS: usize = 24;

/// Natural logarithm of a tree's size, and powers of two of λ, that are close enough: 1 % of the size.
const CLOSE: f64 = 0.01;

/// What becomes of the nodes above and from the top level on.
struct Marks {
    above: Vec<Vec<Shape>>,
    below: Vec<Vec<Shape>>,
}

fn emit_node(
    nodes: &[Node],
    shapes: &[Shape],
    at: usize,
    count: usize,
    to: &mut TreeBuilder,
) -> Result<()> {
    if shapes[at] == Shape::Leaf {
        return to.leaf(nodes[at].value);
    }
    to.open_branch()?;
    for child in nodes[at].first as usize..nodes[at].first as usize + count {
        match shapes[at] {
            Shape::Grid => to.leaf(nodes[child].value)?,
            _ => emit_node(nodes, shapes, child, count, to)?,
        }
    }
    to.close_branch()
}

/// Share of the mean flux below which an incidence scatters nothing: noise of single precision.
pub(super) const LEAST_FLUX: f64 = 1e-6;

/// Mean 1 / flux of the incident cells of every level; 0 for incidences that scatter next to nothing.
fn inverse_flux(fine: &Fine) -> Vec<Vec<f64>> {
    let parts = fine.layout.incident_children();
    let flux = fine.hemispherical();
    let least = LEAST_FLUX * flux.iter().sum::<f64>() / flux.len() as f64;
    let inverse: Vec<f64> = flux.iter().map(|&h| if h > least { 1.0 / h } else { 0.0 }).collect();
    let mut levels =
        vec![inverse.iter().flat_map(|&v| std::iter::repeat_n(v, parts)).collect(), inverse];
    for level in (0..fine.levels.group).rev() {
        let below = &levels[levels.len() - 1];
        let used = fine.layout.incident_cells(level + 1) / fine.layout.incident_cells(level);
        levels.push(below.chunks(used).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect());
    }
    levels.reverse();
    levels
}

#[cfg(test)]
mod tests {
    use bsdfkit::tree::Rank;
    use proptest::prelude::*;

    use super::super::choice::{BRANCH_BYTES, LEAF_BYTES, VALUE_BYTES};
    use super::*;
    use crate::tabulate::fine::Levels;
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
        let leaf = |at: usize| f64::from(pruner.measured[0][at].glare);
        let nodes = &pruner.fine.subtrees[0].nodes;
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
            let pruner = Pruner::new(&fine, 8);
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
            let pruner = Pruner::new(&fine, 8);
            let found = pruner.search(0.0, most);
            prop_assert!(found.values <= most);
            for k in -40..0 {
                let other = pruner.prune_all(f64::from(k).exp2()).0;
                prop_assert!(other.values > most || other.values <= found.values);
            }
        }
    }
}
