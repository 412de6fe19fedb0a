//! A tree read smoothly, as a distribution.

use std::f64::consts::PI;
use std::sync::{Arc, OnceLock};

use super::super::distribution::TreeDistribution;
use super::super::hues::each_pair;
use super::super::lookup::{Incidence, Key};
use super::super::node::{Rank, TensorTree, leaf_value};
use super::fit::{Patches, fit};
use super::ring::Rings;
use super::shaped::{Known, Shaped};
use super::slices::Slices;
use super::values::values;
use crate::distribution::Distribution;
use crate::error::{Error, Result};
use crate::lanes::{Lanes, Sense};
use crate::spectrum::Bands;
use crate::unit::BELOW_ONE;
use crate::{DVec2, DVec3, Xyz};
use bsdfkit_sphere::concentric::disk_to_square;

/// Samples that go down side by side.
const ABREAST: usize = 64;

/// A tree whose leaves have the shapes of [`Patches`]; chromaticity is that stored.
///
/// What sampling and totals need is made at their first use in each sense and kept, as for
/// the stored values. A floor taken out counts as at most [`Distribution::constant_part`].
///
/// Cost: made in 0.9 µs a leaf; a value reads one cache line more than a stored one.
#[derive(Debug)]
pub(crate) struct SmoothTree {
    stored: Arc<TreeDistribution>,
    patches: Vec<Patches>,
    /// The constant part of Y, which every value keeps.
    floor: f64,
    forward: OnceLock<Slices>,
    reverse: OnceLock<Slices>,
    rings: OnceLock<Rings>,
}

impl SmoothTree {
    /// The tree whose leaves these are.
    pub(crate) fn leaves(&self) -> Arc<TreeDistribution> {
        self.stored.clone()
    }

    /// Errors: format, for a tree from a damaged file.
    pub(crate) fn new(stored: Arc<TreeDistribution>) -> Result<Self> {
        let tree = stored.luminance();
        // A mapped file has not been looked through; fitting walks all of it.
        let sound = TensorTree::from_slots(tree.rank(), tree.root_slot(), tree.slots().to_vec())
            .map_err(|e| Error::format(e.to_string()))?;
        if sound.depth() != tree.depth() {
            let (expected, found) = (sound.depth(), tree.depth());
            return Err(Error::format(format!("tree: expected depth {expected}, found {found}")));
        }
        let floor = stored.constant_part().y;
        let patches = fit(tree, floor);
        let (forward, reverse, rings) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Ok(Self { stored, patches, floor, forward, reverse, rings })
    }

    fn shaped(&self) -> Shaped<'_> {
        Shaped { tree: self.stored.luminance(), patches: &self.patches, floor: self.floor }
    }

    fn slices(&self, sense: Sense) -> &Slices {
        let once = match sense {
            Sense::Forward => &self.forward,
            Sense::Reverse => &self.reverse,
        };
        once.get_or_init(|| Slices::new(self.shaped(), sense))
    }

    fn rings(&self) -> &Rings {
        self.rings.get_or_init(|| Rings::new(self.stored.luminance().depth()))
    }

    /// A known direction's place and, forward, the frame in which to read the sampled one; `None`
    /// when the sense has no slices (rank 3 backward).
    fn known(&self, known: DVec3, sense: Sense) -> Option<(Known, Incidence)> {
        let rank = self.stored.luminance().rank();
        let incidence = Incidence::new(rank, known);
        let point = match (sense, rank) {
            (Sense::Forward, _) => incidence.point,
            (Sense::Reverse, Rank::Four) => disk_to_square(known.truncate()),
            (Sense::Reverse, Rank::Three) => return None,
        };
        Some((Known::new(point), incidence))
    }

    /// What of the constant part stays in.
    fn extra(&self, floor: f64) -> f64 {
        (self.floor - floor).max(0.0)
    }
}

