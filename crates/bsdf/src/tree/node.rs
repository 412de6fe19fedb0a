//! The tree itself: flat, pointer-free, one cache line a rank-4 node.

use crate::error::{Error, Result};
use crate::words::Words;

/// Leaves are at least 2⁻¹⁶ wide, the finest that the reference library samples.
pub const MAX_DEPTH: u32 = 16;

/// Branches a tree may have: 2²⁴ (1 GiB at rank 4, a full grid of 2⁷ cells a dimension).
pub const MAX_NODES: usize = 1 << 24;

/// A slot with this bit holds the index of a branch; without it, the bits of a leaf's value
/// (finite and not negative, so its own sign bit is clear).
pub(super) const BRANCH: u32 = 1 << 31;

/// Number of dimensions of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Rank {
    /// Isotropic: (incident radius, scattered square x, y).
    Three,
    /// Anisotropic: (incident square x, y, scattered square x, y).
    Four,
}

impl Rank {
    /// 3 or 4.
    pub const fn dimensions(self) -> u32 {
        match self {
            Self::Three => 3,
            Self::Four => 4,
        }
    }

    /// Number of incident dimensions: 1 or 2.
    pub const fn incident_dimensions(self) -> u32 {
        self.dimensions() - 2
    }

    /// Children of a branch: 8 or 16.
    pub const fn children(self) -> usize {
        1 << self.dimensions()
    }

    /// Child number in the order of the text (bit d: upper half of dimension d) → slot within the
    /// node, in which the scattered bits are lowest: four scattered quadrants lie together.
    pub(super) const fn slot_of_child(self, child: usize) -> usize {
        let k = self.incident_dimensions();
        ((child & ((1 << k) - 1)) << 2) | (child >> k)
    }
}

impl TryFrom<u8> for Rank {
    type Error = Error;

    fn try_from(rank: u8) -> Result<Self> {
        match rank {
            3 => Ok(Self::Three),
            4 => Ok(Self::Four),
            _ => Err(Error::argument(format!("rank: expected 3 or 4, found {rank}"))),
        }
    }
}

/// Receives a tree depth first, in the order of the XML text: child number c of a branch
/// covers the upper half of dimension d iff bit d of c is set (dimension 0 least significant).
pub trait TreeVisitor {
    /// A branch begins; its 2^rank children follow.
    fn open_branch(&mut self) -> Result<()>;
    /// One value for the whole cell.
    fn leaf(&mut self, value: f32) -> Result<()>;
    /// A regular grid of (2^log2)^rank values in C order: dimension 0 slowest, the last fastest.
    fn grid(&mut self, log2: u32, values: &[f32]) -> Result<()>;
    /// The branch ends.
    fn close_branch(&mut self) -> Result<()>;
}

/// An immutable 2^rank-tree of values over the unit hypercube.
///
/// Layout: node n is `slots[n · 2^rank ..][.. 2^rank]`, parents before children.
#[derive(Clone, Debug, PartialEq)]
pub struct TensorTree {
    pub(super) rank: Rank,
    /// The root: a leaf's value or node 0.
    pub(super) root: u32,
    pub(super) slots: Words,
    pub(super) depth: u32,
}

/// What a cell of a tree holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slot {
    /// One value.
    Leaf(f32),
    /// The branch of this number: see [`TensorTree::child`].
    Branch(usize),
}

impl From<u32> for Slot {
    #[inline]
    fn from(bits: u32) -> Self {
        if bits & BRANCH == 0 {
            Self::Leaf(f32::from_bits(bits))
        } else {
            Self::Branch((bits ^ BRANCH) as usize)
        }
    }
}

/// What a slot below the deepest branches holds; 0 for another branch, which is a damaged file's.
#[inline(always)]
pub(super) fn leaf_value(slot: u32) -> f32 {
    if slot & BRANCH == 0 { f32::from_bits(slot) } else { 0.0 }
}

