//! The leaves that one direction meets.

use super::lookup::{Cell as Path, Incidence};
use super::node::{Rank, Slot, TensorTree};
use crate::cell::{Cell, MOST_CELLS, OUTLINE};
use crate::lanes::Sense;
use crate::{DVec2, DVec3};
use bsdfkit_sphere::concentric::{disk_to_square, square_to_disk};

/// A walk down the half of the dimensions that a known direction leaves open.
struct Leaves<'a> {
    tree: &'a TensorTree,
    path: Path,
    incidence: Incidence,
    sense: Sense,
    out: &'a mut Vec<Cell>,
}

impl TensorTree {
    /// Appends the leaves of one known direction; false where there are too many of them.
    pub(super) fn leaves_of(&self, known: DVec3, sense: Sense, out: &mut Vec<Cell>) -> bool {
        let incidence = Incidence::new(self.rank(), known);
        let path = match (self.rank(), sense) {
            (_, Sense::Forward) => incidence.cell(),
            (Rank::Four, Sense::Reverse) => Path::of(disk_to_square(known.truncate())),
            (Rank::Three, Sense::Reverse) => return true,
        };
        let mut leaves = Leaves { tree: self, path, incidence, sense, out };
        leaves.walk(self.root(), 0, [0, 0])
    }
}

impl Leaves<'_> {
    fn walk(&mut self, slot: Slot, level: u32, at: [u32; 2]) -> bool {
        let node = match slot {
            Slot::Branch(node) if level < self.tree.depth() => node,
            _ => {
                self.out.push(self.cell(level, at));
                return self.out.len() <= MOST_CELLS;
            }
        };
        let part = self.path.part(level);
        (0..4).all(|q| {
            let child = match self.sense {
                Sense::Forward => part << 2 | q,
                Sense::Reverse => q << 2 | part,
            };
            let below = Slot::from(self.tree.below(node, child));
            self.walk(below, level + 1, [at[0] << 1 | (q as u32 & 1), at[1] << 1 | (q as u32 >> 1)])
        })
    }

    /// The leaf whose lower corner is `at` in cells of its level.
    fn cell(&self, level: u32, at: [u32; 2]) -> Cell {
        let width = 0.5f64.powi(level as i32);
        let place = |x: f64, y: f64| {
            let square = DVec2::new(f64::from(at[0]) + x, f64::from(at[1]) + y) * width;
            match self.sense {
                Sense::Forward => self.incidence.disk_of(square),
                // The incident square is that of the travel direction.
                Sense::Reverse => -square_to_disk(square),
            }
        };
        let border = |k: usize| {
            const SIDE: usize = OUTLINE / 4;
            let along = (k % SIDE) as f64 / SIDE as f64;
            match k / SIDE {
                0 => place(along, 0.0),
                1 => place(1.0, along),
                2 => place(1.0 - along, 1.0),
                _ => place(0.0, 1.0 - along),
            }
        };
        Cell::of_disk(level, place(0.5, 0.5), border)
    }
}
