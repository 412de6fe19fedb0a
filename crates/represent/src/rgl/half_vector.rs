//! From a point of the unit square to a half vector and a scattered direction.

use std::f64::consts::{FRAC_PI_2, PI};

use bsdfkit_sphere::{DVec2, DVec3};

/// What a point of the square stands for at one incident direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reflected {
    /// Where light goes: below the horizon z ≤ 0.
    pub(super) wo: DVec3,
    /// Solid angle of `wo` by area of the square, sr.
    pub(super) jacobian: f64,
}

/// The point (√(2 θm/π), (φm + π)/2π) of the half vector m; isotropic files measure φm from the incident azimuth.
pub(super) fn reflected(point: DVec2, wi: DVec3, azimuth: f64) -> Reflected {
    let theta = point.x * point.x * FRAC_PI_2;
    let (sin, cos) = theta.sin_cos();
    let (y, x) = ((2.0 * point.y - 1.0) * PI + azimuth).sin_cos();
    let m = DVec3::new(sin * x, sin * y, cos);
    let along = wi.dot(m);
    let wo = 2.0 * along * m - wi;
    if along <= 0.0 || wo.z <= 0.0 {
        return Reflected { wo: DVec3::NEG_Z, jacobian: 0.0 };
    }
    Reflected { wo: wo.normalize(), jacobian: 8.0 * PI * PI * along * point.x * sin }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;

    #[test]
    fn the_jacobian_makes_areas_solid_angles() {
        // Σ cos θo J over the square is ∫ cos θo dωo = π.
        let wi = from_degrees(40.0, 25.0);
        let n = 800;
        let mut sum = 0.0;
        for i in 0..n {
            for k in 0..n {
                let point = DVec2::new(f64::from(i) + 0.5, f64::from(k) + 0.5) / f64::from(n);
                let r = reflected(point, wi, 0.0);
                sum += r.wo.z.max(0.0) * r.jacobian;
            }
        }
        assert!((sum / f64::from(n * n) - PI).abs() < 2e-3, "{}", sum / f64::from(n * n));
    }

    #[test]
    fn the_normal_mirrors() {
        let wi = from_degrees(40.0, 25.0);
        let r = reflected(DVec2::new(0.0, 0.3), wi, 0.0);
        assert!((r.wo - DVec3::new(-wi.x, -wi.y, wi.z)).length() < 1e-12);
    }
}
