//! Spectra of a tree: coefficients of hue beside each leaf, of one basis.

use super::distribution::TreeDistribution;
use super::lookup::Key;
use super::node::{BRANCH, TensorTree};
use crate::lanes::Sense;
use crate::spectrum::{Basis, Hue};
use crate::words::Words;
use crate::{DVec3, Error, Result};

/// Coefficients of hue of the leaves of a tree of luminance, one byte each.
#[derive(Clone, Debug)]
pub struct TreeHues {
    pub(crate) hue: Hue,
    /// (slots, rank): a row a slot of the tree, one for a tree of one leaf; 0 to 255 for 0 to 1.
    pub(crate) coefficients: Words<u8>,
}

/// One leaf of a tree: a cell of incident directions and one of scattered ones, as wide as each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Leaf {
    /// Its row among [`TreeHues`].
    pub row: u32,
    /// Cells are 2^−level wide.
    pub level: u32,
    /// Z order of the incident cell: at rank 3 from grazing (0) to the normal.
    pub incident: u32,
    /// Z order of the scattered cell.
    pub scattered: u32,
}

impl TensorTree {
    /// All leaves that a direction can reach.
    pub fn leaf_cells(&self) -> Vec<Leaf> {
        let mut found = Vec::new();
        let whole = Leaf { row: 0, level: 0, incident: 0, scattered: 0 };
        self.add_leaves(self.root, whole, &mut found);
        found
    }

    /// Rows that [`TreeHues`] have of it.
    pub fn hue_rows(&self) -> usize {
        self.slots.len().max(1)
    }

    fn add_leaves(&self, slot: u32, at: Leaf, found: &mut Vec<Leaf>) {
        if slot & BRANCH == 0 {
            return found.push(at);
        }
        let node = (slot ^ BRANCH) as usize;
        let parts = self.rank.children() as u32 / 4;
        for (k, &below) in self.live_slots(node, at.level).iter().enumerate() {
            let k = k as u32;
            let below_at = Leaf {
                row: (node * self.rank.children()) as u32 + k,
                level: at.level + 1,
                incident: at.incident * parts + k / 4,
                scattered: at.scattered * 4 + k % 4,
            };
            self.add_leaves(below, below_at, found);
        }
    }
}

impl TreeHues {
    /// Those of coefficients as [`Hue::tell`] tells them, (rows, rank).
    ///
    /// Errors: argument, where one is not finite.
    pub fn new(hue: Hue, coefficients: &[f32]) -> Result<Self> {
        let hue = hue.of_all(std::iter::once(coefficients))?;
        let rank = hue.basis().rank();
        let byte =
            |(n, v): (usize, &f32)| (hue.stored(n % rank, f64::from(*v)) * 255.0).round() as u8;
        let coefficients: Vec<u8> = coefficients.iter().enumerate().map(byte).collect();
        Ok(Self { hue, coefficients: coefficients.into() })
    }

    /// How bands follow from luminance and coefficients.
    pub fn hue(&self) -> &Hue {
        &self.hue
    }

    /// f of all bands where the tree's luminance is `y`, 1/sr.
    fn bands(&self, tree: &TensorTree, y: f64, (wi, wo): (DVec3, DVec3), out: &mut [f64]) {
        let rank = self.hue.basis().rank();
        let row = tree.slot_of(Key::of(tree.rank, wi, wo)).map_or(0, |(slot, _)| slot);
        let mut stored = [0.0; Basis::MOST];
        let bytes = self.coefficients.get(row * rank..).unwrap_or_default();
        for (stored, byte) in stored.iter_mut().zip(bytes.iter().take(rank)) {
            *stored = f64::from(*byte) / 255.0;
        }
        self.hue.bands(y, &stored[..rank], out);
    }
}

/// Calls `f` for each pair of a known direction and another with its row of bands.
pub(super) fn each_pair(
    known: DVec3,
    other: &[DVec3],
    sense: Sense,
    out: &mut [f64],
    f: impl Fn(DVec3, DVec3, &mut [f64]),
) {
    let bands = (out.len() / other.len().max(1)).max(1);
    for (&w, out) in other.iter().zip(out.chunks_exact_mut(bands)) {
        match sense {
            Sense::Forward => f(known, w, out),
            Sense::Reverse => f(w, known, out),
        }
    }
}

impl TreeDistribution {
    /// The same with spectra beside its luminance.
    ///
    /// Errors: argument, unless there is a row for each slot of the tree.
    pub fn with_hues(mut self, hues: TreeHues) -> Result<Self> {
        let expected = self.luminance().hue_rows() * hues.hue.basis().rank();
        let found = hues.coefficients.len();
        if found != expected {
            return Err(Error::argument(format!(
                "hues: expected {expected} coefficients, a row a slot, found {found}"
            )));
        }
        self.hues = Some(hues);
        Ok(self)
    }

    /// Its spectra.
    pub fn hues(&self) -> Option<&TreeHues> {
        self.hues.as_ref()
    }

    /// f of all bands of a pair of directions whose luminance is `y`, 1/sr.
    pub(super) fn bands(&self, y: f64, wi: DVec3, wo: DVec3, out: &mut [f64]) {
        match &self.hues {
            Some(hues) if (wi + wo).truncate().is_finite() => {
                hues.bands(self.luminance(), y, (wi, wo), out);
            }
            _ => out.fill(f64::NAN),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::{Rank, TreeBuilder};

    /// Each leaf's row is where a look-up in its middle leads.
    #[test]
    fn leaves_are_found_where_they_are() {
        for rank in [Rank::Three, Rank::Four] {
            let mut b = TreeBuilder::new(rank);
            b.open_branch().unwrap();
            for child in 0..rank.children() {
                if child % 3 == 0 {
                    b.open_branch().unwrap();
                    (0..rank.children()).for_each(|k| b.leaf(k as f32).unwrap());
                    b.close_branch().unwrap();
                } else {
                    b.leaf(child as f32).unwrap();
                }
            }
            b.close_branch().unwrap();
            let tree = b.finish().unwrap();
            let leaves = tree.leaf_cells();
            let even = |z: u32| (0..8).map(|bit| (z >> (2 * bit) & 1) << bit).sum::<u32>();
            for leaf in &leaves {
                // In units of the finest cells, its middle.
                let place = |cell: u32| (2 * cell + 1) << (15 - leaf.level);
                let incident = match rank {
                    Rank::Three => [place(leaf.incident), 0],
                    Rank::Four => [place(even(leaf.incident)), place(even(leaf.incident >> 1))],
                };
                let scattered = [place(even(leaf.scattered)), place(even(leaf.scattered >> 1))];
                let found = tree.slot_of(Key::of_cells(incident, scattered)).unwrap();
                assert_eq!(found, (leaf.row as usize, leaf.level), "{leaf:?}");
            }
            let mut count = 0;
            tree.for_each_leaf(|_, _| count += 1);
            assert_eq!(leaves.len(), count);
        }
    }
}
