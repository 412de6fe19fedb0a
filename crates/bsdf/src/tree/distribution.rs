//! A tree as a distribution: luminance, and optional chromaticity in trees of their own.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::cumulative::{Slice, Slices};
use super::descent::Top;
use super::hues::{TreeHues, each_pair};
use super::lookup::{Cell, Incidence};
use super::loops::{Numbers, Samples, Totals};
use super::node::{Rank, Slot, TensorTree};
use super::ring::{Ring, Rings};
use super::walk::{Along, Warp};
use crate::cell;
use crate::distribution::{Distribution, LAMBERTIAN_THRESHOLD, NEGLIGIBLE_TOTAL};
use crate::error::{Error, Result};
use crate::lanes::{Lanes, Sense};
use crate::spectrum::Bands;
use crate::{DVec2, DVec3, Xyz};
use bsdfkit_sphere::concentric::disk_to_square;
use bsdfkit_sphere::widest::widest;

/// A tree's minimum from here on (1/sr) is not a diffuse floor but a peak: it stays in the tree.
/// The reference library's constant; matrices have none there.
const LAMBERTIAN_LIMIT: f64 = 1.5 / PI;

/// A BSDF component stored as tensor trees.
///
/// What sampling and totals need is made at their first use in each sense and kept; no query
/// takes a lock afterwards.
#[derive(Debug)]
pub struct TreeDistribution {
    luminance: TensorTree,
    /// CIE 1976 u′ and v′.
    chromaticity: Option<[TensorTree; 2]>,
    pub(super) hues: Option<TreeHues>,
    top: OnceLock<Top>,
    forward: OnceLock<Slices>,
    reverse: OnceLock<Slices>,
    rings: OnceLock<Rings>,
}

impl TreeDistribution {
    /// Luminance `y` in the colour stored for a pair of directions; grey where none is.
    pub(super) fn coloured(&self, y: f64, wi: DVec3, wo: DVec3) -> Xyz {
        match &self.chromaticity {
            None => Xyz::grey(y),
            Some([u, v]) => {
                Xyz::from_yuv(y, u.leaf_at(wi, wo).0.into(), v.leaf_at(wi, wo).0.into())
            }
        }
    }

    /// A colourless one; values in 1/sr.
    pub fn new(luminance: TensorTree) -> Self {
        Self {
            luminance,
            chromaticity: None,
            hues: None,
            top: OnceLock::new(),
            forward: OnceLock::new(),
            reverse: OnceLock::new(),
            rings: OnceLock::new(),
        }
    }

    /// A coloured one: trees of Y (1/sr), u′ and v′, of equal rank but any shape.
    pub fn with_chromaticity(luminance: TensorTree, u: TensorTree, v: TensorTree) -> Result<Self> {
        for (tree, name) in [(&u, "u′"), (&v, "v′")] {
            if tree.rank() != luminance.rank() {
                return Err(Error::argument(format!(
                    "{name} tree: expected rank {}, found {}",
                    luminance.rank().dimensions(),
                    tree.rank().dimensions()
                )));
            }
        }
        Ok(Self { chromaticity: Some([u, v]), ..Self::new(luminance) })
    }

    /// The tree of Y, 1/sr.
    pub fn luminance(&self) -> &TensorTree {
        &self.luminance
    }

    /// The trees of CIE 1976 u′ and v′.
    pub fn chromaticity(&self) -> Option<&[TensorTree; 2]> {
        self.chromaticity.as_ref()
    }

    /// With sums that a file holds.
    pub(crate) fn with_slices(self, sense: Sense, slices: Slices) -> Self {
        let once = match sense {
            Sense::Forward => &self.forward,
            Sense::Reverse => &self.reverse,
        };
        // Just made: nobody has filled it yet.
        let _ = once.set(slices);
        self
    }

    /// What sampling and totals need, for a file to hold.
    pub(crate) fn slices(&self, sense: Sense) -> &Slices {
        let once = match sense {
            Sense::Forward => &self.forward,
            Sense::Reverse => &self.reverse,
        };
        once.get_or_init(|| Slices::new(&self.luminance, sense))
    }

