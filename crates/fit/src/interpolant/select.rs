//! Choosing the frame of transport by leaving incidences out.
//!
//! Every candidate predicts measured incidences from the others; the one that errs least is
//! taken. Nothing is assumed about the material, and everything is tried.

use bsdfkit::{DVec3, Result};
use rayon::prelude::*;

use super::build::{FitSettings, fit_all};
use super::component::Component;
use super::frame::Frame;
use super::incidence::FittedIncidence;
use crate::lobe::fit::FitOptions;
use crate::lobe::leaves::{Leaf, bin};
use crate::measurement::{Incidence, Measurement};
use crate::tabulate::Watch;

/// How many incidences are left out, one at a time.
const LEFT_OUT: usize = 10;
/// One point in so many is used: the choice needs less than the fit.
const THINNING: usize = 4;

/// The hypotheses tried, on either side of the surface.
fn candidates(m: &Measurement) -> Vec<Frame> {
    if m.incident == m.scattered {
        vec![Frame::Half, Frame::Turned, Frame::Shift, Frame::Fixed]
    } else {
        vec![Frame::Turned, Frame::Shift, Frame::Refracted { index: 1.5 }, Frame::Fixed]
    }
}

/// The frame in which left-out incidences are predicted best.
///
/// Cost: a fit of every incidence to a quarter of its points for each candidate.
pub fn frame(m: &Measurement, settings: &FitSettings, watch: &Watch<'_>) -> Result<Frame> {
    let candidates = candidates(m);
    if m.incidences.len() < 2 {
        return Ok(candidates[0]);
    }
    let thin = thinned(m);
    let left_out = spread(thin.incidences.len());
    let channel = m.colorimetry.luminance_channel();
    let channels = m.colorimetry.channels();
    let truth: Vec<Vec<Leaf>> = left_out
        .iter()
        .map(|&k| {
            let i = &thin.incidences[k];
            let v: Vec<f64> = i.values.iter().skip(channel).step_by(channels).copied().collect();
            bin(&i.wo, &v)
        })
        .collect();
    let quick = FitSettings {
        lobes: FitOptions { max_lobes: settings.lobes.max_lobes.min(10), target: 0.02 },
        detail_cells: 32,
        ..settings.clone()
    };
    let mut best = (f64::INFINITY, candidates[0]);
    for frame in candidates {
        watch.check()?;
        let (epsilon, fitted) = fit_all(&thin, frame, &quick, &Watch { progress: None, ..*watch })?;
        let errors: Vec<f64> = left_out
            .par_iter()
            .zip(&truth)
            .filter_map(|(&k, truth)| predicted_error(m, frame, &quick, epsilon, &fitted, k, truth))
            .collect();
        let mean = errors.iter().sum::<f64>() / errors.len().max(1) as f64;
        if mean < best.0 {
            best = (mean, frame);
        }
    }
    Ok(best.1)
}

/// Relative L1 error at incidence `k`, predicted from all others.
fn predicted_error(
    m: &Measurement,
    frame: Frame,
    settings: &FitSettings,
    epsilon: f64,
    fitted: &[FittedIncidence],
    k: usize,
    truth: &[Leaf],
) -> Option<f64> {
    let mut others = fitted.to_vec();
    let wi = others.remove(k).wi;
    let component = Component::without_energy(
        m.incident,
        m.scattered,
        m.symmetry,
        frame,
        settings.reach,
        epsilon,
        others,
    )
    .ok()?;
    let predicted = component.at(wi);
    let (mut error, mut total) = (0.0, 0.0);
    for leaf in truth.iter().filter(|l| l.count > 0) {
        error +=
            (predicted.eval(DVec3::new(leaf.u.x, leaf.u.y, 0.0)) - leaf.value).abs() * leaf.area;
        total += leaf.value.max(0.0) * leaf.area;
    }
    (total > 0.0).then(|| error / total)
}

/// Every `THINNING`-th point.
fn thinned(m: &Measurement) -> Measurement {
    let channels = m.colorimetry.channels();
    let mut thin = m.clone();
    for (t, i) in thin.incidences.iter_mut().zip(&m.incidences) {
        let step = if i.wo.len() > 4000 { THINNING } else { 1 };
        *t = Incidence {
            wi: i.wi,
            wo: i.wo.iter().step_by(step).copied().collect(),
            values: i.values.chunks(channels).step_by(step).flatten().copied().collect(),
            files: Vec::new(),
        };
    }
    thin
}

/// Up to [`LEFT_OUT`] of `n` indices, evenly spread.
fn spread(n: usize) -> Vec<usize> {
    let count = n.min(LEFT_OUT);
    (0..count).map(|k| (k * n + n / 2) / count).map(|k| k.min(n - 1)).collect()
}
