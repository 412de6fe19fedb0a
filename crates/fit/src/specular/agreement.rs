//! Narrow peaks of several incidences that stand where one law says.

use bsdfkit::specular::Law;
use bsdfkit::{DVec2, DVec3};

use super::candidate::Candidate;

/// Incidences that a law must hold for.
const FEWEST: usize = 3;
/// Of the incidences that could show its peak, so many must.
const MOST_OF: f64 = 0.6;
/// A law's peak is found within this share of the instrument's resolution.
const WITHIN: f64 = 0.6;
/// Laws of one component: more would be a rough surface.
const MOST: usize = 9;

/// All candidates of one incidence.
pub(super) struct Scanned {
    pub(super) wi: DVec3,
    pub(super) candidates: Vec<Candidate>,
}

/// What laws are looked for among.
pub(super) struct Search<'a> {
    pub(super) scanned: &'a [Scanned],
    /// The instrument's resolution, radians.
    pub(super) radius: f64,
    /// Whether a specimen turned about its normal is the same: then a law does so, too.
    pub(super) isotropic: bool,
    /// Whether a peak there would have been seen at an incidence.
    pub(super) shows: &'a dyn Fn(usize, DVec3) -> bool,
}

impl Search<'_> {
    /// The laws that explain most candidates, the one that most incidences show first.
    pub(super) fn laws(&self) -> Vec<Law> {
        let mut left: Vec<(usize, DVec3)> = self
            .scanned
            .iter()
            .enumerate()
            .flat_map(|(k, s)| s.candidates.iter().map(move |c| (k, c.wo)))
            .collect();
        let mut laws = Vec::new();
        while laws.len() < MOST {
            let proposals = self.proposals(&left);
            let scored = proposals.into_iter().map(|law| (self.followers(&law, &left).len(), law));
            // Of equals the first: proposals begin with the simplest.
            let best = scored.fold(None, |best: Option<(usize, Law)>, one| match best {
                Some(b) if b.0 >= one.0 => Some(b),
                _ => Some(one),
            });
            let Some((count, law)) = best.filter(|b| b.0 >= FEWEST) else { break };
            let followers = self.followers(&law, &left);
            left.retain(|c| !followers.contains(c));
            let could = self.scanned.iter().enumerate().filter(|(k, s)| {
                law.scattered(s.wi, bsdfkit::Side::Front).is_some_and(|w| {
                    let side = self.side();
                    (self.shows)(*k, DVec3::new(w.x, w.y, side * w.z))
                })
            });
            if count as f64 >= MOST_OF * could.count() as f64 {
                laws.push(law);
            }
        }
        laws
    }

    fn side(&self) -> f64 {
        let all = self.scanned.iter().flat_map(|s| &s.candidates);
        all.map(|c| c.wo.z.signum()).next().unwrap_or(1.0)
    }

    /// Candidates where the law says, one an incidence.
    fn followers(&self, law: &Law, left: &[(usize, DVec3)]) -> Vec<(usize, DVec3)> {
        let tolerance = WITHIN * self.radius;
        let mut found: Vec<(usize, DVec3)> = Vec::new();
        for &(k, wo) in left {
            let said = law.scattered(self.scanned[k].wi, bsdfkit::Side::of(wo));
            let near = said.is_some_and(|said| said.angle_between(wo) < tolerance);
            if near && found.iter().all(|f| f.0 != k) {
                found.push((k, wo));
            }
        }
        found
    }

    /// Laws that candidates suggest: turned by half a turn or not at all, moved or not; then refracted ones.
    fn proposals(&self, left: &[(usize, DVec3)]) -> Vec<Law> {
        let mut laws = vec![Law::OPPOSITE, Law::RETRO];
        let cosines = |&(k, wo): &(usize, DVec3)| (self.scanned[k].wi.truncate(), wo.truncate());
        if !self.isotropic {
            for law in [Law::OPPOSITE, Law::RETRO] {
                laws.extend(left.iter().filter_map(|c| {
                    let offset = self.mean_offset(&law, c, left);
                    law.shifted(offset).ok()
                }));
            }
        }
        let aslant = left.iter().map(cosines).filter(|(ui, _)| ui.length() > 0.3);
        laws.extend(aslant.filter_map(|(ui, uo)| {
            let slope = uo.dot(ui) / ui.length_squared();
            Law::affine([[slope, 0.0], [0.0, slope]], [0.0; 2]).ok()
        }));
        laws
    }

    /// How far candidate `c` is from the law, averaged over the candidates that are as far from it.
    fn mean_offset(&self, law: &Law, c: &(usize, DVec3), left: &[(usize, DVec3)]) -> DVec2 {
        let off =
            |&(k, wo): &(usize, DVec3)| wo.truncate() - law.cosines(self.scanned[k].wi.truncate());
        let here = off(c);
        let like = left.iter().map(off).filter(|o| o.distance(here) < self.radius);
        let (sum, count) = like.fold((DVec2::ZERO, 0.0), |(s, n), o| (s + o, n + 1.0));
        sum / f64::max(count, 1.0)
    }
}