    /// The slice of a known direction and, forward, the frame in which to read it; `None` when the
    /// sense has no slices (rank 3 backward).
    #[inline]
    fn slice(&self, known: DVec3, sense: Sense) -> Option<(Slice, Incidence)> {
        let rank = self.luminance.rank();
        let incidence = Incidence::new(rank, known);
        let cell = match (sense, rank) {
            (Sense::Forward, _) => incidence.cell(),
            (Sense::Reverse, Rank::Four) => Cell::of(disk_to_square(known.truncate())),
            (Sense::Reverse, Rank::Three) => return None,
        };
        Some((self.slices(sense).at(cell), incidence))
    }

    #[inline]
    fn top(&self) -> &Top {
        self.top.get_or_init(|| Top::new(&self.luminance))
    }

    fn rings(&self) -> &Rings {
        self.rings.get_or_init(|| Rings::new(&self.luminance))
    }

    /// Smallest "sharp" RGB over the leaves of Y, each with the mean chromaticity of its box.
    fn sharp_minimum(&self, slots: [Slot; 3], level: u32, least: &mut [f64; 3]) {
        let Some([u, v]) = &self.chromaticity else { return };
        let trees = [&self.luminance, u, v];
        match slots[0] {
            Slot::Leaf(y) => {
                let (u, v) = (u.mean_below(slots[1], level), v.mean_below(slots[2], level));
                let rgb = Xyz::from_yuv(y.into(), u, v).to_sharp_rgb();
                *least = std::array::from_fn(|i| least[i].min(rgb[i]));
            }
            Slot::Branch(node) => {
                for child in 0..self.luminance.live_slots(node, level).len() {
                    let below = std::array::from_fn(|i| match slots[i] {
                        Slot::Branch(node) => trees[i].live_slots(node, level)[child].into(),
                        leaf @ Slot::Leaf(_) => leaf,
                    });
                    self.sharp_minimum(below, level + 1, least);
                }
            }
        }
    }
}