impl Distribution for SmoothTree {
    fn value(&self, wi: DVec3, wo: DVec3) -> f64 {
        if !(wi.x + wi.y + wo.x + wo.y).is_finite() {
            return f64::NAN;
        }
        let tree = self.stored.luminance();
        let incidence = Incidence::new(tree.rank(), wi);
        let (s, t) = (Known::new(incidence.point), Known::new(incidence.square_of(wo)));
        match tree.slot_of(Key::of_cells(s.cell, t.cell)) {
            Some((slot, level)) => self.shaped().value(slot, s.place(level), t.place(level)),
            None => leaf_value(tree.root).into(),
        }
    }

    fn values(&self, wi: Lanes<'_>, wo: Lanes<'_>, out: &mut [f64]) {
        values(self.shaped(), wi, wo, out);
    }

    fn value_xyz(&self, wi: DVec3, wo: DVec3) -> Xyz {
        self.stored.coloured(self.value(wi, wo), wi, wo)
    }

    fn is_coloured(&self) -> bool {
        self.stored.is_coloured()
    }

    fn wavelengths(&self) -> Option<&Bands> {
        self.stored.wavelengths()
    }

    fn spectra(&self, known: DVec3, other: &[DVec3], sense: Sense, out: &mut [f64]) {
        each_pair(known, other, sense, out, |wi, wo, out| {
            self.stored.bands(self.value(wi, wo), wi, wo, out);
        });
    }

    fn constant_part(&self) -> Xyz {
        self.stored.constant_part()
    }

    fn total(&self, known: DVec3, sense: Sense, floor: f64) -> f64 {
        if !(known.x + known.y).is_finite() {
            return f64::NAN;
        }
        let extra = self.extra(floor);
        match self.known(known, sense) {
            Some((known, _)) => PI * (self.slices(sense).mean(known) + extra),
            None => self.rings().total(self.shaped(), known.truncate(), extra),
        }
    }

    fn max_total(&self, floor: f64) -> f64 {
        PI * (self.slices(Sense::Forward).largest_mean() + self.extra(floor))
    }

    fn sample(&self, known: DVec3, sense: Sense, floor: f64, u: f64) -> Option<DVec2> {
        if !(known.x + known.y + u).is_finite() {
            return None;
        }
        let (u, extra) = (u.clamp(0.0, BELOW_ONE), self.extra(floor));
        match self.known(known, sense) {
            Some((known, incidence)) => {
                let square = self.slices(sense).sample(self.shaped(), known, extra, u)?;
                Some(incidence.disk_of(square))
            }
            None => self.rings().sample(self.shaped(), known.truncate(), extra, u),
        }
    }

    fn samples(
        &self,
        known: Lanes<'_>,
        sense: Sense,
        floor: f64,
        u: &[f64],
        out: &mut [Option<DVec2>],
    ) {
        for first in (0..out.len()).step_by(ABREAST) {
            let numbers = first..out.len().min(first + ABREAST);
            let valid = |n: usize| (known.x[n] + known.y[n] + u[n]).is_finite();
            let found: Option<Vec<_>> = numbers
                .clone()
                .map(|n| if valid(n) { self.known(known.at(n), sense) } else { None })
                .collect();
            let Some(found) = found else {
                // Some go their own ways.
                for n in numbers {
                    out[n] = self.sample(known.at(n), sense, floor, u[n]);
                }
                continue;
            };
            let (known, frames): (Vec<_>, Vec<_>) = found.into_iter().unzip();
            let u: Vec<f64> = u[numbers.clone()].iter().map(|u| u.clamp(0.0, BELOW_ONE)).collect();
            let (out, extra) = (&mut out[numbers], self.extra(floor));
            self.slices(sense).sample_abreast(self.shaped(), &known, extra, &u, out);
            for (out, frame) in out.iter_mut().zip(frames) {
                *out = out.map(|square| frame.disk_of(square));
            }
        }
    }

    fn projected_solid_angle(
        &self,
        known: DVec3,
        other: Option<DVec3>,
        sense: Sense,
    ) -> Option<(f64, f64)> {
        self.stored.projected_solid_angle(known, other, sense)
    }

    fn min_projected_solid_angle(&self) -> f64 {
        self.stored.min_projected_solid_angle()
    }

    fn stored(&self) -> Option<&dyn Distribution> {
        Some(self.stored.as_ref())
    }
}
