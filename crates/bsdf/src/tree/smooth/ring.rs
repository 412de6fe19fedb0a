//! The reverse sense of a smooth isotropic tree: the scattered direction known, the incident one
//! not.
//!
//! As for the stored values (`tree/ring.rs`), each leaf that the circle of the known direction
//! crosses is a rectangle in (sin θi, azimuth); its value is now quadratic in both. While the
//! radius r stays within one ring of finest cells, the leaves crossed are the same, an end of a
//! crossing is at a corner or at an azimuth proportional to 1/r, and places across and along the
//! rim are linear in r: the mass of a slab of incident angles is a sum of powers of r from 1/r to
//! r⁴, which six values tabulate exactly.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::ops::Range;
use std::sync::OnceLock;

use super::super::lookup::{CELLS, quantise};
use super::super::node::{MAX_DEPTH, Slot};
use super::patch::{Density, Patch};
use super::shaped::Shaped;
use crate::DVec2;
use crate::unit::choose;
use bsdfkit_sphere::hilbert;

/// The deepest tree with tables: 512 rings of 512 slabs are 12 MiB. Deeper ones are walked at each
/// query.
const MAX_TABLE_DEPTH: u32 = 10;

/// Finest cells of dimension 0, from grazing to normal incidence.
const ALL: Range<u32> = 0..1 << (MAX_DEPTH - 1);

/// Radii of a ring at which masses are tabulated: as many as there are powers of the radius.
const NODES: usize = 6;

/// The masses of all slabs of incident angles, by ring of the scattered direction.
#[derive(Debug)]
pub(super) struct Rings {
    /// Finest cells (2⁻¹⁶) in one of the tree.
    width: u32,
    /// A slab's mass at places of the ring's width.
    rings: Vec<OnceLock<Vec<[f64; NODES]>>>,
}

impl Rings {
    /// Tables, yet to be made, for a tree of rank 3 and this depth.
    pub(super) fn new(depth: u32) -> Self {
        let depth = depth.max(1);
        let count = if depth <= MAX_TABLE_DEPTH { 1 << (depth - 1) } else { 0 };
        let rings = (0..count).map(|_| OnceLock::new()).collect();
        Self { width: 1 << (MAX_DEPTH - depth), rings }
    }

    /// Mass over each slab, from grazing to normal incidence; the slabs are equally wide in sin θi.
    fn slabs(&self, shaped: Shaped<'_>, wo: DVec2, extra: f64) -> impl Iterator<Item = f64> {
        let slabs = self.rings.len();
        let radius = wo.length().min(1.0);
        let ring = ((quantise(0.5 + 0.5 * radius) - ALL.end) / self.width) as usize;
        let nodes: [f64; NODES] = std::array::from_fn(|i| {
            // Chebyshev's, at which the least is lost to rounding.
            let part = 0.5 - 0.5 * (PI * (i as f64 + 0.5) / NODES as f64).cos();
            (ring as f64 + part) / slabs as f64
        });
        let table = self.rings.get(ring).map_or(&[][..], |once| {
            once.get_or_init(|| {
                let mut masses = vec![[0.0; NODES]; slabs];
                for (i, radius) in nodes.into_iter().enumerate() {
                    for c in Ring::new(shaped, DVec2::X * radius, ALL, 0.0).crossings {
                        let border = |sine: f64| slabs - (sine * slabs as f64).round() as usize;
                        for n in border(c.sine.1)..border(c.sine.0) {
                            let sine = |n: usize| (slabs - n) as f64 / slabs as f64;
                            masses[n][i] += c.mass_between(sine(n + 1), sine(n));
                        }
                    }
                }
                masses
            })
        });
        // Within the innermost ring only corners of the rim end crossings: no 1/r.
        let scale = |r: f64| if ring == 0 { 1.0 } else { r };
        let weights: [f64; NODES] = std::array::from_fn(|i| {
            let others = (0..NODES).filter(|j| *j != i);
            let lagrange = others.map(|j| (radius - nodes[j]) / (nodes[i] - nodes[j]));
            lagrange.product::<f64>() * scale(nodes[i]) / scale(radius)
        });
        table.iter().enumerate().map(move |(n, masses)| {
            let mass: f64 = masses.iter().zip(weights).map(|(m, w)| m * w).sum();
            let even = ((slabs - n) as f64 - 0.5) / (slabs as f64).powi(2);
            mass.max(0.0) + extra * TAU * even
        })
    }

    /// Whether no table holds: without tables, and at the very centre, which is in one cell of
    /// four.
    fn walks(&self, wo: DVec2) -> bool {
        self.rings.is_empty() || wo == DVec2::ZERO
    }

