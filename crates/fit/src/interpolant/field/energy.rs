//! Energy of the interpolant: directional-hemispherical values are interpolated, not left to chance.
//!
//! Lobes that move toward the horizon lose part of their mass below it. Here the
//! directional-hemispherical values of the measured incidences are interpolated smoothly (and go
//! on smoothly past the last of them, never above 1), and whatever the moved lobes give is scaled
//! to that.

use bsdfkit::{DVec3, Side};
use bsdfkit_sphere::concentric::disk_to_hemisphere;
use bsdfkit_sphere::direction;
use rayon::prelude::*;

use crate::interpolant::component::planned::Planned;
use crate::interpolant::field::multiquadric::{CORNERED, Multiquadric};
use crate::interpolant::field::profile::Profile;
use crate::interpolant::mesh::chart::Chart;
use bsdfkit_measure::{Image, Symmetry};

/// log(wanted / raw) directional-hemispherical value over incident directions.
#[derive(Clone, Debug)]
pub(crate) struct Energy {
    correction: Multiquadric,
}

/// Energy is not raised by more than this factor: where lobes have gone below the horizon, what is
/// left of them must not be blown up into peaks.
const LIMIT: f64 = 2.5;
/// Takes a direction of the rim into the cell within.
const INWARD: f64 = 0.999;
/// Energy that lobes invented is taken away down to this factor.
const LEAST: f64 = 1e-6;

impl Energy {
    /// Makes the correction of what was planned.
    ///
    /// Cost: about 2 ms for each vertex, edge and triangle of the mesh within one fundamental domain.
    pub(crate) fn of(component: &Planned) -> Self {
        Self::among(component, component.probes())
    }

    /// The correction for incident directions within the chord `reach` of `wi` only.
    ///
    /// Cost: that of the mesh about `wi`.
    pub(crate) fn about(component: &Planned, wi: DVec3, reach: f64) -> Self {
        let (wi, _) = component.fitted.symmetry.fold(wi);
        let mut probes = component.probes();
        probes.retain(|p| p.distance(wi) < reach);
        Self::among(component, probes)
    }

    /// The correction as it is about `probes`.
    fn among(component: &Planned, probes: Vec<DVec3>) -> Self {
        let isotropic = component.fitted.symmetry == Symmetry::Isotropic;
        let smooth = Smooth::of(component);
        let samples: Vec<(DVec3, f64)> = probes
            .into_par_iter()
            .map(|wi| {
                let raw = component.at(wi).roughly_hemispherical();
                (wi, (smooth.wanted(component, wi) / raw.max(1e-9)).clamp(LEAST, LIMIT).ln())
            })
            .collect();
        let images = component.fitted.symmetry.images();
        let known = component.mesh.vertices.iter().map(|v| (v.wi, 0.0));
        let probed =
            samples.iter().flat_map(|&(wi, c)| images.iter().map(move |i| (i.apply(wi), c)));
        let (places, values) = spread(known.chain(probed), isotropic);
        Self { correction: Multiquadric::through(&places, &values, CORNERED) }
    }

    /// The constants and the centres with weights, as stored.
    pub(crate) fn parts(&self) -> (f64, f64, Vec<[f64; 4]>) {
        self.correction.parts()
    }

    /// From what [`Energy::parts`] gave.
    pub(crate) fn from_parts(constant: f64, slope: f64, centres: &[[f64; 4]]) -> Self {
        Self { correction: Multiquadric::from_parts(constant, slope, centres, CORNERED) }
    }

    /// log(wanted / raw) at incident direction `wi` (front hemisphere, folded), as a smooth function:
    /// never beyond what the samples may ask, though it overshoots where incidences all but coincide.
    pub(crate) fn logarithm(&self, wi: DVec3) -> f64 {
        bounded(self.correction.at(wi))
    }

    /// The factor on f of such a logarithm, bounded likewise.
    pub(crate) fn factor(logarithm: f64) -> f64 {
        bounded(logarithm).exp()
    }
}

/// Within what samples may ask, whatever numbers a broken file holds.
fn bounded(logarithm: f64) -> f64 {
    logarithm.max(LEAST.ln()).min(LIMIT.ln())
}

