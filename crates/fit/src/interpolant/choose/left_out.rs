//! Incidences left out, and how far others are from foretelling them.

use std::borrow::Cow;

use bsdfkit::{DVec3, Result};
use rayon::prelude::*;

use crate::cache::Stage;
use crate::interpolant::choose::build::{FitSettings, fit_all};
use crate::interpolant::component::fitted::Fitted;
use crate::interpolant::component::planned::{Peaks, Planned};
use crate::interpolant::motion::hypothesis::Motion;
use crate::lobe::fit::FitOptions;
use crate::lobe::leaves::{Leaf, bin};
use bsdfkit_measure::frame::Frame;
use bsdfkit_measure::{Incidence, Measurement};
use bsdfkit_represent::Watch;

/// How many incidences are left out, one at a time. Of 10, which ones decided: a prism film was foretold with an L1 of .003 or .018.
const LEFT_OUT: usize = 20;
/// Errors are not told apart below this.
const LEAST: f64 = 1e-4;
/// About so many points are used in all: the choice needs fewer than the fit.
const POINTS: usize = 400_000;

/// What is left out of a measurement, to be foretold from the rest.
pub(super) struct LeftOut<'a> {
    /// The measurement with fewer points.
    pub(super) thin: Cow<'a, Measurement>,
    settings: FitSettings,
    watch: &'a Watch<'a>,
    /// Errors of hypotheses.
    stage: Stage,
    /// Directional-hemispherical values of all incidences, of what was seen.
    pub(super) energies: Vec<f64>,
    left_out: Vec<usize>,
    truth: Vec<Vec<Leaf>>,
}

impl<'a> LeftOut<'a> {
    pub(super) fn of(m: &'a Measurement, settings: &FitSettings, watch: &'a Watch<'a>) -> Self {
        let thin = thinned(m);
        let all: Vec<Vec<Leaf>> = (0..thin.incidences.len()).map(|k| binned(&thin, k)).collect();
        let energies: Vec<f64> = all.iter().map(|leaves| energy(leaves)).collect();
        let left_out = spread(&thin, (0..thin.incidences.len()).collect(), |k| energies[k]);
        let truth = left_out.iter().map(|&k| all[k].clone()).collect();
        let settings = FitSettings {
            lobes: FitOptions { max_lobes: settings.lobes.max_lobes.min(10), target: 0.02 },
            detail_cells: 24,
            ..settings.clone()
        };
        let stage = Stage::of("left out", &thin, &settings, &());
        Self { thin, settings, watch, stage, energies, left_out, truth }
    }

    /// A quick fit of every incidence in coordinates of `frame`.
    pub(super) fn fit_in(&self, frame: Frame) -> Result<Fitted> {
        self.watch.check()?;
        fit_all(&self.thin, frame, &self.settings, &Watch { progress: None, ..*self.watch })
    }

    /// Logarithms of the L1 errors at the incidences left out, each foretold from all others.
    pub(super) fn errors(&self, motion: Motion, fit: &Fitted, peaks: Peaks) -> Vec<f64> {
        let one = |(&k, truth): (&usize, &Vec<Leaf>)| {
            predicted_error(fit, motion, k, truth, peaks).max(LEAST).ln()
        };
        let all = || self.left_out.par_iter().zip(&self.truth).map(one).collect();
        self.stage.result_of(&(motion, peaks == Peaks::Apart), all)
    }
}

/// The luminance of an incidence.
pub(super) fn binned(m: &Measurement, k: usize) -> Vec<Leaf> {
    bin(m.incidences[k].points(m.colorimetry.luminance_channel()))
}

/// What is compared of a prediction.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Energies {
    /// f as it is.
    Own,
    /// f scaled to the measured energy: past the rim energy is another matter (`field::energy`).
    Alike,
}

/// Relative L1 error at incidence `k`, predicted from all others; 2 where that cannot be done.
fn predicted_error(fit: &Fitted, motion: Motion, k: usize, truth: &[Leaf], peaks: Peaks) -> f64 {
    let rest = Planned::new(fit.without(k), motion, peaks);
    rest.map_or(2.0, |rest| error(&rest, fit.incidences[k].wi, truth, Energies::Own))
}

