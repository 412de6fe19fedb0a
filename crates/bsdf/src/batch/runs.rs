//! Slices of BSDFs that prepare for an incident direction: runs of one share what is prepared.

use std::f64::consts::FRAC_1_PI;

use rayon::prelude::*;

use super::block::Input;
use crate::component::Components;
use crate::lanes::Sense;
use crate::query::Selected;
use crate::{Bsdf, DVec3, Side, Xyz};

/// Results of one run that one thread takes at a time, for each of which the direction is prepared
/// anew: about 2 ms against 50 µs. More would leave threads idle on one long run; a guess.
const GRAIN: usize = 4096;

/// Calls `f` for each run of equal incident directions with the number of its first result.
pub(super) fn runs<T: Send>(
    wi: Input<'_, DVec3>,
    out: &mut [T],
    f: impl Fn(DVec3, usize, &mut [T]) + Sync,
) {
    let mut jobs = Vec::new();
    let (mut first, mut left) = (0, out);
    while !left.is_empty() {
        let most = left.len().min(GRAIN);
        let same = |k: &usize| wi.at(first + k) == wi.at(first);
        let run = 1 + (1..most).take_while(same).count();
        let (now, later) = left.split_at_mut(run);
        jobs.push((first, now));
        (first, left) = (first + run, later);
    }
    jobs.into_par_iter().for_each(|(first, out)| f(wi.at(first), first, out));
}

impl Bsdf {
    /// One result after the other: `f` gets the parts, the incident direction and the number of the
    /// result.
    pub(super) fn each_run<T: Send>(
        &self,
        wi: Input<'_, DVec3>,
        components: Components,
        out: &mut [T],
        f: impl Fn(&Selected<'_>, DVec3, usize) -> T + Sync,
    ) {
        runs(wi, out, |w, first, out| {
            let selected = self.selected(w, components);
            for (n, out) in out.iter_mut().enumerate() {
                *out = f(&selected, w, first + n);
            }
        });
    }

    /// [`Bsdf::eval_xyz`] of many pairs, or `what` of it.
    pub(super) fn eval_runs<T: Send>(
        &self,
        wi: Input<'_, DVec3>,
        wo: Input<'_, DVec3>,
        out: &mut [T],
        what: impl Fn(Xyz) -> T + Sync,
    ) {
        runs(wi, out, |w, first, out| {
            for side in [Side::Front, Side::Back] {
                let on_side = |n: &usize| Side::of(wo.at(first + n)) == side;
                let numbers: Vec<usize> = (0..out.len()).filter(on_side).collect();
                let directions: Vec<DVec3> = numbers.iter().map(|n| wo.at(first + n)).collect();
                let values = self.eval_from(w, side, &directions);
                for ((n, direction), value) in numbers.into_iter().zip(directions).zip(values) {
                    let nan = w.is_nan() || direction.is_nan();
                    out[n] = what(if nan { value * f64::NAN } else { value });
                }
            }
        });
    }

    /// [`Bsdf::eval_xyz`] of one incident direction and scattered ones of one side, but for NaN.
    fn eval_from(&self, wi: DVec3, scattered: Side, wo: &[DVec3]) -> Vec<Xyz> {
        let incident = Side::of(wi);
        let lambertian = self.explicit_lambertian().get(incident, scattered) * FRAC_1_PI;
        let mut sums = vec![lambertian; wo.len()];
        if wo.is_empty() || wi.is_nan() {
            return sums;
        }
        let mut values = vec![Xyz::ZERO; wo.len()];
        for (_, c, sense) in self.answering(incident, scattered) {
            let distribution = c.distribution();
            match (distribution.prepare(wi, sense), sense) {
                _ if c.is_negligible() => values.fill(c.floor()),
                (Some(prepared), _) => prepared.values_xyz(wo, &mut values),
                (None, Sense::Forward) => {
                    values
                        .iter_mut()
                        .zip(wo)
                        .for_each(|(v, &w)| *v = distribution.value_xyz(wi, w));
                }
                (None, Sense::Reverse) => {
                    values
                        .iter_mut()
                        .zip(wo)
                        .for_each(|(v, &w)| *v = distribution.value_xyz(w, wi));
                }
            }
            sums.iter_mut().zip(&values).for_each(|(sum, value)| *sum += *value);
        }
        sums
    }
}
