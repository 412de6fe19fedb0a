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
    /// Σ lobes at frame coordinates `q`, without the floor.
    pub fn density(&self, q: DVec2) -> f64 {
        self.lobes.iter().map(|l| l.density(q)).sum()
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
}
