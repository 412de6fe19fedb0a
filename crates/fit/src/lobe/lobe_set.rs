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

    /// The lobe seen in a mirror: coordinates multiplied by `sign`, each ±1.
    #[must_use]
    pub fn mirrored(mut self, sign: DVec2) -> Self {
        self.mean *= sign;
        self.covariance.xy *= sign.x * sign.y;
        self
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

    /// The set seen in a mirror.
    #[must_use]
    pub fn mirrored(&self, sign: DVec2) -> Self {
        let lobes = self.lobes.iter().map(|l| l.mirrored(sign)).collect();
        Self { floor: self.floor, lobes }
    }
}