    /// ∫ (f − floor + extra) |cos θi| dωi for a scattered direction with projection `wo`.
    pub(super) fn total(&self, shaped: Shaped<'_>, wo: DVec2, extra: f64) -> f64 {
        if self.walks(wo) {
            Ring::new(shaped, wo, ALL, extra).total()
        } else {
            self.slabs(shaped, wo, extra).sum()
        }
    }

    /// The projection of an incident direction with density (f − floor + extra) / total.
    pub(super) fn sample(
        &self,
        shaped: Shaped<'_>,
        wo: DVec2,
        extra: f64,
        u: f64,
    ) -> Option<DVec2> {
        if self.walks(wo) {
            return Ring::new(shaped, wo, ALL, extra).sample(u);
        }
        let total: f64 = self.slabs(shaped, wo, extra).sum();
        let (slab, rest) = choose(self.slabs(shaped, wo, extra).enumerate(), u * total)?;
        let slab = slab as u32 * self.width..(slab as u32 + 1) * self.width;
        Ring::new(shaped, wo, slab, extra).sample(rest)
    }
}

/// A side of the rim, −r to r in A = 2x − 1 or B = 2y − 1.
struct RimSide {
    /// The coordinate along it: scattered dimension 0 or 1.
    along: usize,
    /// Azimuth of its middle, and its sense of rotation.
    azimuth: (f64, f64),
    /// The other coordinate, and its finest cell.
    across: (f64, u32),
}

/// A leaf crossed by the rim.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    /// Sines of the incident angle.
    sine: (f64, f64),
    /// Ends on the rim's side, −1 to 1.
    along: (f64, f64),
    /// Azimuth of wo as seen from the travel direction of the incident light: middle and sense.
    azimuth: (f64, f64),
    /// Value by powers of the sine, then of the place along the side.
    value: [[f64; 3]; 3],
}

impl Crossing {
    /// Half of the extent along the side, and its middle.
    fn extent(&self) -> (f64, f64) {
        (0.5 * (self.along.1 - self.along.0), 0.5 * (self.along.0 + self.along.1))
    }

    /// Mean value along the side by powers of the sine.
    fn means(&self) -> [f64; 3] {
        let (half, middle) = self.extent();
        let square = middle * middle + half * half / 3.0;
        self.value.map(|[one, slope, curve]| one + slope * middle + curve * square)
    }

    /// ∫ value |cos θi| dωi over a range of sines.
    fn mass_between(&self, from: f64, to: f64) -> f64 {
        let [one, slope, curve] = self.means();
        let integral = |s: f64| s * s * (0.5 * one + s * (slope / 3.0 + 0.25 * curve * s));
        let mass = FRAC_PI_4 * (self.along.1 - self.along.0) * (integral(to) - integral(from));
        mass.max(0.0)
    }

    fn mass(&self) -> f64 {
        self.mass_between(self.sine.0, self.sine.1)
    }

    /// Sine and azimuth of a point of the crossing with density value; `u` is in the unit square.
    fn sample(&self, u: DVec2) -> (f64, f64) {
        let (from, to) = self.sine;
        let aim = u.x * self.mass();
        // It rises throughout: Newton's steps, halving where they leave the bracket.
        let (mut low, mut high) = (from, to);
        let mut sine = (from * from + (to * to - from * from) * u.x).sqrt();
        let means = self.means();
        let (half, middle) = self.extent();
        let at = |[one, slope, curve]: [f64; 3], x: f64| one + (slope + curve * x) * x;
        for _ in 0..32 {
            let error = self.mass_between(from, sine) - aim;
            if error > 0.0 {
                high = sine;
            } else {
                low = sine;
            }
            let density = FRAC_PI_4 * 2.0 * half * sine * at(means, sine);
            let next = sine - error / density;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let step = (next - sine).abs();
            sine = next;
            if step <= 1e-15 {
                break;
            }
        }
        // Along the side by powers of the place from −1 to 1 over its extent.
        let [slope, curve] = [1, 2].map(|n| at(self.value.map(|powers| powers[n]), sine));
        let slope = half * (slope + 2.0 * curve * middle);
        let density = Density::new(at(means, sine), slope, curve * half * half);
        let place = middle + half * (2.0 * density.warp(u.y) - 1.0);
        (sine, self.azimuth.0 + self.azimuth.1 * FRAC_PI_4 * place)
    }
}

