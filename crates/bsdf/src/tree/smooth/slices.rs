//! Slices of a smooth tree at a fixed direction: what totals and sampling need.
//!
//! The same graph of regions as for the stored values (`tree/cumulative.rs`), but a region's mean
//! is a function of the known direction: biquadratic over the cell of the known dimensions in which
//! the region is divided in one way. Leaves are biquadratic over larger cells, so those means are
//! exact.

use bsdfkit_sphere::{DVec2, hilbert};

use super::super::node::{BRANCH, MAX_DEPTH, Slot};
use super::super::walk::Turn;
use super::mean::Mean;
use super::patch::Density;
use super::shaped::{Known, Shaped};
use crate::lanes::Sense;
use crate::unit::{BELOW_ONE, choose_of_four};

/// Where a region's quadrants are found.
#[derive(Clone, Copy, Debug, Default)]
enum Link {
    /// Nowhere: all is one leaf that fills the tree.
    #[default]
    Whole,
    /// Nowhere: the region is a leaf, in this slot.
    Leaf(u32),
    /// Four leaves of one node.
    Quad(u32),
    /// Four regions.
    Record(u32),
}

/// Four regions.
#[derive(Clone, Copy, Debug)]
struct Record {
    means: [Mean<f32>; 4],
    links: [Link; 4],
    /// Of the cell over which the means are given.
    level: u8,
}

/// The whole slice for one cell of the known direction.
#[derive(Clone, Copy, Debug, Default)]
struct Slice {
    mean: Mean<f32>,
    link: Link,
    level: u8,
}

/// All slices of a smooth tree in one sense.
///
/// Cost: 20 bytes a leaf; a sample reads one record (180 bytes) a level.
#[derive(Debug)]
pub(super) struct Slices {
    sense: Sense,
    /// Halves (rank 3) or quadrants (rank 4) of the known dimensions.
    known_parts: usize,
    /// The known dimensions' own tree: a slice's number, or with [`BRANCH`] a group of parts.
    index: Vec<u32>,
    root: u32,
    slices: Vec<Slice>,
    records: Vec<Record>,
}

/// The known dimensions' tree while it grows.
enum Growing {
    One { mean: Mean, link: Link, level: u32 },
    Parts(Box<[Growing]>),
}

impl Slices {
    /// Reverse needs rank 4, where the roles of the two squares are alike.
    pub(super) fn new(shaped: Shaped<'_>, sense: Sense) -> Self {
        let mut slices = Self {
            sense,
            known_parts: shaped.tree.rank.children() / 4,
            index: Vec::new(),
            root: 0,
            slices: Vec::new(),
            records: Vec::new(),
        };
        let grown = match shaped.tree.root() {
            Slot::Leaf(value) => {
                let excess = (f64::from(value) - shaped.floor).max(0.0);
                Growing::One { mean: Mean::even(excess), link: Link::Whole, level: 0 }
            }
            Slot::Branch(node) => slices.grow(shaped, node, [0; 2], 0),
        };
        slices.root = slices.flatten(grown);
        slices.index.shrink_to_fit();
        slices.slices.shrink_to_fit();
        slices.records.shrink_to_fit();
        slices
    }

    /// `cell` is that of the known dimensions, in units of its width.
    fn grow(&mut self, shaped: Shaped<'_>, node: usize, cell: [u32; 2], level: u32) -> Growing {
        let parts = (0..self.known_parts).map(|part| {
            let quad = node * self.known_parts + part;
            let slots = shaped.quadrants(self.sense, quad);
            let cell = part_of(cell, part);
            if slots.iter().all(|slot| shaped.is_leaf(*slot)) {
                return Growing::One {
                    mean: Mean::average(slots.map(|slot| Mean::of_leaf(shaped, self.sense, slot))),
                    link: Link::Quad(quad as u32),
                    level: level + 1,
                };
            }
            let quadrants = slots.map(|slot| match Slot::from(shaped.tree.slots[slot]) {
                Slot::Branch(node) => self.grow(shaped, node, cell, level + 1),
                Slot::Leaf(_) => Growing::One {
                    mean: Mean::of_leaf(shaped, self.sense, slot),
                    link: Link::Leaf(slot as u32),
                    level: level + 1,
                },
            });
            self.join(quadrants.each_ref(), cell, level + 1)
        });
        Growing::Parts(parts.collect())
    }

