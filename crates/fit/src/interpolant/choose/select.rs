//! Choosing the motion of lobes by leaving incidences out.
//!
//! Every candidate predicts measured incidences from the others; the one that errs least is
//! taken. Nothing is assumed about the material, and everything is tried. Ten incidences left out
//! cannot tell all candidates apart: where they cannot, light that is transmitted is taken to be
//! shift invariant, because what gratings diffract and thin plates and facets refract is, to first
//! order, and because that frame goes on past the rim without a singularity.

use bsdfkit::{DVec3, Result};
use rayon::prelude::*;

use crate::interpolant::choose::build::{FitSettings, fit_all};
use crate::interpolant::component::component::Component;
use crate::interpolant::incidence::fitted::FittedIncidence;
use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::interpolant::motion::hypothesis::{Motion, ONWARD};
use crate::lobe::fit::FitOptions;
use crate::lobe::frame::Frame;
use crate::lobe::leaves::{Leaf, bin};
use crate::measurement::{Incidence, Measurement};
use crate::watch::Watch;

/// How many incidences are left out, one at a time.
const LEFT_OUT: usize = 10;
/// About so many points are used in all: the choice needs fewer than the fit.
const POINTS: usize = 400_000;

/// Lobes are taken to travel where that is better by so many standard errors. Without, held-out L1 of
/// rough dielectrics was a quarter larger; peaks that do travel are better by three to four.
const SURELY: f64 = 2.0;

/// Or where it is so many times better: few incidences make sure of nothing.
const MUCH: f64 = 1.1;

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

/// The motion with which left-out incidences are predicted best, whether broad lobes stay meanwhile, and how much of the
/// change goes on past the outermost.
///
/// Cost: a fit of every incidence to [`POINTS`] points for each frame.
pub(crate) fn motion(m: &Measurement, settings: &FitSettings, watch: &Watch<'_>) -> Result<Motion> {
    let frames = frames(m, settings);
    if m.incidences.len() < 2 {
        return Ok(Motion::straight(frames[0]));
    }
    let thin = thinned(m);
    let left_out = spread(thin.incidences.len());
    let truth: Vec<Vec<Leaf>> = left_out.iter().map(|&k| binned(&thin, k)).collect();
    let quick = FitSettings {
        lobes: FitOptions { max_lobes: settings.lobes.max_lobes.min(10), target: 0.02 },
        detail_cells: 24,
        ..settings.clone()
    };
    let errors = |motion: Motion, (epsilon, fitted): &Fit| -> Vec<f64> {
        let one = |(&k, truth): (&usize, &Vec<Leaf>)| {
            predicted_error(m, motion, *epsilon, fitted, k, truth)
        };
        left_out.par_iter().zip(&truth).map(one).collect()
    };
    let mut tried: Vec<(Motion, Vec<f64>)> = Vec::new();
    let mut fits: Vec<(Frame, Fit)> = Vec::new();
    for frame in frames {
        watch.check()?;
        let fit = fit_all(&thin, frame, &quick, &Watch { progress: None, ..*watch })?;
        tried.extend(Motion::all(frame).map(|motion| (motion, errors(motion, &fit))));
        fits.push((frame, fit));
    }
    let mut best = chosen(&tried, m.incident != m.scattered);
    let Some((_, fit)) = fits.iter().find(|f| f.0 == best.frame) else {
        return Ok(best);
    };
    let sum = |motion: Motion| errors(motion, fit).iter().map(|e| e.sqrt()).sum::<f64>();
    let still = Motion { still: true, ..best };
    if sum(still) < sum(best) {
        best = still;
    }
    // What cannot be meshed without them does not go on.
    best.onward = onward(&thin, best, fit).unwrap_or(0.0);
    Ok(best)
}

/// The largest of [`ONWARD`] with which the outermost incidences are foretold from the others as well as with any, within a
/// standard error: they are farther past these than most of what will be asked for is past them.
///
/// All are left out at once: one alone is foretold by those beside it. 0 where fewer than two are left.
fn onward(m: &Measurement, motion: Motion, (epsilon, fitted): &Fit) -> Result<f64> {
    let directions: Vec<DVec3> = fitted.iter().map(|i| i.wi).collect();
    let outermost = IncidenceMesh::in_chart(&directions, m.symmetry, motion.chart)?.outermost();
    let rest = (0..fitted.len()).filter(|k| !outermost.contains(k));
    let rest: Vec<FittedIncidence> = rest.map(|k| fitted[k].clone()).collect();
    if rest.len() < 2 {
        return Ok(0.0);
    }
    let foretold = spread(outermost.len()).into_iter().map(|at| outermost[at]);
    let truth: Vec<(DVec3, Vec<Leaf>)> = foretold.map(|k| (fitted[k].wi, binned(m, k))).collect();
    let roots = |onward: f64| -> Result<Vec<f64>> {
        let (motion, rest) = (Motion { onward, ..motion }, rest.clone());
        let c = Component::new(m.incident, m.scattered, m.symmetry, motion, *epsilon, rest)?;
        let one = |(wi, truth): &(DVec3, Vec<Leaf>)| error(&c, *wi, truth, Energies::Alike).sqrt();
        Ok(truth.iter().map(one).collect())
    };
    let tried = ONWARD.map(|onward| roots(onward).map(|roots| (onward, roots)));
    let tried: Vec<(f64, Vec<f64>)> = tried.into_iter().collect::<Result<_>>()?;
    Ok(farthest(&tried))
}

