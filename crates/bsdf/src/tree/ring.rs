//! The reverse sense of an isotropic tree: the scattered direction known, the incident one not.
//!
//! With wo fixed at polar sine r, every incident direction sees it somewhere on the circle of
//! radius r. The concentric map makes that circle the rim of a square, |A| = r or |B| = r in A = 2x
//! − 1, B = 2y − 1, along which the azimuth is linear on each side. So each leaf that the rim
//! crosses is a rectangle in (sin² θi, azimuth), and its projected solid angle is ½ Δ(sin²) Δφ.
//!
//! As long as r stays within one ring of finest cells, the same leaves are crossed, and each end of
//! a crossing is either at a corner of the rim or at an azimuth proportional to 1/r. So the mass of
//! a slab of incident angles is exactly linear in 1/r, and two values a slab tabulate a ring.
//!
//! Cost: totals read one ring's table, made at the first touch by two walks along it; a sample
//! walks along the rim within one slab. Trees deeper than 2^10 cells are walked at each query.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::ops::Range;
use std::sync::OnceLock;

use super::lookup::{CELLS, quantise};
use super::node::{MAX_DEPTH, Slot, TensorTree};
use crate::DVec2;
use crate::unit::choose;
use bsdfkit_sphere::hilbert;

/// A leaf crossed by the rim: one value on a rectangle of incident directions.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    value: f64,
    sin2: (f64, f64),
    /// Azimuth of wo as seen from the travel direction of the incident light.
    azimuth: (f64, f64),
    level: u32,
}

impl Crossing {
    fn azimuth_width(&self) -> f64 {
        self.azimuth.1 - self.azimuth.0
    }

    fn projected_solid_angle(&self) -> f64 {
        0.5 * (self.sin2.1 - self.sin2.0) * self.azimuth_width()
    }
}

/// The deepest tree with tables: 512 rings of 512 slabs are 4 MiB. A guess: no isotropic data
/// seen has more than 2^8 cells.
const MAX_TABLE_DEPTH: u32 = 10;

/// The masses of all slabs of incident angles, by ring of the scattered direction.
#[derive(Debug)]
pub(super) struct Rings {
    /// Finest cells (2⁻¹⁶) in one of the tree.
    width: u32,
    /// A slab's mass at ¼ and at ¾ of the ring's width.
    rings: Vec<OnceLock<Vec<[f64; 2]>>>,
}

impl Rings {
    /// Tables, yet to be made, for a tree of rank 3.
    pub(super) fn new(tree: &TensorTree) -> Self {
        let depth = tree.depth().max(1);
        let count = if depth <= MAX_TABLE_DEPTH { 1 << (depth - 1) } else { 0 };
        let rings = (0..count).map(|_| OnceLock::new()).collect();
        Self { width: 1 << (MAX_DEPTH - depth), rings }
    }

    /// (f − floor) |cos θi| dωi over each slab, from grazing to normal incidence; the slabs are
    /// equally wide in sin θi. Empty where there are no tables.
    fn slabs(&self, tree: &TensorTree, wo: DVec2, floor: f64) -> impl Iterator<Item = f64> {
        let slabs = self.rings.len();
        let radius = wo.length().min(1.0);
        let ring = ((quantise(0.5 + 0.5 * radius) - (1 << (MAX_DEPTH - 1))) / self.width) as usize;
        let at = |part: f64| (ring as f64 + part) / slabs as f64;
        let table = self.rings.get(ring).map_or(&[][..], |once| {
            once.get_or_init(|| {
                let mut masses = vec![[0.0; 2]; slabs];
                for (i, radius) in [at(0.25), at(0.75)].into_iter().enumerate() {
                    for c in Ring::new(tree, DVec2::X * radius, 0..1 << (MAX_DEPTH - 1)).crossings {
                        // sin² at the borders of slabs: ((slabs − n) / slabs)².
                        let border =
                            |sin2: f64| slabs - (sin2.sqrt() * slabs as f64).round() as usize;
                        for n in border(c.sin2.1)..border(c.sin2.0) {
                            masses[n][i] += c.value * c.azimuth_width() * slab_sin2(n, slabs);
                        }
                    }
                }
                masses
            })
        });
        // Within the innermost ring only corners of the rim end crossings: no 1/r.
        let (inner, outer) = (1.0 / at(0.25), 1.0 / at(0.75));
        let mix = if ring == 0 { 0.0 } else { (1.0 / radius - inner) / (outer - inner) };
        table.iter().enumerate().map(move |(n, [a, b])| {
            (a + (b - a) * mix - floor * TAU * slab_sin2(n, slabs)).max(0.0)
        })
    }

    /// Whether no table holds: without tables, and at the very centre, which is in one cell of
    /// four.
    fn walks(&self, wo: DVec2) -> bool {
        self.rings.is_empty() || wo == DVec2::ZERO
    }

