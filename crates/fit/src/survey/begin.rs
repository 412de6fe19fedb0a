//! What to measure first, when nothing is known of a specimen but its symmetry.

use std::sync::atomic::AtomicUsize;

use bsdfkit::{DVec3, Result};

use super::domain::Domain;
use super::layout::Layout;
use super::limits::Limits;
use super::state::{Ground, Law};
use crate::interpolant::Chart;
use crate::measurement::Symmetry;
use crate::tabulate::Watch;

/// Proposes the first `budget` incident directions, on the front hemisphere; fewer where the spacing
/// leaves no room.
///
/// They are denser toward grazing, where scattering changes most, and lie off the mirrors of the
/// specimen, where each stands for two or four. The normal is the first of them unless the specimen
/// is isotropic: lobes are fitted from there outward.
///
/// Errors: argument for limits out of range; limit when cancelled.
/// Cost: 20 ms for each of 40, 60 ms for each of 100 and more.
pub fn begin(
    symmetry: Symmetry,
    limits: &Limits,
    budget: usize,
    watch: &Watch<'_>,
) -> Result<Vec<DVec3>> {
    limits.validate()?;
    let domain = Domain::new(symmetry, limits.max_theta_degrees.to_radians().sin());
    let mut first = Vec::new();
    if symmetry != Symmetry::Isotropic && budget > 0 {
        first.push(DVec3::Z);
    }
    let chart = Chart::Disk;
    let ground = Ground { law: Law::Guessed, symmetry, chart, measured: first.clone() };
    let spread = domain.spread();
    let layout = Layout { grounds: vec![ground], domain, spread, spacing: limits.spacing() };
    let more = budget - first.len();
    let (done, total) = (AtomicUsize::new(0), Layout::looks(more));
    let chosen = layout.choose(more, watch, &|| watch.finished(&done, total))?;
    first.extend(layout.in_order(chosen, watch)?.into_iter().map(|step| step.wi));
    Ok(first)
}
