//! Klems matrix → tensor tree: a step function, whose means over cells and errors are known
//! exactly.
//!
//! A leaf's value is Σᵢ Σₒ aᵢ aₒ Mᵢₒ, a the shares of patches in its incident and scattered cell;
//! its error the same sum of |Mᵢₒ − value|. Leaves inside one pair of patches have none, so that
//! leaves go to edges, where they help most first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::tree::{Rank, TensorTree, TreeBuilder};
use bsdfkit::{Error, Result};

use super::measured::LEAST_FLUX;
use super::missed::{Limit, Missed};
use super::overlap::{Coverage, Shares};
use super::tree_settings::{TreeReport, TreeSettings};
use crate::watch::Watch;

/// Deepest level unless another is asked for; and the deepest that may be asked for.
const DEPTHS: (u32, u32) = (8, 10);

/// Splits between two looks at whether to stop.
const PATIENCE: usize = 4096;

/// Share of `max_error` by which the total of an incident patch may be off, where leaves are left.
/// A guess: at 1 totals of a matrix that L1 calls smooth err by 2 % in the outermost ring.
const TOTALS: f64 = 0.5;

/// A matrix over the squares of both directions.
struct Steps {
    incident: Coverage,
    scattered: Coverage,
    columns: usize,
    /// f, with a row and a column of zeros for what lies beyond the bases.
    values: Vec<f64>,
    /// 1 / flux of each row, 0 where next to nothing is scattered.
    inverse: Vec<f64>,
    /// The same over the share of the incident square that the row has.
    weights: Vec<f64>,
}

/// A pair of cells of one level.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Cell {
    level: u32,
    incident: u32,
    scattered: u32,
}

impl Cell {
    const WHOLE: Self = Self { level: 0, incident: 0, scattered: 0 };

    fn child(self, c: u32) -> Self {
        Self {
            level: self.level + 1,
            incident: 4 * self.incident + c % 4,
            scattered: 4 * self.scattered + c / 4,
        }
    }
}

/// A leaf that may be split; the largest gain comes first, then the older node.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Candidate {
    /// Bits of what is to be gained: those of positive numbers are in their order.
    gain: u64,
    node: Reverse<u32>,
    cell: Cell,
    /// Bits of the error as a leaf.
    error: u64,
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
/// Meaning: leaves hold exact means, so integrals over any of the tree's cells are the matrix's; so
/// are those over a patch but for the leaves that cross its edges. The total of each incident patch
/// is kept to half of `max_error`, too, if leaves are left for it. `max_samples` and `reciprocity`
/// do not count.
/// Accuracy: the stated L1 is exact.
/// Errors: argument for rank 3 and for an error that is none; limit for too deep a tree, or
/// cancelled.
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
    let steps = Steps::new(matrix, deepest);
    let (max_leaves, _) = settings.budget(Rank::Four, deepest, false);
    let mut growth = Growth::new(&steps, deepest, max_leaves, watch);
    growth.toward_error(settings.max_error)?;
    let full = growth.full;
    growth.toward_totals(TOTALS * settings.max_error)?;
    let mut builder = TreeBuilder::new(Rank::Four);
    emit(&growth.nodes, 0, &mut builder)?;
    let tree = builder.finish()?;
    // What is left after so many sums is rounding.
    let error = if growth.error < 1e-12 { 0.0 } else { growth.error };
    let limit = if full { Limit::Leaves(max_leaves) } else { Limit::Depth(deepest) };
    let missed = Missed { target: settings.max_error, limit };
    let report = TreeReport {
        error,
        missed: (error > settings.max_error).then_some(missed),
        ..TreeReport::exact(&tree)
    };
    Ok((tree, report))
}

/// A tree that grows where it gains most.
struct Growth<'a> {
    steps: &'a Steps,
    deepest: u32,
    max_leaves: usize,
    watch: &'a Watch<'a>,
    nodes: Vec<Node>,
    open: BinaryHeap<Candidate>,
    leaves: usize,
    /// L1 of all leaves.
    error: f64,
    /// By row: how much more the tree scatters than the matrix, as a share.
    surplus: Vec<f64>,
    /// Whether there was no leaf left for a split.
    full: bool,
}

impl<'a> Growth<'a> {
    fn new(steps: &'a Steps, deepest: u32, max_leaves: usize, watch: &'a Watch<'a>) -> Self {
        let mut growth = Self {
            steps,
            deepest,
            max_leaves,
            watch,
            nodes: Vec::new(),
            open: BinaryHeap::new(),
            leaves: 0,
            error: 0.0,
            surplus: vec![0.0; steps.inverse.len()],
            full: false,
        };
        let root = growth.leaf(Cell::WHOLE);
        growth.open.extend(root);
        growth
    }

    /// A new leaf; a candidate if a split may help it.
    fn leaf(&mut self, cell: Cell) -> Option<Candidate> {
        let (value, error) = self.steps.measure(cell);
        let node = Reverse(self.nodes.len() as u32);
        self.nodes.push(Node { value: value as f32, first: 0 });
        self.leaves += 1;
        self.error += error;
        self.steps.for_each_surplus(cell, value, |row, share| self.surplus[row] += share);
        let error = error.to_bits();
        let candidate = Candidate { gain: error, node, cell, error };
        (cell.level < self.deepest && error > 0).then_some(candidate)
    }