    /// ∫ (f − floor) |cos θi| dωi for a scattered direction with projection `wo`.
    pub(super) fn total(&self, tree: &TensorTree, wo: DVec2, floor: f64) -> f64 {
        if self.walks(wo) {
            Ring::new(tree, wo, 0..1 << (MAX_DEPTH - 1)).total(floor)
        } else {
            self.slabs(tree, wo, floor).sum()
        }
    }

    /// The slab of incident angles that u falls in, and where in it.
    fn slab(&self, tree: &TensorTree, wo: DVec2, floor: f64, u: f64) -> Option<(Range<u32>, f64)> {
        if self.walks(wo) {
            return Some((0..1 << (MAX_DEPTH - 1), u));
        }
        let total = self.total(tree, wo, floor);
        let (n, rest) = choose(self.slabs(tree, wo, floor).enumerate(), u * total)?;
        Some((n as u32 * self.width..(n as u32 + 1) * self.width, rest))
    }

    /// The projection of an incident direction with density (f − floor) / total.
    pub(super) fn sample(&self, tree: &TensorTree, wo: DVec2, floor: f64, u: f64) -> Option<DVec2> {
        let (slab, rest) = self.slab(tree, wo, floor, u)?;
        let ring = Ring::new(tree, wo, slab);
        let (crossing, rest) = ring.crossing(floor, rest)?;
        Some(ring.place(crossing, hilbert::unfold(rest)))
    }

    /// The same by two numbers: the polar angle follows the first, the azimuth the second.
    pub(super) fn sample2(
        &self,
        tree: &TensorTree,
        wo: DVec2,
        floor: f64,
        u: DVec2,
    ) -> Option<DVec2> {
        let (slab, x) = self.slab(tree, wo, floor, u.x)?;
        let ring = Ring::new(tree, wo, slab);
        let (crossing, y) = ring.crossing(floor, u.y)?;
        Some(ring.place(crossing, DVec2::new(x, y)))
    }
}

/// ½ Δ(sin² θ) of a slab.
fn slab_sin2(n: usize, slabs: usize) -> f64 {
    let sine = |n: usize| (slabs - n) as f64 / slabs as f64;
    0.5 * (sine(n).powi(2) - sine(n + 1).powi(2))
}

/// Every incident direction's value for one wo, within a slab of incident angles.
pub(super) struct Ring {
    wo: DVec2,
    /// Finest cells of dimension 0.
    slab: Range<u32>,
    crossings: Vec<Crossing>,
}

/// The sides of the rim, in finest cells and in A, B.
struct Rim {
    radius: f64,
    low: u32,
    high: u32,
}

impl Ring {
    /// `tree` has rank 3, `wo` is the projection of the scattered direction.
    pub(super) fn new(tree: &TensorTree, wo: DVec2, slab: Range<u32>) -> Self {
        let radius = wo.length().min(1.0);
        let rim =
            Rim { radius, low: quantise(0.5 - 0.5 * radius), high: quantise(0.5 + 0.5 * radius) };
        let mut ring = Self { wo, slab, crossings: Vec::new() };
        ring.walk(tree, tree.root.into(), [0; 3], 0, &rim);
        ring
    }

    fn walk(&mut self, tree: &TensorTree, slot: Slot, corner: [u32; 3], level: u32, rim: &Rim) {
        let width = 1 << (MAX_DEPTH - level);
        let spans = |c: u32, at: u32| (c..c + width).contains(&at);
        let [_, x, y] = corner;
        let meets = |c| spans(c, rim.low) || spans(c, rim.high);
        // Neither coordinate reaches a side, or both lie outside: no crossing below here.
        let outside = corner[0] >= self.slab.end || corner[0] + width <= self.slab.start;
        if outside || !meets(x) && !meets(y) {
            return;
        }
        match slot {
            Slot::Leaf(value) => self.cross(f64::from(value), corner, level, rim),
            Slot::Branch(node) => {
                let half = width / 2;
                for (i, &slot) in tree.live_slots(node, level).iter().enumerate() {
                    // Slot bits: scattered x, scattered y, incident.
                    let bit = |b: u32| ((i >> b) & 1) as u32 * half;
                    let child = [corner[0] + bit(2), x + bit(0), y + bit(1)];
                    self.walk(tree, slot.into(), child, level + 1, rim);
                }
            }
        }
    }

