//! The incident directions among which new ones are chosen, and over which errors are averaged.

use bsdfkit::{DVec2, DVec3};
use bsdfkit_sphere::concentric::disk_to_hemisphere;

use crate::measurement::Symmetry;

/// Directions of the front hemisphere that no symmetry makes images of each other.
#[derive(Clone, Debug)]
pub(super) struct Domain {
    symmetry: Symmetry,
    /// Largest sin θ.
    limit: f64,
}

/// Places along the diameter of the disk: 4 degrees at the normal. Doubled, a proposal takes ten
/// times as long.
const PLACES: i32 = 28;

impl Domain {
    pub(super) fn new(symmetry: Symmetry, limit: f64) -> Self {
        Self { symmetry, limit }
    }

    /// Directions of equal projected solid angle, with that angle's share as weight, to average over.
    pub(super) fn spread(&self) -> Vec<(DVec3, f64)> {
        let all = if self.symmetry == Symmetry::Isotropic {
            let ring = |k: i32| (f64::from(k) + 0.5) / f64::from(PLACES);
            (0..PLACES).map(|k| (DVec2::new(self.limit * ring(k), 0.0), ring(k))).collect()
        } else {
            self.square(0.5)
        };
        let total: f64 = all.iter().map(|a| a.1).sum();
        all.into_iter().map(|(p, w)| (lifted(p), w / total)).collect()
    }

    /// Directions that may be proposed: the normal, mirrors and the rim are among them.
    pub(super) fn candidates(&self) -> Vec<DVec3> {
        let mut places: Vec<DVec2> = if self.symmetry == Symmetry::Isotropic {
            let place = |k: i32| DVec2::new(self.limit * f64::from(k) / f64::from(2 * PLACES), 0.0);
            (0..=2 * PLACES).map(place).collect()
        } else {
            self.square(0.0).into_iter().map(|(p, _)| p).collect()
        };
        if self.symmetry != Symmetry::Isotropic {
            let rim = 3 * PLACES;
            let around = (0..rim).map(|k| {
                DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / f64::from(rim))
                    * self.limit
            });
            places.extend(around.filter(|&p| self.holds(p)));
        }
        places.into_iter().map(lifted).collect()
    }

    /// Places of a square lattice within the limit, `offset` cells off the centre.
    fn square(&self, offset: f64) -> Vec<(DVec2, f64)> {
        let half = PLACES / 2;
        let at = |k: i32| (f64::from(k) + offset) / f64::from(half) * self.limit;
        let lattice = (-half..=half).flat_map(|i| (-half..=half).map(move |j| (i, j)));
        lattice
            .map(|(i, j)| DVec2::new(at(i), at(j)))
            .filter(|&p| p.length() <= self.limit && self.holds(p))
            .map(|p| (p, 1.0))
            .collect()
    }

    /// Whether a place is in the fundamental domain.
    fn holds(&self, p: DVec2) -> bool {
        let (folded, _) = self.symmetry.fold(lifted(p));
        folded.truncate().distance(p) < 1e-9
    }
}

fn lifted(p: DVec2) -> DVec3 {
    disk_to_hemisphere(p, bsdfkit::Side::Front)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measurement::Mirror;

    #[test]
    fn directions_are_within_limit_and_domain_and_fill_it() {
        for (symmetry, images) in [
            (Symmetry::None, 1.0),
            (Symmetry::Quadrilateral, 4.0),
            (Symmetry::Bilateral(Mirror::Y), 2.0),
            (Symmetry::Rotational180, 2.0),
        ] {
            let domain = Domain::new(symmetry, 0.9);
            let spread = domain.spread();
            let disk = std::f64::consts::PI * f64::from(PLACES * PLACES) / 4.0;
            assert!((spread.len() as f64 * images / disk - 1.0).abs() < 0.06, "{symmetry}");
            assert!((spread.iter().map(|s| s.1).sum::<f64>() - 1.0).abs() < 1e-12);
            let candidates = domain.candidates();
            assert!(candidates.iter().any(|w| w.z > 1.0 - 1e-12), "{symmetry}");
            assert!(candidates.iter().any(|w| w.truncate().length() > 0.9 - 1e-9));
            for w in candidates {
                assert!(
                    w.truncate().length() <= 0.9 + 1e-9 && symmetry.fold(w).0.distance(w) < 1e-9
                );
            }
        }
    }
}
