//! The anisotropic GGX distribution of microfacets with its height-correlated masking. [WMLT07], [Hei14]

use std::f64::consts::PI;

use bsdfkit_sphere::DVec3;

/// A rough surface of GGX facets, roughness `x` along X and `y` along Y.
#[derive(Clone, Copy)]
pub(super) struct Ggx {
    pub(super) x: f64,
    pub(super) y: f64,
}

impl Ggx {
    /// Density of facet normals around `h`, 1/sr.
    pub(super) fn density(self, h: DVec3) -> f64 {
        if h.z <= 0.0 {
            return 0.0;
        }
        let e = (h.x / self.x).powi(2) + (h.y / self.y).powi(2) + h.z * h.z;
        1.0 / (PI * self.x * self.y * e * e)
    }

    /// Hidden over visible facet area from direction `v`.
    fn hidden(self, v: DVec3) -> f64 {
        let tan2 = ((self.x * v.x).powi(2) + (self.y * v.y).powi(2)) / (v.z * v.z).max(1e-12);
        0.5 * ((1.0 + tan2).sqrt() - 1.0)
    }

    /// Fraction of facets seen from both directions.
    pub(super) fn visible(self, a: DVec3, b: DVec3) -> f64 {
        1.0 / (1.0 + self.hidden(a) + self.hidden(b))
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::{DVec2, Side, concentric};

    use super::*;

    #[test]
    fn facets_cover_the_surface_once() {
        // ∫ D cos θ dω = 1
        let ggx = Ggx { x: 0.2, y: 0.5 };
        let n = 400;
        let mut sum = 0.0;
        for i in 0..n {
            for j in 0..n {
                let s = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5) / f64::from(n);
                sum += ggx.density(concentric::square_to_hemisphere(s, Side::Front));
            }
        }
        let covered = sum * PI / f64::from(n * n);
        assert!((covered - 1.0).abs() < 2e-3, "{covered}");
    }
}
