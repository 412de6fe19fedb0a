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
use crate::distribution::Sense;
use crate::query::BELOW_ONE;
use crate::words::Words;
use bsdfkit_sphere::{DVec2, hilbert};

/// Where a region's quadrants are found; packed it is never 0, which stands for a region of one leaf.
#[derive(Clone, Copy, Debug)]
enum Link {
    /// Four leaves of one tree node, for the known part `quad % known_parts`.
    Quad(u32),
    /// Four regions, in `records`.
    Record(u32),
}

/// Positions on the order-32 curve, and cells along a side of its square.
const INDICES: f64 = FINEST * FINEST;
const FINEST: f64 = 4_294_967_296.0;

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
    /// Three words each: the mean's bits, a link, the levels of the largest and smallest leaf (·256).
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

    /// A point of the square with density (value − floor) / (mean − floor), in Hilbert order.
    ///
    /// Each level takes from `u` the choice of one of four quadrants in the curve's order;
    /// what remains of `u` walks along the curve inside the leaf.
    pub(super) fn sample(
        &self,
        tree: &TensorTree,
        slice: &Slice,
        floor: f64,
        u: f64,
    ) -> Option<DVec2> {
        let (records, slots) = (&*self.tables.records, &*tree.slots);
        let mut walk = Walk::new(slice, u);
        while walk.link != 0 {
            let (means, links) = quadrants(records, slots, self.sense, walk.link);
            walk.step(means, links, floor);
        }
        (f64::from(slice.mean) > floor).then(|| walk.end())
    }

    /// [`Slices::sample`] of many, a level of all after the other, so that their cache misses overlap.
    ///
    /// Points of the square, whatever the mean.
    #[inline(always)]
    pub(super) fn sample_abreast(
        &self,
        tree: &TensorTree,
        slices: &[Slice; ABREAST],
        floor: f64,
        u: &[f64; ABREAST],
    ) -> [DVec2; ABREAST] {
        let (records, slots) = (&*self.tables.records, &*tree.slots);
        let mut walks: [Walk; ABREAST] = std::array::from_fn(|k| Walk::new(&slices[k], u[k]));
        // Those still on their way.
        let (mut numbers, mut count) = ([0; ABREAST], 0);
        for k in 0..ABREAST {
            numbers[count] = k;
            count += usize::from(walks[k].link != 0);
        }
        let mut below = [([0.0; 4], [0; 4]); ABREAST];
        while count > 0 {
            for (below, k) in below.iter_mut().zip(&numbers[..count]) {
                *below = quadrants(records, slots, self.sense, walks[*k].link);
            }
            let mut left = 0;
            for n in 0..count {
                let (k, (means, links)) = (numbers[n], below[n]);
                walks[k].step(means, links, floor);
                numbers[left] = k;
                left += usize::from(walks[k].link != 0);
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

/// A sample on its way down.
#[derive(Clone, Copy, Default)]
struct Walk {
    link: u32,
    level: u32,
    /// Position along the curve, two bits a level.
    index: u64,
    turn: Turn,
    /// Place within the region reached, in \[0, 1).
    u: f64,
}

impl Walk {
    #[inline(always)]
    fn new(slice: &Slice, u: f64) -> Self {
        Self { link: slice.link, u, ..Self::default() }
    }

    #[inline(always)]
    fn step(&mut self, means: [f32; 4], links: [u32; 4], floor: f64) {
        let quadrants = self.turn.quadrants();
        let masses = quadrants.map(|q| (f64::from(means[(q & 3) as usize]) - floor).max(0.0));
        let chosen = if self.level < MAX_DEPTH { choose(masses, self.u) } else { None };
        let Some((digit, rest)) = chosen else {
            self.link = 0;
            return;
        };
        self.u = rest;
        self.index = self.index << 2 | digit as u64;
        self.link = links[(quadrants[digit] & 3) as usize];
        self.turn = self.turn.inside(digit);
        self.level += 1;
    }

    #[inline(always)]
    fn end(&self) -> DVec2 {
        // 4^(32 − level) finest positions remain along the curve.
        let rest = (self.u * INDICES) as u64 >> (2 * self.level);
        // In two steps: at level 0 the index is 0, and a shift by 64 is none.
        let prefix = self.index << 1 << (63 - 2 * self.level);
        let (x, y) = hilbert::index_to_cell(32, prefix | rest);
        DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / FINEST
    }
}

fn mean(values: [f32; 4]) -> f32 {
    (values.iter().map(|&v| f64::from(v)).sum::<f64>() * 0.25) as f32
}

/// Which of four masses `u` falls in, and its place there in \[0, 1). A mass of 0 is never chosen.
#[inline]
pub(super) fn choose(masses: [f64; 4], u: f64) -> Option<(usize, f64)> {
    let first = masses[0];
    let second = first + masses[1];
    let third = second + masses[2];
    let total = third + masses[3];
    if total <= 0.0 {
        return None;
    }
    // Less than the total, as u is at most BELOW_ONE: so past a trailing 0 it never falls.
    let at = u * total;
    let digit = usize::from(at >= first) + usize::from(at >= second) + usize::from(at >= third);
    let start = [0.0, first, second, third][digit];
    Some((digit, ((at - start) / masses[digit]).min(BELOW_ONE)))
}

/// How the Hilbert curve lies in a cell: bit 0 x and y exchanged, bit 1 half turn.
#[derive(Clone, Copy, Default)]
pub(super) struct Turn(u8);

impl Turn {
    /// Quadrants (x + 2y) in the order of the curve.
    #[inline]
    pub(super) fn quadrants(self) -> [u8; 4] {
        const ORDERS: [[u8; 4]; 4] = [[0, 1, 3, 2], [0, 2, 3, 1], [3, 2, 0, 1], [3, 1, 0, 2]];
        ORDERS[(self.0 & 3) as usize]
    }

    /// How it lies in the quadrant that comes `digit`-th.
    #[inline]
    pub(super) fn inside(self, digit: usize) -> Self {
        Self(self.0 ^ [1, 0, 0, 3][digit])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_those_of_the_hilbert_curve() {
        let order = 5;
        for index in 0..1_u64 << (2 * order) {
            let (mut turn, mut cell) = (Turn::default(), (0, 0));
            for level in (0..order).rev() {
                let digit = (index >> (2 * level) & 3) as usize;
                let q = u32::from(turn.quadrants()[digit]);
                cell = (cell.0 << 1 | (q & 1), cell.1 << 1 | q >> 1);
                turn = turn.inside(digit);
            }
            assert_eq!(cell, hilbert::index_to_cell(order, index));
        }
    }

    #[test]
    fn choice_skips_nothing_and_zero() {
        assert_eq!(choose([0.0, 1.0, 0.0, 3.0], 0.0), Some((1, 0.0)));
        assert_eq!(choose([0.0, 1.0, 0.0, 3.0], 0.25), Some((3, 0.0)));
        assert_eq!(choose([0.0, 1.0, 0.0, 0.0], 0.999_999).map(|c| c.0), Some(1));
        assert_eq!(choose([0.0; 4], 0.5), None);
    }
}
