//! From two directions to a leaf: coordinates in the unit hypercube, and the descent.

use super::node::{BRANCH, Rank, Slot, TensorTree, leaf_value};
use crate::{DVec2, DVec3};
use bsdfkit_sphere::concentric::{disk_to_square, square_to_disk};

/// Bits of a coordinate that can tell cells apart: those of the deepest tree.
const BITS: u32 = super::node::MAX_DEPTH;

/// Levels that one look-up skips. With 3 the table fits half of a first-level cache; 2 and 4 are
/// slower.
pub(super) const TOP: u32 = 3;

/// 2¹⁶: the finest cells along a side.
pub(super) const CELLS: f64 = (1 << BITS) as f64;

/// Where the incident direction is in a tree, and the frame in which it sees the scattered one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Incidence {
    rank: Rank,
    /// Rank 3: (½ − ½ sin θ, unused). Rank 4: the square of the travel direction.
    pub(super) point: DVec2,
    /// The travel direction's projection, whose azimuth rank 3 turns away, and its length.
    ///
    /// Kept apart and divided last: so what is parallel to it has y = 0 exactly, and mirror and
    /// straight-through directions fall on one side of the line y = ½, not on either by rounding.
    travel: DVec2,
    length: f64,
}

impl Incidence {
    /// Convention: a tree is indexed by the *travel* direction −wi of the incident light, so that
    /// mirror reflection and straight transmission lie on the diagonal. At rank 3 that
    /// direction is turned to +X; dimension 0 runs from 0 (grazing) to ½ (normal).
    ///
    /// At exactly normal incidence, where the azimuth is free, it is that of −X, as in the
    /// reference library. Differs from: the reference's 0.499999 − ½ sin θ, which is negative
    /// near grazing; here the coordinate is clamped below ½ instead.
    #[inline(always)]
    pub(super) fn new(rank: Rank, wi: DVec3) -> Self {
        let travel = -wi.truncate();
        match rank {
            Rank::Four => Self { rank, point: disk_to_square(travel), travel, length: 1.0 },
            Rank::Three => {
                let sin = travel.length();
                let x = (0.5 - 0.5 * sin).clamp(0.0, 0.5 - 0.5 / CELLS);
                let (travel, length) = if sin > 0.0 { (travel, sin) } else { (DVec2::NEG_X, 1.0) };
                Self { rank, point: DVec2::new(x, 0.0), travel, length }
            }
        }
    }

    /// The scattered direction's place in the square.
    #[inline(always)]
    pub(super) fn square_of(&self, wo: DVec3) -> DVec2 {
        let d = wo.truncate();
        disk_to_square(match self.rank {
            Rank::Four => d,
            Rank::Three => DVec2::new(self.travel.dot(d), self.travel.perp_dot(d)) / self.length,
        })
    }

    /// Inverse of [`Incidence::square_of`], as far as x and y.
    #[inline(always)]
    pub(super) fn disk_of(&self, square: DVec2) -> DVec2 {
        let d = square_to_disk(square);
        match self.rank {
            Rank::Four => d,
            Rank::Three => self.travel.rotate(d) / self.length,
        }
    }

    /// The cell of the incident coordinates.
    #[inline(always)]
    pub(super) fn cell(&self) -> Cell {
        match self.rank {
            Rank::Four => Cell::of(self.point),
            Rank::Three => Cell(spread(quantise(self.point.x))),
        }
    }
}

/// Coordinate in \[0, 1\] → finest cell, without the branches of a conversion.
///
/// Between 1 and 2 the highest bits of the mantissa are the cell.
#[inline(always)]
pub(super) fn quantise(c: f64) -> u32 {
    const LARGEST: f64 = 1.0 - 0.5 / CELLS;
    let c = if c < LARGEST { c } else { LARGEST };
    ((c + 1.0).to_bits() >> (f64::MANTISSA_DIGITS - 1 - BITS)) as u32 & ((1 << BITS) - 1)
}

/// A finest cell of the incident or the scattered dimensions: four bits a level, coarsest highest,
/// of which the lowest is the first dimension's, the next the second's, and two are clear.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell(u64);

impl Cell {
    /// The cell of a point of the square.
    #[inline(always)]
    pub(super) fn of(square: DVec2) -> Self {
        Self(spread(quantise(square.x)) | spread(quantise(square.y)) << 1)
    }

    /// Which half or quadrant, `level` levels below the root.
    #[inline]
    pub(super) fn part(self, level: u32) -> usize {
        (self.0 >> (4 * (BITS - 1 - level)) & 3) as usize
    }
}

/// A finest cell of all dimensions: the slots on the way to it, four bits a level, coarsest
/// highest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Key(u64);

impl Key {
    /// From finest cells of the two squares; at rank 3 the second incident one is 0.
    #[inline(always)]
    pub(super) fn of_cells(incident: [u32; 2], scattered: [u32; 2]) -> Self {
        Self(interleave([scattered[0], scattered[1], incident[0], incident[1]]))
    }

