//! Incident directions chosen together: none is best where it is only for those chosen before it.

use std::f64::consts::FRAC_PI_3;

use bsdfkit::{DVec2, DVec3, Result};
use rayon::prelude::*;

use super::domain::Domain;
use super::state::{Light, State, SurveyedComponent};
use bsdfkit_represent::Watch;

/// Where directions may be chosen, and what is gained by them.
#[derive(Clone, Debug)]
pub(super) struct Layout<'a> {
    /// What has been measured of each component.
    pub(super) components: Vec<SurveyedComponent<'a>>,
    pub(super) domain: Domain,
    /// Directions over which errors are averaged, with their shares.
    pub(super) spread: Vec<(DVec3, f64)>,
    /// Least chord between incident directions, images among them.
    pub(super) spacing: f64,
}

/// Every direction is looked at so often at most; the last times little moves.
const SWEEPS: usize = 8;
/// A sweep that gains less than this share is the last.
const GAIN: f64 = 3e-3;
/// Of more directions than this, each is looked at fewer times: the cost of one look grows with
/// them, too.
const LOOKS: usize = 1000;
/// A direction moves by these shares of the hole that it would leave, six ways each.
const STEPS: [f64; 3] = [0.5, 0.2, 0.07];
/// Or to one of so many places where most light is misplaced: doubled, nothing more is gained.
const ELSEWHERE: usize = 6;
/// These are as far apart as this share of the hole.
const APART: f64 = 0.3;
/// The next in order is sought among so many.
const CLOSELY: usize = 16;

/// A chosen direction, in the order of use.
pub(super) struct Step {
    pub(super) wi: DVec3,
    /// Light to expect there before it is measured.
    pub(super) before: Light,
    /// Light to expect of all directions once it is measured.
    pub(super) after: Light,
}

