//! What figures rest on, said beside them: marks of totals, and warnings of fits that are not to be trusted.

use bsdfkit::DVec3;
use bsdfkit_fit::interpolant::{Component, Part};
use bsdfkit_fit::measurement::{self, IncidenceQuality, Measurement};
use bsdfkit_fit::validate::TRUSTED;

use crate::stop::remark;

/// A total, marked ~ where it is extrapolated.
pub(crate) fn total(value: f64, extrapolated: bool) -> String {
    format!("{}{value:.4}", if extrapolated { "~" } else { "" })
}

/// The totals of a measured incidence, one a channel: ~ and the uncertainty of what a plane lets expect, > before
/// what was seen alone.
pub(crate) fn totals(i: &IncidenceQuality) -> String {
    let one = |c: usize| {
        let (value, least) = (i.hemispherical[c], i.hemispherical_at_least[c]);
        match &i.hemispherical_uncertainty {
            Some(off) => format!("{}±{:.4}", total(value, i.extrapolated), off[c]),
            None if value.is_finite() => total(value, i.extrapolated),
            None if least.is_finite() => format!(">{least:.4}"),
            None => "unknown".to_owned(),
        }
    };
    (0..i.hemispherical.len()).map(one).collect::<Vec<_>>().join(" ")
}

/// Whether the total at `wi` is extrapolated; of Radiance's interpolants nobody knows.
pub(crate) fn extrapolated(part: &Part, wi: DVec3) -> bool {
    match part {
        Part::Transported(c) => !c.tells(wi),
        Part::Sir(_) => false,
    }
}

/// Says on standard error what `m` shows too little of.
pub(crate) fn warn_scant(place: &str, m: &Measurement) {
    let scant = measurement::scant(&m.sights());
    remark("warning", &scant.iter().map(|s| format!("{place}: {s}")).collect::<Vec<_>>());
}

/// The error to expect between incidences, in words.
pub(crate) fn expected(error: Option<f64>) -> String {
    error.map_or_else(|| "unknown".to_owned(), |e| format!("{e:.4}"))
}

/// Says on standard error where a fit is not to be trusted between its incidences.
pub(crate) fn warn_expected(place: &str, component: &Component) {
    let incidences = component.incidences.len();
    let text = match component.expected_error {
        Some(error) if error > TRUSTED => format!(
            "{place}: an L1 error of {error:.2} is to be expected half-way between its {incidences} incidences (at them {:.4}): \
             `bsdf validate` shows where, `bsdf plan` says what to measure next",
            component.incidences.iter().map(|i| i.fit_error).sum::<f64>()
                / incidences.max(1) as f64
        ),
        Some(_) => return,
        None => format!(
            "{place}: the error between incidences is unknown: too few of {incidences} incidences to leave any out; `bsdf plan` \
             says what to measure next"
        ),
    };
    remark("warning", &[text]);
}
