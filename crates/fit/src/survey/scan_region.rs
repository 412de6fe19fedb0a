//! Where a scan of a new incidence should be denser.

use bsdfkit::{DVec3, Side};

use crate::interpolant::Component;
use crate::validate::{Peak, View};

/// A cone of scattered directions about a predicted peak.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanRegion {
    /// Its axis: the predicted peak.
    pub direction: DVec3,
    /// Its half angle: the peak has fallen to a tenth there, and may be off by as much as peaks of
    /// left-out incidences were.
    pub radius_degrees: f64,
}

/// Share of its height to which a peak is to be scanned densely.
const FALLEN: f64 = 0.1;
/// What is broader needs no denser scan.
const BROADEST_DEGREES: f64 = 20.0;

impl ScanRegion {
    /// The peaks that `whole` predicts for `wi`, within `limit` (sin θₒ), each widened by `margin`
    /// degrees; none for peaks broader than 20 degrees every way.
    pub(super) fn of(whole: &Component, wi: DVec3, limit: f64, margin: f64) -> Vec<Self> {
        let distribution = whole.at(wi);
        let f = |w| distribution.eval(w);
        let view = View { f: &f, side: whole.scattered(), limit };
        let region = |p: Peak| {
            let radius = radius(&view, p)?;
            Some(Self { direction: p.direction, radius_degrees: radius + margin })
        };
        view.peaks().into_iter().filter_map(region).collect()
    }
}

/// Degrees to where the peak has fallen to a tenth along the broadest of eight ways, at most
/// [`BROADEST_DEGREES`]; `None` if it is as broad along the narrowest.
fn radius(view: &View<'_>, peak: Peak) -> Option<f64> {
    let (u, v) = peak.direction.any_orthonormal_pair();
    let (mut narrowest, mut broadest) = (BROADEST_DEGREES, 0.0f64);
    for k in 0..8 {
        let (sin, cos) = (std::f64::consts::FRAC_PI_4 * f64::from(k)).sin_cos();
        let fallen = |degrees: &f64| {
            let (s, c) = degrees.to_radians().sin_cos();
            let w = c * peak.direction + s * (cos * u + sin * v);
            Side::of(w) != view.side || view.height(w) < FALLEN * peak.height
        };
        let mut steps = (1..).map(|k| 0.5 * f64::from(k)).take_while(|d| *d < BROADEST_DEGREES);
        let reach = steps.find(fallen).unwrap_or(BROADEST_DEGREES);
        narrowest = narrowest.min(reach);
        broadest = broadest.max(reach);
    }
    (narrowest < BROADEST_DEGREES).then_some(broadest)
}
