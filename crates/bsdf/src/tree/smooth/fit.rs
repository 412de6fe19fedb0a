//! Patches of a whole tree, from the means of neighbouring regions.

use rayon::prelude::*;

use super::super::node::{BRANCH, MAX_DEPTH, Rank, Slot, TensorTree};
use super::patch::Patch;

/// The largest logarithm of a ratio of neighbours that counts: e³ = 20. Measured: the error at
/// measured and held-out incidences is the same from 3 to 8, past the rim it rises.
const STEEPEST: f64 = 3.0;

/// How often a neighbour is halved to see what borders on the leaf. A leaf is large because little varies in it; by
/// the mean of a whole neighbour with a peak in it, it would rise towards that to three times its value. Measured,
/// at incidences never measured: brushed metal .0291, .0260, .0256 and .0259 with 0 to 3, fritted glass .0156, .0114,
/// .0108 and .0109, prism .0414, .0402, .0398 and .0399, rotated metal .0341 and then .0343.
const LAYERS: i32 = 2;

/// From this level on leaves at the rim of incidences are curved and twisted there, too: wider ones reach far inside, and what
/// two of them hold says little about the rim.
const NARROW: u32 = 6;

/// The x and the y factor of a leaf.
pub(super) type Patches = [Patch; 2];

/// A leaf: its slot, its corner in finest cells by dimension, incident ones first.
#[derive(Clone, Copy)]
struct Leaf {
    slot: u32,
    corner: [u16; 4],
}

/// Slots from the root's down, and their numbers.
type Way = [(u32, usize); MAX_DEPTH as usize + 1];

/// What the patches of smaller leaves are made from.
struct Fit<'a> {
    tree: &'a TensorTree,
    floor: f64,
    /// Mean below each branch.
    means: Vec<f32>,
    /// By slot; those of coarser leaves are there.
    patches: Vec<Patches>,
}

/// The patches of each leaf, by the number of its slot; `tree` is sound.
///
/// The logarithm of the 3 × 3 means around a leaf in each plane (incident, scattered) of an axis gives
/// its slopes, its curvatures and its twist. In a larger neighbour a region of the leaf's size counts, whose mean its
/// own patch gives: so large leaves go first. Of a divided one slopes and curvatures see the layer that borders on the
/// leaf.
///
/// Cost: 16 bytes a leaf, and 0.9 µs of one core.
pub(super) fn fit(tree: &TensorTree, floor: f64) -> Vec<Patches> {
    let mut levels = vec![Vec::new(); MAX_DEPTH as usize + 1];
    if let Slot::Branch(node) = tree.root() {
        collect(tree, node, [0; 4], 0, &mut levels);
    }
    let patches = vec![Patches::default(); tree.slots.len()];
    let mut fit = Fit { tree, floor, means: means(tree), patches };
    for (level, leaves) in levels.iter().enumerate() {
        let found: Vec<Patches> =
            leaves.par_iter().map(|leaf| fit.patches_of(*leaf, level as u32)).collect();
        for (leaf, patches) in leaves.iter().zip(found) {
            fit.patches[leaf.slot as usize] = patches;
        }
    }
    fit.patches
}

/// Finest cells along a side of a cell.
fn width(level: u32) -> u32 {
    (1 << MAX_DEPTH) >> level
}

/// Which of the two halves of each dimension a slot of a node is.
fn halves(rank: Rank, slot: usize) -> [u32; 4] {
    let bit = |n: usize| (slot >> n & 1) as u32;
    match rank {
        Rank::Three => [bit(2), bit(0), bit(1), 0],
        Rank::Four => [bit(2), bit(3), bit(0), bit(1)],
    }
}

fn collect(tree: &TensorTree, node: usize, corner: [u16; 4], level: u32, levels: &mut [Vec<Leaf>]) {
    let first = node * tree.rank.children();
    for (n, &slot) in tree.live_slots(node, level).iter().enumerate() {
        let halves = halves(tree.rank, n);
        let corner = std::array::from_fn(|d| corner[d] + (halves[d] * width(level + 1)) as u16);
        match Slot::from(slot) {
            Slot::Branch(node) => collect(tree, node, corner, level + 1, levels),
            Slot::Leaf(_) => {
                levels[level as usize + 1].push(Leaf { slot: (first + n) as u32, corner });
            }
        }
    }
}

