//! Choosing how lobes move, by leaving incidences out.
//!
//! Every hypothesis foretells measured incidences from the others. Nothing is assumed of the material. One rule decides
//! everywhere: the simplest hypothesis is taken unless another errs less by more than a standard error (that of ten
//! incidences at least), or by a tenth. The logarithms of errors are compared: holes are not equally wide, and the widest,
//! past the rim, must not decide alone.

use bsdfkit::Result;

use crate::interpolant::choose::build::FitSettings;
use crate::interpolant::choose::grooves::grooves;
use crate::interpolant::choose::left_out::LeftOut;
use crate::interpolant::choose::rim::onward;
use crate::interpolant::component::fitted::Fitted;
use crate::interpolant::component::planned::Peaks;
use crate::interpolant::mesh::chart::Chart;
use crate::interpolant::motion::hypothesis::{MOST_LAWS, Motion, REACHES, SHARES};
use bsdfkit_measure::Measurement;
use bsdfkit_measure::frame::Frame;
use bsdfkit_represent::Watch;

/// So many times better is better however few incidences there are to be sure of it.
const MUCH: f64 = 1.1;
/// A standard error is never taken for less than that of so many incidences. With that of twenty, charts of a prism film are taken for a
/// gain that is none elsewhere; with that of five, fritted glass loses a law that it needs (L1 .0014 to .0023).
const SURE: f64 = 10.0;

/// The laws tried, on either side of the surface; the first also gives the coordinates in which lobes are fitted for it.
fn laws(m: &Measurement) -> Vec<Frame> {
    if m.incident == m.scattered {
        vec![Frame::Half, Frame::Turned, Frame::Shift, Frame::Fixed]
    } else {
        vec![Frame::Shift, Frame::Turned, Frame::Refracted { index: 1.5 }, Frame::Fixed]
    }
}

/// Those of a specimen that is drawn out along the azimuth `grooves`: profile angles are mirrored, stay, or turn back.
fn laws_along(azimuth: f64) -> [Frame; 3] {
    [1.0, 0.0, -1.0].map(|sense| Frame::Profile { azimuth, sense })
}

/// The motion with which left-out incidences are foretold best.
///
/// In turn: the law of most of the light and the chart, whether lobes travel besides, which lobes have laws of their own, and how
/// much of the change goes on past the outermost incidences.
///
/// Cost: two fits of every incidence to few points, and 30 to 60 times twenty meshes of all but one incidence.
pub(crate) fn motion(m: &Measurement, settings: &FitSettings, watch: &Watch<'_>) -> Result<Motion> {
    let first = settings.frame.map_or_else(|| laws(m), |frame| vec![frame]);
    if m.incidences.len() < 2 {
        return Ok(Motion::straight(first[0]));
    }
    let left_out = LeftOut::of(m, settings, watch);
    let grooves = grooves(&left_out.thin, &left_out.energies);
    let mut fits = vec![(first[0], left_out.fit_in(first[0])?)];
    let mut best = blended(&left_out, &fits[0], &first, grooves, settings.frame.is_none());
    if best.0.frame != first[0] {
        fits.push((best.0.frame, left_out.fit_in(best.0.frame)?));
    }
    let tried = |motion: Motion| {
        let fit = fits.iter().find(|f| f.0 == motion.frame).map_or(&fits[0].1, |f| &f.1);
        (motion, left_out.errors(motion, fit, Peaks::Apart))
    };
    best = travelling(best.0, fits.iter().map(|f| f.0), tried);
    let along = if let Chart::Profile { .. } = best.0.chart { grooves } else { None };
    let new =
        laws(m).into_iter().chain([Frame::Back]).chain(along.into_iter().flat_map(laws_along));
    let mut best = with_laws(best, &new.collect::<Vec<Frame>>(), tried).0;
    if let Some((_, fit)) = fits.iter().find(|f| f.0 == best.frame) {
        // What cannot be meshed without them does not go on.
        best.onward = onward(&left_out.thin, best, fit).unwrap_or(0.0);
    }
    Ok(best)
}

/// The law and the chart with which all light, blended, is foretold best.
///
/// In whatever coordinates lobes were fitted, any law may carry them: one fit serves all.
fn blended(
    left_out: &LeftOut<'_>,
    (ground, fit): &(Frame, Fitted),
    laws: &[Frame],
    grooves: Option<f64>,
    any: bool,
) -> Tried {
    let carried = |law: Frame, chart: Chart| {
        let motion = Motion { chart, reach: 0.0, ..Motion::straight(*ground) };
        let errors = left_out.errors(motion.with_law(law), fit, Peaks::Alike);
        (Motion { frame: law, ..motion }, errors)
    };
    let in_chart = |chart: Chart| least(laws.iter().map(|&law| carried(law, chart)));
    // Refracted and diffracted directions are affine in the disk; what is reflected changes most near grazing.
    let reflected = left_out.thin.incident == left_out.thin.scattered;
    let [usual, other] =
        if reflected { [Chart::Beneath, Chart::Disk] } else { [Chart::Disk, Chart::Beneath] };
    let mut best = simplest(in_chart(usual), in_chart(other));
    if let Some(azimuth) = grooves {
        for share in SHARES {
            let chart = Chart::Profile { azimuth, share };
            let along = laws_along(azimuth).into_iter().filter(|_| any);
            let along = least(along.map(|law| carried(law, chart)));
            best = simplest(best, least([in_chart(chart), along].into_iter()));
        }
    }
    best
}

