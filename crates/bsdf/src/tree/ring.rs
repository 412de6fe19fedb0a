//! The reverse sense of an isotropic tree: the scattered direction known, the incident one not.
//!
//! With wo fixed at polar sine r, every incident direction sees it somewhere on the circle of radius
//! r. The concentric map makes that circle the rim of a square, |A| = r or |B| = r in
//! A = 2x − 1, B = 2y − 1, along which the azimuth is linear on each side. So each leaf that the rim
//! crosses is a rectangle in (sin² θi, azimuth), and its projected solid angle is ½ Δ(sin²) Δφ.
//!
//! Cost: a walk over the leaves crossed at each query, 2^(2 depth) of them at most. No table
//! would do for all r, as the lengths of the crossings at the corners change with r.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use super::lookup::{CELLS, quantise};
use super::node::{MAX_DEPTH, Slot, TensorTree};
use crate::DVec2;
use crate::query::BELOW_ONE;
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
    fn projected_solid_angle(&self) -> f64 {
        0.5 * (self.sin2.1 - self.sin2.0) * (self.azimuth.1 - self.azimuth.0)
    }
}

/// Every incident direction's value for one wo.
pub(super) struct Ring {
    wo: DVec2,
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
    pub(super) fn new(tree: &TensorTree, wo: DVec2) -> Self {
        let radius = wo.length().min(1.0);
        let rim =
            Rim { radius, low: quantise(0.5 - 0.5 * radius), high: quantise(0.5 + 0.5 * radius) };
        let mut ring = Self { wo, crossings: Vec::new() };
        ring.walk(tree, tree.root.into(), [0; 3], 0, &rim);
        ring
    }

    fn walk(&mut self, tree: &TensorTree, slot: Slot, corner: [u32; 3], level: u32, rim: &Rim) {
        let width = 1 << (MAX_DEPTH - level);
        let spans = |c: u32, at: u32| (c..c + width).contains(&at);
        let [_, x, y] = corner;
        let meets = |c| spans(c, rim.low) || spans(c, rim.high);
        // Neither coordinate reaches a side, or both lie outside: no crossing below here.
        if !meets(x) && !meets(y) {
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
        let sin2 = (sine(c0 + width).powi(2), sine(c0).powi(2));
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

    /// ∫ (f − floor) |cos θi| dωi.
    pub(super) fn total(&self, floor: f64) -> f64 {
        self.crossings.iter().map(|c| (c.value - floor).max(0.0) * c.projected_solid_angle()).sum()
    }

    /// The projection of an incident direction with density (f − floor) / total.
    pub(super) fn sample(&self, floor: f64, u: f64) -> Option<DVec2> {
        let mut left = u * self.total(floor);
        let mut chosen = None;
        for c in &self.crossings {
            let mass = (c.value - floor).max(0.0) * c.projected_solid_angle();
            if mass > 0.0 {
                chosen = Some((c, (left / mass).min(BELOW_ONE)));
                if left < mass {
                    break;
                }
                left -= mass;
            }
        }
        let (c, rest) = chosen?;
        let p = hilbert::unfold(rest);
        let sin = (c.sin2.0 + (c.sin2.1 - c.sin2.0) * p.x).sqrt();
        let seen = c.azimuth.0 + (c.azimuth.1 - c.azimuth.0) * p.y;
        // wo is seen at `seen` from the travel direction, which points away from wi.
        let towards = self.wo.y.atan2(self.wo.x) - seen + PI;
        Some(DVec2::from_angle(towards) * sin)
    }

    /// Levels of the largest and of the smallest leaf crossed.
    pub(super) fn levels(&self) -> Option<(u32, u32)> {
        let levels = self.crossings.iter().map(|c| c.level);
        Some((levels.clone().min()?, levels.max()?))
    }
}
