//! Slices of a tree at a fixed direction, with the means that totals and sampling need.
//!
//! For a fixed known direction the tree is a quadtree over the other one's square. The reference
//! library makes a sorted table of it for each cell of the known direction that is asked for, and
//! searches a list of them. Here the quadtrees of neighbouring cells share every subtree on which
//! the known cell has no influence: a directed acyclic graph of records of four means and four
//! links each, whose root is found by descending the known dimensions once.
//!
//! Means, not sums: the mean of equal values is exact, so a constant floor taken out of a
//! region with that constant leaves exactly 0, and any floor can be taken out at query time.
//!
//! Cost: 3 bytes a leaf (a band of 5.1 million leaves: tree 22 MB, slices 15 MB, made in 36 ms); a
//! sample reads one record (32 bytes) a level, at random incidence as at the same one.

use super::lookup::Cell;
use super::node::{BRANCH, MAX_DEPTH, Slot, TensorTree};
use super::walk::Walk;
use crate::lanes::Sense;
use crate::words::Words;
use bsdfkit_sphere::DVec2;

/// Where a region's quadrants are found; packed it is never 0, which stands for a region of one
/// leaf.
#[derive(Clone, Copy, Debug)]
enum Link {
    /// Four leaves of one tree node, for the known part `quad % known_parts`.
    Quad(u32),
    /// Four regions, in `records`.
    Record(u32),
}

const QUAD: u32 = 1 << 30;
const RECORD: u32 = 2 << 30;

impl Link {
    fn pack(self) -> u32 {
        match self {
            Self::Quad(quad) => quad | QUAD,
            Self::Record(record) => record | RECORD,
        }
    }
}

/// The whole slice for one cell of the known direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slice {
    pub(super) mean: f32,
    link: u32,
    /// Levels of the largest and of the smallest leaf.
    pub(super) coarsest: u8,
    pub(super) finest: u8,
}

impl Slice {
    fn pack(self) -> [u32; 3] {
        let levels = u32::from(self.coarsest) | u32::from(self.finest) << 8;
        [self.mean.to_bits(), self.link, levels]
    }

    #[inline(always)]
    fn unpack([mean, link, levels]: &[u32; 3]) -> Self {
        let [coarsest, finest, ..] = levels.to_le_bytes();
        Self { mean: f32::from_bits(*mean), link: *link, coarsest, finest }
    }
}

/// All slices of a tree in one sense.
#[derive(Debug)]
pub(crate) struct Slices {
    sense: Sense,
    /// Halves (rank 3) or quadrants (rank 4) of the known dimensions.
    known_parts: usize,
    tables: Tables,
}

/// The arrays of [`Slices`], as a file holds them.
#[derive(Clone, Debug)]
pub(crate) struct Tables {
    /// The known dimensions' own tree: a slice's number, or with [`BRANCH`] a group of parts.
    /// The last element is its root.
    pub(crate) index: Words,
    /// Three words each: the mean's bits, a link, the levels of the largest and smallest leaf
    /// (·256).
    pub(crate) slices: Words,
    /// Eight words each: the bits of four means, four links.
    pub(crate) records: Words,
}

/// The arrays while they grow.
struct Growth {
    sense: Sense,
    known_parts: usize,
    index: Vec<u32>,
    slices: Vec<u32>,
    records: Vec<u32>,
}

/// The known dimensions' tree while it grows.
enum Known {
    One(Slice),
    Parts(Box<[Known]>),
}

impl Slices {
    /// Reverse needs rank 4, where the roles of the two squares are alike.
    pub(super) fn new(tree: &TensorTree, sense: Sense) -> Self {
        let mut growth = Growth {
            sense,
            known_parts: tree.rank.children() / 4,
            index: Vec::new(),
            slices: Vec::new(),
            records: Vec::new(),
        };
        let known = growth.grow(tree, tree.root.into(), 0);
        let root = growth.flatten(known);
        growth.index.push(root);
        growth.index.shrink_to_fit();
        growth.slices.shrink_to_fit();
        growth.records.shrink_to_fit();
        let Growth { known_parts, index, slices, records, .. } = growth;
        let tables = Tables { index: index.into(), slices: slices.into(), records: records.into() };
        Self { sense, known_parts, tables }
    }