impl Distribution for TreeDistribution {
    #[inline]
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        self.top().value(&self.luminance, wi, wo).into()
    }

    fn cells(&self, known: DVec3, sense: Sense, out: &mut Vec<cell::Cell>) -> bool {
        self.luminance.leaves_of(known, sense, out)
    }

    fn values(&self, wi: Lanes<'_>, wo: Lanes<'_>, out: &mut [f64]) {
        self.top().values(&self.luminance, wi, wo, out);
    }

    fn value_xyz(&self, wi: DVec3, wo: DVec3) -> Xyz {
        self.coloured(self.value(wi, wo), wi, wo)
    }

    fn is_coloured(&self) -> bool {
        self.chromaticity.is_some()
    }

    fn wavelengths(&self) -> Option<&Bands> {
        self.hues.as_ref().map(|hues| hues.hue().basis().bands())
    }

    fn spectra(&self, known: DVec3, other: &[DVec3], sense: Sense, out: &mut [f64]) {
        each_pair(known, other, sense, out, |wi, wo, out| {
            self.bands(self.value(wi, wo), wi, wo, out);
        });
    }

    fn constant_part(&self) -> Xyz {
        let (part, limit) = match &self.chromaticity {
            None => (Xyz::grey(self.luminance.range().0.into()), LAMBERTIAN_LIMIT),
            Some([u, v]) => {
                let roots = [self.luminance.root.into(), u.root.into(), v.root.into()];
                let mut least = [f64::INFINITY; 3];
                self.sharp_minimum(roots, 0, &mut least);
                (Xyz::from_sharp_rgb(least), f64::INFINITY)
            }
        };
        if part.y > LAMBERTIAN_THRESHOLD && part.y < limit { part } else { Xyz::ZERO }
    }

    fn total(&self, known: DVec3, sense: Sense, floor: f64) -> f64 {
        if !(known.x + known.y).is_finite() {
            return f64::NAN;
        }
        match self.slice(known, sense) {
            Some((slice, _)) => PI * (f64::from(slice.mean) - floor).max(0.0),
            None => self.rings().total(&self.luminance, known.truncate(), floor),
        }
    }

    fn totals(&self, known: Lanes<'_>, sense: Sense, floor: f64, out: &mut [f64]) {
        if sense == Sense::Reverse && self.luminance.rank() == Rank::Three {
            for (n, out) in out.iter_mut().enumerate() {
                *out = self.total(known.at(n), sense, floor);
            }
            return;
        }
        let rank = self.luminance.rank();
        widest(Totals { rank, slices: self.slices(sense), known, sense, floor, out });
    }

    fn max_total(&self, floor: f64) -> f64 {
        let largest = self.slices(Sense::Forward).iter().map(|s| s.mean).fold(0.0, f32::max);
        PI * (f64::from(largest) - floor).max(0.0)
    }

    fn is_negligible(&self, floor: f64) -> bool {
        // The mean over all directions is at most the largest total, and needs no slices.
        !self.luminance.mean_exceeds(floor, NEGLIGIBLE_TOTAL / PI)
            && self.max_total(floor) <= NEGLIGIBLE_TOTAL
    }

    fn sample(&self, known: DVec3, sense: Sense, floor: f64, u: f64) -> Option<DVec2> {
        if !(known.x + known.y + u).is_finite() {
            return None;
        }
        let u = u.inside();
        let Some((slice, incidence)) = self.slice(known, sense) else {
            return self.rings().sample(&self.luminance, known.truncate(), floor, u);
        };
        let square = self.slices(sense).sample::<Along>(&self.luminance, &slice, floor, u)?;
        Some(incidence.disk_of(square))
    }

    fn sample2(&self, known: DVec3, sense: Sense, floor: f64, u: DVec2) -> Option<DVec2> {
        if !(known.x + known.y + u.x + u.y).is_finite() {
            return None;
        }
        let u = u.inside();
        let Some((slice, incidence)) = self.slice(known, sense) else {
            return self.rings().sample2(&self.luminance, known.truncate(), floor, u);
        };
        let square = self.slices(sense).sample::<Warp>(&self.luminance, &slice, floor, u)?;
        Some(incidence.disk_of(square))
    }

    fn samples(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        u: &[f64],
        out: &mut [Option<DVec2>],
    ) {
        if sense == Sense::Reverse && self.luminance.rank() == Rank::Three {
            for (n, out) in out.iter_mut().enumerate() {
                *out = self.sample(known.at(n), sense, floor, u[n]);
            }
            return;
        }
        let tree = &self.luminance;
        widest(Samples::<Along> { tree, slices: self.slices(sense), known, sense, floor, u, out });
    }

    fn samples2(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        u: &[DVec2],
        out: &mut [Option<DVec2>],
    ) {
        if sense == Sense::Reverse && self.luminance.rank() == Rank::Three {
            for (n, out) in out.iter_mut().enumerate() {
                *out = self.sample2(known.at(n), sense, floor, u[n]);
            }
            return;
        }
        let tree = &self.luminance;
        widest(Samples::<Warp> { tree, slices: self.slices(sense), known, sense, floor, u, out });
    }

    fn projected_solid_angle(
        &self,
        known: DVec3,
        other: Option<DVec3>,
        sense: Sense,
    ) -> Option<(f64, f64)> {
        let (coarsest, finest) = match (other, sense) {
            (Some(wo), Sense::Forward) => {
                let (value, level) = self.luminance.leaf_at(known, wo);
                (!value.is_nan()).then_some((level, level))?
            }
            (Some(wi), Sense::Reverse) => {
                let (value, level) = self.luminance.leaf_at(wi, known);
                (!value.is_nan()).then_some((level, level))?
            }
            (None, _) if !(known.x + known.y).is_finite() => return None,
            (None, _) => match self.slice(known, sense) {
                Some((slice, _)) => (slice.coarsest.into(), slice.finest.into()),
                None => Ring::levels(&self.luminance, known.truncate())?,
            },
        };
        Some((cell_solid_angle(finest), cell_solid_angle(coarsest)))
    }

    fn min_projected_solid_angle(&self) -> f64 {
        let mut finest = 0;
        self.luminance.for_each_leaf(|_, level| finest = finest.max(level));
        cell_solid_angle(finest)
    }
}

/// π w² for w = 2^−level.
fn cell_solid_angle(level: u32) -> f64 {
    PI * (-2.0 * f64::from(level)).exp2()
}
