//! Light that goes all one way, as narrow cells of a tree.

use std::collections::HashMap;

use super::TreeBuilder;
use super::lookup::Key;
use super::node::{MAX_DEPTH, Rank, Slot, TensorTree};
use crate::{DVec2, DVec3, Error, Result};
use bsdfkit_sphere::concentric::{disk_to_square, square_to_disk};

/// Points along each side of an incident cell whose light is followed.
const POINTS: usize = 4;
/// Light in the plane of incidence falls on the border of cells of rank 3: half of it to either side. About the normal all
/// of it to that side where direction cosines of 0 are looked up: Radiance, which asks with the ray as the scattered
/// direction, sees no other cell there ([`Incidence`](super::lookup)).
const BESIDE: f64 = 1e-6;
/// A leaf of at least this in [`TensorTree::beneath`] says that nothing was changed there. No BSDF is as large.
pub(crate) const UNCHANGED: f32 = 1e38;

/// What light adds to narrow cells: their keys, ascending, and values in 1/sr.
pub(crate) struct Deposits {
    depth: u32,
    cells: Vec<(Key, f64)>,
}

impl Deposits {
    /// Of light from each incident direction that goes where `to` says, a share of it: in cells 2^−`depth` wide, with the
    /// right energy from each incident cell. x and y of directions count, sides do not.
    pub(crate) fn new(rank: Rank, depth: u32, to: impl Fn(DVec3) -> Option<(DVec3, f64)>) -> Self {
        let cells = 1_usize << depth;
        let shift = MAX_DEPTH - depth;
        let size = std::f64::consts::PI / (cells * cells) as f64;
        let mut sums: HashMap<Key, f64> = HashMap::new();
        let mut add = |incident: [u32; 2], square: DVec2, share: f64| {
            let cell = |c: f64| ((c * cells as f64) as u32).min(cells as u32 - 1) << shift;
            let key = Key::of_cells(incident, [cell(square.x), cell(square.y)]);
            *sums.entry(key).or_default() += share / size;
        };
        let point =
            |cell: usize, k: usize| (cell as f64 + (k as f64 + 0.5) / POINTS as f64) / cells as f64;
        match rank {
            Rank::Three => {
                for cell in 0..cells / 2 {
                    for k in 0..POINTS {
                        let sine = 1.0 - 2.0 * point(cell, k);
                        let wi = DVec3::new(sine, 0.0, (1.0 - sine * sine).sqrt());
                        let Some((wo, share)) = to(wi) else { continue };
                        // The travel direction is turned to +X.
                        let square = disk_to_square(-wo.truncate());
                        let to_sides: &[f64] =
                            if cell == cells / 2 - 1 { &[BESIDE] } else { &[-BESIDE, BESIDE] };
                        for beside in to_sides {
                            let y = (square.y + beside).clamp(0.0, 1.0);
                            let share = share / (to_sides.len() * POINTS) as f64;
                            add([(cell as u32) << shift, 0], DVec2::new(square.x, y), share);
                        }
                    }
                }
            }
            Rank::Four => {
                for n in 0..cells * cells {
                    let (x, y) = (n / cells, n % cells);
                    for k in 0..POINTS * POINTS {
                        let square = DVec2::new(point(x, k / POINTS), point(y, k % POINTS));
                        let u = -square_to_disk(square);
                        let wi = u.extend((1.0 - u.length_squared()).max(0.0).sqrt());
                        let Some((wo, share)) = to(wi) else { continue };
                        let incident = [x, y].map(|c| (c as u32) << shift);
                        let share = share / (POINTS * POINTS) as f64;
                        add(incident, disk_to_square(wo.truncate()), share);
                    }
                }
            }
        }
        let mut cells: Vec<(Key, f64)> = sums.into_iter().collect();
        cells.sort_by_key(|c| c.0);
        Self { depth, cells }
    }

    /// The same with every value divided by that of the same cell in `by`.
    pub(crate) fn over(mut self, by: &Self) -> Self {
        for (one, other) in self.cells.iter_mut().zip(&by.cells) {
            one.1 /= other.1.max(f64::MIN_POSITIVE);
        }
        self
    }

    /// Of cells that are known: incident one, scattered one, value.
    pub(crate) fn of_cells(
        depth: u32,
        cells: impl Iterator<Item = ([u32; 2], [u32; 2], f64)>,
    ) -> Self {
        let finest = |cell: [u32; 2]| cell.map(|c| c << (MAX_DEPTH - depth));
        let mut cells: Vec<(Key, f64)> =
            cells.map(|(i, o, value)| (Key::of_cells(finest(i), finest(o)), value)).collect();
        cells.sort_by_key(|c| c.0);
        cells.dedup_by_key(|c| c.0);
        Self { depth, cells }
    }

