//! Builds a tree from a depth-first stream: no nested boxes, validated as it comes.

use super::node::{BRANCH, MAX_DEPTH, MAX_NODES, Rank, TensorTree, TreeVisitor};
use crate::error::{Error, Result};

/// Streaming constructor of a [`TensorTree`]; its calls are those of [`TreeVisitor`].
///
/// Errors: argument, with the place in the tree, for a value that is negative or not finite, a
/// wrong number of children or values; limit for a tree deeper than [`MAX_DEPTH`] or with more
/// than [`MAX_NODES`] branches.
///
/// ```
/// # use bsdfkit::tree::*;
/// # fn main() -> bsdfkit::Result<()> {
/// let mut b = TreeBuilder::new(Rank::Three);
/// b.open_branch()?;
/// for child in 0..8 {
///     b.leaf(child as f32)?;
/// }
/// b.close_branch()?;
/// assert_eq!(b.finish()?.leaf_count(), 8);
/// # Ok(())
/// # }
/// ```
#[derive(Debug)]
pub struct TreeBuilder {
    rank: Rank,
    root: Option<u32>,
    slots: Vec<u32>,
    /// Open branches: (node, children so far).
    open: Vec<(usize, usize)>,
    depth: u32,
}

impl TreeBuilder {
    /// Nothing yet: the first call gives the root.
    pub fn new(rank: Rank) -> Self {
        Self { rank, root: None, slots: Vec::new(), open: Vec::new(), depth: 0 }
    }

    /// A branch begins; its 2^rank children follow.
    pub fn open_branch(&mut self) -> Result<()> {
        let node = self.branch(&[0; 16][..self.rank.children()])?;
        self.open.push((node, 0));
        Ok(())
    }

    /// Places a branch with these slots and returns its number.
    #[inline]
    fn branch(&mut self, slots: &[u32]) -> Result<usize> {
        if self.open.len() as u32 == MAX_DEPTH {
            return Err(Error::limit(format!("{self}: tree deeper than {MAX_DEPTH} levels")));
        }
        let node = self.slots.len() / slots.len();
        if node == MAX_NODES {
            return Err(Error::limit(format!("tree: more than {MAX_NODES} branches")));
        }
        self.place(node as u32 | BRANCH)?;
        self.slots.extend_from_slice(slots);
        self.depth = self.depth.max(self.open.len() as u32 + 1);
        Ok(node)
    }

