//! Rate against distortion: which nodes of the finest tabulation a tree keeps.

use bsdfkit::Result;
use bsdfkit::tree::{TensorTree, TreeBuilder};
use rayon::prelude::*;

use super::fine::{Fine, Node, Subtree};

/// Bytes in the XML of one value inside a grid, of a leaf with its braces, and of a branch's braces.
/// Estimates for five significant digits; only their ratios steer pruning.
const VALUE_BYTES: f64 = 7.5;
const LEAF_BYTES: f64 = 9.5;
const BRANCH_BYTES: f64 = 3.0;

/// Contrast, in units of a Lambertian of equal flux, at which an error counts twice, so that
/// glare survives that carries little flux. A guess, not measured.
const GLARE: f64 = 200.0;

/// What a node costs when it becomes a leaf.
#[derive(Clone, Copy, Debug, Default)]
struct Distortion {
    /// Share of each incidence's flux that lies in a wrong place, mean over incidences: L1.
    error: f32,
    /// The same, large errors counted more.
    glare: f32,
}

/// What a subtree costs when it is pruned at best.
#[derive(Clone, Copy, Debug, Default)]
struct Choice {
    distortion: f64,
    bytes: f64,
    error: f64,
    values: usize,
    leaf: bool,
}

/// A pruned tree and what it costs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pruned {
    pub(super) lambda: f64,
    pub(super) error: f64,
    pub(super) values: usize,
    pub(super) bytes: f64,
}

/// A value seen from above: mean f, spread, weight.
struct Terminal {
    value: f64,
    spread: f64,
    /// Share of all incidences times projected solid angle.
    measure: f64,
    /// 1 / flux.
    inverse: f64,
}

impl Terminal {
    fn distortion(&self, mean: f64) -> (f64, f64) {
        let contrast = (self.value - mean).abs().max(self.spread) * self.inverse;
        let error = self.measure * contrast;
        (error, error * (1.0 + contrast * std::f64::consts::PI / GLARE))
    }
}