    /// From the arrays of a file, which are not looked through: what is wrong with them reads as 0.
    pub(crate) fn unchecked(tree: &TensorTree, sense: Sense, tables: Tables) -> Self {
        Self { sense, known_parts: tree.rank.children() / 4, tables }
    }

    /// The arrays.
    pub(crate) fn tables(&self) -> &Tables {
        &self.tables
    }

    /// The slice that a finest cell of the known direction lies in.
    #[inline]
    pub(super) fn at(&self, known: Cell) -> Slice {
        let index = &*self.tables.index;
        let mut at = index.last().copied().unwrap_or(0);
        for level in 0..MAX_DEPTH {
            if at & BRANCH == 0 {
                break;
            }
            let part = (at ^ BRANCH) as usize * self.known_parts + known.part(level);
            at = index.get(part).copied().unwrap_or(0);
        }
        slice(&self.tables.slices, at)
    }

    /// [`Slices::at`] of many, side by side.
    #[inline(always)]
    pub(super) fn at_abreast(&self, known: &[Cell; ABREAST]) -> [Slice; ABREAST] {
        let index = &*self.tables.index;
        let mut at = [index.last().copied().unwrap_or(0); ABREAST];
        for level in 0..MAX_DEPTH {
            let mut more = 0;
            for k in 0..ABREAST {
                // One that has arrived reads the first part, in vain: no branch.
                let part = (at[k] ^ BRANCH) as usize * self.known_parts + known[k].part(level);
                let branch = at[k] & BRANCH != 0;
                let below = index.get(if branch { part } else { 0 }).copied().unwrap_or(0);
                at[k] = if branch { below } else { at[k] };
                more |= at[k];
            }
            if more & BRANCH == 0 {
                break;
            }
        }
        let slices = &*self.tables.slices;
        at.map(|at| slice(slices, at))
    }

    /// All slices.
    pub(super) fn iter(&self) -> impl Iterator<Item = Slice> {
        self.tables.slices.as_chunks().0.iter().map(Slice::unpack)
    }

    /// A point of the square with density (value − floor) / (mean − floor), by a walk down to a
    /// leaf.
    pub(super) fn sample<W: Walk>(
        &self,
        tree: &TensorTree,
        slice: &Slice,
        floor: f64,
        u: W::Numbers,
    ) -> Option<DVec2> {
        let (records, slots) = (&*self.tables.records, &*tree.slots);
        let mut walk = W::new(slice.link, u);
        while walk.link() != 0 {
            let (means, links) = quadrants(records, slots, self.sense, walk.link());
            walk.step(means, links, floor);
        }
        (f64::from(slice.mean) > floor).then(|| walk.end())
    }

    /// [`Slices::sample`] of many, a level of all after the other, so that their cache misses
    /// overlap.
    ///
    /// Points of the square, whatever the mean.
    #[inline(always)]
    pub(super) fn sample_abreast<W: Walk>(
        &self,
        tree: &TensorTree,
        slices: &[Slice; ABREAST],
        floor: f64,
        u: &[W::Numbers; ABREAST],
    ) -> [DVec2; ABREAST] {
        let (records, slots) = (&*self.tables.records, &*tree.slots);
        let mut walks: [W; ABREAST] = std::array::from_fn(|k| W::new(slices[k].link, u[k]));
        // Those still on their way.
        let (mut numbers, mut count) = ([0; ABREAST], 0);
        for k in 0..ABREAST {
            numbers[count] = k;
            count += usize::from(walks[k].link() != 0);
        }
        let mut below = [([0.0; 4], [0; 4]); ABREAST];
        while count > 0 {
            for (below, k) in below.iter_mut().zip(&numbers[..count]) {
                *below = quadrants(records, slots, self.sense, walks[*k].link());
            }
            let mut left = 0;
            for n in 0..count {
                let (k, (means, links)) = (numbers[n], below[n]);
                walks[k].step(means, links, floor);
                numbers[left] = k;
                left += usize::from(walks[k].link() != 0);
            }
            count = left;
        }
        walks.map(|walk| walk.end())
    }
}

#[inline(always)]
fn slice(slices: &[u32], at: u32) -> Slice {
    slices.as_chunks().0.get(at as usize).map_or(Slice::default(), Slice::unpack)
}

