//! What to measure first, when nothing is known of a specimen but its symmetry.

use std::sync::atomic::AtomicUsize;

use bsdfkit::{DVec3, Result, Side};

use super::domain::Domain;
use super::layout::Layout;
use super::limits::Limits;
use super::rings::{chain, rings};
use super::state::{ErrorLaw, SurveyedComponent};
use crate::interpolant::Chart;
use bsdfkit_measure::Symmetry;
use bsdfkit_represent::Watch;

/// Of reflected light, the power of the cosine with which errors are guessed to grow. Of 0.5, 1 and
/// 1.5, on six virtual materials; the three differ by less than a tenth of the incidences saved.
const REFLECTED: f64 = -1.5;
/// Of transmitted light they are as large everywhere in the disk: what is refracted there is
/// shifted by as much as its incident direction. With -0.5 and -1, 17 and 20 % more is left in
/// wrong places of prism films. Of reflected light and one mirror, everywhere in the chart from
/// beneath.
const EVENLY: f64 = 0.0;

/// Proposes the first `budget` incident directions, on the front hemisphere; fewer where the
/// spacing leaves no room.
///
/// `scattered`: `Back` where only transmitted light is to be measured. They go where holes in the
/// disk of directions are widest, so that these become alike. `Front` where reflected light is,
/// too. They lie on rings, denser toward grazing, where scattering changes most, the outermost a
/// quarter of a step within the limit (past it scattering goes on changing): each turned by half a
/// step against the next; with two mirrors every other ring is on both. What rings leave over goes
/// where holes are widest, as do fewer than nine (four with two mirrors). With one mirror rings
/// would have to cross it or lie beside each other: there, too, holes decide, in the chart from
/// beneath, which has as much room for grazing directions. The normal is the first of them unless
/// the specimen is isotropic: lobes are fitted from there outward.
///
/// Errors: argument for limits out of range; limit when cancelled.
/// Cost: 1 s for 40, 5 s for 100 where holes decide; a fifth and less on rings.
pub fn begin(
    symmetry: Symmetry,
    scattered: Side,
    limits: &Limits,
    budget: usize,
    watch: &Watch<'_>,
) -> Result<Vec<DVec3>> {
    limits.validate()?;
    if symmetry == Symmetry::Isotropic {
        return Ok(chain(limits, budget));
    }
    let (law, chart, mut first) = match (scattered, symmetry) {
        (Side::Back, _) => (ErrorLaw::Assumed(EVENLY), Chart::Disk, Vec::new()),
        (Side::Front, Symmetry::Bilateral(_)) => {
            (ErrorLaw::Assumed(EVENLY), Chart::Beneath, Vec::new())
        }
        _ => (ErrorLaw::Assumed(REFLECTED), Chart::Disk, rings(symmetry, limits, budget)),
    };
    if first.is_empty() && budget > 0 {
        first.push(DVec3::Z);
    }
    let domain = Domain::new(symmetry, limits.max_theta_degrees.to_radians().sin());
    let spread = domain.spread();
    let surveyed = |measured: Vec<DVec3>| SurveyedComponent { law, symmetry, chart, measured };
    let mut layout = Layout {
        components: vec![surveyed(first.clone())],
        domain,
        spread,
        spacing: limits.spacing(),
    };
    let more = budget - first.len();
    let (done, total) = (AtomicUsize::new(0), Layout::looks(more));
    first.extend(layout.choose(more, watch, &|| watch.finished(&done, total))?);
    // The normal, then those that take away most.
    let rest = first.split_off(first.len().min(1));
    layout.components = vec![surveyed(first.clone())];
    first.extend(layout.in_order(rest, watch)?.into_iter().map(|step| step.wi));
    Ok(first)
}
