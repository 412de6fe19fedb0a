//! What to measure next.

use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use bsdfkit::{DVec3, Error, Result, Side};

use super::domain::Domain;
use super::layout::{Layout, Step};
use super::limits::Limits;
use super::scan_region::ScanRegion;
use super::state::{ErrorLaw, SurveyedComponent};
use crate::interpolant::Component;
use crate::validate::{ErrorModel, Validated, Validation};
use bsdfkit_measure::{Measurement, Symmetry};
use bsdfkit_represent::Watch;

/// One component of the specimen, and how far it is to be trusted.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// Fitted to what has been measured.
    pub component: &'a Component,
    /// Its incidences left out.
    pub validation: &'a Validation,
    /// What to expect of it.
    pub model: &'a ErrorModel,
}

/// An incident direction to measure.
#[derive(Clone, Debug)]
pub struct Proposal {
    /// Incident direction, on the side of the components.
    pub wi: DVec3,
    /// L1 to expect there with what is measured and proposed so far.
    pub expected_l1: f64,
    /// L1 to expect of all incident directions together once this one is measured, too: directions
    /// in which the specimen is nearly dark count little.
    pub mean_l1: f64,
    /// Where to scan densely.
    pub regions: Vec<ScanRegion>,
}

/// Proposes `budget` incident directions for each side that was lit, by leaving out what was
/// measured there.
///
/// `max_theta_degrees`: what the instrument reaches; by default the largest that was measured.
///
/// Errors: as [`propose`] and [`Validated::of`].
pub fn next(
    measured: &[(Arc<Component>, Measurement)],
    max_theta_degrees: Option<f64>,
    spacing_degrees: f64,
    budget: usize,
    watch: &Watch<'_>,
) -> Result<Vec<Proposal>> {
    let mut proposals = Vec::new();
    for side in [Side::Front, Side::Back] {
        let lit: Vec<_> = measured.iter().filter(|(_, m)| m.incident == side).collect();
        if lit.is_empty() {
            continue;
        }
        let known = lit.iter().map(|(c, m)| Validated::of(m, c, watch));
        let known = known.collect::<Result<Vec<Validated>>>()?;
        let subjects: Vec<Subject<'_>> = lit
            .iter()
            .zip(&known)
            .map(|((component, _), Validated { validation, model })| Subject {
                component,
                validation,
                model,
            })
            .collect();
        let farthest = lit.iter().map(|(_, m)| m.largest_incident_degrees());
        let farthest = farthest.map(|theta| theta.min(180.0 - theta)).fold(0.0, f64::max);
        let limits = Limits {
            max_theta_degrees: max_theta_degrees.unwrap_or(farthest.clamp(1.0, 89.9)),
            spacing_degrees,
        };
        proposals.extend(propose(&subjects, &limits, budget, watch)?);
    }
    Ok(proposals)
}

/// Proposes `budget` incident directions for components lit from one side; fewer where the spacing
/// leaves no room. Together they leave least of the light to expect in wrong places; the first of
/// them takes away most of it, each further one most of what remains.
///
/// Errors: argument for no components, components of two incident sides, or limits out of range;
/// limit when cancelled.
/// Cost: 20 ms for each of 40 proposals, 60 ms for each of 100 and more.
pub fn propose(
    subjects: &[Subject<'_>],
    limits: &Limits,
    budget: usize,
    watch: &Watch<'_>,
) -> Result<Vec<Proposal>> {
    let symmetry = common_symmetry(subjects)?;
    limits.validate()?;
    let domain = Domain::new(symmetry, limits.max_theta_degrees.to_radians().sin());
    let (components, spread) = (subjects.iter().map(surveyed).collect(), domain.spread());
    let layout = Layout { components, domain, spread, spacing: limits.spacing() };
    let (done, total) = (AtomicUsize::new(0), Layout::looks(budget));
    let chosen = layout.choose(budget, watch, &|| watch.finished(&done, total))?;
    let steps = layout.in_order(chosen, watch)?;
    Ok(steps.into_iter().map(|step| proposal(subjects, &step)).collect())
}

fn surveyed<'a>(subject: &Subject<'a>) -> SurveyedComponent<'a> {
    SurveyedComponent {
        law: ErrorLaw::Measured(subject.model),
        symmetry: subject.component.symmetry(),
        chart: subject.component.motion().chart,
        measured: subject.component.incidences().iter().map(|i| i.wi).collect(),
    }
}

fn proposal(subjects: &[Subject<'_>], step: &Step) -> Proposal {
    let regions = subjects.iter().flat_map(|s| {
        let limit = s.component.incidences().iter().map(|i| i.limit).fold(0.0, f64::max);
        ScanRegion::of(s.component, step.wi, limit, s.validation.peak_offset_degrees())
    });
    let side = subjects[0].component.incident();
    Proposal {
        wi: DVec3::new(step.wi.x, step.wi.y, side.sign() * step.wi.z),
        expected_l1: step.before.l1(),
        mean_l1: step.after.l1(),
        regions: regions.collect(),
    }
}

/// The symmetry that all components have, if they have the same, else none.
fn common_symmetry(subjects: &[Subject<'_>]) -> Result<Symmetry> {
    let Some(first) = subjects.first() else {
        return Err(Error::argument("expected at least one component, found none"));
    };
    if subjects.iter().any(|s| s.component.incident() != first.component.incident()) {
        return Err(Error::argument("expected components lit from one side, found two sides"));
    }
    let symmetry = first.component.symmetry();
    let same = subjects.iter().all(|s| s.component.symmetry() == symmetry);
    Ok(if same { symmetry } else { Symmetry::None })
}