/// Blended as `motion` says, or with lobes that travel besides, in one of `frames`, and along curves.
fn travelling(
    motion: Motion,
    frames: impl Iterator<Item = Frame>,
    tried: impl Fn(Motion) -> Tried,
) -> Tried {
    // Lobes that travel need a layout in which their tracks are affine.
    let profile = matches!(motion.chart, Chart::Profile { .. });
    let chart = if profile { motion.chart } else { Chart::Disk };
    let each =
        frames.flat_map(|frame| REACHES.map(|reach| Motion { frame, reach, chart, ..motion }));
    let best = simplest(tried(motion), least(each.map(&tried)));
    if best.0.reach == 0.0 {
        return best;
    }
    let curved = tried(Motion { curved: true, ..best.0 });
    simplest(best, curved)
}

/// The same with those of `laws` that some lobes obey.
fn with_laws(mut best: Tried, laws: &[Frame], tried: impl Fn(Motion) -> Tried) -> Tried {
    while best.0.laws().len() < MOST_LAWS {
        let motion = best.0;
        let new = laws.iter().filter(|l| **l != motion.frame && !motion.laws.contains(&Some(**l)));
        best = simplest(best, least(new.map(|l| tried(motion.with_law(*l)))));
        if best.0 == motion {
            break;
        }
    }
    best
}

/// A hypothesis, and the logarithms of its errors.
type Tried = (Motion, Vec<f64>);

/// The one that errs least, the first of equals.
fn least(tried: impl Iterator<Item = Tried>) -> Tried {
    let none = || (Motion::straight(Frame::Fixed), vec![f64::INFINITY]);
    tried.min_by(|a, b| mean(&a.1).total_cmp(&mean(&b.1))).unwrap_or_else(none)
}

/// The simpler of two hypotheses, unless the other surely errs less.
fn simplest(simple: Tried, other: Tried) -> Tried {
    if surely(&simple.1, &other.1) { other } else { simple }
}

/// Mean of errors.
fn mean(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len().max(1) as f64
}

/// Whether `b` errs less than `a` by more than a standard error, see [`SURE`], or by much.
fn surely(a: &[f64], b: &[f64]) -> bool {
    let by = mean(a) - mean(b);
    by > MUCH.ln() || worse(a, b, (a.len() as f64 / SURE).max(1.0).sqrt())
}

/// Whether the mean of `a` is above that of `b` by more than so many standard errors of the mean of
/// their differences.
pub(super) fn worse(a: &[f64], b: &[f64], errors: f64) -> bool {
    let n = a.len().max(1) as f64;
    let differences = || a.iter().zip(b).map(|(a, b)| a - b);
    let mean = differences().sum::<f64>() / n;
    let squares: f64 = differences().map(|d| (d - mean).powi(2)).sum();
    mean > errors * (squares / (n * (n - 1.0).max(1.0))).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tried(frame: Frame, errors: [f64; 4]) -> Tried {
        (Motion::straight(frame), errors.map(f64::ln).to_vec())
    }

    #[test]
    fn the_simpler_hypothesis_holds_unless_the_other_is_surely_better() {
        let simple = tried(Frame::Half, [0.10, 0.20, 0.15, 0.30]);
        let against = |errors| simplest(simple.clone(), tried(Frame::Shift, errors)).0.frame;
        assert_eq!(against([0.11, 0.19, 0.16, 0.29]), Frame::Half);
        // Everywhere by a little, or by much though not everywhere.
        assert_eq!(against([0.09, 0.19, 0.14, 0.29]), Frame::Shift);
        assert_eq!(against([0.11, 0.10, 0.07, 0.31]), Frame::Shift);
        assert_eq!(against([0.11, 0.21, 0.16, 0.31]), Frame::Half);
    }

    #[test]
    fn one_hole_past_the_rim_does_not_decide_alone() {
        let near = tried(Frame::Half, [0.02, 0.03, 0.02, 0.98]);
        let far = tried(Frame::Shift, [0.05, 0.06, 0.05, 0.58]);
        assert_eq!(least([far.clone(), near.clone()].into_iter()).0.frame, Frame::Half);
        assert_eq!(simplest(near, far).0.frame, Frame::Half);
    }

    #[test]
    fn of_no_hypothesis_the_plainest_is_left() {
        assert_eq!(least(std::iter::empty()).0.frame, Frame::Fixed);
        assert_eq!(
            simplest(least(std::iter::empty()), tried(Frame::Half, [1.0; 4])).0.frame,
            Frame::Half
        );
    }
}
