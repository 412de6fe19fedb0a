//! Peaks that end all at once, as by total reflection or behind an edge of the structure.
//!
//! A peak that is found at one incidence and not at the next has either died away or been cut off on
//! the way. What it does further in tells: one that dies away has lost energy before. Leaving
//! incidences out cannot tell, because the middle between two incidences is where both guesses err alike.
//! Where on the way it ends is the matter of [`super::ending`].

use crate::interpolant::facet::ending::Endings;
use crate::interpolant::facet::facets::Facets;
use crate::interpolant::mesh::incidence_mesh::IncidenceMesh;
use crate::interpolant::motion::edge_plan::{EdgePlan, Pair, cost};
use crate::interpolant::motion::hypothesis::REACHES;
use crate::lobe::{Lobe, LobeSet};

/// Share of an incidence's energy that is gone at the next without anything in its place, from which
/// on the edge is a cliff. More than peaks that cross exchange: at 0.1 those of a louver that sends light
/// straight on and mirrored were cut off, and its energy was up to twice what it should be.
const LOST: f64 = 0.25;

/// A peak that dies away linearly keeps 1/2 of its energy one incidence before it is gone, one that
/// is cut off all of it.
const KEPT: f64 = 0.75;

/// Cosine of the angle from which on two edges at a vertex go opposite ways: 134 degrees.
const OPPOSITE: f64 = -0.7;

/// Marks the plans along which a peak is cut off; whether there are any. `energy`:
/// directional-hemispherical values at the vertices. Lobes that follow `facets` end where those have it.
pub(crate) fn mark(
    mesh: &IncidenceMesh,
    lobes: &[LobeSet],
    energy: &[f64],
    plans: &mut [EdgePlan],
    facets: &Facets,
) -> bool {
    let edges = mesh.topology.edges();
    // Lobes may have much of their mass below the horizon: what counts is their share of the energy.
    let seen =
        |v: u32, mass: f64| energy[v as usize] * mass / lobes[v as usize].total().max(1e-300);
    let free = |v: u32, lobe: Option<u16>| lobe.is_some_and(|i| !facets.rules(v, i));
    let marked = |(&[a, b], plan): (&[u32; 2], &EdgePlan)| {
        let (at_a, at_b) = (energy[a as usize], energy[b as usize]);
        let least = LOST * at_a.max(at_b);
        let gone: f64 =
            plan.pairs.iter().filter(|p| p.to.is_none() && free(a, p.from)).map(|p| p.start).sum();
        let new: f64 =
            plan.pairs.iter().filter(|p| p.from.is_none() && free(b, p.to)).map(|p| p.end).sum();
        let (gone, new) = (seen(a, gone), seen(b, new));
        let replaced = gone.min(new) > 0.25 * gone.max(new);
        if !replaced && (gone - new).abs() > least && (at_a - at_b).abs() > least {
            Mark::Cliff
        } else if gone.min(new) > least && strangers(lobes, [a, b], plan) {
            Mark::Exchange
        } else {
            Mark::None
        }
    };
    let wide = |edge: [u32; 2]| facets.plan(lobes, edge, REACHES[0]);
    // What only fades in place is not gone: it must be whichever the reach.
    let marks: Vec<Mark> = (edges.iter().zip(plans.iter()))
        .map(|(edge, plan)| match marked((edge, plan)) {
            Mark::Cliff if plan.pairs.iter().all(Pair::is_alone) => marked((edge, &wide(*edge))),
            mark => mark,
        })
        .collect();
    // Of each cliff: what is left at its upper end of the height one edge further in.
    let (mut kept, mut count) = (0.0, 0.0);
    for (&[a, b], _) in edges.iter().zip(&marks).filter(|(_, m)| **m == Mark::Cliff) {
        let upper_first = energy[a as usize] > energy[b as usize];
        let (upper, lower) = if upper_first { (a, b) } else { (b, a) };
        let at = |v: u32| mesh.vertices[v as usize].wi;
        let down = at(lower) - at(upper);
        let further_in = edges
            .iter()
            .filter_map(|&[i, j]| (i == upper).then_some(j).or((j == upper).then_some(i)))
            .filter(|&k| (at(k) - at(upper)).normalize().dot(down.normalize()) < OPPOSITE);
        for k in further_in {
            let height = energy[k as usize] - energy[lower as usize];
            if height > 0.0 {
                kept += ((energy[upper as usize] - energy[lower as usize]) / height).min(1.0);
                count += 1.0;
            }
        }
    }
    let any = count > 0.0 && kept >= KEPT * count;
    if any {
        let endings = Endings::new(mesh, lobes, energy, plans);
        let cliffs: Vec<_> = (edges.iter().zip(&marks))
            .map(|(&edge, mark)| (*mark != Mark::None).then(|| endings.on(edge)))
            .collect();
        plans.iter_mut().zip(cliffs).for_each(|(plan, cliff)| plan.cliff = cliff);
    }
    any
}