impl TensorTree {
    /// A tree from its flat form: the root's slot, and 2^rank slots a branch.
    ///
    /// A slot below 2³¹ is a leaf (the bits of its value), else the low 31 bits number a
    /// branch; branches come after their parents.
    ///
    /// Errors: argument, for anything that [`TreeBuilder`](super::TreeBuilder) could not have
    /// built: a value that is not finite, a branch out of order, missing or used twice, a tree
    /// deeper than [`MAX_DEPTH`].
    pub fn from_slots(rank: Rank, root: u32, slots: Vec<u32>) -> Result<Self> {
        let n = rank.children();
        let branches = slots.len() / n;
        if slots.len() != branches * n || branches > MAX_NODES {
            return Err(Error::argument(format!(
                "tree: expected {n} slots for each of at most {} branches, found {} slots",
                MAX_NODES,
                slots.len()
            )));
        }
        // Level below the root; 0 is not reached yet.
        let mut levels = vec![0_u32; branches];
        let mut reach = |slot: u32, parent: Option<usize>| -> Result<()> {
            let place = || parent.map_or("root".to_owned(), |p| format!("branch {p}"));
            match Slot::from(slot) {
                Slot::Leaf(value) if value.is_finite() => Ok(()),
                Slot::Leaf(value) => Err(Error::argument(format!(
                    "tree: {}: expected a finite value, found {value}",
                    place()
                ))),
                Slot::Branch(node) => {
                    let level = parent.map_or(0, |p| levels[p]) + 1;
                    let later = parent.is_none_or(|p| node > p);
                    match levels.get_mut(node) {
                        Some(free @ 0) if later && level <= MAX_DEPTH => *free = level,
                        _ => {
                            return Err(Error::argument(format!(
                                "tree: {}: branch {node} is missing, out of order, used twice or \
                                 deeper than {MAX_DEPTH} levels",
                                place()
                            )));
                        }
                    }
                    Ok(())
                }
            }
        };
        reach(root, None)?;
        for (i, &slot) in slots.iter().enumerate() {
            reach(slot, Some(i / n))?;
        }
        if let Some(unused) = levels.iter().position(|&level| level == 0) {
            return Err(Error::argument(format!("tree: branch {unused} belongs to no other")));
        }
        let depth = levels.into_iter().max().unwrap_or(0);
        Ok(Self { rank, root, slots: slots.into(), depth })
    }

    /// A tree in a file that is not looked through: what is wrong with it reads as 0.
    pub(crate) fn unchecked(rank: Rank, root: u32, slots: Words, depth: u32) -> Self {
        Self { rank, root, slots, depth: depth.min(MAX_DEPTH) }
    }

    /// What a slot of a branch holds; 0 beyond the array, where only a damaged file leads.
    #[inline(always)]
    pub(super) fn below(&self, node: usize, slot: usize) -> u32 {
        self.slots.get(node * self.rank.children() + slot).copied().unwrap_or(0)
    }

    /// The slots of a branch, as [`TensorTree::below`] gives them.
    #[inline(always)]
    pub(super) fn node(&self, node: usize) -> &[u32] {
        let n = self.rank.children();
        self.slots.get(node * n..node * n + n).unwrap_or(&[0; 16][..n])
    }

    /// The flat form of all branches, as [`TensorTree::from_slots`] takes it.
    pub fn slots(&self) -> &[u32] {
        &self.slots
    }

    /// The slot of the whole hypercube.
    pub fn root_slot(&self) -> u32 {
        self.root
    }

    /// Number of dimensions.
    pub fn rank(&self) -> Rank {
        self.rank
    }

    /// Levels of branches above the deepest leaf: its width is 2^−depth.
    pub fn depth(&self) -> u32 {
        self.depth
    }

    /// Number of branches.
    pub fn branch_count(&self) -> usize {
        self.slots.len() / self.rank.children()
    }

    /// Number of leaves.
    pub fn leaf_count(&self) -> usize {
        1 + self.branch_count() * (self.rank.children() - 1)
    }

    /// What the whole hypercube holds.
    pub fn root(&self) -> Slot {
        self.root.into()
    }

    /// What a child holds, by its number in the order of the text; a leaf continues in each.
    pub fn child(&self, slot: Slot, child: usize) -> Slot {
        match slot {
            Slot::Leaf(_) => slot,
            Slot::Branch(node) => self.below(node, self.rank.slot_of_child(child)).into(),
        }
    }

    /// Sends the whole tree to `visitor`; sibling leaves that fill a branch arrive as one grid.
    pub fn visit(&self, visitor: &mut impl TreeVisitor) -> Result<()> {
        self.visit_slot(self.root.into(), 0, visitor)
    }

    pub(super) fn visit_slot(
        &self,
        slot: Slot,
        level: u32,
        visitor: &mut impl TreeVisitor,
    ) -> Result<()> {
        let node = match slot {
            Slot::Leaf(value) => return visitor.leaf(value),
            Slot::Branch(_) if level == self.depth => return visitor.leaf(0.0),
            Slot::Branch(node) => node,
        };
        let n = self.rank.children();
        let slots = self.node(node);
        if slots.iter().all(|s| s & BRANCH == 0) {
            let mut values = [0.0; 16];
            for (place, value) in values[..n].iter_mut().enumerate() {
                // C order has dimension 0 in the highest bit, the text's children in the lowest.
                let child = place.reverse_bits() >> (usize::BITS - self.rank.dimensions());
                *value = f32::from_bits(slots[self.rank.slot_of_child(child)]);
            }
            return visitor.grid(1, &values[..n]);
        }
        visitor.open_branch()?;
        for child in 0..n {
            self.visit_slot(slots[self.rank.slot_of_child(child)].into(), level + 1, visitor)?;
        }
        visitor.close_branch()
    }
}