    /// None.
    pub(crate) fn none(depth: u32) -> Self {
        Self { depth, cells: Vec::new() }
    }

    /// Both together.
    pub(crate) fn with(mut self, other: Self) -> Self {
        for (key, value) in other.cells {
            match self.cells.binary_search_by_key(&key, |c| c.0) {
                Ok(at) => self.cells[at].1 += value,
                Err(at) => self.cells.insert(at, (key, value)),
            }
        }
        self
    }
}

/// What becomes of the leaves of a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Change {
    /// The value is added.
    Added,
    /// The value stands instead.
    Replaced,
}

/// A part of the deposits: those of one cell.
type Here<'a> = &'a [(Key, f64)];

impl TensorTree {
    /// The tree with deposits in it.
    ///
    /// Errors: limit, for too many branches.
    pub(crate) fn deposited(&self, deposits: &Deposits, change: Change) -> Result<Self> {
        let mut out = TreeBuilder::new(self.rank());
        self.deposit(self.root(), 0, (&deposits.cells, deposits.depth), change, &mut out)?;
        out.finish()
    }

    fn deposit(
        &self,
        slot: Slot,
        level: u32,
        (here, depth): (Here<'_>, u32),
        change: Change,
        out: &mut TreeBuilder,
    ) -> Result<()> {
        if here.is_empty() {
            return self.visit_slot(slot, level, out);
        }
        if level >= depth {
            let value: f64 = here.iter().map(|c| c.1).sum();
            return self.change(slot, level, value, change, out);
        }
        out.open_branch()?;
        for child in 0..self.rank().children() {
            let here = part(here, level, self.rank().slot_of_child(child));
            self.deposit(self.child(slot, child), level + 1, (here, depth), change, out)?;
        }
        out.close_branch()
    }

    /// All leaves below a slot, changed alike.
    fn change(
        &self,
        slot: Slot,
        level: u32,
        value: f64,
        change: Change,
        out: &mut TreeBuilder,
    ) -> Result<()> {
        match slot {
            Slot::Leaf(leaf) => out.leaf(match change {
                Change::Added => (f64::from(leaf) + value).min(f64::from(f32::MAX)) as f32,
                Change::Replaced => value as f32,
            }),
            Slot::Branch(_) if level >= self.depth() => out.leaf(0.0),
            Slot::Branch(_) => {
                out.open_branch()?;
                for child in 0..self.rank().children() {
                    self.change(self.child(slot, child), level + 1, value, change, out)?;
                }
                out.close_branch()
            }
        }
    }

    /// What the tree holds where deposits change it; elsewhere a leaf of [`UNCHANGED`] or more.
    pub(crate) fn beneath(&self, deposits: &Deposits) -> Result<Self> {
        let mut out = TreeBuilder::new(self.rank());
        self.mark(self.root(), 0, (&deposits.cells, deposits.depth), &mut out)?;
        out.finish()
    }

    fn mark(
        &self,
        slot: Slot,
        level: u32,
        (here, depth): (Here<'_>, u32),
        out: &mut TreeBuilder,
    ) -> Result<()> {
        if here.is_empty() {
            return out.leaf(f32::MAX);
        }
        if level >= depth || matches!(slot, Slot::Leaf(_)) {
            return self.visit_slot(slot, level, out);
        }
        out.open_branch()?;
        for child in 0..self.rank().children() {
            let here = part(here, level, self.rank().slot_of_child(child));
            self.mark(self.child(slot, child), level + 1, (here, depth), out)?;
        }
        out.close_branch()
    }

    /// The tree without deposits, from what [`TensorTree::beneath`] said of it.
    ///
    /// Errors: argument, where both do not belong together.
    pub(crate) fn restored(&self, below: &Self) -> Result<Self> {
        if below.rank() != self.rank() {
            return Err(Error::argument("tree below peaks: expected the rank of the tree above"));
        }
        let mut out = TreeBuilder::new(self.rank());
        self.restore(self.root(), 0, (below, below.root()), &mut out)?;
        out.finish()
    }

    fn restore(
        &self,
        slot: Slot,
        level: u32,
        (below, mark): (&Self, Slot),
        out: &mut TreeBuilder,
    ) -> Result<()> {
        match (mark, slot) {
            (Slot::Leaf(value), _) if value >= UNCHANGED => self.visit_slot(slot, level, out),
            (Slot::Leaf(value), _) => out.leaf(value),
            (Slot::Branch(_), Slot::Leaf(_)) => Err(Error::argument(
                "tree below peaks: expected a branch wherever it has one, found a leaf",
            )),
            (Slot::Branch(_), Slot::Branch(_)) => {
                out.open_branch()?;
                for child in 0..self.rank().children() {
                    let mark = (below, below.child(mark, child));
                    self.restore(self.child(slot, child), level + 1, mark, out)?;
                }
                out.close_branch()
            }
        }
    }
}

/// Of the deposits of a branch those of one slot.
fn part(here: Here<'_>, level: u32, slot: usize) -> Here<'_> {
    let from = here.partition_point(|c| c.0.slot(level) < slot);
    let to = here.partition_point(|c| c.0.slot(level) <= slot);
    &here[from..to]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::TreeDistribution;
    use crate::{Distribution, Sense};
    use bsdfkit_sphere::direction::from_degrees;

    fn straight(wi: DVec3) -> Option<(DVec3, f64)> {
        Some((DVec3::new(-wi.x, -wi.y, -wi.z), 0.7))
    }

    #[test]
    fn the_energy_is_right_from_every_direction_and_comes_out_again() {
        for (rank, depth) in [(Rank::Three, 8), (Rank::Four, 5)] {
            let tree = TensorTree::constant(rank, 0.05).unwrap();
            let deposits = Deposits::new(rank, depth, straight);
            let above = tree.deposited(&deposits, Change::Added).unwrap();
            let both = TreeDistribution::new(above.clone());
            for k in 0..40 {
                let wi = from_degrees(f64::from(k) * 2.1, f64::from(k) * 53.0);
                let total = both.total(wi, Sense::Forward, 0.0);
                let expected = 0.7 + 0.05 * std::f64::consts::PI;
                assert!((total - expected).abs() < 1e-4, "{rank:?} {k}: {total}");
                assert!(both.value(wi, -wi) > 100.0, "{rank:?} {k}");
            }
            let below = tree.beneath(&deposits).unwrap();
            let back = TreeDistribution::new(above.restored(&below).unwrap());
            for k in 0..40 {
                let wi = from_degrees(f64::from(k) * 2.1, f64::from(k) * 53.0);
                assert_eq!(back.value(wi, -wi), f64::from(0.05_f32), "{rank:?} {k}");
            }
        }
    }

    /// As Radiance asks a tree of light at exactly normal incidence: with the scattered direction kept, and with the
    /// incident one.
    #[test]
    fn at_the_normal_one_cell_has_all_of_the_peak() {
        let deposits = Deposits::new(Rank::Three, 8, straight);
        let tree = TensorTree::constant(Rank::Three, 0.0).unwrap();
        let both = TreeDistribution::new(tree.deposited(&deposits, Change::Added).unwrap());
        let size = std::f64::consts::PI / f64::from(1 << 16);
        for k in 0..8 {
            let near = from_degrees(0.2, 45.0 * f64::from(k) + 1.0);
            let found = both.value(near, -DVec3::Z) * size;
            assert!((found - 0.7).abs() < 1e-3, "{k}: {found}");
        }
        let total = both.total(DVec3::Z, Sense::Forward, 0.0);
        assert!((total - 0.7).abs() < 1e-4, "{total}");
    }

    #[test]
    fn deposits_in_a_finer_tree_are_spread_and_come_out_bit_for_bit() {
        // Finer than the deposits everywhere.
        let values: Vec<f32> = (0..512).map(|k| 0.01 * k as f32).collect();
        let mut builder = TreeBuilder::new(Rank::Three);
        builder.grid(3, &values).unwrap();
        let tree = builder.finish().unwrap();
        let deposits = Deposits::new(Rank::Three, 2, straight);
        let above = tree.deposited(&deposits, Change::Added).unwrap();
        let [before, after] = [tree.clone(), above.clone()].map(TreeDistribution::new);
        for k in 0..40 {
            let wi = from_degrees(f64::from(k) * 2.1, 0.0);
            let [a, b] = [&before, &after].map(|d| d.total(wi, Sense::Forward, 0.0));
            assert!((b - a - 0.7).abs() < 1e-4, "{k}: {a} {b}");
        }
        assert_eq!(above.restored(&tree.beneath(&deposits).unwrap()).unwrap(), tree);
    }

    #[test]
    fn what_does_not_belong_together_is_refused() {
        let flat = TensorTree::constant(Rank::Three, 0.1).unwrap();
        let deposits = Deposits::new(Rank::Three, 2, straight);
        let mut builder = TreeBuilder::new(Rank::Three);
        builder.grid(1, &[0.5; 8]).unwrap();
        let below = builder.finish().unwrap().beneath(&deposits).unwrap();
        assert!(flat.restored(&below).is_err());
        let four = TensorTree::constant(Rank::Four, 0.1).unwrap();
        assert!(four.restored(&below).is_err());
    }
}