    #[inline(always)]
    pub(super) fn of(rank: Rank, wi: DVec3, wo: DVec3) -> Self {
        let incidence = Incidence::new(rank, wi);
        let (i, o) = (incidence.point, incidence.square_of(wo));
        Self(interleave([o.x, o.y, i.x, i.y].map(quantise)))
    }

    /// The slot within a node, `level` levels below the root.
    #[inline(always)]
    pub(super) fn slot(self, level: u32) -> usize {
        (self.0 >> (4 * (BITS - 1 - level)) & 15) as usize
    }

    /// The slots of the first [`TOP`] levels.
    #[inline(always)]
    pub(super) fn top(self) -> usize {
        (self.0 >> (4 * (BITS - TOP))) as usize
    }
}

/// Bits 0, 1, 2, … of number n of 16 bits → n, n + 4, n + 8, ….
///
/// Numbers one after the other, a bit's place has the number in its two high bits; interleaved, in
/// the two low ones. Each step exchanges two bits of the places.
#[inline(always)]
fn interleave([a, b, c, d]: [u32; 4]) -> u64 {
    let mut w = u64::from(a | b << 16) | u64::from(c | d << 16) << 32;
    for (shift, low) in [
        (24, 0x0000_0000_ff00_ff00),
        (12, 0x0000_f0f0_0000_f0f0),
        (6, 0x00cc_00cc_00cc_00cc),
        (3, 0x0a0a_0a0a_0a0a_0a0a),
    ] {
        let exchanged = (w >> shift ^ w) & low;
        w ^= exchanged ^ exchanged << shift;
    }
    w
}

/// Bits 0, 1, 2, … of 16 → 0, 4, 8, ….
#[inline(always)]
fn spread(b: u32) -> u64 {
    let mut b = u64::from(b);
    b = (b | b << 24) & 0x0000_00ff_0000_00ff;
    b = (b | b << 12) & 0x000f_000f_000f_000f;
    b = (b | b << 6) & 0x0303_0303_0303_0303;
    (b | b << 3) & 0x1111_1111_1111_1111
}

impl TensorTree {
    /// The value stored for a pair of directions, and the level of its leaf (width 2^−level).
    ///
    /// NaN in, NaN out. Cost: one cache line (two at rank 3 now and then) a level.
    #[inline]
    pub fn leaf_at(&self, wi: DVec3, wo: DVec3) -> (f32, u32) {
        if !(wi.x + wi.y + wo.x + wo.y).is_finite() {
            return (f32::NAN, 0);
        }
        self.leaf(Key::of(self.rank, wi, wo))
    }

    #[inline]
    fn leaf(&self, key: Key) -> (f32, u32) {
        let mut slot = self.root;
        for level in 0..self.depth {
            match Slot::from(slot) {
                Slot::Leaf(value) => return (value, level),
                Slot::Branch(node) => slot = self.below(node, key.slot(level)),
            }
        }
        (leaf_value(slot), self.depth)
    }

    /// The number of the slot that a finest cell's leaf is in, and its level; `None` of the root.
    #[inline]
    pub(super) fn slot_of(&self, key: Key) -> Option<(usize, u32)> {
        let mut slot = self.root;
        let mut found = None;
        for level in 0..self.depth {
            if slot & BRANCH == 0 {
                break;
            }
            let at = (slot ^ BRANCH) as usize * self.rank.children() + key.slot(level);
            slot = self.slots.get(at).copied()?;
            found = Some((at, level + 1));
        }
        found
    }

    /// Calls `f(value, level)` for every leaf that a direction can reach: at rank 3 the half
    /// of the hypercube past normal incidence (dimension 0 from ½ on) is left out.
    pub fn for_each_leaf(&self, mut f: impl FnMut(f32, u32)) {
        self.walk(self.root.into(), 0, &mut f);
    }

    fn walk(&self, slot: Slot, level: u32, f: &mut impl FnMut(f32, u32)) {
        match slot {
            Slot::Leaf(value) => f(value, level),
            Slot::Branch(node) => {
                for &slot in self.live_slots(node, level) {
                    self.walk(slot.into(), level + 1, f);
                }
            }
        }
    }

    /// The children of a node that directions can reach.
    pub(super) fn live_slots(&self, node: usize, level: u32) -> &[u32] {
        let n = self.rank.children();
        let live = if level == 0 && self.rank == Rank::Three { n / 2 } else { n };
        let slots = if level < self.depth { self.node(node) } else { &[0; 16] };
        &slots[..live]
    }

    /// Smallest and largest leaf value.
    pub fn range(&self) -> (f32, f32) {
        let mut range = (f32::INFINITY, 0.0_f32);
        if self.rank == Rank::Four && !self.slots.is_empty() {
            // Every slot counts, in any order. Leaves compare as their bits do, below all branches
            // as u32 and above them as i32.
            let (mut least, mut most) = (f32::INFINITY.to_bits(), 0);
            for &slot in self.slots.iter() {
                least = least.min(slot);
                most = most.max(slot.cast_signed());
            }
            return (f32::from_bits(least), f32::from_bits(most.cast_unsigned()));
        }
        self.for_each_leaf(|v, _| range = (range.0.min(v), range.1.max(v)));
        range
    }