/// Mean below each branch, by volume.
fn means(tree: &TensorTree) -> Vec<f32> {
    let n = tree.rank.children();
    let mut means = vec![0.0_f32; tree.branch_count()];
    // Children come after their parents.
    for node in (0..means.len()).rev() {
        let sum: f64 = tree.node(node).iter().map(|&slot| f64::from(mean(&means, slot))).sum();
        means[node] = (sum / n as f64) as f32;
    }
    means
}

fn mean(means: &[f32], slot: u32) -> f32 {
    match Slot::from(slot) {
        Slot::Leaf(value) => value,
        Slot::Branch(node) => means[node],
    }
}

impl Fit<'_> {
    fn patches_of(&self, leaf: Leaf, level: u32) -> Patches {
        let value = f64::from(f32::from_bits(self.tree.slots[leaf.slot as usize])) - self.floor;
        if value <= 0.0 {
            return Patches::default();
        }
        let incident = self.tree.rank.incident_dimensions() as usize;
        let corner = leaf.corner.map(u32::from);
        let way = self.way_to(corner, level);
        // The cell one on, and how many levels it has in common.
        let moved = |steps: &[(usize, i32)]| -> Option<([u32; 4], u32)> {
            let mut region = corner;
            let mut differing = 0;
            for &(d, step) in steps {
                let end = if d == 0 && incident == 1 { width(1) } else { width(0) };
                let moved = i64::from(region[d]) + i64::from(step) * i64::from(width(level));
                region[d] = u32::try_from(moved).ok().filter(|c| *c < end)?;
                differing |= region[d] ^ corner[d];
            }
            Some((region, differing.leading_zeros() - (u32::BITS - MAX_DEPTH)))
        };
        // Logarithm of a mean, relative to the leaf's.
        let log = |mean: f64| (mean / value).ln().clamp(-STEEPEST, STEEPEST);
        // From the middle of the leaf: how far away, in half cells, the neighbour's near layer is, and its
        // logarithm over that.
        let slope = |d: usize, step: i32| -> Option<(f64, f64)> {
            let (region, common) = moved(&[(d, step)])?;
            let (slot, at, reached) = self.descent(region, level, &way, common);
            let mut layers = 0;
            let mean = if slot & BRANCH != 0 {
                f64::from(self.layer(slot, d, step < 0, 0, &mut layers)) - self.floor
            } else {
                self.region(region, level, (slot, at, reached))
            };
            let distance = 1.0 + 0.5_f64.powi(layers);
            Some((distance, log(mean.max(0.0)) / distance))
        };
        let log_at = |steps: &[(usize, i32)]| {
            let (region, common) = moved(steps)?;
            Some(log(self.region(region, level, self.descent(region, level, &way, common))))
        };
        // At the rim of incidences: through the leaf and two cells on its one side. A line through one alone takes the flank of
        // a peak for a slope. What falls too steeply to tell is half of a peak.
        let one_sided = |d: usize, step: i32, (_, line): (f64, f64)| {
            if d >= incident || level < NARROW {
                return (f64::from(step) * line, 0.0);
            }
            let near = log_at(&[(d, step)]).unwrap_or(0.0);
            let far = match near <= -STEEPEST {
                true => 4.0 * near,
                false => log_at(&[(d, 2 * step)]).unwrap_or(2.0 * near),
            };
            (f64::from(step) * (4.0 * near - far) / 4.0, (far - 2.0 * near) / 8.0)
        };
        // Per half a cell, and per its square.
        let along = |d: usize| match (slope(d, -1), slope(d, 1)) {
            (Some((p, below)), Some((q, above))) => {
                let curve = (above + below) / (p + q);
                (above - curve * q, curve)
            }
            (Some(below), None) => one_sided(d, -1, below),
            (None, Some(above)) => one_sided(d, 1, above),
            (None, None) => (0.0, 0.0),
        };
        std::array::from_fn(|axis| {
            let (p, q) = (axis, incident + axis);
            let (slope_t, curve_t) = along(q);
            if axis >= incident {
                return Patch::of_logarithm([0.0, slope_t, 0.0, 0.0, curve_t]);
            }
            let (slope_s, curve_s) = along(p);
            // Of the corners of the largest rectangle about the leaf.
            let ends = |d: usize| {
                [-1, 1].map(|k| if level < NARROW || moved(&[(d, k)]).is_some() { k } else { 0 })
            };
            let ([a, b], [c, d]) = (ends(p), ends(q));
            let corner = |i, j| log_at(&[(p, i), (q, j)]);
            let twist = match (corner(b, d), corner(b, c), corner(a, d), corner(a, c)) {
                (Some(bd), Some(bc), Some(ad), Some(ac)) if a < b && c < d => {
                    (bd - bc - ad + ac) / f64::from(4 * (b - a) * (d - c))
                }
                _ => 0.0,
            };
            Patch::of_logarithm([slope_s, slope_t, twist, curve_s, curve_t])
        })
    }

    /// The slots on the way to a leaf, from the root's, and their numbers.
    fn way_to(&self, corner: [u32; 4], level: u32) -> Way {
        let mut way = [(self.tree.root, 0); MAX_DEPTH as usize + 1];
        for reached in 0..level {
            way[reached as usize + 1] = self.below(way[reached as usize].0, corner, reached);
        }
        way
    }

    /// The slot of a branch's part that holds a corner, and its number.
    fn below(&self, branch: u32, corner: [u32; 4], level: u32) -> (u32, usize) {
        let bit = |d: usize| ((corner[d] / width(level + 1)) & 1) as usize;
        let part = match self.tree.rank {
            Rank::Three => bit(1) | bit(2) << 1 | bit(0) << 2,
            Rank::Four => bit(2) | bit(3) << 1 | bit(0) << 2 | bit(1) << 3,
        };
        let at = (branch ^ BRANCH) as usize * self.tree.rank.children() + part;
        (self.tree.slots[at], at)
    }

    /// The slot that holds a cell, or that the cell is, its number and its level; the `way` leads to a cell that
    /// has its first `reached` levels in common.
    fn descent(
        &self,
        corner: [u32; 4],
        level: u32,
        way: &Way,
        mut reached: u32,
    ) -> (u32, usize, u32) {
        let (mut slot, mut at) = way[reached as usize];
        while slot & BRANCH != 0 && reached < level {
            (slot, at) = self.below(slot, corner, reached);
            reached += 1;
        }
        (slot, at, reached)
    }

    /// Mean of the part of a branch that is lowest, or `upper`most, in a dimension: a quarter thick where it is
    /// divided so far, else half. `layers`: how often it was halved.
    fn layer(&self, slot: u32, d: usize, upper: bool, depth: i32, layers: &mut i32) -> f32 {
        *layers = depth.max(*layers);
        if slot & BRANCH == 0 || depth == LAYERS {
            return mean(&self.means, slot);
        }
        let near = |(n, slot): (usize, &u32)| {
            let is_near = (halves(self.tree.rank, n)[d] == 1) == upper;
            is_near.then_some(*slot)
        };
        let slots = self.tree.node((slot ^ BRANCH) as usize).iter().enumerate().filter_map(near);
        let half = self.tree.rank.children() as f32 / 2.0;
        slots.map(|slot| self.layer(slot, d, upper, depth + 1, layers)).sum::<f32>() / half
    }

    /// Mean of value − floor over a cell, 0 at least; `found`: its [descent](Self::descent).
    fn region(&self, corner: [u32; 4], level: u32, found: (u32, usize, u32)) -> f64 {
        let rank = self.tree.rank;
        let (slot, at, reached) = found;
        let mut value = (f64::from(mean(&self.means, slot)) - self.floor).max(0.0);
        if reached < level && slot & BRANCH == 0 {
            // The centre of a cell within a larger leaf.
            let place = |d: usize| {
                let inside = f64::from(corner[d] % width(reached)) + 0.5 * f64::from(width(level));
                2.0 * inside / f64::from(width(reached)) - 1.0
            };
            let incident = rank.incident_dimensions() as usize;
            for (axis, patch) in self.patches[at].iter().enumerate() {
                let s = if axis < incident { place(axis) } else { 0.0 };
                value *= patch.at(s, place(incident + axis));
            }
        }
        value
    }
}
