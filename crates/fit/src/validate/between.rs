//! The error to expect between incidences, at a small part of the cost of a fit.

use bsdfkit::Result;
use rayon::prelude::*;

use super::error_model::ErrorModel;
use super::left_out::LeftOut;
use crate::interpolant::Component;
use bsdfkit_measure::Measurement;
use bsdfkit_represent::Watch;

/// Incidences left out, one at a time: what they show differs by a third, so of the mean a tenth is left.
const LEFT_OUT: usize = 8;

/// Fewer incidences leave nothing to predict one from.
const FEWEST: usize = 3;

/// L1 above which a fit is not to be trusted between its incidences: one part of the light in ten is in a wrong
/// place. The virtual materials and published measurements stay below a tenth.
pub const TRUSTED: f64 = 0.2;

/// Why a fit is not to be trusted between its incidences, and what to do: nothing where the error to expect is known
/// and below [`TRUSTED`].
pub fn doubt(component: &Component) -> Option<String> {
    let incidences = component.incidences().len();
    let fit = component.incidences().iter().map(|i| i.fit_error).sum::<f64>();
    match component.expected_error {
        Some(error) if error > TRUSTED => Some(format!(
            "an L1 error of {error:.2} is to be expected half-way between its {incidences} incidences (at them {:.4}): \
             `bsdf validate` shows where, `bsdf plan` says what to measure next",
            fit / incidences.max(1) as f64
        )),
        Some(_) => None,
        None => Some(format!(
            "the error between incidences is unknown: too few of {incidences} incidences to leave any out; `bsdf plan` \
             says what to measure next"
        )),
    }
}

/// L1 error to expect half-way between neighbouring incidences of `m`, to which `whole` was fitted: the mean over the
/// edges of the mesh.
///
/// As [`ErrorModel`] has it, from [`LEFT_OUT`] incidences that the others surround. `None` where there are fewer than
/// three, or the others surround none.
///
/// Errors: limit when cancelled.
/// Cost: of each left out the mesh, plans and energy of the others.
pub fn expected_between(
    m: &Measurement,
    whole: &Component,
    watch: &Watch<'_>,
) -> Result<Option<f64>> {
    let total = m.incidences.len();
    if total < FEWEST || total != whole.incidences().len() {
        return Ok(None);
    }
    let outermost = whole.mesh().outermost();
    let inner: Vec<usize> = (0..total).filter(|k| !outermost.contains(k)).collect();
    let count = inner.len().min(LEFT_OUT);
    let chosen = (0..count).map(|k| inner[(2 * k + 1) * inner.len() / (2 * count)]);
    let one = |k: usize| {
        watch.check()?;
        // What the others cannot be meshed without tells nothing.
        Ok(LeftOut::of(m, whole, k).ok().filter(|i| !i.extrapolated).map(|i| (k, i)))
    };
    let left_out =
        chosen.collect::<Vec<_>>().into_par_iter().map(one).collect::<Result<Vec<_>>>()?;
    let left_out: Vec<(usize, LeftOut)> = left_out.into_iter().flatten().collect();
    if left_out.is_empty() {
        return Ok(None);
    }
    let model = ErrorModel::of_some(whole, &left_out);
    let mesh = whole.mesh();
    let half_way = |&[a, b]: &[u32; 2]| mesh.between(&[(a, 0.5), (b, 0.5)]);
    let errors: Vec<f64> =
        mesh.topology.edges().iter().map(|edge| model.at(half_way(edge)).l1).collect();
    Ok(Some(errors.iter().sum::<f64>() / errors.len().max(1) as f64))
}