impl Layout<'_> {
    /// Most looks at `count` directions.
    pub(super) fn looks(count: usize) -> usize {
        count * Self::sweeps(count)
    }

    fn sweeps(count: usize) -> usize {
        (LOOKS / count.max(1)).clamp(1, SWEEPS)
    }

    /// Up to `budget` directions that together leave least light misplaced; fewer where the spacing
    /// leaves no room.
    ///
    /// Errors: limit when cancelled. `looked` is called after each look at one of them.
    /// Cost: 20 ms for each of 40, 60 ms for each of 100 and more.
    pub(super) fn choose(
        &self,
        budget: usize,
        watch: &Watch<'_>,
        looked: &dyn Fn(),
    ) -> Result<Vec<DVec3>> {
        let mut chosen = self.seeded(budget, watch)?;
        let mut misplaced = self.misplaced(&chosen);
        for _ in 0..Self::sweeps(chosen.len()) {
            let before = misplaced;
            for k in 0..chosen.len() {
                watch.check()?;
                if let Some((less, wi)) = self.moved(&chosen, k)
                    && less < misplaced
                {
                    (misplaced, chosen[k]) = (less, wi);
                }
                looked();
            }
            if misplaced >= (1.0 - GAIN) * before {
                break;
            }
        }
        Ok(chosen)
    }

    /// The first of them takes away most of the light misplaced; each further one most of the rest.
    ///
    /// Errors: limit when cancelled.
    pub(super) fn in_order(&self, mut chosen: Vec<DVec3>, watch: &Watch<'_>) -> Result<Vec<Step>> {
        let mut steps: Vec<Step> = Vec::new();
        let mut taken: Vec<DVec3> = Vec::new();
        while !chosen.is_empty() {
            watch.check()?;
            let states = self.states(&taken);
            let here = |wi: DVec3| states.as_ref().map_or(Light::default(), |s| light(s, wi));
            chosen.sort_by(|a, b| here(*b).misplaced.total_cmp(&here(*a).misplaced));
            let tried = chosen.par_iter().enumerate().take(CLOSELY).map(|(k, &wi)| {
                let after =
                    self.states(&with(&taken, wi)).map_or(Light::default(), |s| self.mean(&s));
                (k, after)
            });
            let least = tried.min_by(|a, b| a.1.misplaced.total_cmp(&b.1.misplaced));
            let Some((k, after)) = least else { break };
            let wi = chosen.remove(k);
            steps.push(Step { wi, before: here(wi), after });
            taken.push(wi);
        }
        Ok(steps)
    }

    /// One by one where most light is misplaced.
    fn seeded(&self, budget: usize, watch: &Watch<'_>) -> Result<Vec<DVec3>> {
        let mut chosen = Vec::new();
        while chosen.len() < budget {
            watch.check()?;
            let next = match self.states(&chosen) {
                Some(states) => self.worst(&states).find(|&wi| self.is_free(&states, wi)),
                None => Some(self.domain.nearest(DVec2::ZERO, self.spacing)),
            };
            let Some(next) = next else { break };
            chosen.push(next);
        }
        Ok(chosen)
    }

    /// The best other place for one of the directions, and what is misplaced then.
    fn moved(&self, chosen: &[DVec3], k: usize) -> Option<(f64, DVec3)> {
        let mut others = chosen.to_vec();
        let own = others.remove(k);
        let states = self.states(&others)?;
        let hole = states.iter().map(|s| s.gap(own).reach).fold(f64::MAX, f64::min);
        let mut places: Vec<DVec3> = Vec::new();
        for wi in self.worst(&states) {
            if places.len() == ELSEWHERE {
                break;
            }
            if places.iter().all(|p| p.distance(wi) > APART * hole) {
                places.push(wi);
            }
        }
        for (i, step) in STEPS.iter().enumerate() {
            let turn = 0.25 * i as f64;
            places.extend((0..6).map(|j| {
                let way = DVec2::from_angle(FRAC_PI_3 * (f64::from(j) + turn));
                self.domain.nearest(own.truncate() + step * hole * way, self.spacing)
            }));
        }
        let open = places.into_par_iter().filter(|&wi| self.is_free(&states, wi));
        let tried = open.map(|wi| (self.misplaced(&with(&others, wi)), wi));
        tried.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// All components with `chosen`; `None` where one cannot be meshed.
    fn states(&self, chosen: &[DVec3]) -> Option<Vec<State<'_>>> {
        self.components.iter().map(|g| g.with(chosen)).collect()
    }

    /// The mean over all incident directions.
    fn mean(&self, states: &[State<'_>]) -> Light {
        let zero = Light::default();
        self.spread.iter().fold(zero, |sum, &(wi, share)| sum.plus(share, light(states, wi)))
    }

    /// Light misplaced over all incident directions.
    fn misplaced(&self, chosen: &[DVec3]) -> f64 {
        self.states(chosen).map_or(f64::MAX, |s| self.mean(&s).misplaced)
    }

    /// Directions that may be chosen, where most light is misplaced first.
    fn worst(&self, states: &[State<'_>]) -> impl Iterator<Item = DVec3> {
        let place = |&(wi, share): &(DVec3, f64)| (share * light(states, wi).misplaced, wi);
        let mut places: Vec<(f64, DVec3)> = self.spread.iter().map(place).collect();
        places.sort_by(|a, b| b.0.total_cmp(&a.0));
        places.into_iter().map(|(_, wi)| self.domain.nearest(wi.truncate(), self.spacing))
    }

    fn is_free(&self, states: &[State<'_>], wi: DVec3) -> bool {
        states.iter().all(|s| s.distance_to_nearest(wi) >= self.spacing)
    }
}

fn with(chosen: &[DVec3], wi: DVec3) -> Vec<DVec3> {
    let mut all = chosen.to_vec();
    all.push(wi);
    all
}

/// Light to expect at `wi` from all components.
fn light(states: &[State<'_>], wi: DVec3) -> Light {
    states.iter().fold(Light::default(), |sum, s| sum.plus(1.0, s.light(wi)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolant::Chart;
    use crate::survey::state::ErrorLaw;
    use bsdfkit_measure::Symmetry;

    fn layout(symmetry: Symmetry, measured: Vec<DVec3>) -> Layout<'static> {
        let domain = Domain::new(symmetry, 0.95);
        let spread = domain.spread();
        let surveyed = SurveyedComponent {
            law: ErrorLaw::Assumed(-1.5),
            symmetry,
            chart: Chart::Disk,
            measured,
        };
        Layout { components: vec![surveyed], domain, spread, spacing: 0.05 }
    }

    fn chosen(layout: &Layout<'_>, budget: usize) -> Vec<DVec3> {
        layout.choose(budget, &Watch::default(), &|| ()).expect("not cancelled")
    }

    /// Slow twin: all pairs of places on a chain.
    #[test]
    fn no_other_pair_leaves_less_misplaced() {
        for measured in [Vec::new(), vec![DVec3::new(0.6, 0.0, 0.8)]] {
            let layout = layout(Symmetry::Isotropic, measured);
            let at = |k: u32| layout.domain.nearest(DVec2::new(0.02 * f64::from(k), 0.0), 0.05);
            let pairs = (0..48).flat_map(|a| (a + 3..48).map(move |b| [a, b]));
            let best = pairs.map(|p| layout.misplaced(&p.map(at))).fold(f64::MAX, f64::min);
            let ours = layout.misplaced(&chosen(&layout, 2));
            assert!(ours < 1.01 * best, "{ours}, best of all pairs {best}");
        }
    }

    #[test]
    fn together_they_leave_less_than_one_by_one() {
        for (symmetry, budget, share) in [
            (Symmetry::Isotropic, 4, 0.9),
            (Symmetry::Quadrilateral, 9, 0.9),
            (Symmetry::None, 30, 0.95),
        ] {
            let layout = layout(symmetry, vec![DVec3::Z]);
            let single = layout.seeded(budget, &Watch::default()).expect("not cancelled");
            let together = chosen(&layout, budget);
            assert_eq!((single.len(), together.len()), (budget, budget), "{symmetry}");
            let (ours, theirs) = (layout.misplaced(&together), layout.misplaced(&single));
            assert!(ours < share * theirs, "{symmetry}: {ours}, one by one {theirs}");
        }
    }

    #[test]
    fn each_in_order_takes_away_less_than_the_one_before() {
        let layout = layout(Symmetry::Quadrilateral, vec![DVec3::Z]);
        let all = chosen(&layout, 8);
        let steps = layout.in_order(all.clone(), &Watch::default()).expect("not cancelled");
        let left: Vec<f64> = [layout.misplaced(&[])]
            .into_iter()
            .chain(steps.iter().map(|s| s.after.misplaced))
            .collect();
        assert_eq!(steps.len(), 8);
        assert!(left.windows(2).all(|w| w[1] < w[0]), "{left:?}");
        assert!(left[0] - left[1] > left[7] - left[8], "{left:?}");
        let alone = all.iter().map(|&wi| layout.misplaced(&[wi])).fold(f64::MAX, f64::min);
        assert!((left[1] - alone).abs() < 1e-12, "{left:?}, the best alone {alone}");
        assert!((left[8] - layout.misplaced(&all)).abs() < 1e-12);
    }
}
