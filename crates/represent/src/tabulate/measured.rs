//! What every node of the finest tabulation loses as a leaf.

use rayon::prelude::*;

use super::distortion::{Cell, Distortion, Terminal, distortion};
use super::fine::{Fine, Subtree};
use super::trend::Trend;

/// A finest tabulation whose nodes are measured.
pub(super) struct Measured<'a> {
    pub(super) fine: &'a Fine,
    /// By subtree and node.
    pub(super) below: Vec<Vec<Distortion>>,
    /// Nodes above the subtrees by level, incident cell and scattered cell: mean f, and what they
    /// lose.
    pub(super) above: Vec<Vec<(f64, Distortion)>>,
}

impl<'a> Measured<'a> {
    /// `emphasis`: how much incidences count, by incident cell of the level below groups.
    pub(super) fn of(fine: &'a Fine, emphasis: &[f64]) -> Self {
        let measures =
            Measures { fine, inverse: inverse_flux(fine), emphasis: means(fine, emphasis) };
        let scattered = 1usize << (2 * fine.levels.top);
        let of = |(k, subtree): (usize, &Subtree)| {
            let mut measured = vec![Distortion::default(); subtree.nodes.len()];
            let (z, mut terminals) = (k / scattered, Vec::new());
            let top = fine.levels.top;
            measures.measure(subtree, 0, Cell::WHOLE, top, z, &mut measured, &mut terminals);
            measured
        };
        let below: Vec<_> = fine.subtrees.par_iter().enumerate().map(of).collect();
        let above = measures.above(&below);
        Self { fine, below, above }
    }

    /// What node `k` of `level`, at most the top one, costs as a leaf.
    pub(super) fn as_leaf(&self, level: u32, k: usize) -> Distortion {
        match self.above.get(level as usize) {
            Some(nodes) => nodes[k].1,
            None => self.below[k][0],
        }
    }

    /// Mean f over node `k` of `level`, at most the top one.
    pub(super) fn mean(&self, level: u32, k: usize) -> f32 {
        match self.above.get(level as usize) {
            Some(nodes) => nodes[k].0 as f32,
            None => self.fine.subtrees[k].nodes[0].value,
        }
    }
}

/// How much a cell counts.
struct Measures<'a> {
    fine: &'a Fine,
    /// 1 / flux by level and incident cell, Z order.
    inverse: Vec<Vec<f64>>,
    /// Likewise.
    emphasis: Vec<Vec<f64>>,
}

impl Measures<'_> {
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
                emphasis: self.emphasis[level as usize][z],
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
    fn above(&self, measured: &[Vec<Distortion>]) -> Vec<Vec<(f64, Distortion)>> {
        let (layout, top) = (self.fine.layout, self.fine.levels.top);
        let parts = layout.incident_children();
        let mut below: Vec<(f64, Distortion)> = self
            .fine
            .subtrees
            .iter()
            .zip(measured)
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
                            emphasis: self.emphasis[level as usize + 1][cz],
                        };
                        let (error, weighted) = own.distortion(mean, mean);
                        sum.error += d.error.max(error as f32);
                        sum.weighted += d.weighted.max(weighted as f32);
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
        levels
    }
}

/// Share of the mean flux below which an incidence scatters nothing: noise of single precision.
pub(super) const LEAST_FLUX: f64 = 1e-6;

/// Mean 1 / flux of the incident cells of every level; 0 for incidences that scatter next to
/// nothing.
fn inverse_flux(fine: &Fine) -> Vec<Vec<f64>> {
    let parts = fine.layout.incident_children();
    let flux = fine.hemispherical();
    let least = LEAST_FLUX * flux.iter().sum::<f64>() / flux.len() as f64;
    let inverse: Vec<f64> = flux.iter().map(|&h| if h > least { 1.0 / h } else { 0.0 }).collect();
    let finest: Vec<f64> = inverse.iter().flat_map(|&v| std::iter::repeat_n(v, parts)).collect();
    means(fine, &finest)
}

/// By level, the means of numbers that incident cells of the level below groups have.
fn means(fine: &Fine, finest: &[f64]) -> Vec<Vec<f64>> {
    let mut levels = vec![finest.to_vec()];
    for level in (0..=fine.levels.group).rev() {
        let below = &levels[levels.len() - 1];
        let used = below.len() / fine.layout.incident_cells(level);
        levels.push(below.chunks(used).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect());
    }
    levels.reverse();
    levels
}
