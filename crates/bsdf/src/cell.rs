//! The stored cells that light from one direction meets: leaves of a tree, patches of a matrix.

use crate::{Bsdf, DVec2, DVec3, Error, Result, Side};

/// Points along the outline of a [`Cell`].
pub const OUTLINE: usize = 32;

/// Cells of one direction that are looked at: leaves of a full tree of 2¹⁰ a side. More are a damaged file's.
pub(crate) const MOST_CELLS: usize = 1 << 20;

/// A region of directions that has one stored value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// A direction in it.
    pub middle: DVec3,
    /// Directions along its border, in order; the first follows the last.
    pub outline: [DVec3; OUTLINE],
    /// The level of a leaf, 0 the whole square; the number of a patch from 0.
    pub number: u32,
}

impl Cell {
    /// From projections (x, y), on the front.
    pub(crate) fn of_disk(number: u32, middle: DVec2, outline: impl Fn(usize) -> DVec2) -> Self {
        let up = |d: DVec2| d.extend((1.0 - d.length_squared()).max(0.0).sqrt());
        Self { middle: up(middle), outline: std::array::from_fn(|k| up(outline(k))), number }
    }

    fn on(mut self, side: Side) -> Self {
        self.middle = side.facing(self.middle);
        self.outline = self.outline.map(|w| side.facing(w));
        self
    }
}

impl Bsdf {
    /// The cells of all components that say where light from `wi` goes on side `scattered`.
    ///
    /// The value of a cell is `eval(wi, cell.middle)`, other components included. None of what is stored otherwise, nor of an isotropic tree
    /// of a transmission that was stored the other way: its leaves have no borders in these directions.
    ///
    /// Errors: limit, for more than 2²⁰ cells.
    /// Cost: 0.5 µs a cell.
    pub fn cells(&self, wi: DVec3, scattered: Side) -> Result<Vec<Cell>> {
        let mut all = Vec::new();
        if !wi.is_finite() {
            return Ok(all);
        }
        for (_, component, sense) in self.answering(Side::of(wi), scattered) {
            let distribution = component.distribution();
            let stored = distribution.stored().unwrap_or(distribution);
            if !stored.cells(wi, sense, &mut all) {
                return Err(Error::limit(format!(
                    "cells: expected at most {MOST_CELLS} for one direction"
                )));
            }
        }
        Ok(all.into_iter().map(|cell| cell.on(scattered)).collect())
    }
}
