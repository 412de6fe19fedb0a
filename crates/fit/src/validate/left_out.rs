//! One measured incidence, predicted from the others.

use bsdfkit::{DVec3, Error, Result};
use bsdfkit_sphere::direction::to_degrees;

use super::gap::Gap;
use super::peak::{PeakError, View};
use crate::interpolant::{Component, Distribution};
use crate::lobe::leaves::{Leaf, bin};
use crate::measurement::Measurement;

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
    /// Relative error of the directional-hemispherical value.
    pub hemispherical_error: f64,
    /// Peaks of the measured distribution, the highest first.
    pub peaks: Vec<PeakError>,
}

/// Energy is balanced out to this many distances of the farthest corner of the cell that leaving
/// out opens: farther probes count for little there. Doubled, it takes three times as long.
const BALANCED: f64 = 1.5;

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
        let own = &whole.incidences[k];
        let (fitted, predicted) = (whole.at(own.wi), rest.at(own.wi));
        let leaves = luminance_leaves(m, k);
        let view = |distribution| View { distribution, side: m.scattered, limit: own.limit };
        let peaks = view(&fitted).peaks();
        let room = |k: usize| {
            let others = peaks.iter().enumerate().filter(|&(j, _)| j != k);
            let apart = others.map(|(_, p)| p.direction.angle_between(peaks[k].direction));
            apart.fold(std::f64::consts::PI, f64::min).to_degrees()
        };
        Ok(Self {
            wi: m.incidences[k].wi,
            extrapolated: !rest.is_measured(own.wi),
            l1: misplaced(&predicted, &leaves),
            fit_l1: misplaced(&fitted, &leaves),
            hemispherical_error: predicted.directional_hemispherical() / own.hemispherical - 1.0,
            peaks: (0..peaks.len()).map(|k| view(&predicted).miss(peaks[k], room(k))).collect(),
        })
    }
}

/// The component without incidence `k`: meshed and planned anew, and balanced where `k` was.
pub(super) fn without(whole: &Component, k: usize) -> Result<Component> {
    let mut others = whole.incidences.clone();
    let wi = others.remove(k).wi;
    let Component { incident, scattered, symmetry, motion, epsilon, .. } = *whole;
    let rest = Component::new(incident, scattered, symmetry, motion, epsilon, others)?;
    let reach = BALANCED * Gap::at(rest.mesh(), symmetry, wi).reach;
    Ok(rest.balanced_about(wi, reach))
}

/// The measured luminance of incidence `k`, each cell with its projected solid angle.
pub(super) fn luminance_leaves(m: &Measurement, k: usize) -> Vec<Leaf> {
    let (channels, y) = (m.colorimetry.channels(), m.colorimetry.luminance_channel());
    let i = &m.incidences[k];
    let values: Vec<f64> = i.values.iter().skip(y).step_by(channels).copied().collect();
    let mut leaves = bin(&i.wo, &values);
    leaves.retain(|l| l.count > 0);
    leaves
}

/// Σ|f − f′| / Σ f over leaves that hold points; 0 where nothing is scattered.
pub(super) fn misplaced(predicted: &Distribution<'_>, leaves: &[Leaf]) -> f64 {
    let (mut error, mut total) = (0.0, 0.0);
    for leaf in leaves {
        let value = predicted.eval(leaf.u.extend(0.0));
        error += (value - leaf.value).abs() * leaf.area;
        total += leaf.value.max(0.0) * leaf.area;
    }
    if total > 0.0 { error / total } else { 0.0 }
}
