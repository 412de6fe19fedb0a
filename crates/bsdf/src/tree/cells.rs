//! The leaves that light from one direction can reach.

use bsdfkit_sphere::concentric::{disk_to_square, square_to_disk};

use super::lookup::{Cell as Known, Incidence};
use super::node::{Rank, Slot, TensorTree};
use crate::cell::Cell;
use crate::lanes::Sense;
use crate::{DVec2, DVec3};

/// Chords along an edge as long as the square's: 4 degrees each.
const CHORDS: f64 = 24.0;

impl TensorTree {
    /// Leaves as cells of the other direction; none at rank 3 backward.
    pub(super) fn cells(&self, known: DVec3, sense: Sense) -> Vec<Cell> {
        let mut cells = Vec::new();
        match (sense, self.rank()) {
            (Sense::Forward, rank) => {
                let incidence = Incidence::new(rank, known);
                let number = |part, quadrant| part * 4 + quadrant;
                let at = |square| incidence.disk_of(square);
                self.gather(
                    self.root(),
                    0,
                    DVec2::ZERO,
                    incidence.cell(),
                    &number,
                    &at,
                    &mut cells,
                );
            }
            (Sense::Reverse, Rank::Four) => {
                let cell = Known::of(disk_to_square(known.truncate()));
                let number = |part, quadrant| quadrant * 4 + part;
                let at = |square| -square_to_disk(square);
                self.gather(self.root(), 0, DVec2::ZERO, cell, &number, &at, &mut cells);
            }
            (Sense::Reverse, Rank::Three) => {}
        }
        cells
    }

    /// `number` tells the slot of a branch from the part that the known direction is in and a quadrant of the other one.
    fn gather(
        &self,
        slot: Slot,
        level: u32,
        corner: DVec2,
        known: Known,
        number: &impl Fn(usize, usize) -> usize,
        at: &impl Fn(DVec2) -> DVec2,
        cells: &mut Vec<Cell>,
    ) {
        let width = 0.5_f64.powi(level.cast_signed());
        match slot {
            Slot::Leaf(value) => {
                let steps = (CHORDS * width).ceil() as usize;
                let square = [corner, corner + width];
                cells.push(Cell::new(value.into(), square, [steps; 2], at));
            }
            // Branches of a damaged tree may share what is below them.
            Slot::Branch(_) if level >= self.depth() || cells.len() > self.slots().len() => {}
            Slot::Branch(node) => {
                for quadrant in 0..4 {
                    let child = self.below(node, number(known.part(level), quadrant)).into();
                    let step = DVec2::new((quadrant & 1) as f64, (quadrant >> 1) as f64);
                    let corner = corner + step * (0.5 * width);
                    self.gather(child, level + 1, corner, known, number, at, cells);
                }
            }
        }
    }
}
