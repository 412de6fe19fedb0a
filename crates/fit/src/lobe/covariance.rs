//! Symmetric positive 2×2 matrices: the shape of a lobe.

use bsdfkit_sphere::DVec2;

/// Covariance of a planar Gaussian, [[xx, xy], [xy, yy]].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Covariance {
    /// Variance along x.
    pub xx: f64,
    /// Covariance.
    pub xy: f64,
    /// Variance along y.
    pub yy: f64,
}

impl Covariance {
    /// σ² I.
    pub fn isotropic(variance: f64) -> Self {
        Self { xx: variance, xy: 0.0, yy: variance }
    }

    /// With these principal axes, which are one standard deviation long and perpendicular.
    pub fn of_axes(u: DVec2, v: DVec2) -> Self {
        Self { xx: u.x * u.x + v.x * v.x, xy: u.x * u.y + v.x * v.y, yy: u.y * u.y + v.y * v.y }
    }

    /// xx yy − xy².
    #[inline]
    pub fn determinant(self) -> f64 {
        self.xx * self.yy - self.xy * self.xy
    }

    /// xx + yy.
    #[inline]
    pub fn trace(self) -> f64 {
        self.xx + self.yy
    }

    /// Inverse, itself symmetric.
    #[inline]
    pub fn inverse(self) -> Self {
        let d = 1.0 / self.determinant();
        Self { xx: self.yy * d, xy: -self.xy * d, yy: self.xx * d }
    }

    /// The principal axes, the longest first, one standard deviation long.
    pub fn axes(self) -> [DVec2; 2] {
        let half = 0.5 * self.trace();
        let wide = (half + (half * half - self.determinant()).max(0.0).sqrt()).sqrt();
        let narrow = self.determinant().max(0.0).sqrt() / wide.max(1e-150);
        let along = DVec2::from_angle(0.5 * (2.0 * self.xy).atan2(self.xx - self.yy));
        [wide * along, narrow * along.perp()]
    }

    /// M v.
    #[inline]
    pub fn apply(self, v: DVec2) -> DVec2 {
        DVec2::new(self.xx * v.x + self.xy * v.y, self.xy * v.x + self.yy * v.y)
    }

    /// vᵀ M v.
    #[inline]
    pub fn quadratic(self, v: DVec2) -> f64 {
        self.xx * v.x * v.x + 2.0 * self.xy * v.x * v.y + self.yy * v.y * v.y
    }

    /// a M + b N.
    #[inline]
    pub fn combine(a: f64, m: Self, b: f64, n: Self) -> Self {
        Self { xx: a * m.xx + b * n.xx, xy: a * m.xy + b * n.xy, yy: a * m.yy + b * n.yy }
    }

    /// Principal square root: (M + √det I) / √(tr M + 2 √det).
    pub fn sqrt(self) -> Self {
        let s = self.determinant().max(0.0).sqrt();
        let t = (self.trace() + 2.0 * s).sqrt().max(1e-150);
        Self { xx: (self.xx + s) / t, xy: self.xy / t, yy: (self.yy + s) / t }
    }

    /// A M A for symmetric A (symmetric again).
    #[inline]
    pub fn congruence(self, a: Self) -> Self {
        // B = M A, not symmetric; result = A B.
        let (b00, b01) = (self.xx * a.xx + self.xy * a.xy, self.xx * a.xy + self.xy * a.yy);
        let (b10, b11) = (self.xy * a.xx + self.yy * a.xy, self.xy * a.xy + self.yy * a.yy);
        Self {
            xx: a.xx * b00 + a.xy * b10,
            xy: a.xx * b01 + a.xy * b11,
            yy: a.xy * b01 + a.yy * b11,
        }
    }

    /// Squared Bures distance tr M + tr N − 2 tr (M½ N M½)½, without eigenvectors.
    pub fn bures_squared(self, n: Self) -> f64 {
        let tr = self.xx * n.xx + 2.0 * self.xy * n.xy + self.yy * n.yy;
        let det = (self.determinant() * n.determinant()).max(0.0).sqrt();
        (self.trace() + n.trace() - 2.0 * (tr + 2.0 * det).max(0.0).sqrt()).max(0.0)
    }

    /// The same matrix with both eigenvalues raised to at least `floor`.
    pub fn floored(self, floor: f64) -> Self {
        let half = 0.5 * self.trace();
        let diff = (0.25 * (self.xx - self.yy).powi(2) + self.xy * self.xy).sqrt();
        let (hi, lo) = (half + diff, half - diff);
        if lo >= floor {
            return self;
        }
        let (hi, lo) = (hi.max(floor), lo.max(floor));
        let (c, s) = if diff > 1e-300 {
            ((self.xx - self.yy) * 0.5 / diff, self.xy / diff)
        } else {
            (1.0, 0.0)
        };
        let (m, d) = (0.5 * (hi + lo), 0.5 * (hi - lo));
        Self { xx: m + d * c, xy: d * s, yy: m - d * c }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A: Covariance = Covariance { xx: 0.04, xy: 0.01, yy: 0.09 };
    const B: Covariance = Covariance { xx: 0.2, xy: -0.05, yy: 0.03 };

    fn close(a: Covariance, b: Covariance) -> bool {
        (a.xx - b.xx).abs() + (a.xy - b.xy).abs() + (a.yy - b.yy).abs() < 1e-9
    }

    #[test]
    fn axes_give_the_covariance_back() {
        let m = Covariance { xx: 0.02, xy: -0.006, yy: 0.01 };
        let [long, short] = m.axes();
        let back = Covariance::of_axes(long, short);
        let off = [back.xx - m.xx, back.xy - m.xy, back.yy - m.yy];
        assert!(off.iter().all(|d| d.abs() < 1e-14), "{back:?}");
    }

    #[test]
    fn square_root_squares_back() {
        let r = A.sqrt();
        assert!(close(Covariance::isotropic(1.0).congruence(r), A));
    }

    #[test]
    fn axes_square_back() {
        for c in [A, B, Covariance::isotropic(0.3)] {
            let [long, short] = c.axes();
            let outer = |v: DVec2| Covariance { xx: v.x * v.x, xy: v.x * v.y, yy: v.y * v.y };
            assert!(close(Covariance::combine(1.0, outer(long), 1.0, outer(short)), c));
            assert!(long.length() > short.length() - 1e-12);
        }
    }

    #[test]
    fn bures_of_commuting_matrices_is_distance_of_deviations() {
        let m = Covariance { xx: 4.0, xy: 0.0, yy: 1.0 };
        let n = Covariance { xx: 1.0, xy: 0.0, yy: 9.0 };
        assert!((m.bures_squared(n) - (1.0 + 4.0)).abs() < 1e-12);
    }

    #[test]
    fn floor_raises_the_small_eigenvalue_only() {
        let f = A.floored(0.05);
        assert!((f.determinant() / f.trace()) > 0.02);
        assert!(close(A.floored(1e-4), A));
        let g = Covariance { xx: 1.0, xy: 0.0, yy: 1e-9 }.floored(0.1);
        assert!(close(g, Covariance { xx: 1.0, xy: 0.0, yy: 0.1 }));
    }
}