/// Powers of zero + unit · x → those of x.
fn moved([one, slope, curve]: [f64; 3], zero: f64, unit: f64) -> [f64; 3] {
    [one + (slope + curve * zero) * zero, (slope + 2.0 * curve * zero) * unit, curve * unit * unit]
}

/// Every incident direction's value for one wo, within a slab of incident angles.
struct Ring<'a> {
    shaped: Shaped<'a>,
    wo: DVec2,
    radius: f64,
    extra: f64,
    /// Finest cells of dimension 0.
    slab: Range<u32>,
    sides: [RimSide; 4],
    crossings: Vec<Crossing>,
}

impl<'a> Ring<'a> {
    /// The tree has rank 3, `wo` is the projection of the scattered direction.
    fn new(shaped: Shaped<'a>, wo: DVec2, slab: Range<u32>, extra: f64) -> Self {
        let radius = wo.length().min(1.0);
        let side = |along, sign: f64, azimuth| {
            let across = 0.5 + 0.5 * sign * radius;
            RimSide { along, azimuth, across: (across, quantise(across)) }
        };
        let sides = [
            side(1, 1.0, (0.0, 1.0)),
            side(0, 1.0, (FRAC_PI_2, -1.0)),
            side(1, -1.0, (PI, -1.0)),
            side(0, -1.0, (PI + FRAC_PI_2, 1.0)),
        ];
        let mut ring = Self { shaped, wo, radius, extra, slab, sides, crossings: Vec::new() };
        ring.walk(shaped.tree.root(), usize::MAX, [0; 3], 0);
        ring
    }

    fn walk(&mut self, slot: Slot, number: usize, corner: [u32; 3], level: u32) {
        let width = 1 << (MAX_DEPTH - level);
        let meets =
            |s: &RimSide| (corner[2 - s.along]..corner[2 - s.along] + width).contains(&s.across.1);
        let outside = corner[0] >= self.slab.end || corner[0] + width <= self.slab.start;
        if outside || !self.sides.iter().any(meets) {
            return;
        }
        match slot {
            Slot::Leaf(_) => self.cross(number, corner, level),
            Slot::Branch(node) => {
                let tree = self.shaped.tree;
                for (i, &slot) in tree.live_slots(node, level).iter().enumerate() {
                    // Slot bits: scattered x, scattered y, incident.
                    let bit = |b: u32| ((i >> b) & 1) as u32 * (width / 2);
                    let [p, x, y] = corner;
                    let child = [p + bit(2), x + bit(0), y + bit(1)];
                    self.walk(slot.into(), 8 * node + i, child, level + 1);
                }
            }
        }
    }

    fn cross(&mut self, slot: usize, corner: [u32; 3], level: u32) {
        let width = 1 << (MAX_DEPTH - level);
        // Dimension 0 is ½ − ½ sin θ; a root that is one leaf reaches past normal incidence.
        let sine = |c: u32| (1.0 - 2.0 * f64::from(c) / CELLS).max(0.0);
        let first = corner[0].max(self.slab.start);
        let last = (corner[0] + width).min(self.slab.end);
        let excess = if level == 0 { self.whole() } else { self.shaped.excess(slot) };
        let [[a, b, c, d, e], [_, b_y, _, _, e_y]] =
            self.shaped.patches(slot).map(Patch::coefficients);
        // Place in the leaf, −1 to 1, of a coordinate: its value at 0, and per unit.
        let scale = 2.0 * CELLS / f64::from(width);
        let place = |corner: u32| (-2.0 * f64::from(corner) / f64::from(width) - 1.0, scale);
        let (s_zero, s_unit) = place(corner[0]);
        let (s_zero, s_unit) = (s_zero + 0.5 * s_unit, -0.5 * s_unit);
        let centre = self.radius == 0.0;
        for side in &self.sides {
            let (across, along) = (corner[2 - side.along], corner[1 + side.along]);
            let spans = |c: u32, at: u32| (c..c + width).contains(&at);
            if !spans(across, side.across.1) {
                continue;
            }
            let end = |c: u32| ((2.0 * f64::from(c) / CELLS - 1.0) / self.radius).clamp(-1.0, 1.0);
            let ends = if !centre {
                (end(along), end(along + width))
            } else if side.azimuth.0 == 0.0 && spans(along, side.across.1) {
                // The centre belongs to one cell, at whatever azimuth.
                (-4.0, 4.0)
            } else {
                continue;
            };
            if ends.0 >= ends.1 {
                continue;
            }
            let (zero, unit) = place(across);
            let tau = (zero + unit * side.across.0).clamp(-1.0, 1.0);
            let (zero, unit) = place(along);
            let (zero, unit) = (zero + 0.5 * unit, 0.5 * unit * self.radius);
            // By powers of s, then of the place t along the side.
            let shape = if side.along == 1 {
                let y = [1.0 - e_y / 3.0, b_y, e_y];
                let middle = 1.0 - (d + e) / 3.0 + (b + e * tau) * tau;
                [middle, a + c * tau, d].map(|by_s| y.map(|by_t| by_s * by_t))
            } else {
                let y = 1.0 + b_y * tau + e_y * (tau * tau - 1.0 / 3.0);
                let middle = 1.0 - (d + e) / 3.0;
                [[middle, b, e], [a, c, 0.0], [d, 0.0, 0.0]].map(|by_t| by_t.map(|c| c * y))
            };
            let along_side = shape.map(|by_t| moved(by_t, zero, unit));
            let mut value = [[0.0; 3]; 3];
            for n in 0..3 {
                let by_sine = moved([0, 1, 2].map(|m| along_side[m][n]), s_zero, s_unit);
                for m in 0..3 {
                    value[m][n] = excess * by_sine[m];
                }
            }
            value[0][0] += self.extra;
            self.crossings.push(Crossing {
                sine: (sine(last), sine(first)),
                along: ends,
                azimuth: side.azimuth,
                value,
            });
        }
    }