    /// Splits a leaf; its children that may be split, too. `None` where no leaf is left.
    ///
    /// Errors: limit when cancelled.
    fn split(&mut self, leaf: Candidate) -> Result<Option<Vec<Candidate>>> {
        if self.leaves + 15 > self.max_leaves {
            self.full = true;
            return Ok(None);
        }
        if self.nodes.len() % (16 * PATIENCE) == 1 {
            self.watch.check()?;
        }
        let first = self.nodes.len() as u32;
        let node = &mut self.nodes[leaf.node.0 as usize];
        node.first = first;
        let value = node.value.into();
        self.leaves -= 1;
        self.error -= leaf.error();
        self.steps.for_each_surplus(leaf.cell, value, |row, share| self.surplus[row] -= share);
        Ok(Some((0..16).filter_map(|c| self.leaf(leaf.cell.child(c))).collect()))
    }

    /// Splits until L1 is at most `most`, the largest error first: by gains, looked up one level
    /// ahead, L1 would be 1 % less.
    fn toward_error(&mut self, most: f64) -> Result<()> {
        while self.error > most {
            let Some(leaf) = self.open.pop() else { break };
            let Some(children) = self.split(leaf)? else { break };
            self.open.extend(children);
        }
        Ok(())
    }

    /// Splits until the total of every row is within `most` of the matrix's, as a share.
    fn toward_totals(&mut self, most: f64) -> Result<()> {
        let gain = |growth: &Self, leaf: Candidate| {
            let mut gain = 0.0f64;
            let value = growth.nodes[leaf.node.0 as usize].value.into();
            growth.steps.for_each_surplus(leaf.cell, value, |row, share| {
                if growth.surplus[row].abs() > most {
                    gain = gain.max(share * growth.surplus[row].signum());
                }
            });
            gain.to_bits()
        };
        let open = std::mem::take(&mut self.open);
        let mut open: BinaryHeap<Candidate> =
            open.into_iter().map(|leaf| Candidate { gain: gain(self, leaf), ..leaf }).collect();
        while let Some(leaf) = open.pop().filter(|leaf| leaf.gain > 0) {
            let now = gain(self, leaf);
            if now < leaf.gain {
                open.push(Candidate { gain: now, ..leaf });
                continue;
            }
            let Some(children) = self.split(leaf)? else { break };
            for child in children {
                open.push(Candidate { gain: gain(self, child), ..child });
            }
        }
        Ok(())
    }
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
        let inverse: Vec<f64> = fluxes.iter().map(inverse).collect();
        let mut weights = inverse.clone();
        for (i, weight) in weights[..rows - 1].iter_mut().enumerate() {
            *weight *= PI / matrix.incident().projected_solid_angle(i);
        }
        Self { incident, scattered, columns, values, inverse, weights }
    }

    /// Mean f over a pair of cells, and what they contribute to L1 with that value.
    fn measure(&self, cell: Cell) -> (f64, f64) {
        let rows = self.incident.of(cell.level, cell.incident as usize);
        let columns = self.scattered.of(cell.level, cell.scattered as usize);
        if let (&[(i, _)], &[(o, _)]) = (rows, columns) {
            return (self.values[i as usize * self.columns + o as usize], 0.0);
        }
        let value: f64 = rows.iter().map(|&(i, share)| share * self.over(i, columns, |f| f)).sum();
        let error = |&(i, share): &(u32, f64)| {
            share * self.inverse[i as usize] * self.over(i, columns, |f| (f - value).abs())
        };
        let error = PI * rows.iter().map(error).sum::<f64>();
        // Rounding of a pair of cells where all values are the same.
        let error = if error < 1e-12 { 0.0 } else { error };
        (value, error * (-4.0 * f64::from(cell.level)).exp2())
    }

    /// Mean g(f) over the scattered cell of `columns`, in a row.
    fn over(&self, row: u32, columns: &Shares, g: impl Fn(f64) -> f64) -> f64 {
        let row = &self.values[row as usize * self.columns..][..self.columns];
        columns.iter().map(|&(o, share)| share * g(row[o as usize])).sum()
    }

    /// What a leaf of `value` scatters more than the matrix, as a share of the flux of each row in
    /// it.
    fn for_each_surplus(&self, cell: Cell, value: f64, mut f: impl FnMut(usize, f64)) {
        let rows = self.incident.of(cell.level, cell.incident as usize);
        let columns = self.scattered.of(cell.level, cell.scattered as usize);
        // Alone, a row has what it should.
        for &(i, share) in rows.iter().filter(|_| rows.len() > 1) {
            let excess = value - self.over(i, columns, |f| f);
            let measure = PI * (-4.0 * f64::from(cell.level)).exp2() * share;
            f(i as usize, excess * measure * self.weights[i as usize]);
        }
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