    /// Four quadrants, each with its own division of the known cell → their common one.
    fn join(&mut self, quadrants: [&Growing; 4], cell: [u32; 2], level: u32) -> Growing {
        let one = |k: &Growing| match k {
            Growing::One { mean, link, level: own } => {
                Some((mean.within(level - own, cell), *link))
            }
            Growing::Parts(_) => None,
        };
        if let [Some(a), Some(b), Some(c), Some(d)] = quadrants.map(one) {
            let four = [a, b, c, d];
            let means = four.map(|(mean, _)| mean);
            self.records.push(Record {
                means: means.map(Mean::pack),
                links: four.map(|(_, link)| link),
                level: level as u8,
            });
            let link = Link::Record(self.records.len() as u32 - 1);
            return Growing::One { mean: Mean::average(means), link, level };
        }
        let parts = (0..self.known_parts).map(|part| {
            let quadrants = quadrants.map(|k| match k {
                Growing::One { .. } => k,
                Growing::Parts(parts) => &parts[part],
            });
            self.join(quadrants, part_of(cell, part), level + 1)
        });
        Growing::Parts(parts.collect())
    }

    fn flatten(&mut self, grown: Growing) -> u32 {
        match grown {
            Growing::One { mean, link, level } => {
                self.slices.push(Slice { mean: mean.pack(), link, level: level as u8 });
                self.slices.len() as u32 - 1
            }
            Growing::Parts(parts) => {
                let first = self.index.len();
                self.index.resize(first + self.known_parts, 0);
                for (i, part) in parts.into_iter().enumerate() {
                    self.index[first + i] = self.flatten(part);
                }
                (first / self.known_parts) as u32 | BRANCH
            }
        }
    }

    fn at(&self, known: Known) -> Slice {
        let mut at = self.root;
        for level in 0..MAX_DEPTH {
            if at & BRANCH == 0 {
                break;
            }
            let bit = |n: u32| (n >> (MAX_DEPTH - 1 - level) & 1) as usize;
            let part = (bit(known.cell[0]) | bit(known.cell[1]) << 1) & (self.known_parts - 1);
            at = self.index[(at ^ BRANCH) as usize * self.known_parts + part];
        }
        self.slices.get(at as usize).copied().unwrap_or_default()
    }

    /// Mean of value − floor over the square.
    pub(super) fn mean(&self, known: Known) -> f64 {
        let slice = self.at(known);
        slice.mean.at(known.place(slice.level.into()))
    }

    /// What no [`Slices::mean`] exceeds.
    pub(super) fn largest_mean(&self) -> f64 {
        self.slices.iter().map(|slice| slice.mean.largest()).fold(0.0, f64::max)
    }

    /// A point of the square with density value − floor + `extra`, in Hilbert order.
    ///
    /// Each level takes from `u` the choice of one of four quadrants in the curve's order; what
    /// remains of `u` walks along the curve inside the leaf, whose density then draws it aside.
    pub(super) fn sample(
        &self,
        shaped: Shaped<'_>,
        known: Known,
        extra: f64,
        u: f64,
    ) -> Option<DVec2> {
        let mut walk = self.begin(known, extra, u);
        while let Some(quadrants) = self.quadrants(shaped, known, &walk) {
            walk.step(&quadrants, extra);
        }
        walk.end(shaped, self.sense, known, extra)
    }

    /// [`Slices::sample`] of many, a level of all after the other, so that their cache misses
    /// overlap.
    pub(super) fn sample_abreast(
        &self,
        shaped: Shaped<'_>,
        known: &[Known],
        extra: f64,
        u: &[f64],
        out: &mut [Option<DVec2>],
    ) {
        let mut walks: Vec<Walk> =
            known.iter().zip(u).map(|(k, u)| self.begin(*k, extra, *u)).collect();
        let mut below = vec![None; walks.len()];
        loop {
            for ((walk, known), below) in walks.iter().zip(known).zip(&mut below) {
                *below = self.quadrants(shaped, *known, walk);
            }
            if below.iter().all(Option::is_none) {
                break;
            }
            for (walk, below) in walks.iter_mut().zip(&below) {
                if let Some(quadrants) = below {
                    walk.step(quadrants, extra);
                }
            }
        }
        for ((walk, known), out) in walks.into_iter().zip(known).zip(out) {
            *out = walk.end(shaped, self.sense, *known, extra);
        }
    }

