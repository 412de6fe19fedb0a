//! What figures rest on, said beside them: marks of totals, and warnings of fits that are not to be trusted.

use bsdfkit::{Bsdf, DVec3, Side};
use bsdfkit_fit::interpolant::{Component, Continuous, Part};
use bsdfkit_fit::validate::doubt;
use bsdfkit_measure::{IncidenceQuality, Measurement};

use crate::terminal::stop::remark;

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
        Part::Sir(_) | Part::Dense(_) => false,
    }
}

/// Whether the total of light from `wi` to side `to` is extrapolated: what is stored is what it is.
pub(crate) fn extrapolated_total(bsdf: &Bsdf, wi: DVec3, to: Side) -> bool {
    let part = |c: &bsdfkit::Component| {
        let sides = (c.incident, c.scattered);
        let continuous = c.distribution().downcast_ref::<Continuous>();
        match continuous.map(Continuous::part) {
            Some(part) if sides == (Side::of(wi), to) => extrapolated(part, wi),
            // Light the other way is made of all incidences, those past the rim among them.
            Some(Part::Transported(_)) => sides == (to, Side::of(wi)) && sides.0 != sides.1,
            _ => false,
        }
    };
    bsdf.components().iter().any(part)
}

/// Says on standard error what `m` shows too little of.
pub(crate) fn warn_scant(place: &str, m: &Measurement) {
    let scant = bsdfkit_measure::scant(&m.sights());
    remark("warning", &scant.iter().map(|s| format!("{place}: {s}")).collect::<Vec<_>>());
}

/// The error to expect between incidences, in words.
pub(crate) fn expected(error: Option<f64>) -> String {
    error.map_or_else(|| "unknown".to_owned(), |e| format!("{e:.4}"))
}

/// Says on standard error where a fit is not to be trusted between its incidences.
pub(crate) fn warn_expected(place: &str, component: &Component) {
    remark("warning", doubt(component).map(|doubt| format!("{place}: {doubt}")).as_slice());
}
