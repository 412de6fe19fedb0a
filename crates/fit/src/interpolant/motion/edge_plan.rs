//! Transport plans along the edges of the mesh. [BvdPPH11], [WKB14 §2.2]

use bsdfkit_transport::partial;

use crate::interpolant::facet::refracted_lobe::visible;
use crate::lobe::{Lobe, LobeSet};
use bsdfkit_measure::frame::FrameAt;

/// A lobe at one end of an edge and its partner at the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pair {
    /// Index of the lobe at the first end; `None` if the lobe appears along the edge.
    pub from: Option<u16>,
    /// Index of the lobe at the second end; `None` if the lobe fades along the edge.
    pub to: Option<u16>,
    /// Mass at the first end: over all pairs of one lobe these sum to the lobe's mass.
    pub start: f64,
    /// Mass at the second end, likewise.
    pub end: f64,
}

/// How the lobes of two neighbouring incidences belong together.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct EdgePlan {
    /// Pairs, by first lobe.
    pub pairs: Vec<Pair>,
    /// Share of the mass that does not travel but fades and appears, each end's mass counting 1.
    pub left: f64,
}

/// A lobe that sends or receives less than this share of its mass has no partner.
/// Doubling it lets a few more small lobes fade in place. A guess.
const PARTNERED: f64 = 0.02;
/// Flows below this share of both of their lobes are dropped (the rest is scaled up).
const NEGLIGIBLE: f64 = 0.01;

/// A lobe of which more than this would be seen where it is missing keeps nothing of its mass there.
const SHOWN: f64 = 0.02;

/// What it costs to turn one lobe into the other: squared distance of the Gaussians in the
/// Wasserstein metric, |Δμ|² + Bures². [DD20]
pub(crate) fn cost(a: &Lobe, b: &Lobe) -> f64 {
    a.mean.distance_squared(b.mean) + a.covariance.bures_squared(b.covariance)
}

impl EdgePlan {
    /// The optimal partial plan between two lobe sets in common frame coordinates.
    ///
    /// Masses are first normalised to sum 1 on both sides; mass travels only where `cost` < `reach`;
    /// what finds no partner fades or appears where it is. Energy that a lobe loses or gains on the
    /// way changes along its track instead of travelling to other peaks.
    ///
    /// Cost: < 1 ms for 24 × 24 lobes.
    pub(crate) fn between(a: &LobeSet, b: &LobeSet, reach: f64) -> Self {
        let normalised = |set: &LobeSet| {
            let total = set.total();
            set.lobes.iter().map(|l| l.mass / total.max(1e-300)).collect::<Vec<f64>>()
        };
        let (supply, demand) = (normalised(a), normalised(b));
        let costs: Vec<f64> =
            a.lobes.iter().flat_map(|i| b.lobes.iter().map(move |j| cost(i, j))).collect();
        let flows: Vec<(usize, usize, f64)> = if supply.is_empty() || demand.is_empty() {
            Vec::new()
        } else {
            partial::solve(&supply, &demand, &costs, reach)
                .map(|p| {
                    p.travelling
                        .entries()
                        .iter()
                        .map(|f| (f.from as usize, f.to as usize, f.mass))
                        .collect()
                })
                .unwrap_or_default()
        };
        let flows: Vec<_> = flows
            .into_iter()
            .filter(|&(i, j, q)| q > NEGLIGIBLE * supply[i] || q > NEGLIGIBLE * demand[j])
            .collect();
        let (mut sent, mut received) = (vec![0.0; supply.len()], vec![0.0; demand.len()]);
        for &(i, j, q) in &flows {
            sent[i] += q;
            received[j] += q;
        }
        let alone = |moved: f64, mass: f64| moved < PARTNERED * mass || moved == 0.0;
        let mut pairs = Vec::new();
        for &(i, j, q) in &flows {
            let start = if alone(sent[i], supply[i]) { 0.0 } else { a.lobes[i].mass * q / sent[i] };
            let end =
                if alone(received[j], demand[j]) { 0.0 } else { b.lobes[j].mass * q / received[j] };
            pairs.push(Pair { from: Some(i as u16), to: Some(j as u16), start, end });
        }
        for (i, lobe) in a.lobes.iter().enumerate() {
            if alone(sent[i], supply[i]) {
                pairs.push(Pair { from: Some(i as u16), to: None, start: lobe.mass, end: 0.0 });
            }
        }
        for (j, lobe) in b.lobes.iter().enumerate() {
            if alone(received[j], demand[j]) {
                pairs.push(Pair { from: None, to: Some(j as u16), start: 0.0, end: lobe.mass });
            }
        }
        pairs.sort_by_key(|p| (p.from.unwrap_or(u16::MAX), p.to.unwrap_or(u16::MAX)));
        let moved: f64 = flows.iter().map(|f| f.2).sum();
        Self { pairs, left: (1.0 - moved).max(0.0) }
    }

    /// The plan along an edge that leads nowhere: every lobe is its own partner.
    pub(crate) fn staying(set: &LobeSet) -> Self {
        let pair = |(i, lobe): (usize, &Lobe)| {
            let own = Some(i as u16);
            Pair { from: own, to: own, start: lobe.mass, end: lobe.mass }
        };
        Self { pairs: set.lobes.iter().enumerate().map(pair).collect(), left: 0.0 }
    }

