//! Choosing incident directions one by one.

use std::sync::atomic::AtomicUsize;

use bsdfkit::{DVec3, Error, Result};
use rayon::prelude::*;

use super::domain::Domain;
use super::scan::ScanRegion;
use super::state::{Light, State};
use crate::interpolant::Component;
use crate::measurement::Symmetry;
use crate::tabulate::Watch;
use crate::validate::{ErrorModel, Validation};

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

/// What the instrument can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Largest incident angle from the normal.
    pub max_theta_degrees: f64,
    /// Least distance of a new incidence from any other, and from its own images.
    pub spacing_degrees: f64,
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

/// Candidates looked at closely: those where most error is to be expected. All of them would take
/// five times as long.
const CLOSELY: usize = 64;

/// Proposes `budget` incident directions for components lit from one side; fewer where the spacing
/// leaves no room. The first of them takes away most of the error to expect; each further one most
/// of what remains.
///
/// Errors: argument for no components, components of two incident sides, or limits out of range;
/// limit when cancelled.
/// Cost: about 0.1 s for each proposal over a hundred incidences and images.
pub fn propose(
    subjects: &[Subject<'_>],
    limits: &Limits,
    budget: usize,
    watch: &Watch<'_>,
) -> Result<Vec<Proposal>> {
    let symmetry = common_symmetry(subjects)?;
    limits.validate()?;
    let domain = Domain::new(symmetry, limits.max_theta_degrees.to_radians().sin());
    let (spread, candidates) = (domain.spread(), domain.candidates());
    let mut states = subjects
        .iter()
        .map(|s| State::new(s.component, s.model))
        .collect::<Result<Vec<State<'_>>>>()?;
    let spacing = 2.0 * (0.5 * limits.spacing_degrees.to_radians()).sin();
    let apart_from_images = |wi: DVec3| {
        let images = symmetry.images().iter().map(|i| i.apply(wi).distance(wi));
        images.into_iter().all(|d| d < 1e-9 || d >= spacing)
    };
    let done = AtomicUsize::new(0);
    let mut proposals: Vec<Proposal> = Vec::new();
    while proposals.len() < budget {
        watch.check()?;
        let mut open: Vec<(Light, DVec3)> = candidates
            .iter()
            .filter(|&&wi| apart_from_images(wi))
            .filter(|&&wi| states.iter().all(|s| s.room(wi) >= spacing))
            .map(|&wi| (expected(&states, wi), wi))
            .collect();
        open.sort_by(|a, b| b.0.misplaced.total_cmp(&a.0.misplaced));
        open.truncate(CLOSELY);
        let tried = open.into_par_iter().filter_map(|(here, wi)| {
            let with = states.iter().map(|s| s.with(wi)).collect::<Option<Vec<State<'_>>>>()?;
            let mean = spread
                .iter()
                .fold(Light::default(), |sum, &(w, share)| sum.plus(share, expected(&with, w)));
            Some((mean.l1(), here.l1(), wi, with))
        });
        let Some((mean_l1, expected_l1, wi, with)) = tried.min_by(|a, b| a.0.total_cmp(&b.0))
        else {
            break; // no room
        };
        states = with;
        let regions = subjects.iter().flat_map(|s| {
            let limit = s.component.incidences.iter().map(|i| i.limit).fold(0.0, f64::max);
            ScanRegion::of(s.component, wi, limit, s.validation.peak_offset_degrees())
        });
        let side = subjects[0].component.incident;
        proposals.push(Proposal {
            wi: DVec3::new(wi.x, wi.y, side.sign() * wi.z),
            expected_l1,
            mean_l1,
            regions: regions.collect(),
        });
        watch.finished(&done, budget);
    }
    Ok(proposals)
}

impl Limits {
    /// Errors: argument, naming the limit, expected and found.
    fn validate(&self) -> Result<()> {
        let ranges = [
            ("largest theta", self.max_theta_degrees, 1.0, 89.9),
            ("spacing", self.spacing_degrees, 0.1, 45.0),
        ];
        for (name, value, low, high) in ranges {
            if !(low..=high).contains(&value) {
                let text = format!("{name}: expected {low} to {high} degrees, found {value}");
                return Err(Error::argument(text));
            }
        }
        Ok(())
    }
}

/// The symmetry that all components have, if they have the same, else none.
fn common_symmetry(subjects: &[Subject<'_>]) -> Result<Symmetry> {
    let Some(first) = subjects.first() else {
        return Err(Error::argument("expected at least one component, found none"));
    };
    if subjects.iter().any(|s| s.component.incident != first.component.incident) {
        return Err(Error::argument("expected components lit from one side, found two sides"));
    }
    let symmetry = first.component.symmetry;
    let same = subjects.iter().all(|s| s.component.symmetry == symmetry);
    Ok(if same { symmetry } else { Symmetry::None })
}

/// Light to expect at `wi` from all components.
fn expected(states: &[State<'_>], wi: DVec3) -> Light {
    states.iter().fold(Light::default(), |sum, s| sum.plus(1.0, s.expected(wi)))
}
