//! The incident directions among which new ones are chosen, and over which errors are averaged.

use bsdfkit::{DVec2, DVec3};
use bsdfkit_sphere::concentric::disk_to_hemisphere;

use bsdfkit_measure::Symmetry;

/// Directions of the front hemisphere that no symmetry makes images of each other.
#[derive(Clone, Debug)]
pub(super) struct Domain {
    symmetry: Symmetry,
    /// Largest sin θ.
    limit: f64,
}

/// Places along the diameter of the disk without symmetry: 4 degrees at the normal. Doubled, a
/// choice takes four times as long.
const PLACES: f64 = 28.0;

impl Domain {
    pub(super) fn new(symmetry: Symmetry, limit: f64) -> Self {
        Self { symmetry, limit }
    }

    /// About 600 directions of equal projected solid angle (along a chain: 56 with that angle's share
    /// as weight), to average over.
    pub(super) fn spread(&self) -> Vec<(DVec3, f64)> {
        let all = if self.symmetry == Symmetry::Isotropic {
            let count = 2.0 * PLACES;
            let ring = |k: i32| (f64::from(k) + 0.5) / count;
            (0..count as i32).map(|k| (DVec2::new(self.limit * ring(k), 0.0), ring(k))).collect()
        } else {
            self.square()
        };
        let total: f64 = all.iter().map(|a| a.1).sum();
        all.into_iter().map(|(p, w)| (lifted(p), w / total)).collect()
    }

    /// The direction nearest to a place of the disk that may be proposed: within limit and domain,
    /// and on a mirror rather than nearer than `spacing` to its own image.
    pub(super) fn nearest(&self, p: DVec2, spacing: f64) -> DVec3 {
        let (chain, images) = match self.symmetry {
            Symmetry::Isotropic => (true, Symmetry::Rotational180.images()),
            other => (false, other.images()),
        };
        let p = if chain { DVec2::new(p.x, 0.0) } else { p };
        let (mut wi, _) = self.symmetry.fold(lifted(p.clamp_length_max(self.limit)));
        for image in &images[1..] {
            let twin = image.apply(wi);
            if twin.distance(wi) < spacing {
                wi = lifted(0.5 * (wi + twin).truncate());
            }
        }
        wi
    }

    /// Places in the middle of the cells of a square lattice within the limit.
    fn square(&self) -> Vec<(DVec2, f64)> {
        let half = (0.5 * PLACES * (self.symmetry.images().len() as f64).sqrt()).round() as i32;
        let at = |k: i32| (f64::from(k) + 0.5) / f64::from(half) * self.limit;
        let lattice = (-half..half).flat_map(|i| (-half..half).map(move |j| (i, j)));
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
    use bsdfkit_measure::Mirror;

    const ALL: [(Symmetry, usize); 4] = [
        (Symmetry::None, 1),
        (Symmetry::Quadrilateral, 4),
        (Symmetry::Bilateral(Mirror::Y), 2),
        (Symmetry::Rotational180, 2),
    ];

    #[test]
    fn directions_are_within_limit_and_domain_and_fill_it() {
        let disk = std::f64::consts::PI * PLACES * PLACES / 4.0;
        for (symmetry, images) in ALL {
            let spread = Domain::new(symmetry, 0.9).spread();
            assert!((spread.len() as f64 / disk - 1.0).abs() < 0.06, "{symmetry}");
            assert!((spread.iter().map(|s| s.1).sum::<f64>() - 1.0).abs() < 1e-12);
            // The mean of x² over the disk of radius 0.9.
            let moment: f64 = spread.iter().map(|(w, share)| share * w.x * w.x).sum();
            assert!((moment / (0.81 / 4.0) - 1.0).abs() < 0.02, "{symmetry} {images}: {moment}");
        }
        let chain = Domain::new(Symmetry::Isotropic, 0.9).spread();
        let moment: f64 = chain.iter().map(|(w, share)| share * w.x * w.x).sum();
        assert!((moment / (0.81 / 2.0) - 1.0).abs() < 0.01, "{moment}");
    }

    #[test]
    fn what_may_be_proposed_is_far_from_its_images_or_on_the_mirror() {
        let spacing = 0.1;
        let all = ALL.iter().map(|a| a.0).chain([Symmetry::Isotropic]);
        for symmetry in all {
            let domain = Domain::new(symmetry, 0.9);
            for k in 0..500 {
                let t = f64::from(k) + 0.5;
                let p = DVec2::from_angle(2.4 * t) * (t / 500.0).sqrt() * 1.1;
                let p = if symmetry == Symmetry::Isotropic { DVec2::new(p.x, 0.0) } else { p };
                let w = domain.nearest(p, spacing);
                assert!(w.truncate().length() <= 0.9 + 1e-9, "{symmetry} {p}");
                assert!(symmetry.fold(w).0.distance(w) < 1e-9, "{symmetry} {p}: {w}");
                for image in symmetry.images() {
                    let apart = image.apply(w).distance(w);
                    assert!(apart < 1e-9 || apart >= spacing - 1e-9, "{symmetry} {p}: {w}");
                }
                // Nothing is moved farther than it must be.
                let inside = p.clamp_length_max(0.9 - 1e-9);
                let (folded, _) = symmetry.fold(lifted(inside));
                assert!(w.truncate().distance(folded.truncate()) < spacing, "{symmetry} {p}: {w}");
            }
        }
    }
}