/// What an edge looks like.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    None,
    /// A peak ends and nothing takes its place.
    Cliff,
    /// A peak ends and another one begins: a cliff on either side, where there are cliffs at all.
    Exchange,
}

/// Whether what ends along the edge and what begins there are too far apart to be one peak that
/// moved, whichever the reach.
fn strangers(lobes: &[LobeSet], [a, b]: [u32; 2], plan: &EdgePlan) -> bool {
    let (a, b) = (&lobes[a as usize], &lobes[b as usize]);
    // Lobes below a hundredth of all are left-overs of the fit.
    let peak = |set: &LobeSet, i: u16| -> Option<Lobe> {
        let lobe = set.lobes[i as usize];
        (lobe.mass > 0.01 * set.total()).then_some(lobe)
    };
    let gone = plan.pairs.iter().filter(|p| p.to.is_none()).filter_map(|p| peak(a, p.from?));
    gone.into_iter().all(|i| {
        let mut new = plan.pairs.iter().filter(|p| p.from.is_none());
        new.all(|p| p.to.and_then(|j| peak(b, j)).is_none_or(|j| cost(&i, &j) > REACHES[0]))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobe::{Covariance, Lobe};
    use crate::measurement::Symmetry;
    use bsdfkit::{DVec2, DVec3};
    use bsdfkit_sphere::direction::from_degrees;

    /// A peak at 0 that stays, and one at 0.5 whose mass is `second(polar degrees)`.
    fn scene(second: impl Fn(f64) -> f64) -> (IncidenceMesh, Vec<LobeSet>) {
        let mut wi = vec![DVec3::Z];
        let mut polar = vec![0.0];
        for t in [15.0, 30.0, 45.0, 60.0] {
            for p in 0..12 {
                wi.push(from_degrees(t, f64::from(p) * 30.0));
                polar.push(t);
            }
        }
        let lobe = |mass, x| Lobe {
            mass,
            mean: DVec2::new(x, 0.0),
            covariance: Covariance::isotropic(0.001),
        };
        let set = |t: &f64| {
            let both = [lobe(0.3, 0.0), lobe(second(*t), 0.5)];
            LobeSet { floor: 0.0, lobes: both.into_iter().filter(|l| l.mass > 0.0).collect() }
        };
        let lobes = polar.iter().map(set).collect();
        (IncidenceMesh::new(&wi, Symmetry::None).expect("mesh"), lobes)
    }

    fn marked(reach: f64, second: impl Fn(f64) -> f64) -> usize {
        let (mesh, lobes) = scene(second);
        let between =
            |&[a, b]: &[u32; 2]| EdgePlan::between(&lobes[a as usize], &lobes[b as usize], reach);
        let mut plans: Vec<EdgePlan> = mesh.topology.edges().iter().map(between).collect();
        let energy: Vec<f64> = lobes.iter().map(LobeSet::total).collect();
        let any = mark(&mesh, &lobes, &energy, &mut plans, &Facets::default());
        let count = plans.iter().filter(|p| p.cliff.is_some()).count();
        assert_eq!(any, count > 0);
        count
    }

    #[test]
    fn a_peak_that_ends_all_at_once_is_cut_off_and_one_that_dies_away_is_not() {
        // Twelve edges along the meridians and twelve diagonals lead from 30 to 45 degrees.
        assert_eq!(marked(0.1, |t| if t < 40.0 { 0.4 } else { 0.0 }), 24);
        assert_eq!(marked(0.1, |t| (0.4 * (1.0 - t / 45.0)).max(0.0)), 0);
        assert_eq!(marked(0.1, |_| 0.4), 0);
        // A fifth of all, as peaks that cross may exchange.
        assert_eq!(marked(0.1, |t| if t < 40.0 { 0.08 } else { 0.0 }), 0);
    }

    #[test]
    fn a_peak_that_darkens_in_place_is_not_cut_off_though_nothing_travels() {
        assert_eq!(marked(0.0, |t| if t < 40.0 { 2.0 } else { 0.05 }), 0);
        assert_eq!(marked(0.0, |t| if t < 40.0 { 2.0 } else { 0.0 }), 24);
    }
}
