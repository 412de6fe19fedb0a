//! A lobe as numbers that may take any value.

use bsdfkit_sphere::DVec2;

use super::covariance::Covariance;
use super::lobe_set::Lobe;

/// Parameters per lobe: log mass, centre, and the Cholesky factor (log l₁₁, l₂₁, log l₂₂).
pub(super) const PER_LOBE: usize = 6;

/// Σ = L Lᵀ, L = [[l11, 0], [l21, l22]].
#[derive(Clone, Debug)]
pub(super) struct Parameters {
    pub(super) log_mass: f64,
    pub(super) mean: DVec2,
    pub(super) l11: f64,
    pub(super) l21: f64,
    pub(super) l22: f64,
}

impl Parameters {
    pub(super) fn of(lobe: &Lobe) -> Self {
        let c = lobe.covariance;
        let l11 = c.xx.max(1e-12).sqrt();
        let l21 = c.xy / l11;
        let l22 = (c.yy - l21 * l21).max(1e-12).sqrt();
        Self { log_mass: lobe.mass.max(1e-12).ln(), mean: lobe.mean, l11, l21, l22 }
    }

    /// The lobe, no narrower than `floor`.
    pub(super) fn lobe(&self, floor: f64) -> Lobe {
        let covariance = Covariance {
            xx: self.l11 * self.l11,
            xy: self.l11 * self.l21,
            yy: self.l21 * self.l21 + self.l22 * self.l22,
        };
        Lobe { mass: self.log_mass.exp(), mean: self.mean, covariance: covariance.floored(floor) }
    }

    /// After a step `d` of the parameters, which is bounded.
    pub(super) fn step(&self, d: &[f64]) -> Self {
        let limit = |v: f64, m: f64| v.clamp(-m, m);
        // At most a factor e^½ in mass and width, two widths in position, each step.
        let reach = 2.0 * (self.l11 + self.l22 + self.l21.abs());
        Self {
            log_mass: self.log_mass + limit(d[0], 0.7),
            mean: self.mean + DVec2::new(limit(d[1], reach), limit(d[2], reach)),
            l11: self.l11 * limit(d[3], 0.5).exp(),
            l21: self.l21 + limit(d[4], reach),
            l22: self.l22 * limit(d[5], 0.5).exp(),
        }
    }

    /// The density at q and its derivatives, slowly.
    #[cfg(test)]
    pub(super) fn density(&self, q: DVec2) -> (f64, [f64; PER_LOBE]) {
        let d = q - self.mean;
        // Whitened: y = L⁻¹ d.
        let y0 = d.x / self.l11;
        let y1 = (d.y - self.l21 * y0) / self.l22;
        let e = 0.5 * (y0 * y0 + y1 * y1);
        let g = (self.log_mass - e).exp() / (std::f64::consts::TAU * self.l11 * self.l22);
        // Σ⁻¹ d = L⁻ᵀ y.
        let s1 = y1 / self.l22;
        let s0 = (d.x / self.l11 - self.l21 * s1) / self.l11;
        let dl11 = s0 * y0 * self.l11 - 1.0;
        (g, [g, g * s0, g * s1, g * dl11, g * s1 * y0, g * (y1 * y1 - 1.0)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_match_differences() {
        let covariance = Covariance { xx: 0.02, xy: 0.005, yy: 0.01 };
        let p = Parameters::of(&Lobe { mass: 0.5, mean: DVec2::new(0.2, 0.1), covariance });
        let q = DVec2::new(0.3, 0.15);
        let (_, j) = p.density(q);
        for i in 0..PER_LOBE {
            let mut d = [0.0; PER_LOBE];
            d[i] = 1e-6;
            let up = p.step(&d).density(q).0;
            d[i] = -1e-6;
            let down = p.step(&d).density(q).0;
            let difference = (up - down) / 2e-6;
            assert!((difference - j[i]).abs() < 1e-5, "{i}: {difference} {}", j[i]);
        }
    }
}