    /// The plan of those lobes only that are `free` at either end; the others are none of its business.
    pub(crate) fn among(
        sets: [&LobeSet; 2],
        free: &[impl Fn(usize) -> bool; 2],
        reach: f64,
    ) -> Self {
        let [(from, a), (to, b)] = [0, 1].map(|end| {
            let index: Vec<u16> = (0..sets[end].lobes.len() as u16).collect();
            let index: Vec<u16> = index.into_iter().filter(|&i| free[end](i as usize)).collect();
            let lobes = index.iter().map(|&i| sets[end].lobes[i as usize]).collect();
            (index, LobeSet { floor: sets[end].floor, lobes })
        });
        let mut plan = Self::between(&a, &b, reach);
        for pair in &mut plan.pairs {
            pair.from = pair.from.map(|i| from[i as usize]);
            pair.to = pair.to.map(|j| to[j as usize]);
        }
        plan
    }

    /// The same where a lobe without partner keeps its mass if that is because it would be below the horizon at the other end.
    /// `ends`: the frame at either.
    #[must_use]
    pub(crate) fn beneath(mut self, [a, b]: [&LobeSet; 2], ends: [FrameAt; 2]) -> Self {
        let hidden = |lobe: &Lobe, end: usize| (1.0 - visible(lobe, &ends[end]) / SHOWN).max(0.0);
        for pair in &mut self.pairs {
            match (pair.from, pair.to) {
                (Some(i), None) => pair.end = pair.start * hidden(&a.lobes[i as usize], 1),
                (None, Some(j)) => pair.start = pair.end * hidden(&b.lobes[j as usize], 0),
                _ => {}
            }
        }
        self
    }

    /// The same plan seen from the other end.
    #[must_use]
    pub(crate) fn reversed(&self) -> Self {
        let turn = |p: &Pair| Pair { from: p.to, to: p.from, start: p.end, end: p.start };
        Self { pairs: self.pairs.iter().map(turn).collect(), left: self.left }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobe::Covariance;
    use bsdfkit::DVec2;

    fn set(lobes: &[(f64, f64)]) -> LobeSet {
        let lobe = |&(mass, x)| Lobe {
            mass,
            mean: DVec2::new(x, 0.0),
            covariance: Covariance::isotropic(0.001),
        };
        LobeSet { floor: 0.0, lobes: lobes.iter().map(lobe).collect() }
    }

    fn sums(plan: &EdgePlan, lobes: usize, from: bool) -> Vec<f64> {
        let mut s = vec![0.0; lobes];
        for p in &plan.pairs {
            match (from, p.from, p.to) {
                (true, Some(i), _) => s[i as usize] += p.start,
                (false, _, Some(j)) => s[j as usize] += p.end,
                _ => {}
            }
        }
        s
    }

    #[test]
    fn masses_of_both_ends_are_kept() {
        let (a, b) =
            (set(&[(0.3, -0.2), (0.2, 0.1), (0.1, 0.9)]), set(&[(0.1, -0.1), (0.6, 0.15)]));
        let plan = EdgePlan::between(&a, &b, 0.1);
        for (got, lobe) in sums(&plan, 3, true).iter().zip(&a.lobes) {
            assert!((got - lobe.mass).abs() < 1e-12);
        }
        for (got, lobe) in sums(&plan, 2, false).iter().zip(&b.lobes) {
            assert!((got - lobe.mass).abs() < 1e-12);
        }
    }

    #[test]
    fn peaks_that_exchange_energy_stay_where_they_are() {
        // Two far peaks, energy moving from one to the other: nothing may travel between them.
        let (a, b) = (set(&[(0.6, -0.5), (0.2, 0.5)]), set(&[(0.2, -0.5), (0.6, 0.5)]));
        let plan = EdgePlan::between(&a, &b, 0.1);
        assert_eq!(plan.pairs.len(), 2);
        assert!(plan.pairs.iter().all(|p| p.from == p.to));
    }

    #[test]
    fn a_lobe_without_partner_fades_in_place() {
        let (a, b) = (set(&[(0.5, 0.0), (0.5, 0.9)]), set(&[(0.5, 0.0)]));
        let plan = EdgePlan::between(&a, &b, 0.1);
        assert!(plan.pairs.iter().any(|p| p.from == Some(1) && p.to.is_none() && p.end == 0.0));
    }

    #[test]
    fn a_lobe_that_is_missing_because_it_is_below_the_horizon_keeps_its_mass() {
        use bsdfkit_measure::frame::Frame;
        use bsdfkit_sphere::direction::from_degrees;
        // In the disk shifted by p, at u = q − p: out of it at 60 degrees, well within at 20 and at the normal.
        let (a, b) = (set(&[(0.4, -0.4)]), set(&[]));
        let at = |theta: f64| Frame::Shift.at(from_degrees(theta, 0.0));
        let plan = |far: f64| {
            EdgePlan::between(&a, &b, 0.1).beneath([&a, &b], [at(0.0), at(far)]).pairs[0].end
        };
        assert!((plan(60.0) - 0.4).abs() < 1e-3, "{}", plan(60.0));
        assert_eq!(plan(20.0), 0.0);
    }
}