    fn cross(&mut self, value: f64, [c0, x, y]: [u32; 3], level: u32, rim: &Rim) {
        let width = 1 << (MAX_DEPTH - level);
        // Dimension 0 is ½ − ½ sin θ; a root that is one leaf reaches past normal incidence.
        let sine = |c: u32| (1.0 - 2.0 * f64::from(c) / CELLS).max(0.0);
        let (from, to) = (c0.max(self.slab.start), (c0 + width).min(self.slab.end));
        let sin2 = (sine(to).powi(2), sine(from).powi(2));
        if rim.radius == 0.0 {
            // The centre belongs to one cell, at whatever azimuth.
            if (x..x + width).contains(&rim.low) && (y..y + width).contains(&rim.low) {
                self.crossings.push(Crossing { value, sin2, azimuth: (0.0, TAU), level });
            }
            return;
        }
        let r = rim.radius;
        // The part of a side, −r to r, that the cell's other coordinate covers, over r.
        let part = |c: u32| {
            let at = |c: u32| ((2.0 * f64::from(c) / CELLS - 1.0) / r).clamp(-1.0, 1.0);
            (at(c), at(c + width))
        };
        let mut push = |(from, to): (f64, f64), centre: f64, sign: f64| {
            let ends = (centre + sign * FRAC_PI_4 * from, centre + sign * FRAC_PI_4 * to);
            let azimuth = (ends.0.min(ends.1), ends.0.max(ends.1));
            if azimuth.1 > azimuth.0 {
                self.crossings.push(Crossing { value, sin2, azimuth, level });
            }
        };
        let spans = |c: u32, at: u32| (c..c + width).contains(&at);
        if spans(x, rim.high) {
            push(part(y), 0.0, 1.0);
        }
        if spans(y, rim.high) {
            push(part(x), FRAC_PI_2, -1.0);
        }
        if spans(x, rim.low) {
            push(part(y), PI, -1.0);
        }
        if spans(y, rim.low) {
            push(part(x), PI + FRAC_PI_2, 1.0);
        }
    }

    /// Crossings with their (f − floor) |cos θi| dωi.
    fn masses(&self, floor: f64) -> impl Iterator<Item = (&Crossing, f64)> {
        let mass = move |c: &Crossing| (c.value - floor).max(0.0) * c.projected_solid_angle();
        self.crossings.iter().map(move |c| (c, mass(c)))
    }

    /// ∫ (f − floor) |cos θi| dωi.
    pub(super) fn total(&self, floor: f64) -> f64 {
        self.masses(floor).map(|(_, mass)| mass).sum()
    }

    /// The crossing that u falls in, and where in it.
    fn crossing(&self, floor: f64, u: f64) -> Option<(&Crossing, f64)> {
        choose(self.masses(floor), u * self.total(floor))
    }

    /// A point of the unit square in a crossing's rectangle, as projection of an incident
    /// direction.
    fn place(&self, c: &Crossing, p: DVec2) -> DVec2 {
        let sin = (c.sin2.0 + (c.sin2.1 - c.sin2.0) * p.x).sqrt();
        let seen = c.azimuth.0 + (c.azimuth.1 - c.azimuth.0) * p.y;
        // wo is seen at `seen` from the travel direction, which points away from wi.
        let towards = self.wo.y.atan2(self.wo.x) - seen + PI;
        DVec2::from_angle(towards) * sin
    }

    /// Levels of the largest and of the smallest leaf crossed.
    pub(super) fn levels(tree: &TensorTree, wo: DVec2) -> Option<(u32, u32)> {
        let ring = Self::new(tree, wo, 0..1 << (MAX_DEPTH - 1));
        let levels = ring.crossings.iter().map(|c| c.level);
        Some((levels.clone().min()?, levels.max()?))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::tree::{Rank, TreeBuilder};

    /// Cells of two sizes: a grid of 8 in half of the children, single leaves in the others.
    pub(in crate::tree) fn uneven() -> TensorTree {
        let mut b = TreeBuilder::new(Rank::Three);
        b.open_branch().unwrap();
        for child in 0..8_u16 {
            if child % 3 == 0 {
                let grid: Vec<f32> =
                    (0..512).map(|i| f32::from(i * 37 % 101 + child + 1)).collect();
                b.grid(3, &grid).unwrap();
            } else {
                b.leaf(f32::from(child) * 10.0 + 1.0).unwrap();
            }
        }
        b.close_branch().unwrap();
        b.finish().unwrap()
    }

    /// The walk is the oracle of the tables, at every radius.
    #[test]
    fn tables_agree_with_walks() {
        let tree = uneven();
        let rings = Rings::new(&tree);
        assert_eq!(rings.rings.len(), 8);
        for k in 1..2000 {
            // An irrational step meets no border of rings, where the tables give the outer side.
            let wo = DVec2::from_angle(f64::from(k)) * (f64::from(k) * 0.000_499_87);
            let walk = Ring::new(&tree, wo, 0..1 << (MAX_DEPTH - 1));
            for floor in [0.0, 1.0] {
                let (ours, oracle) = (rings.total(&tree, wo, floor), walk.total(floor));
                assert!((ours / oracle - 1.0).abs() < 1e-11, "{wo}: {ours}, by walk {oracle}");
            }
        }
    }

    /// Every direction drawn sees wo where a look-up finds more than the floor.
    #[test]
    fn samples_land_where_there_is_light() {
        let tree = uneven();
        let rings = Rings::new(&tree);
        for k in 1..2000 {
            let u = bsdfkit_sphere::sequence::golden(k as usize);
            let wo = DVec2::from_angle(f64::from(k)) * (f64::from(k) * 0.000_499_87);
            let wi = rings.sample(&tree, wo, 1.0, u).unwrap();
            assert!(wi.length() <= 1.0);
            assert!(tree.leaf_at(wi.extend(0.0), wo.extend(0.0)).0 > 1.0, "{wo} from {wi}");
        }
    }
}
