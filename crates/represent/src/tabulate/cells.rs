//! The cells of a stored tree, by level and number.

use bsdfkit::tree::{Rank, Slot, TensorTree};

use super::layout::Layout;

/// A cell of a tree: incident and scattered cell of one level, numbered in Z order.
#[derive(Clone, Copy)]
pub(super) struct TreeCell {
    pub(super) level: u32,
    pub(super) incident: usize,
    pub(super) scattered: usize,
}

impl TreeCell {
    pub(super) const WHOLE: Self = Self { level: 0, incident: 0, scattered: 0 };

    /// Child `child` in the tree's order; `None` where rank 3 has no incident directions.
    pub(super) fn child(self, rank: Rank, child: usize) -> Option<Self> {
        let parts = Layout(rank).incident_children();
        let incident = self.incident * parts + child % parts;
        let level = self.level + 1;
        let used = incident < Layout(rank).incident_cells(level);
        used.then_some(Self { level, incident, scattered: 4 * self.scattered + child / parts })
    }
}

/// Calls `f` with every leaf down to level `deepest` and its value; a branch there counts as its mean.
pub(super) fn for_each_leaf(tree: &TensorTree, deepest: u32, f: &mut impl FnMut(TreeCell, f64)) {
    visit(tree, tree.root(), TreeCell::WHOLE, deepest, f);
}

fn visit(
    tree: &TensorTree,
    slot: Slot,
    cell: TreeCell,
    deepest: u32,
    f: &mut impl FnMut(TreeCell, f64),
) {
    match slot {
        Slot::Leaf(value) => f(cell, value.into()),
        Slot::Branch(_) if cell.level == deepest => f(cell, mean(tree, slot, cell)),
        Slot::Branch(_) => {
            for c in 0..tree.rank().children() {
                if let Some(child) = cell.child(tree.rank(), c) {
                    visit(tree, tree.child(slot, c), child, deepest, f);
                }
            }
        }
    }
}

/// Mean f over a cell.
pub(super) fn mean(tree: &TensorTree, slot: Slot, cell: TreeCell) -> f64 {
    if let Slot::Leaf(value) = slot {
        return value.into();
    }
    let (mut sum, mut count) = (0.0, 0.0);
    for c in 0..tree.rank().children() {
        if let Some(child) = cell.child(tree.rank(), c) {
            sum += mean(tree, tree.child(slot, c), child);
            count += 1.0;
        }
    }
    sum / count
}