/// The largest share whose errors are as small as the least, within a standard error.
fn farthest(tried: &[(f64, Vec<f64>)]) -> f64 {
    let sum = |errors: &[f64]| errors.iter().sum::<f64>();
    let least = tried.iter().map(|t| &t.1).min_by(|a, b| sum(a).total_cmp(&sum(b)));
    let as_well = |t: &&(f64, Vec<f64>)| least.is_some_and(|least| !worse(&t.1, least, 1.0));
    tried.iter().filter(as_well).map(|t| t.0).fold(0.0, f64::max)
}

/// The luminance of an incidence.
fn binned(m: &Measurement, k: usize) -> Vec<Leaf> {
    let (i, channels) = (&m.incidences[k], m.colorimetry.channels());
    let luminance = i.values.iter().skip(m.colorimetry.luminance_channel()).step_by(channels);
    bin(&i.wo, &luminance.copied().collect::<Vec<f64>>())
}

/// Quick fits of all incidences, and their small BSDF.
type Fit = (f64, Vec<FittedIncidence>);

/// What is compared of a prediction.
#[derive(Clone, Copy, PartialEq)]
enum Energies {
    /// f as it is.
    Own,
    /// f scaled to the measured energy: past the rim energy is another matter (`field::energy`).
    Alike,
}

/// The candidate with the least mean of the roots of its errors: holes are not equally wide, and
/// the widest, past the rim, must not decide alone.
///
/// Of transmission whose lobes travel, the best with [`Frame::Shift`] instead if it is worse by no
/// more than a standard error of the difference. (Where they only fade, the frame is the motion.)
///
/// Then plain blending in that frame, unless it is worse by [`SURELY`] standard errors or by a tenth
/// (few incidences make sure of nothing): its errors fall with the square of the distance between
/// incidences, those of travelling lobes with the distance, and what is left out leaves holes twice
/// as wide as those to be filled.
fn chosen(tried: &[(Motion, Vec<f64>)], transmission: bool) -> Motion {
    let roots = |errors: &[f64]| errors.iter().map(|e| e.sqrt()).collect::<Vec<f64>>();
    let tried: Vec<(Motion, Vec<f64>)> = tried.iter().map(|(m, e)| (*m, roots(e))).collect();
    let least = |of: &dyn Fn(&Motion) -> bool| {
        let sum = |t: &(Motion, Vec<f64>)| t.1.iter().sum::<f64>();
        tried.iter().filter(|t| of(&t.0)).min_by(|a, b| sum(a).total_cmp(&sum(b)))
    };
    let Some(best) = least(&|_| true) else {
        return Motion::straight(Frame::Shift);
    };
    let shift = least(&|m| transmission && best.0.reach > 0.0 && m.frame == Frame::Shift);
    let best = shift.filter(|shift| !worse(&shift.1, &best.1, 1.0)).unwrap_or(best);
    let sum = |errors: &[f64]| errors.iter().sum::<f64>();
    let blends =
        |b: &&(Motion, Vec<f64>)| !worse(&b.1, &best.1, SURELY) && sum(&b.1) < MUCH * sum(&best.1);
    let blend = least(&|m| m.reach == 0.0 && m.frame == best.0.frame);
    blend.filter(blends).unwrap_or(best).0
}

/// Whether the mean of `a` is above that of `b` by more than so many standard errors of the mean of
/// their differences.
fn worse(a: &[f64], b: &[f64], errors: f64) -> bool {
    let n = a.len().max(1) as f64;
    let differences = || a.iter().zip(b).map(|(a, b)| a - b);
    let mean = differences().sum::<f64>() / n;
    let squares: f64 = differences().map(|d| (d - mean).powi(2)).sum();
    mean > errors * (squares / (n * (n - 1.0).max(1.0))).sqrt()
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
    component.map_or(2.0, |c| error(&c, wi, truth, Energies::Own))
}

