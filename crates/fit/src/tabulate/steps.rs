//! Klems matrix → tensor tree: a step function, whose means over cells and errors are known exactly.
//!
//! A leaf's value is Σᵢ Σₒ aᵢ aₒ Mᵢₒ, a the shares of patches in its incident and scattered cell; its
//! error the same sum of |Mᵢₒ − value|. Leaves inside one pair of patches have none, so that leaves go to
//! edges, where they help most first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::tree::{Rank, TensorTree, TreeBuilder};
use bsdfkit::{Error, Result};

use super::missed::{Limit, Missed};
use super::overlap::Coverage;
use super::prune::LEAST_FLUX;
use super::tree::{TreeReport, TreeSettings};
use super::watch::Watch;

/// Deepest level unless another is asked for; and the deepest that may be asked for.
const DEPTHS: (u32, u32) = (8, 10);

/// Splits between two looks at whether to stop.
const PATIENCE: usize = 4096;

/// A matrix over the squares of both directions.
struct Steps {
    incident: Coverage,
    scattered: Coverage,
    columns: usize,
    /// f, with a row and a column of zeros for what lies beyond the bases.
    values: Vec<f64>,
    /// 1 / flux of each row, 0 where next to nothing is scattered.
    inverse: Vec<f64>,
}

/// A pair of cells that may be split; the largest error comes first, then the older node.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Bits of the error: those of positive numbers are in their order.
    error: u64,
    node: Reverse<u32>,
    level: u32,
    incident: u32,
    scattered: u32,
}

impl Candidate {
    fn error(&self) -> f64 {
        f64::from_bits(self.error)
    }
}

/// A leaf's value, or the first of 16 children.
#[derive(Clone, Copy)]
struct Node {
    value: f32,
    first: u32,
}

/// Klems matrix → tree of rank 4 of at most `max_leaves` values, of `max_error` if these suffice.
///
/// Meaning: leaves hold exact means, so integrals over any of the tree's cells are the matrix's; so are
/// those over a patch but for the leaves that cross its edges. `max_samples` and `reciprocity` do not count.
/// Accuracy: the stated L1 is exact.
/// Errors: argument for rank 3 and for an error that is none; limit for too deep a tree, or cancelled.
/// Cost: 1 µs a leaf.
pub(super) fn tree_of(
    matrix: &KlemsMatrix,
    settings: &TreeSettings,
    watch: &Watch<'_>,
) -> Result<(TensorTree, TreeReport)> {
    settings.check()?;
    if settings.rank == Some(Rank::Three) {
        return Err(Error::argument("tree: expected rank 4 for a matrix, found rank 3"));
    }
    let deepest = settings.max_depth.unwrap_or(DEPTHS.0);
    if deepest > DEPTHS.1 {
        return Err(Error::limit(format!(
            "tree: expected a depth of at most {} for a matrix, found {deepest}",
            DEPTHS.1
        )));
    }
    let (max_leaves, _) = settings.budget(Rank::Four, deepest);
    let steps = Steps::new(matrix, deepest);
    let (value, error) = steps.measure(0, 0, 0);
    let mut nodes = vec![Node { value, first: 0 }];
    let mut open = BinaryHeap::new();
    let root =
        Candidate { error: error.to_bits(), node: Reverse(0), level: 0, incident: 0, scattered: 0 };
    let (mut left, mut leaves, mut splits, mut cut) = (error, 1, 0usize, false);
    if deepest > 0 {
        open.push(root);
    }
    while left > settings.max_error {
        let Some(candidate) = open.pop().filter(|c| c.error > 0) else { break };
        if leaves + 15 > max_leaves {
            cut = true;
            break;
        }
        if splits.is_multiple_of(PATIENCE) {
            watch.check()?;
        }
        splits += 1;
        leaves += 15;
        let first = nodes.len() as u32;
        nodes[candidate.node.0 as usize].first = first;
        left -= candidate.error();
        let level = candidate.level + 1;
        for c in 0..16 {
            let incident = 4 * candidate.incident + c % 4;
            let scattered = 4 * candidate.scattered + c / 4;
            let (value, error) = steps.measure(level, incident, scattered);
            let node = nodes.len() as u32;
            nodes.push(Node { value, first: 0 });
            left += error;
            if level < deepest && error > 0.0 {
                let (error, node) = (error.to_bits(), Reverse(node));
                open.push(Candidate { error, node, level, incident, scattered });
            }
        }
    }
    let mut builder = TreeBuilder::new(Rank::Four);
    emit(&nodes, 0, &mut builder)?;
    let tree = builder.finish()?;
    // What is left after so many sums is rounding.
    let error = if left < 1e-12 { 0.0 } else { left };
    let limit = if cut { Limit::Leaves(max_leaves) } else { Limit::Depth(deepest) };
    let missed = Missed { target: settings.max_error, limit };
    let report = TreeReport {
        error,
        leaves,
        missed: (error > settings.max_error).then_some(missed),
        ..TreeReport::exact(&tree)
    };
    Ok((tree, report))
}

