//! Choosing the motion of lobes by leaving incidences out.
//!
//! Every candidate predicts measured incidences from the others; the one that errs least is
//! taken. Nothing is assumed about the material, and everything is tried.

use bsdfkit::{DVec3, Result};
use rayon::prelude::*;

use super::build::{FitSettings, fit_all};
use super::component::Component;
use super::frame::Frame;
use super::incidence::FittedIncidence;
use super::motion::Motion;
use crate::lobe::fit::FitOptions;
use crate::lobe::leaves::{Leaf, bin};
use crate::measurement::{Incidence, Measurement};
use crate::tabulate::Watch;

/// How many incidences are left out, one at a time.
const LEFT_OUT: usize = 10;
/// About so many points are used in all: the choice needs fewer than the fit.
const POINTS: usize = 400_000;

/// The frames tried, on either side of the surface.
fn frames(m: &Measurement, settings: &FitSettings) -> Vec<Frame> {
    if let Some(frame) = settings.frame {
        vec![frame]
    } else if m.incident == m.scattered {
        vec![Frame::Half, Frame::Turned, Frame::Shift, Frame::Fixed]
    } else {
        vec![Frame::Turned, Frame::Shift, Frame::Refracted { index: 1.5 }, Frame::Fixed]
    }
}

/// The motion with which left-out incidences are predicted best.
///
/// Cost: a fit of every incidence to [`POINTS`] points for each frame.
pub fn motion(m: &Measurement, settings: &FitSettings, watch: &Watch<'_>) -> Result<Motion> {
    let frames = frames(m, settings);
    if m.incidences.len() < 2 {
        return Ok(Motion::straight(frames[0]));
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
    let mut best = (f64::INFINITY, Motion::straight(frames[0]));
    for frame in frames {
        watch.check()?;
        let (epsilon, fitted) = fit_all(&thin, frame, &quick, &Watch { progress: None, ..*watch })?;
        for motion in Motion::all(frame) {
            let error: f64 = left_out
                .par_iter()
                .zip(&truth)
                .map(|(&k, truth)| predicted_error(m, motion, epsilon, &fitted, k, truth))
                .sum();
            if error < best.0 {
                best = (error, motion);
            }
        }
    }
    Ok(best.1)
}

/// Relative L1 error at incidence `k`, predicted from all others; 2 where that cannot be done.
fn predicted_error(
    m: &Measurement,
    motion: Motion,
    epsilon: f64,
    fitted: &[FittedIncidence],
    k: usize,
    truth: &[Leaf],
) -> f64 {
    let mut others = fitted.to_vec();
    let wi = others.remove(k).wi;
    let (incident, scattered) = (m.incident, m.scattered);
    let component = Component::new(incident, scattered, m.symmetry, motion, epsilon, others);
    let Ok(component) = component else {
        return 2.0;
    };
    let predicted = component.at(wi);
    let (mut error, mut total) = (0.0, 0.0);
    for leaf in truth.iter().filter(|l| l.count > 0) {
        let value = predicted.eval(DVec3::new(leaf.u.x, leaf.u.y, 0.0));
        error += (value - leaf.value).abs() * leaf.area;
        total += leaf.value.max(0.0) * leaf.area;
    }
    // No prediction is worse than predicting nothing where there is all, and all where is nothing.
    if total > 0.0 { (error / total).min(2.0) } else { 0.0 }
}

/// The measurement with about [`POINTS`] of its points.
fn thinned(m: &Measurement) -> Measurement {
    let channels = m.colorimetry.channels();
    let step = (m.points() / POINTS).max(1);
    let mut thin = m.clone();
    for (t, i) in thin.incidences.iter_mut().zip(&m.incidences) {
        let step = step.min((i.wo.len() / 2000).max(1));
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