/// Means and links of the quadrants of a region that is no leaf.
#[inline(always)]
fn quadrants(records: &[u32], slots: &[u32], sense: Sense, link: u32) -> ([f32; 4], [u32; 4]) {
    let at = (link & !(3 << 30)) as usize;
    let quad = link & QUAD != 0;
    let links = records.as_chunks().0.get(if quad { usize::MAX } else { 2 * at + 1 });
    let means = match sense {
        Sense::Reverse if quad => reverse_quad(slots, at),
        _ => {
            let (words, at) = if quad { (slots, at) } else { (records, 2 * at) };
            words.as_chunks().0.get(at).copied().unwrap_or_default()
        }
    };
    (means.map(f32::from_bits), links.copied().unwrap_or_default())
}

impl Growth {
    fn grow(&mut self, tree: &TensorTree, slot: Slot, level: u8) -> Known {
        let node = match slot {
            Slot::Leaf(mean) => {
                return Known::One(Slice { mean, link: 0, coarsest: level, finest: level });
            }
            Slot::Branch(node) => node,
        };
        let parts = (0..self.known_parts).map(|part| {
            let quad = node * self.known_parts + part;
            let slots = quad_of(tree, self.sense, quad);
            if slots.iter().all(|s| s & BRANCH == 0) {
                Known::One(Slice {
                    mean: mean(slots.map(f32::from_bits)),
                    link: Link::Quad(quad as u32).pack(),
                    coarsest: level + 1,
                    finest: level + 1,
                })
            } else {
                let quadrants = slots.map(|s| self.grow(tree, s.into(), level + 1));
                self.join(quadrants.each_ref())
            }
        });
        Known::Parts(parts.collect())
    }

    /// Four quadrants, each with its own division of the known dimensions → their common one.
    fn join(&mut self, quadrants: [&Known; 4]) -> Known {
        let one = |k: &Known| match k {
            Known::One(slice) => Some(*slice),
            Known::Parts(_) => None,
        };
        if let [Some(a), Some(b), Some(c), Some(d)] = quadrants.map(one) {
            let four = [a, b, c, d];
            let means = four.map(|s| s.mean);
            self.records.extend(means.map(f32::to_bits));
            self.records.extend(four.map(|s| s.link));
            return Known::One(Slice {
                mean: mean(means),
                link: Link::Record(self.records.len() as u32 / 8 - 1).pack(),
                coarsest: four.map(|s| s.coarsest).into_iter().min().unwrap_or(0),
                finest: four.map(|s| s.finest).into_iter().max().unwrap_or(0),
            });
        }
        let parts = (0..self.known_parts).map(|part| {
            self.join(quadrants.map(|k| match k {
                Known::One(_) => k,
                Known::Parts(parts) => &parts[part],
            }))
        });
        Known::Parts(parts.collect())
    }

    fn flatten(&mut self, known: Known) -> u32 {
        match known {
            Known::One(slice) => {
                self.slices.extend(slice.pack());
                self.slices.len() as u32 / 3 - 1
            }
            Known::Parts(parts) => {
                let first = self.index.len();
                self.index.resize(first + self.known_parts, 0);
                for (i, part) in parts.into_iter().enumerate() {
                    self.index[first + i] = self.flatten(part);
                }
                (first / self.known_parts) as u32 | BRANCH
            }
        }
    }
}

/// The four slots of a tree node for one part of the known dimensions: quadrants (x + 2y) of
/// the sampled direction's square, which the stored incident one mirrors at its centre.
#[inline]
fn quad_of(tree: &TensorTree, sense: Sense, quad: usize) -> [u32; 4] {
    match sense {
        Sense::Forward => tree.slots.as_chunks().0.get(quad).copied().unwrap_or_default(),
        Sense::Reverse => reverse_quad(&tree.slots, quad),
    }
}

#[inline]
fn reverse_quad(slots: &[u32], quad: usize) -> [u32; 4] {
    let node = slots.as_chunks::<16>().0.get(quad / 4).copied().unwrap_or_default();
    [12, 8, 4, 0].map(|first| node[first + quad % 4])
}

/// Samples that go down side by side.
pub(super) const ABREAST: usize = 64;

fn mean(values: [f32; 4]) -> f32 {
    (values.iter().map(|&v| f64::from(v)).sum::<f64>() * 0.25) as f32
}
