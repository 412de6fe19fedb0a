//! What several materials share of geometry and electromagnetics.

use std::f64::consts::PI;

use bsdfkit_sphere::{DVec2, DVec3};

/// Unpolarised Fresnel reflectance from index 1 into index `n`; `cosine` of the angle of incidence.
pub(super) fn fresnel(cosine: f64, n: f64) -> f64 {
    let c = cosine.abs().min(1.0);
    let sin2 = (1.0 - c * c) / (n * n);
    if sin2 >= 1.0 {
        return 1.0;
    }
    let t = (1.0 - sin2).sqrt();
    let s = (c - n * t) / (c + n * t);
    let p = (n * c - t) / (n * c + t);
    0.5 * (s * s + p * p)
}

/// Reflectance of a metal: `normal` at normal incidence, 1 at grazing. [Sch94]
pub(super) fn schlick(cosine: f64, normal: f64) -> f64 {
    normal + (1.0 - normal) * (1.0 - cosine.clamp(0.0, 1.0)).powi(5)
}

/// A Gaussian on the sphere (von Mises–Fisher) of width `sigma` radians, integral 1; 1/sr.
pub(super) fn spherical_gaussian(cosine: f64, sigma: f64) -> f64 {
    let sharpness = 1.0 / (sigma * sigma);
    let norm = sharpness / (2.0 * PI * (1.0 - (-2.0 * sharpness).exp()));
    norm * (sharpness * (cosine - 1.0)).exp()
}

/// f of a peak that is a Gaussian in direction cosines, `off` its centre by as much: 1/sr.
///
/// f |cos θ| dω = f du on the projected disk, so that its energy is 1, less what lies beyond the horizon; and f is
/// reciprocal wherever `off` is the same, or the opposite, for both orders of its directions.
pub(super) fn disk_gaussian(off: DVec2, sigma: f64) -> f64 {
    (-0.5 * off.length_squared() / (sigma * sigma)).exp() / (2.0 * PI * sigma * sigma)
}

/// |z| kept from zero: energy over it stays bounded at the horizon.
pub(super) fn soft_cosine(z: f64) -> f64 {
    0.95 * z.abs() + 0.05
}

/// Direction of light travelling along `d` after a face of index ratio `n` (inside over outside) and unit normal
/// `m` on the side it leaves to; `None` at total reflection or when it never meets the face.
pub(super) fn refract_out(d: DVec3, m: DVec3, n: f64) -> Option<DVec3> {
    let c = d.dot(m);
    let sin2 = n * n * (1.0 - c * c);
    if c <= 0.0 || sin2 >= 1.0 {
        return None;
    }
    let t = (1.0 - sin2).sqrt();
    Some((n * d + (t - n * c) * m).normalize())
}

/// `v` turned about +Z by `degrees`.
pub(super) fn turn_z(v: DVec3, degrees: f64) -> DVec3 {
    let (s, c) = degrees.to_radians().sin_cos();
    DVec3::new(c * v.x - s * v.y, s * v.x + c * v.y, v.z)
}

/// `v` turned about +Y by `degrees`.
pub(super) fn turn_y(v: DVec3, degrees: f64) -> DVec3 {
    let (s, c) = degrees.to_radians().sin_cos();
    DVec3::new(c * v.x + s * v.z, v.y, c * v.z - s * v.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fresnel_at_known_angles() {
        assert!((fresnel(1.0, 1.5) - 0.04).abs() < 1e-12);
        assert!((fresnel(0.0, 1.5) - 1.0).abs() < 1e-12);
        // Brewster's angle: only half of the light, polarised across, is reflected
        let brewster = 1.5f64.atan();
        let s = (brewster.cos().powi(2) - 1.5 * 1.5 * (1.5f64.recip().atan()).cos().powi(2)).abs();
        assert!(s > 0.0 && (fresnel(brewster.cos(), 1.5) - 0.5 * 0.147_928_994_1).abs() < 1e-9);
    }

    #[test]
    fn spherical_gaussian_integrates_to_one() {
        // substitution c = cos: 2π ∫ g(c) dc
        let steps = 200_000;
        let h = 2.0 / f64::from(steps);
        let sum: f64 =
            (0..steps).map(|i| spherical_gaussian(-1.0 + (f64::from(i) + 0.5) * h, 0.2)).sum();
        assert!((2.0 * PI * sum * h - 1.0).abs() < 1e-6);
    }

    #[test]
    fn disk_gaussian_has_its_energy_and_width() {
        let h = 0.01;
        let (mut energy, mut second) = (0.0, 0.0);
        for k in 0..200 * 200 {
            let p = h * DVec2::new(f64::from(k / 200) - 99.5, f64::from(k % 200) - 99.5);
            energy += h * h * disk_gaussian(p, 0.1);
            second += h * h * p.x * p.x * disk_gaussian(p, 0.1);
        }
        assert!((energy - 1.0).abs() < 1e-9 && (second.sqrt() - 0.1).abs() < 1e-9);
    }

    #[test]
    fn refraction_obeys_snell() {
        let inside = DVec3::new(0.3f64.sin(), 0.0, -(0.3f64.cos()));
        let out = refract_out(inside, DVec3::NEG_Z, 1.5).unwrap();
        assert!((out.x - 1.5 * 0.3f64.sin()).abs() < 1e-12 && out.z < 0.0);
        let beyond = DVec3::new(0.8f64.sin(), 0.0, -(0.8f64.cos()));
        assert!(refract_out(beyond, DVec3::NEG_Z, 1.5).is_none());
    }
}