    /// Value − floor of a tree that is one leaf.
    fn whole(&self) -> f64 {
        match self.shaped.tree.root() {
            Slot::Leaf(value) => (f64::from(value) - self.shaped.floor).max(0.0),
            Slot::Branch(_) => 0.0,
        }
    }

    fn total(&self) -> f64 {
        self.crossings.iter().map(Crossing::mass).sum()
    }

    fn sample(&self, u: f64) -> Option<DVec2> {
        let masses = self.crossings.iter().map(|c| (c, c.mass()));
        let (crossing, rest) = choose(masses, u * self.total())?;
        let (sine, seen) = crossing.sample(hilbert::unfold(rest));
        // wo is seen at `seen` from the travel direction, which points away from wi.
        let towards = self.wo.y.atan2(self.wo.x) - seen + PI;
        Some(DVec2::from_angle(towards) * sine)
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::fit;
    use super::*;
    use crate::DVec3;
    use crate::distribution::Distribution;
    use crate::tree::TreeDistribution;
    use crate::tree::ring::tests::uneven;
    use std::sync::Arc;

    /// The walk is the oracle of the tables, at every radius.
    #[test]
    fn tables_agree_with_walks() {
        let tree = uneven();
        let patches = fit(&tree, 1.0);
        let shaped = Shaped { tree: &tree, patches: &patches, floor: 1.0 };
        let rings = Rings::new(tree.depth());
        for k in 1..2000 {
            // An irrational step meets no border of rings, where the tables give the outer side.
            let wo = DVec2::from_angle(f64::from(k)) * (f64::from(k) * 0.000_499_87);
            for extra in [0.0, 1.0] {
                let (ours, walk) =
                    (rings.total(shaped, wo, extra), Ring::new(shaped, wo, ALL, extra).total());
                assert!((ours / walk - 1.0).abs() < 1e-11, "{wo}: {ours}, by walk {walk}");
            }
        }
    }

    /// Quadrature over incident directions is the oracle of the walk.
    #[test]
    fn walks_agree_with_look_ups() {
        let smooth = super::super::SmoothTree::new(Arc::new(TreeDistribution::new(uneven())));
        let smooth = smooth.unwrap();
        for radius in [0.0, 0.21, 0.47, 0.83, 0.999] {
            let wo = DVec2::from_angle(2.0) * radius;
            // Azimuths and sines that are symmetric within each cell: midpoints, 16 a cell.
            let (turns, steps) = (4096, 256);
            let mut sum = 0.0;
            for i in 0..turns * steps {
                let sine = (f64::from(i / turns) + 0.5) / f64::from(steps);
                let azimuth = TAU * (f64::from(i % turns) + 0.5) / f64::from(turns);
                let wi = DVec2::from_angle(azimuth) * sine;
                let (wi, wo): (DVec3, DVec3) = (wi.extend(0.0), wo.extend(0.0));
                sum += smooth.value(wi, wo) * sine;
            }
            let integral = sum * TAU / f64::from(turns * steps);
            let total = smooth.total(wo.extend(0.0), crate::Sense::Reverse, 0.0);
            assert!((total / integral - 1.0).abs() < 1e-3, "{radius}: {total} {integral}");
        }
    }
}
