//! The arrays of a tree of luminance, for programs that read them in place: C, devices.

use super::TreeDistribution;
use crate::lanes::Sense;

/// A tree and its forward slices, as the [container](crate::container) stores them.
#[derive(Clone, Copy, Debug)]
pub struct FlatTree<'a> {
    /// 2^rank slots a branch.
    pub slots: &'a [u32],
    /// The slot of the whole hypercube.
    pub root: u32,
    /// Which slice a cell of the incident direction has.
    pub index: &'a [u32],
    /// Three words a slice.
    pub slices: &'a [u32],
    /// Eight words a record.
    pub records: &'a [u32],
}

impl TreeDistribution {
    /// The arrays of Y. Cost: makes the slices at the first call, unless they came with the file.
    pub fn flat(&self) -> FlatTree<'_> {
        let tree = self.luminance();
        let tables = self.slices(Sense::Forward).tables();
        FlatTree {
            slots: tree.slots(),
            root: tree.root_slot(),
            index: &tables.index,
            slices: &tables.slices,
            records: &tables.records,
        }
    }
}
