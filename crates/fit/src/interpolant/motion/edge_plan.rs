//! Transport plans along the edges of the mesh. [BvdPPH11], [WKB14 §2.2]

use bsdfkit_transport::partial;

use crate::lobe::{Lobe, LobeSet};

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

impl Pair {
    /// Whether it is a lobe without partner.
    pub(crate) fn is_alone(&self) -> bool {
        self.from.is_none() || self.to.is_none()
    }
}

/// Where on an edge peaks end, as shares of the way from its first end to its second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cliff {
    /// Lobes of the first end are there up to here.
    pub gone: f64,
    /// Lobes of the second end are there from here.
    pub new: f64,
}

/// How the lobes of two neighbouring incidences belong together.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct EdgePlan {
    /// Pairs, by first lobe.
    pub pairs: Vec<Pair>,
    /// Share of the mass that does not travel but fades and appears, each end's mass counting 1.
    pub left: f64,
    /// Where lobes that are missing at one end are cut off; `None`: they fade. See `facet::cliff`.
    pub cliff: Option<Cliff>,
}

/// A lobe that sends or receives less than this share of its mass has no partner.
/// Doubling it lets a few more small lobes fade in place. A guess.
const PARTNERED: f64 = 0.02;
/// Flows below this share of both of their lobes are dropped (the rest is scaled up).
const NEGLIGIBLE: f64 = 0.01;

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
        Self { pairs, left: (1.0 - moved).max(0.0), cliff: None }
    }

    /// The same plan seen from the other end.
    #[must_use]
    pub(crate) fn reversed(&self) -> Self {
        let turn = |p: &Pair| Pair { from: p.to, to: p.from, start: p.end, end: p.start };
        let cliff = self.cliff.map(|c| Cliff { gone: 1.0 - c.new, new: 1.0 - c.gone });
        Self { pairs: self.pairs.iter().map(turn).collect(), left: self.left, cliff }
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
}