    /// One value for the whole cell. −0 becomes 0.
    pub fn leaf(&mut self, value: f32) -> Result<()> {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(Error::argument(format!(
                "{self}: expected a finite value of at least 0, found {value}"
            )));
        }
        self.place(value.abs().to_bits())
    }

    /// A regular grid of (2^log2)^rank values in C order: dimension 0 slowest, the last fastest.
    pub fn grid(&mut self, log2: u32, values: &[f32]) -> Result<()> {
        let rank = self.rank.dimensions();
        if log2 > MAX_DEPTH - self.open.len() as u32 {
            return Err(Error::limit(format!("{self}: tree deeper than {MAX_DEPTH} levels")));
        }
        if values.len() as u64 != 1_u64 << (rank * log2).min(63) {
            let expected = 2_f64.powf(f64::from(rank * log2));
            return Err(Error::argument(format!(
                "{self}: expected a grid of {expected} values, found {}",
                values.len()
            )));
        }
        // Almost all grids are of one branch.
        match (self.rank, log2) {
            (_, 0) => self.leaf(values[0]),
            (Rank::Three, 1) => self.grid_cell(1, 0, const { &offsets(Rank::Three, 1) }, values),
            (Rank::Four, 1) => self.grid_cell(1, 0, const { &offsets(Rank::Four, 1) }, values),
            _ => self.grid_cell(log2, 0, &offsets(self.rank, log2), values),
        }
    }

    /// The cell of a grid that is 2^left entries wide and begins at entry `first`.
    fn grid_cell(
        &mut self,
        left: u32,
        first: usize,
        offsets: &[usize; 16],
        values: &[f32],
    ) -> Result<()> {
        if left == 0 {
            return self.leaf(values[first]);
        }
        if left == 1 && self.finest(&values[first..], offsets)? {
            return Ok(());
        }
        self.open_branch()?;
        for child in 0..self.rank.children() {
            let offset = offsets[self.rank.slot_of_child(child)] << (left - 1);
            self.grid_cell(left - 1, first + offset, offsets, values)?;
        }
        self.close_branch()
    }

    /// A branch of leaves, if all values are sound; else nothing.
    fn finest(&mut self, values: &[f32], offsets: &[usize; 16]) -> Result<bool> {
        let offsets = &offsets[..self.rank.children()];
        let mut sound = true;
        let mut slots = [0; 16];
        for (slot, &offset) in slots.iter_mut().zip(offsets) {
            let value = values[offset];
            sound &= value >= 0.0 && value.is_finite();
            // −0 becomes 0.
            *slot = value.abs().to_bits();
        }
        if sound {
            self.branch(&slots[..offsets.len()])?;
        }
        Ok(sound)
    }

    /// The branch opened last ends.
    pub fn close_branch(&mut self) -> Result<()> {
        let expected = self.rank.children();
        match self.open.last() {
            None => Err(Error::argument("tree: a branch ends that was never opened")),
            Some(&(_, found)) if found != expected => {
                Err(Error::argument(format!("{self}: expected {expected} children, found {found}")))
            }
            Some(_) => {
                self.open.pop();
                Ok(())
            }
        }
    }

    /// The tree, when it is complete.
    pub fn finish(self) -> Result<TensorTree> {
        if !self.open.is_empty() {
            return Err(Error::argument(format!("{self}: the tree ends inside a branch")));
        }
        let Some(root) = self.root else {
            return Err(Error::argument("tree: expected a value or a branch, found nothing"));
        };
        let Self { rank, mut slots, depth, .. } = self;
        slots.shrink_to_fit();
        Ok(TensorTree { rank, root, slots: slots.into(), depth })
    }

    fn place(&mut self, bits: u32) -> Result<()> {
        let n = self.rank.children();
        match self.open.last_mut() {
            Some((node, child)) if *child < n => {
                self.slots[*node * n + self.rank.slot_of_child(*child)] = bits;
                *child += 1;
                Ok(())
            }
            None if self.root.is_none() => {
                self.root = Some(bits);
                Ok(())
            }
            Some(_) => Err(Error::argument(format!("{self}: expected {n} children, found more"))),
            None => Err(Error::argument("tree: expected its end, found another root")),
        }
    }
}

/// Where in a grid the entries of a finest branch lie behind its first one, by slot.
const fn offsets(rank: Rank, log2: u32) -> [usize; 16] {
    let mut offsets = [0; 16];
    let mut child = 0;
    while child < rank.children() {
        let mut d = 0;
        while d < rank.dimensions() {
            let upper = child >> d & 1;
            offsets[rank.slot_of_child(child)] |= upper << (log2 * (rank.dimensions() - 1 - d));
            d += 1;
        }
        child += 1;
    }
    offsets
}

/// The place reached, for messages: `tree/3/15` is in child 15 of child 3.
impl std::fmt::Display for TreeBuilder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("tree")?;
        for (i, (_, child)) in self.open.iter().enumerate() {
            // An outer branch has already counted the child that is open inside it.
            let inner = usize::from(i + 1 < self.open.len());
            write!(f, "/{}", child - inner)?;
        }
        Ok(())
    }
}

impl TreeVisitor for TreeBuilder {
    fn open_branch(&mut self) -> Result<()> {
        Self::open_branch(self)
    }
    fn leaf(&mut self, value: f32) -> Result<()> {
        Self::leaf(self, value)
    }
    fn grid(&mut self, log2: u32, values: &[f32]) -> Result<()> {
        Self::grid(self, log2, values)
    }
    fn close_branch(&mut self) -> Result<()> {
        Self::close_branch(self)
    }
}

impl TensorTree {
    /// One value everywhere.
    pub fn constant(rank: Rank, value: f32) -> Result<Self> {
        let mut builder = TreeBuilder::new(rank);
        builder.leaf(value)?;
        builder.finish()
    }
}