    fn begin(&self, known: Known, extra: f64, u: f64) -> Walk {
        let slice = self.at(known);
        let black = slice.mean.at(known.place(slice.level.into())) + extra <= 0.0;
        Walk { link: slice.link, u, black, ..Walk::default() }
    }

    /// What the quadrants of the region reached hold; `None` of a leaf.
    #[inline]
    fn quadrants(&self, shaped: Shaped<'_>, known: Known, walk: &Walk) -> Option<Quadrants> {
        match walk.link {
            Link::Whole | Link::Leaf(_) => None,
            Link::Record(record) => {
                let record = self.records.get(record as usize)?;
                let place = known.place(record.level.into());
                Some(Quadrants { masses: record.means.map(|m| m.at(place)), links: record.links })
            }
            Link::Quad(quad) => {
                let slots = shaped.quadrants(self.sense, quad as usize);
                let place = known.place(walk.level + 1);
                let mass = |slot| Mean::of_leaf(shaped, self.sense, slot).at(place);
                let links = slots.map(|slot| Link::Leaf(slot as u32));
                Some(Quadrants { masses: slots.map(mass), links })
            }
        }
    }
}

/// A half or quadrant of a cell.
fn part_of([x, y]: [u32; 2], part: usize) -> [u32; 2] {
    [2 * x + (part & 1) as u32, 2 * y + (part >> 1) as u32]
}

/// What the quadrants (x + 2y) of a region hold at a known direction.
#[derive(Clone, Copy)]
struct Quadrants {
    masses: [f64; 4],
    links: [Link; 4],
}

/// A sample on its way down.
#[derive(Clone, Copy, Default)]
struct Walk {
    link: Link,
    level: u32,
    /// Position along the curve, two bits a level.
    index: u64,
    turn: Turn,
    /// Place within the region reached, in \[0, 1).
    u: f64,
    /// Whether nothing is to be drawn.
    black: bool,
}

impl Walk {
    #[inline]
    fn step(&mut self, quadrants: &Quadrants, extra: f64) {
        let order = self.turn.quadrants().map(usize::from);
        let Some((digit, u)) = choose_of_four(order.map(|q| quadrants.masses[q] + extra), self.u)
        else {
            (self.link, self.black) = (Link::Whole, true);
            return;
        };
        *self = Self {
            link: quadrants.links[order[digit]],
            level: self.level + 1,
            index: self.index << 2 | digit as u64,
            turn: self.turn.inside(digit),
            u,
            black: self.black,
        };
    }

    fn end(mut self, shaped: Shaped<'_>, sense: Sense, known: Known, extra: f64) -> Option<DVec2> {
        let mut densities = [Density::default(); 2];
        if let Link::Leaf(slot) = self.link {
            let place = known.place(self.level);
            let [x, y] = shaped.patches(slot as usize);
            let ((x_mean, x), (y_mean, y)) = (x.sampled(sense, place.x), y.sampled(sense, place.y));
            // What is extra is even: of two shares of the leaf it comes first.
            let excess = shaped.excess(slot as usize) * x_mean * y_mean;
            let even = if extra > 0.0 { extra / (extra + excess) } else { 0.0 };
            if self.u < even {
                self.u /= even;
            } else {
                self.u = ((self.u - even) / (1.0 - even)).min(BELOW_ONE);
                densities = [x, y];
            }
        }
        (!self.black).then(|| self.point(densities))
    }

    /// The point along the curve in the region, drawn aside to where its density is larger.
    fn point(&self, densities: [Density; 2]) -> DVec2 {
        /// Positions on the order-32 curve, and cells along a side of its square.
        const INDICES: f64 = FINEST * FINEST;
        const FINEST: f64 = 4_294_967_296.0;
        // 4^(32 − level) finest positions remain along the curve.
        let rest = (self.u * INDICES) as u64 >> (2 * self.level);
        let prefix = self.index.checked_shl(64 - 2 * self.level).unwrap_or(0);
        let (x, y) = hilbert::index_to_cell(32, prefix | rest);
        let width = FINEST / f64::from(1_u32 << self.level);
        let aside = |cell: u32, density: Density| {
            let (cell, point) = ((f64::from(cell) / width).floor(), f64::from(cell) + 0.5);
            (cell + density.warp(point / width - cell)) * width / FINEST
        };
        DVec2::new(aside(x, densities[0]), aside(y, densities[1]))
    }
}
