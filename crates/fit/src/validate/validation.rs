//! Leave-one-incidence-out over a whole measurement.

use std::sync::atomic::AtomicUsize;

use bsdfkit::{Error, Result};
use rayon::prelude::*;

use super::left_out::LeftOut;
use crate::interpolant::Component;
use bsdfkit_measure::Measurement;
use bsdfkit_represent::Watch;

/// Every incidence of one component, predicted from the others.
#[derive(Clone, Debug)]
pub struct Validation {
    /// In the measurement's order.
    pub incidences: Vec<LeftOut>,
}

/// Means over some of the incidences.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Summary {
    /// How many.
    pub incidences: usize,
    /// Mean of [`LeftOut::l1`].
    pub l1: f64,
    /// Largest of them.
    pub largest_l1: f64,
    /// Mean of [`LeftOut::fit_l1`].
    pub fit_l1: f64,
    /// Root mean square of [`LeftOut::hemispherical_error`].
    pub hemispherical_rms: f64,
    /// Mean over the highest peak of each, degrees; NaN where there is none.
    pub peak_offset_degrees: f64,
    /// Geometric mean over the highest peak of each; NaN where there is none.
    pub peak_height_ratio: f64,
}

impl Validation {
    /// Leaves out every incidence of `m`, to which `whole` was fitted, one at a time.
    ///
    /// The motion is that of `whole` and lobes are those of `whole`: neither is chosen again.
    ///
    /// Errors: argument for fewer than three incidences; limit when cancelled.
    /// Cost: for each incidence the mesh, plans and energy of the others, about 2 ms for each of
    /// their triangles.
    pub fn of(m: &Measurement, whole: &Component, watch: &Watch<'_>) -> Result<Self> {
        let total = m.incidences.len();
        if total < 3 || total != whole.incidences().len() {
            let text = format!("expected at least 3 incidences to leave one out, found {total}");
            return Err(Error::argument(text));
        }
        let done = AtomicUsize::new(0);
        let one = |k| {
            watch.check()?;
            let left_out = LeftOut::of(m, whole, k)?;
            watch.finished(&done, total);
            Ok(left_out)
        };
        let incidences = (0..total).into_par_iter().map(one).collect::<Result<_>>()?;
        Ok(Self { incidences })
    }

    /// Means over the incidences inside the mesh of the others, or over the extrapolated ones.
    pub fn summary(&self, extrapolated: bool) -> Option<Summary> {
        let chosen: Vec<&LeftOut> =
            self.incidences.iter().filter(|i| i.extrapolated == extrapolated).collect();
        if chosen.is_empty() {
            return None;
        }
        let n = chosen.len() as f64;
        let mean = |of: &dyn Fn(&LeftOut) -> f64| chosen.iter().map(|i| of(i)).sum::<f64>() / n;
        let peaks: Vec<_> = chosen.iter().filter_map(|i| i.peaks.first()).collect();
        let highest = peaks.len() as f64;
        Some(Summary {
            incidences: chosen.len(),
            l1: mean(&|i| i.l1),
            largest_l1: chosen.iter().map(|i| i.l1).fold(0.0, f64::max),
            fit_l1: mean(&|i| i.fit_l1),
            hemispherical_rms: mean(&|i| i.hemispherical_error.powi(2)).sqrt(),
            peak_offset_degrees: peaks.iter().map(|p| p.offset_degrees).sum::<f64>() / highest,
            peak_height_ratio: (peaks.iter().map(|p| p.height_ratio.max(1e-6).ln()).sum::<f64>()
                / highest)
                .exp(),
        })
    }

    /// Mean distance, in degrees, by which the highest peak of each incidence is missed; 0 where no
    /// incidence has peaks.
    pub(crate) fn peak_offset_degrees(&self) -> f64 {
        let offsets = self.incidences.iter().filter_map(|i| Some(i.peaks.first()?.offset_degrees));
        let (sum, count) = offsets.fold((0.0, 0.0), |(s, n), o| (s + o, n + 1.0));
        if count > 0.0 { sum / count } else { 0.0 }
    }
}
