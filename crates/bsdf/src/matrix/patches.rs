//! The patches that one direction meets.

use super::matrix::{KlemsMatrix, basis_form};
use crate::DVec2;
use crate::DVec3;
use crate::cell::{Cell, OUTLINE};
use crate::klems::Patch;
use crate::lanes::Sense;

impl KlemsMatrix {
    /// Appends the patches of the other direction, if the known one is in the basis.
    pub(super) fn patches_of(&self, known: DVec3, sense: Sense, out: &mut Vec<Cell>) {
        let [(own, role), (basis, other)] = self.sides(sense);
        if own.index(basis_form(known, role)).is_none() {
            return;
        }
        out.extend((0..basis.directions()).map(|k| {
            let patch = Patch::new(basis, k);
            let whole = basis.extent(k).2 == 1;
            let place = |u: f64, v: f64| other.sign() * patch.at(DVec2::new(u, v));
            let border = |n: usize| {
                const HALF: usize = OUTLINE / 2;
                // A cap has no inner border.
                if whole {
                    return place(1.0, n as f64 / OUTLINE as f64);
                }
                let along = (n % HALF) as f64 / (HALF - 1) as f64;
                if n < HALF { place(1.0, along) } else { place(0.0, 1.0 - along) }
            };
            let middle = if whole { DVec2::ZERO } else { place(0.5, 0.5) };
            Cell::of_disk(k as u32, middle, border)
        }));
    }
}
