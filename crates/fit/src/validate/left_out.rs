//! One measured incidence, predicted from the others.

use std::f64::consts::{FRAC_2_PI, PI};

use bsdfkit::{DVec3, Error, Result};
use bsdfkit_sphere::direction::to_degrees;

use super::gap::{BACKGROUND, Gap};
use super::peak::{PeakError, View};
use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::interpolant::{Component, Distribution};
use crate::lobe::leaves::{Leaf, bin};
use bsdfkit_measure::{Incidence, Measurement};

/// How far one measured incidence is from what the others predict of it.
#[derive(Clone, Debug)]
pub struct LeftOut {
    /// Incident direction, on the side of the measurement.
    pub wi: DVec3,
    /// Whether it lies past the rim of the mesh of the others: extrapolated, not interpolated.
    pub extrapolated: bool,
    /// Σ|f − f′| / Σ f over the measured points, each by the projected solid angle it stands for:
    /// the share of light in a wrong place, doubled.
    pub l1: f64,
    /// The same of the interpolant that has the incidence: what noise and lobe fit leave.
    pub fit_l1: f64,
    /// What the scatter of the points alone adds to both.
    pub noise: f64,
    /// Relative error of the directional-hemispherical value.
    pub hemispherical_error: f64,
    /// Peaks of the measured distribution, the highest first.
    pub peaks: Vec<PeakError>,
    /// |f − f′| / (f′ + a tenth of the mean of f) that [`COVERED`] of the measured directions keep
    /// below, by projected solid angle.
    pub(crate) spread: f64,
    /// The same of the interpolant that has the incidence.
    pub(crate) fit_spread: f64,
    /// Equivalent width of the hole that it leaves; see [`Gap`].
    pub(crate) gap: f64,
}

/// Energy is balanced out to this many distances of the farthest corner of the cell that leaving
/// out opens: farther probes count for little there. Doubled, it takes three times as long.
const BALANCED: f64 = 1.5;

/// The share of directions that an interval is to hold.
const COVERED: f64 = 0.9;

impl LeftOut {
    /// Predicts incidence `k` of `m` from the rest of `whole`, which was fitted to `m`.
    ///
    /// Cost: the mesh, plans and energy of the others; no lobe is fitted anew.
    pub(super) fn of(m: &Measurement, whole: &Component, k: usize) -> Result<Self> {
        let place = |e: Error| {
            let (theta, phi) = to_degrees(m.incidences[k].wi);
            e.context(format!("without incidence theta {theta:.1} phi {phi:.1}"))
        };
        let rest = without(whole, k).map_err(place)?;
        let own = &whole.incidences()[k];
        let (fitted, predicted) = (whole.at(own.wi), rest.at(own.wi));
        let points = Points::of(m, k);
        let (f, g) = (|w| fitted.eval(w), |w| predicted.eval(w));
        let view = View { f: &f, side: m.scattered, limit: own.limit };
        let peaks = view.peaks();
        let room = |k: usize| {
            let others = peaks.iter().enumerate().filter(|&(j, _)| j != k);
            let apart = others.map(|(_, p)| p.direction.angle_between(peaks[k].direction));
            apart.fold(PI, f64::min).to_degrees()
        };
        let prediction = View { f: &g, ..view };
        let (fit, error) = (points.compare(&fitted), points.compare(&predicted));
        let gap = Gap::at(rest.mesh(), rest.symmetry(), own.wi).equivalent();
        Ok(Self {
            gap,
            wi: m.incidences[k].wi,
            extrapolated: !rest.is_measured(own.wi),
            l1: error.l1,
            fit_l1: fit.l1,
            noise: fit.noise,
            spread: error.spread,
            fit_spread: fit.spread,
            hemispherical_error: predicted.directional_hemispherical() / own.hemispherical - 1.0,
            peaks: (0..peaks.len()).map(|k| prediction.miss(peaks[k], room(k))).collect(),
        })
    }
}

/// The component without incidence `k`: meshed and planned anew, and balanced where `k` was.
pub(super) fn without(whole: &Component, k: usize) -> Result<Component> {
    let (fitted, symmetry) = (whole.fitted(), whole.symmetry());
    let wi = fitted.incidences[k].wi;
    let reach = |mesh: &IncidenceMesh| BALANCED * Gap::at(mesh, symmetry, wi).reach;
    Component::about(fitted.without(k), whole.motion(), wi, reach)
}

/// The measured luminance of one incidence.
struct Points<'a> {
    incidence: &'a Incidence,
    channel: usize,
    /// Their directional-hemispherical value.
    total: f64,
}

impl<'a> Points<'a> {
    fn of(m: &'a Measurement, k: usize) -> Self {
        let (incidence, channel) = (&m.incidences[k], m.colorimetry.luminance_channel());
        let total = bin(incidence.points(channel)).iter().map(|l| l.value * l.area).sum();
        Self { incidence, channel, total }
    }

    /// Compares with a prediction.
    ///
    /// Differences are averaged over cells of a few points before their size is taken: noise of one
    /// point weighs less, structure of a cell remains.
    fn compare(&self, predicted: &Distribution<'_>) -> Difference {
        let points = self.incidence.points(self.channel);
        let differences = points.map(|(w, v)| (w, predicted.eval(w) - v));
        let leaves: Vec<Leaf> = bin(differences).into_iter().filter(|l| l.count > 0).collect();
        let background = BACKGROUND * self.total.max(0.0) / PI;
        let (mut error, mut noise, mut area) = (0.0, 0.0, 0.0);
        let mut relative = Vec::with_capacity(leaves.len());
        for leaf in &leaves {
            error += leaf.value.abs() * leaf.area;
            noise += (leaf.variance * FRAC_2_PI).sqrt() * leaf.area;
            area += leaf.area;
            let value = predicted.eval(leaf.u.extend(0.0)) + background;
            relative.push((leaf.value.abs() / value.max(1e-12), leaf.area));
        }
        relative.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut below = 0.0;
        let reached = |r: &&(f64, f64)| {
            below += r.1;
            below >= COVERED * area
        };
        let spread = relative.iter().find(reached).map_or(0.0, |r| r.0);
        let share = |x: f64| if self.total > 0.0 { x / self.total } else { 0.0 };
        Difference { l1: share(error), noise: share(noise), spread }
    }
}

/// How a prediction differs from measured points.
struct Difference {
    /// Σ|f − f′| / Σ f; 0 where nothing is scattered.
    l1: f64,
    /// What of it the scatter of the points alone explains.
    noise: f64,
    /// See [`LeftOut::spread`].
    spread: f64,
}