fn distortion(terminals: &[Terminal], mean: f64) -> Distortion {
    let (error, glare) = terminals
        .iter()
        .map(|t| t.distortion(mean))
        .fold((0.0, 0.0), |(e, g), (error, glare)| (e + error, g + glare));
    Distortion { error: error as f32, glare: glare as f32 }
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
        level: u32,
        z: usize,
        measured: &mut [Distortion],
        terminals: &mut Vec<Terminal>,
    ) {
        let node = subtree.nodes[at];
        let before = terminals.len();
        if node.first == 0 {
            terminals.push(Terminal {
                value: node.value.into(),
                spread: node.spread.into(),
                measure: self.measure_of(level),
                inverse: self.inverse[level as usize][z],
            });
        } else {
            let parts = self.fine.layout.incident_children();
            for c in 0..4 * parts {
                let child = node.first as usize + c;
                self.measure(subtree, child, level + 1, z * parts + c % parts, measured, terminals);
            }
        }
        measured[at] = distortion(&terminals[before..], node.value.into());
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
                            measure: self.measure_of(level + 1),
                            inverse: self.inverse[level as usize + 1][cz],
                        };
                        let (error, glare) = own.distortion(mean);
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

    /// The better of a leaf and of `children`, in place of both.
    fn choose(
        &self,
        leaf: Distortion,
        level: u32,
        children: Option<Choice>,
        lambda: f64,
    ) -> Choice {
        let leaf = Choice {
            distortion: leaf.glare.into(),
            bytes: LEAF_BYTES,
            error: leaf.error.into(),
            values: 1,
            leaf: true,
        };
        match children {
            Some(split)
                if level < self.deepest
                    && split.distortion + lambda * split.bytes
                        < leaf.distortion + lambda * leaf.bytes =>
            {
                split
            }
            _ => leaf,
        }
    }

    /// Prunes one subtree below `at`; marks which nodes split.
    fn prune(&self, k: usize, at: usize, level: u32, lambda: f64, split: &mut [bool]) -> Choice {
        let node = self.fine.subtrees[k].nodes[at];
        let children = (node.first != 0 && level < self.deepest).then(|| {
            let count = 4 * self.fine.layout.incident_children();
            join(
                (0..count)
                    .map(|c| self.prune(k, node.first as usize + c, level + 1, lambda, split)),
            )
        });
        let choice = self.choose(self.measured[k][at], level, children, lambda);
        split[at] = !choice.leaf;
        choice
    }

    /// Prunes the whole tree.
    fn prune_all(&self, lambda: f64) -> (Choice, Marks) {
        let top = self.fine.levels.top;
        let (mut choices, below): (Vec<Choice>, Vec<Vec<bool>>) = (0..self.fine.subtrees.len())
            .into_par_iter()
            .map(|k| {
                let mut split = vec![false; self.fine.subtrees[k].nodes.len()];
                (self.prune(k, 0, top, lambda, &mut split), split)
            })
            .unzip();
        let parts = self.fine.layout.incident_children();
        let mut above = Vec::new();
        for level in (0..top).rev() {
            let scattered = 1usize << (2 * level);
            let used =
                self.fine.layout.incident_cells(level + 1) / self.fine.layout.incident_cells(level);
            choices = (0..self.above[level as usize].len())
                .map(|k| {
                    let (z, s) = (k / scattered, k % scattered);
                    let children = join((0..4 * parts).map(|c| match c % parts {
                        i if i < used => {
                            choices[(z * parts + i) * 4 * scattered + 4 * s + c / parts]
                        }
                        _ => {
                            Choice { bytes: LEAF_BYTES, values: 1, leaf: true, ..Choice::default() }
                        }
                    }));
                    self.choose(self.above[level as usize][k].1, level, Some(children), lambda)
                })
                .collect();
            above.push(choices.iter().map(|c| !c.leaf).collect());
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
        // From "every value that changes anything" to "one leaf": L1 per byte.
        let (mut fine, mut coarse) = (-46.0f64, 4.0f64);
        let mut best = at(coarse);
        for _ in 0..STEPS {
            let middle = 0.5 * (fine + coarse);
            let tree = at(middle);
            let fits = tree.values <= max_values;
            if fits && (tree.error <= max_error || best.error > max_error) {
                best = tree;
            }
            if fits && tree.error > max_error { coarse = middle } else { fine = middle }
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
        if level == self.fine.levels.top {
            let k = z * scattered + s;
            return emit_node(
                &self.fine.subtrees[k].nodes,
                &marks.below[k],
                0,
                self.fine.layout.0.children(),
                to,
            );
        }
        if z >= self.fine.layout.incident_cells(level) {
            return to.leaf(0.0);
        }
        let k = z * scattered + s;
        if !marks.above[level as usize][k] {
            return to.leaf(self.above[level as usize][k].0 as f32);
        }
        to.open_branch()?;
        let parts = self.fine.layout.incident_children();
        for c in 0..4 * parts {
            let (cz, cs) = (z * parts + c % parts, 4 * s + c / parts);
            if cz >= self.fine.layout.incident_cells(level + 1) {
                to.leaf(0.0)?;
            } else {
                self.emit(marks, level + 1, cz, cs, to)?;
            }
        }
        to.close_branch()
    }
}

/// Bisections of λ over 50 powers of two: 0.02 powers, 1 % of the tree's size.
const STEPS: usize = 12;

/// Which nodes split, above and below the top level.
struct Marks {
    above: Vec<Vec<bool>>,
    below: Vec<Vec<bool>>,
}

fn emit_node(
    nodes: &[Node],
    split: &[bool],
    at: usize,
    count: usize,
    to: &mut TreeBuilder,
) -> Result<()> {
    if !split[at] {
        return to.leaf(nodes[at].value);
    }
    to.open_branch()?;
    for c in 0..count {
        emit_node(nodes, split, nodes[at].first as usize + c, count, to)?;
    }
    to.close_branch()
}

/// A branch of these children; all leaves make one grid.
fn join(children: impl Iterator<Item = Choice>) -> Choice {
    let (mut sum, mut leaves) = (Choice::default(), true);
    let mut count = 0.0;
    for c in children {
        sum.distortion += c.distortion;
        sum.bytes += c.bytes;
        sum.error += c.error;
        sum.values += c.values;
        leaves &= c.leaf;
        count += 1.0;
    }
    sum.bytes = BRANCH_BYTES + if leaves { VALUE_BYTES * count } else { sum.bytes };
    sum
}

/// Mean 1 / flux of the incident cells of every level; 0 for incidences that scatter next to nothing.
fn inverse_flux(fine: &Fine) -> Vec<Vec<f64>> {
    let parts = fine.layout.incident_children();
    let flux = fine.hemispherical();
    // A millionth of the mean flux: noise of the source's single precision.
    let least = 1e-6 * flux.iter().sum::<f64>() / flux.len() as f64;
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