/// Relative L1 error at `wi`; 2 at most.
fn error(component: &Component, wi: DVec3, truth: &[Leaf], energy: Energies) -> f64 {
    let predicted = component.at(wi);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobe::LobeSet;
    use crate::lobe::detail::Detail;
    use crate::measurement::{Seen, Symmetry};
    use bsdfkit::{DVec2, Side};
    use bsdfkit_sphere::concentric::square_to_hemisphere;

    fn of(frame: Frame, reach: f64) -> Motion {
        Motion { reach, ..Motion::straight(frame) }
    }

    #[test]
    fn shift_invariance_is_taken_of_transmission_where_nothing_speaks_against_it() {
        let (turned, shift) = (of(Frame::Turned, 0.1), of(Frame::Shift, 0.01));
        let even = [(turned, vec![0.10, 0.20, 0.15, 0.30]), (shift, vec![0.14, 0.18, 0.17, 0.28])];
        assert_eq!(chosen(&even, true), shift);
        assert_eq!(chosen(&even, false), turned);
        let fading = (of(Frame::Refracted { index: 1.5 }, 0.0), even[0].1.clone());
        assert_eq!(chosen(&[fading.clone(), even[1].clone()], true), fading.0);
        // As much worse in the mean, but everywhere.
        let plain = [(turned, vec![0.10, 0.20, 0.15, 0.30]), (shift, vec![0.11, 0.21, 0.16, 0.31])];
        assert_eq!(chosen(&plain, true), turned);
    }

    #[test]
    fn one_hole_past_the_rim_does_not_decide_alone() {
        let (near, far) = (of(Frame::Half, 0.0), of(Frame::Half, 0.1));
        let tried = [(near, vec![0.02, 0.03, 0.02, 0.98]), (far, vec![0.05, 0.06, 0.05, 0.88])];
        assert_eq!(chosen(&tried, false), near);
    }

    #[test]
    fn lobes_travel_only_where_that_is_surely_better() {
        let (travels, blends) = (of(Frame::Half, 0.1), of(Frame::Half, 0.0));
        let errors = vec![0.10, 0.20, 0.15, 0.30];
        let among = |blend: Vec<f64>| [(travels, errors.clone()), (blends, blend)];
        assert_eq!(chosen(&among(vec![0.11, 0.19, 0.16, 0.31]), false), blends);
        assert_eq!(chosen(&among(vec![0.12, 0.24, 0.18, 0.36]), false), travels);
        // Not surely, but by much.
        assert_eq!(chosen(&among(vec![0.10, 0.20, 0.15, 0.60]), false), travels);
    }

    #[test]
    fn change_goes_on_unless_that_is_surely_worse() {
        let errors = |share: f64, errors: [f64; 3]| (share, errors.to_vec());
        let (none, half) = (errors(0.0, [0.20, 0.22, 0.24]), errors(0.5, [0.19, 0.21, 0.23]));
        let among = |all: [f64; 3]| farthest(&[none.clone(), half.clone(), errors(1.0, all)]);
        assert_eq!(among([0.17, 0.24, 0.23]), 1.0);
        assert_eq!(among([0.21, 0.24, 0.25]), 0.5);
        assert_eq!(farthest(&[none.clone(), errors(1.0, [0.23, 0.25, 0.28])]), 0.0);
        // One alone decides outright.
        assert_eq!(farthest(&[(0.0, vec![0.2]), (1.0, vec![0.21])]), 0.0);
        assert_eq!(farthest(&[(0.0, vec![0.2]), (1.0, vec![0.19])]), 1.0);
    }

    #[test]
    fn energies_are_alike_where_only_shapes_are_compared() {
        let matte = FittedIncidence {
            wi: DVec3::Z,
            lobes: LobeSet { floor: 0.2, lobes: Vec::new() },
            details: vec![Detail::fit(&[DVec3::Z], &[1.0], &[1.0], 8)],
            points: 1,
            hemispherical: 0.6,
            fit_error: 0.0,
            limit: 1.0,
            seen: Seen::whole(),
        };
        let (front, motion) = (Side::Front, Motion::straight(Frame::Half));
        let c = Component::new(front, front, Symmetry::Isotropic, motion, 1e-9, vec![matte]);
        let wo = hemisphere();
        let truth = bin(&wo, &vec![0.1; wo.len()]);
        let of = |energy: Energies| error(c.as_ref().expect("component"), DVec3::Z, &truth, energy);
        let (own, alike) = (of(Energies::Own), of(Energies::Alike));
        assert!((own - 1.0).abs() < 1e-6 && alike < 1e-6, "{own} {alike}");
    }

    fn hemisphere() -> Vec<DVec3> {
        let at = |k: usize| DVec2::new((k / 40) as f64 + 0.5, (k % 40) as f64 + 0.5) / 40.0;
        (0..1600).map(|k| square_to_hemisphere(at(k), Side::Front)).collect()
    }

    #[test]
    fn without_incidences_to_leave_out_any_candidate_will_do() {
        assert_eq!(chosen(&[], true).frame, Frame::Shift);
        assert_eq!(chosen(&[(of(Frame::Fixed, 0.0), vec![])], false).frame, Frame::Fixed);
    }
}
