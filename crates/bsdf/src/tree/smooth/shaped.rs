//! A tree with the shapes of its leaves.

use super::super::lookup::quantise;
use super::super::node::{BRANCH, TensorTree, leaf_value};
use super::fit::Patches;
use super::patch::place;
use crate::DVec2;
use crate::lanes::Sense;

/// A tree whose leaves have shapes.
#[derive(Clone, Copy)]
pub(super) struct Shaped<'a> {
    pub(super) tree: &'a TensorTree,
    pub(super) patches: &'a [Patches],
    /// What all leaves exceed.
    pub(super) floor: f64,
}

impl Shaped<'_> {
    /// Value − floor of a leaf.
    #[inline]
    pub(super) fn excess(&self, slot: usize) -> f64 {
        let value = leaf_value(self.tree.slots.get(slot).copied().unwrap_or(0));
        (f64::from(value) - self.floor).max(0.0)
    }

    #[inline]
    pub(super) fn patches(&self, slot: usize) -> Patches {
        self.patches.get(slot).copied().unwrap_or_default()
    }

    /// f in a slot's leaf, at places in its cell.
    #[inline(always)]
    pub(super) fn value(&self, slot: usize, s: DVec2, t: DVec2) -> f64 {
        let value = f64::from(leaf_value(self.tree.slots.get(slot).copied().unwrap_or(0)));
        let [x, y] = self.patches(slot);
        let shape = x.at(s.x, t.x) * y.at(s.y, t.y);
        value + (value - self.floor).max(0.0) * (shape - 1.0)
    }

    pub(super) fn is_leaf(&self, slot: usize) -> bool {
        self.tree.slots[slot] & BRANCH == 0
    }

    /// The slots of the quadrants (x + 2y) of the sampled square, of one part of a node's known
    /// dimensions; the stored incident square is turned by half.
    #[inline]
    pub(super) fn quadrants(&self, sense: Sense, quad: usize) -> [usize; 4] {
        match sense {
            Sense::Forward => [0, 1, 2, 3].map(|n| 4 * quad + n),
            Sense::Reverse => [12, 8, 4, 0].map(|n| 16 * (quad / 4) + n + quad % 4),
        }
    }
}

/// A direction's place in its square (an incident one's in the interval, at rank 3), and its finest
/// cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known {
    pub(super) point: DVec2,
    pub(super) cell: [u32; 2],
}

impl Known {
    #[inline]
    pub(super) fn new(point: DVec2) -> Self {
        Self { point, cell: [quantise(point.x), quantise(point.y)] }
    }

    /// Place in its cell of a level, each coordinate −1 to 1.
    #[inline]
    pub(super) fn place(&self, level: u32) -> DVec2 {
        let [x, y] = self.cell;
        DVec2::new(place(self.point.x, x, level), place(self.point.y, y, level))
    }
}