/// Relative L1 error at `wi`; 2 at most.
pub(super) fn error(planned: &Planned, wi: DVec3, truth: &[Leaf], energy: Energies) -> f64 {
    let predicted = planned.at(wi);
    let seen: Vec<&Leaf> = truth.iter().filter(|l| l.count > 0).collect();
    let at = |leaf: &&Leaf| predicted.eval(DVec3::new(leaf.u.x, leaf.u.y, 0.0));
    let values: Vec<f64> = seen.iter().map(at).collect();
    let total: f64 = seen.iter().map(|leaf| leaf.value.max(0.0) * leaf.area).sum();
    let own: f64 = seen.iter().zip(&values).map(|(leaf, value)| value * leaf.area).sum();
    let scale = if energy == Energies::Alike && own > 0.0 { total / own } else { 1.0 };
    let wrong = |(leaf, value): (&&Leaf, &f64)| (scale * value - leaf.value).abs() * leaf.area;
    let error: f64 = seen.iter().zip(&values).map(wrong).sum();
    // No prediction is worse than predicting nothing where there is all, and all where is nothing.
    if total > 0.0 { (error / total).min(2.0) } else { 0.0 }
}

/// The measurement with about [`POINTS`] of its points.
fn thinned(m: &Measurement) -> Cow<'_, Measurement> {
    let channels = m.colorimetry.channels();
    let step = (m.points() / POINTS).max(1);
    if step == 1 {
        return Cow::Borrowed(m);
    }
    let thin = |i: &Incidence| {
        let step = step.min((i.wo.len() / 2000).max(1));
        Incidence {
            wi: i.wi,
            wo: i.wo.iter().step_by(step).collect(),
            values: i.values.chunks(channels).step_by(step).flatten().copied().collect(),
            files: Vec::new(),
        }
    };
    Cow::Owned(Measurement {
        incidences: m.incidences.iter().map(thin).collect(),
        colorimetry: m.colorimetry.clone(),
        sample_name: None,
        notes: Vec::new(),
        ..*m
    })
}

/// The directional-hemispherical value of what was seen.
fn energy(leaves: &[Leaf]) -> f64 {
    leaves.iter().map(|l| l.value.max(0.0) * l.area).sum()
}

/// Polar angles as near as this, in radians, are one.
const SAME_RING: f64 = 1e-6;

/// Up to [`LEFT_OUT`] of those incidences, evenly spread over polar angles and, on one ring, over energies: neither changes
/// when the specimen is turned or mirrored, so the same incidences are chosen then.
pub(super) fn spread(
    m: &Measurement,
    mut incidences: Vec<usize>,
    energy: impl Fn(usize) -> f64,
) -> Vec<usize> {
    let polar = |k: usize| m.incidences[k].wi.z.abs().min(1.0).acos();
    incidences.sort_by(|&a, &b| polar(a).total_cmp(&polar(b)));
    for ring in incidences.chunk_by_mut(|&a, &b| polar(b) - polar(a) < SAME_RING) {
        ring.sort_by(|&a, &b| energy(a).total_cmp(&energy(b)));
    }
    let n = incidences.len();
    let count = n.min(LEFT_OUT);
    (0..count).map(|k| incidences[((k * n + n / 2) / count).min(n - 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolant::incidence::fitted::FittedIncidence;
    use crate::lobe::LobeSet;
    use crate::lobe::detail::Detail;
    use bsdfkit::{DVec2, Side};
    use bsdfkit_measure::{Seen, Symmetry};
    use bsdfkit_sphere::concentric::square_to_hemisphere;

    #[test]
    fn energies_are_alike_where_only_shapes_are_compared() {
        let matte = FittedIncidence {
            wi: DVec3::Z,
            lobes: LobeSet { floor: 0.2, lobes: Vec::new() },
            details: vec![Detail::fit([DVec3::Z], &[1.0], &[1.0], 8)],
            coefficients: Vec::new(),
            points: 1,
            hemispherical: 0.6,
            fit_error: 0.0,
            limit: 1.0,
            seen: Seen::whole(),
        };
        let (front, motion) = (Side::Front, Motion::straight(Frame::Half));
        let (symmetry, incidences) = (Symmetry::Isotropic, vec![matte]);
        let fitted = Fitted {
            incident: front,
            scattered: front,
            symmetry,
            epsilon: 1e-9,
            spectra: None,
            incidences,
        };
        let c = Planned::new(fitted, motion, Peaks::Apart);
        let wo = hemisphere();
        let truth = bin(wo.into_iter().map(|w| (w, 0.1)));
        let of = |energy: Energies| error(c.as_ref().expect("component"), DVec3::Z, &truth, energy);
        let (own, alike) = (of(Energies::Own), of(Energies::Alike));
        assert!((own - 1.0).abs() < 1e-6 && alike < 1e-6, "{own} {alike}");
    }

    fn hemisphere() -> Vec<DVec3> {
        let at = |k: usize| DVec2::new((k / 40) as f64 + 0.5, (k % 40) as f64 + 0.5) / 40.0;
        (0..1600).map(|k| square_to_hemisphere(at(k), Side::Front)).collect()
    }
}
