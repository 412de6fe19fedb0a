//! Gaussian lobes of one incidence.

use bsdfkit_sphere::DVec2;

use super::covariance::Covariance;

/// One positive Gaussian in frame coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Integral over the plane: the share of the directional-hemispherical value it carries.
    pub mass: f64,
    /// Centre.
    pub mean: DVec2,
    /// Shape.
    pub covariance: Covariance,
}

impl Lobe {
    /// mass · N(q; mean, covariance).
    pub fn density(&self, q: DVec2) -> f64 {
        let e = self.covariance.inverse().quadratic(q - self.mean);
        self.mass / (std::f64::consts::TAU * self.covariance.determinant().sqrt())
            * (-0.5 * e).exp()
    }

    /// Whether centres and shapes differ by less than a fifth of the extent.
    fn nearly_is(&self, other: &Self) -> bool {
        let apart = self.mean.distance_squared(other.mean)
            + self.covariance.bures_squared(other.covariance);
        apart < 0.04 * self.covariance.trace().min(other.covariance.trace())
    }

    /// Both as one: mass added, centre and shape averaged by mass.
    fn merged(&self, other: &Self) -> Self {
        let mass = self.mass + other.mass;
        let t = other.mass / mass.max(1e-300);
        let mix = |a: f64, b: f64| a + t * (b - a);
        let (a, b) = (self.covariance, other.covariance);
        let covariance =
            Covariance { xx: mix(a.xx, b.xx), xy: mix(a.xy, b.xy), yy: mix(a.yy, b.yy) };
        Self { mass, mean: self.mean.lerp(other.mean, t), covariance }
    }

    /// The lobe under the orthogonal map that takes +X to `x` and +Y to `y`.
    #[must_use]
    pub fn transformed(&self, x: DVec2, y: DVec2) -> Self {
        let c = self.covariance;
        let (cx, cy) = (c.xx * x + c.xy * y, c.xy * x + c.yy * y);
        Self {
            mass: self.mass,
            mean: self.mean.x * x + self.mean.y * y,
            covariance: Covariance {
                xx: x.x * cx.x + y.x * cy.x,
                xy: x.y * cx.x + y.y * cy.x,
                yy: x.y * cx.y + y.y * cy.y,
            },
        }
    }
}

/// The fitted model of one incidence: f(u) = floor + Σ lobes(q(u)) / |du/dq|.
#[derive(Clone, Debug, PartialEq)]
pub struct LobeSet {
    /// Lambertian floor, 1/sr; never transported.
    pub floor: f64,
    /// Lobes in frame coordinates.
    pub lobes: Vec<Lobe>,
}

impl LobeSet {
    /// Mass of all lobes.
    pub fn total(&self) -> f64 {
        self.lobes.iter().map(|l| l.mass).sum()
    }

    /// Σ lobes at frame coordinates `q`, without the floor.
    pub fn density(&self, q: DVec2) -> f64 {
        self.lobes.iter().map(|l| l.density(q)).sum()
    }

    /// The mean of the set and its images under the other members of a group of orthogonal maps, each
    /// given as what it takes +X and +Y to: exactly symmetric. Lobes that (nearly) coincide become one.
    #[must_use]
    pub fn symmetrised(&self, others: &[(DVec2, DVec2)]) -> Self {
        let share = 1.0 / (others.len() + 1) as f64;
        let mut lobes: Vec<Lobe> = Vec::new();
        let images = others.iter().map(|&(x, y)| self.transformed(x, y).lobes);
        for lobe in std::iter::once(self.lobes.clone()).chain(images).flatten() {
            let lobe = Lobe { mass: share * lobe.mass, ..lobe };
            match lobes.iter_mut().find(|l| l.nearly_is(&lobe)) {
                Some(l) => *l = l.merged(&lobe),
                None => lobes.push(lobe),
            }
        }
        Self { floor: self.floor, lobes }
    }

    /// The set under the orthogonal map that takes +X to `x` and +Y to `y`.
    #[must_use]
    pub fn transformed(&self, x: DVec2, y: DVec2) -> Self {
        let lobes = self.lobes.iter().map(|l| l.transformed(x, y)).collect();
        Self { floor: self.floor, lobes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_lobe_has_the_same_value_at_the_turned_place() {
        let lobe = Lobe {
            mass: 0.3,
            mean: DVec2::new(0.2, -0.1),
            covariance: Covariance { xx: 0.02, xy: 0.006, yy: 0.01 },
        };
        let q = DVec2::new(0.25, -0.02);
        for (x, y) in [(DVec2::NEG_X, DVec2::Y), (DVec2::Y, DVec2::NEG_X)] {
            let turned = lobe.transformed(x, y).density(q.x * x + q.y * y);
            assert!((turned / lobe.density(q) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_symmetrised_set_is_its_own_image_and_keeps_its_mass() {
        let lobe = |mass, x, y, xy| Lobe {
            mass,
            mean: DVec2::new(x, y),
            covariance: Covariance { xx: 0.02, xy, yy: 0.01 },
        };
        // Beside the mirror; almost on it; two that are almost each other's images.
        let lobes = vec![
            lobe(0.3, 0.1, 0.4, 0.003),
            lobe(0.2, 0.5, 0.002, 0.0003),
            lobe(0.1, -0.5, 0.3, 0.001),
            lobe(0.12, -0.501, -0.299, -0.001),
        ];
        let mirror = (DVec2::X, DVec2::NEG_Y);
        let set = LobeSet { floor: 0.05, lobes }.symmetrised(&[mirror]);
        assert_eq!(set.lobes.len(), 5);
        assert!((set.total() - 0.72).abs() < 1e-12);
        for k in 0..60 {
            let q = DVec2::new(f64::from(k % 10) * 0.17 - 0.8, f64::from(k / 10) * 0.11);
            let other = set.density(DVec2::new(q.x, -q.y));
            assert!((set.density(q) - other).abs() < 1e-12 * other.max(1.0), "{q}");
        }
        assert_eq!(set.symmetrised(&[]), set);
    }
}