impl Smooth {
    /// The value at `wi`: between the measured ones near them; past the rim between what a rim value
    /// falling with cos² θ and one rising to 1 would give.
    fn wanted(&self, component: &Planned, wi: DVec3) -> f64 {
        let mesh = &component.mesh;
        let corners = mesh.locate(wi).weights(&mesh.topology);
        let on_mesh = mesh.between(&corners);
        // Of a whole cell, also on its edges: those of the rim dip far toward the normal.
        let inward = disk_to_hemisphere(INWARD * on_mesh.truncate(), Side::Front);
        let cell = mesh.locate(inward).weights(&mesh.topology);
        let of = |v: u32| {
            let shown = self.shown(component, mesh.vertices[v as usize].wi);
            component.hemispherical(v) * (1.0 - component.following(v)) / shown
        };
        let values = cell.map(|(v, _)| of(v));
        let lo = values.into_iter().fold(f64::MAX, f64::min);
        let hi = values.into_iter().fold(0.0, f64::max);
        let play = 0.25 * (hi - lo) + 0.02 * hi;
        let at = |w| self.log.at(self.place(w)).exp();
        let smooth =
            self.chain.as_ref().map_or_else(|| at(on_mesh), |chain| chain.at(on_mesh).exp());
        let inside = smooth.clamp((lo - play).max(0.5 * lo), hi + play);
        let fall = (wi.z / on_mesh.z.max(1e-6)).clamp(0.0, 1.0);
        // Interfaces reflect more toward grazing and transmit less.
        let rise = if component.fitted.incident == component.fitted.scattered {
            inside + (1.0 - inside).max(0.0) * (1.0 - fall)
        } else {
            inside
        };
        let wanted = (inside + at(wi) - at(on_mesh)).clamp(inside * fall * fall, rise);
        (wanted * self.shown(component, wi) + component.on_facets(wi)).max(1e-9)
    }
}

/// How far apart along grooves incidences are taken to be, in proportion.
const SHARES: [f64; 3] = [0.3, 0.1, 0.05];

/// A logarithm of energies that is smooth over the hemisphere; of an isotropic specimen, a curve of the polar angle where that
/// foretells more.
struct Smooth {
    log: Multiquadric,
    chain: Option<Profile>,
    /// Whether of all that lobes would scatter, above the horizon and below it.
    unclipped: bool,
    /// Over which chart; `None`: over the sphere.
    chart: Option<Chart>,
}

impl Smooth {
    /// Of the four, that whose values the others foretell best.
    fn of(component: &Planned) -> Self {
        let mut charts = vec![None];
        if let Chart::Profile { azimuth, .. } = component.motion.chart {
            charts.extend(SHARES.map(|share| Some(Chart::Profile { azimuth, share })));
        }
        let tried = [false, true].into_iter().flat_map(|unclipped| {
            charts.iter().map(move |&chart| Self::with(component, unclipped, chart))
        });
        tried.min_by(|a, b| a.1.total_cmp(&b.1)).expect("some were tried").0
    }

    /// And its error.
    fn with(component: &Planned, unclipped: bool, chart: Option<Chart>) -> (Self, f64) {
        let mut smooth =
            Self { log: Multiquadric::through(&[], &[], CORNERED), chain: None, unclipped, chart };
        let known = component.mesh.vertices.iter().enumerate().map(|(v, vertex)| {
            let energy = component.hemispherical(v as u32) * (1.0 - component.following(v as u32));
            (vertex.wi, (energy.max(1e-9) / smooth.shown(component, vertex.wi)).ln())
        });
        let isotropic = component.fitted.symmetry == Symmetry::Isotropic;
        let (places, logs) = spread(known, isotropic);
        let foretold = |others: &[(f64, f64)], theta: f64| {
            let at = |theta: f64| direction::from_degrees(theta, 0.0);
            let (places, logs) = spread(others.iter().map(|&(t, log)| (at(t), log)), true);
            Multiquadric::smooth_through(&places, &logs).at(at(theta))
        };
        let values = || places.iter().copied().zip(logs.iter().copied());
        let chain = isotropic.then(|| Profile::through(values(), &foretold)).flatten();
        let centres: Vec<DVec3> = places.iter().map(|&w| smooth.place(w)).collect();
        let (log, error) = Multiquadric::smooth_with_error(&centres, &logs);
        (smooth.log, smooth.chain) = (log, chain);
        (smooth, error)
    }

    fn place(&self, wi: DVec3) -> DVec3 {
        self.chart.map_or(wi, |chart| chart.place(wi).extend(0.0))
    }

    /// What is seen at `wi` of all that the function is of.
    fn shown(&self, component: &Planned, wi: DVec3) -> f64 {
        if self.unclipped { component.visible_share(wi) } else { 1.0 }
    }
}

/// Values as centres of a function on the hemisphere, doubles removed; an isotropic chain is
/// repeated round the circle so that the function has no preferred azimuth.
fn spread(values: impl Iterator<Item = (DVec3, f64)>, isotropic: bool) -> (Vec<DVec3>, Vec<f64>) {
    let turns: u32 = if isotropic { 6 } else { 1 };
    let (mut places, mut kept): (Vec<DVec3>, Vec<f64>) = Default::default();
    for (w, v) in values {
        for k in 0..turns {
            let turned =
                Image::rotation_to(direction::from_degrees(90.0, f64::from(k) * 60.0)).apply(w);
            if places.iter().all(|p: &DVec3| p.distance(turned) > 1e-3) {
                places.push(turned);
                kept.push(v);
            }
        }
    }
    (places, kept)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factor_is_bounded_however_the_function_overshoots() {
        for (constant, bound) in [(400.0, LIMIT), (-400.0, LEAST)] {
            let energy = Energy::from_parts(constant, 0.0, &[]);
            assert!((Energy::factor(energy.logarithm(DVec3::Z)) / bound - 1.0).abs() < 1e-9);
        }
    }
}