    /// Mean value over all pairs of coordinates that directions can reach; times π the mean
    /// directional-hemispherical total.
    pub fn mean(&self) -> f64 {
        self.mean_below(self.root.into(), 0)
    }

    /// Whether the mean of value − `floor` (at most the smallest value) exceeds `least`: found
    /// out as soon as the leaves seen so far suffice.
    pub(super) fn mean_exceeds(&self, floor: f64, least: f64) -> bool {
        fn add(tree: &TensorTree, slot: Slot, level: u32, volume: f64, left: &mut f64, floor: f64) {
            match slot {
                Slot::Leaf(value) => *left -= (f64::from(value) - floor) * volume,
                Slot::Branch(node) => {
                    let slots = tree.live_slots(node, level);
                    let volume = volume / slots.len() as f64;
                    for &slot in slots {
                        if *left >= 0.0 {
                            add(tree, slot.into(), level + 1, volume, left, floor);
                        }
                    }
                }
            }
        }
        let mut left = least;
        add(self, self.root.into(), 0, 1.0, &mut left, floor);
        left < 0.0
    }

    /// Mean value below a slot at `level`, by volume.
    pub(super) fn mean_below(&self, slot: Slot, level: u32) -> f64 {
        match slot {
            Slot::Leaf(value) => value.into(),
            Slot::Branch(node) => {
                let slots = self.live_slots(node, level);
                let sum: f64 = slots.iter().map(|&s| self.mean_below(s.into(), level + 1)).sum();
                sum / slots.len() as f64
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::TreeBuilder;
    use bsdfkit_sphere::direction::from_degrees;

    /// Rank 3, one branch: child c holds c + 1.
    fn eight() -> TensorTree {
        let mut b = TreeBuilder::new(Rank::Three);
        b.open_branch().unwrap();
        (1..=8_u8).for_each(|v| b.leaf(v.into()).unwrap());
        b.close_branch().unwrap();
        b.finish().unwrap()
    }

    #[test]
    fn grazing_and_axial_directions_stay_inside() {
        let grid: Vec<f32> = (0..256_u16).map(f32::from).collect();
        let mut b = TreeBuilder::new(Rank::Four);
        b.grid(2, &grid).unwrap();
        let tree = b.finish().unwrap();
        // On +X at grazing: the last cell of x, and the upper one of the middle two in y.
        let x = DVec3::X;
        assert_eq!(tree.leaf_at(-x, x).0, (((3 * 4) + 2) * 4 + 3) as f32 * 4.0 + 2.0);
        assert_eq!(tree.leaf_at(x, -x).0, ((2 * 4) * 4 + 2) as f32);
        let (rank3, slightly_long) = (eight(), DVec3::new(1.0 + 1e-9, 0.0, 0.0));
        assert!(rank3.leaf_at(slightly_long, slightly_long).0 > 0.0);
        assert_eq!(rank3.leaf_at(DVec3::X, DVec3::Z).1, 1);
    }

    #[test]
    fn rank_three_turns_with_the_incident_direction() {
        let tree = eight();
        for azimuth in [0.0, 37.0, 90.0, 200.0] {
            let wi = from_degrees(40.0, azimuth + 180.0);
            // Seen along the travel direction: ahead on the left, then behind on the right.
            let ahead = from_degrees(50.0, azimuth + 10.0);
            let behind = from_degrees(50.0, azimuth + 190.0);
            assert_eq!(tree.leaf_at(wi, ahead).0, 7.0);
            assert_eq!(tree.leaf_at(wi, behind).0, 1.0);
        }
        // Normal incidence is in the lower half of dimension 0 too.
        assert!(tree.leaf_at(DVec3::Z, DVec3::Z).0 as u32 % 2 == 1);
    }

    #[test]
    fn nan_in_nan_out() {
        assert!(eight().leaf_at(DVec3::NAN, DVec3::Z).0.is_nan());
        assert!(eight().leaf_at(DVec3::Z, DVec3::new(0.0, f64::NAN, 1.0)).0.is_nan());
    }

    #[test]
    fn dead_half_counts_nowhere() {
        // Live children are the even ones: 1, 3, 5, 7.
        assert_eq!(eight().range(), (1.0, 7.0));
        assert_eq!(eight().mean(), 4.0);
    }

    #[test]
    fn keys_interleave_the_bits_of_cells() {
        for k in 0..1000_u32 {
            let numbers =
                [1, 7, 31, 127].map(|m| k.wrapping_mul(m).wrapping_mul(2_654_435_761) >> 16);
            let [ox, oy, ix, iy] = numbers.map(spread);
            assert_eq!(interleave(numbers), ox | oy << 1 | ix << 2 | iy << 3);
        }
    }
}