impl Steps {
    fn new(matrix: &KlemsMatrix, deepest: u32) -> Self {
        let incident = Coverage::new(matrix.incident(), deepest);
        let scattered = Coverage::new(matrix.scattered(), deepest);
        let (rows, basis) = (matrix.incident().directions() + 1, matrix.scattered());
        let columns = basis.directions() + 1;
        let mut values = vec![0.0; rows * columns];
        let mut fluxes = vec![0.0; rows];
        for (i, row) in matrix.values().chunks_exact(basis.directions()).enumerate() {
            for (o, &value) in row.iter().enumerate() {
                values[i * columns + o] = value.into();
                fluxes[i] += f64::from(value) * basis.projected_solid_angle(o);
            }
        }
        let mean = (0..rows - 1)
            .map(|i| fluxes[i] * matrix.incident().projected_solid_angle(i) / PI)
            .sum::<f64>();
        let inverse = |&flux: &f64| if flux > LEAST_FLUX * mean { 1.0 / flux } else { 0.0 };
        let inverse = fluxes.iter().map(inverse).collect();
        Self { incident, scattered, columns, values, inverse }
    }

    /// Mean f over a pair of cells, and what they contribute to L1 with that value.
    fn measure(&self, level: u32, incident: u32, scattered: u32) -> (f32, f64) {
        let rows = self.incident.of(level, incident as usize);
        let columns = self.scattered.of(level, scattered as usize);
        if let (&[(i, _)], &[(o, _)]) = (rows, columns) {
            return (self.values[i as usize * self.columns + o as usize] as f32, 0.0);
        }
        // ∫ g(f) over the scattered cell, for a row.
        let over = |i: u32, g: &dyn Fn(f64) -> f64| {
            let row = &self.values[i as usize * self.columns..][..self.columns];
            columns.iter().map(|&(o, share)| share * g(row[o as usize])).sum::<f64>()
        };
        let value: f64 = rows.iter().map(|&(i, share)| share * over(i, &|f| f)).sum();
        let error: f64 = rows
            .iter()
            .map(|&(i, share)| share * self.inverse[i as usize] * over(i, &|f| (f - value).abs()))
            .sum();
        // Rounding of a pair of cells where all values are the same.
        let error = if error * PI < 1e-12 { 0.0 } else { error };
        (value as f32, error * PI * (-4.0 * f64::from(level)).exp2())
    }
}

fn emit(nodes: &[Node], at: u32, to: &mut TreeBuilder) -> Result<()> {
    let node = nodes[at as usize];
    if node.first == 0 {
        return to.leaf(node.value);
    }
    to.open_branch()?;
    for child in node.first..node.first + 16 {
        emit(nodes, child, to)?;
    }
    to.close_branch()
}
