//! The concentric map of Shirley and Chiu: square ↔ disk ↔ hemisphere. [SC97], [WKB14 §2.3]

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DVec2, DVec3};

use crate::Side;

/// Unit square → unit disk, area-preserving up to the factor π.
///
/// Convention: +X ↔ (1, ½), +Y ↔ (½, 1); the square's corners map to the diagonals.
#[inline]
pub fn square_to_disk(s: DVec2) -> DVec2 {
    let a = 2.0 * s.x - 1.0;
    let b = 2.0 * s.y - 1.0;
    if a == 0.0 && b == 0.0 {
        return DVec2::ZERO;
    }
    let (r, phi) = if a.abs() > b.abs() {
        (a, FRAC_PI_4 * (b / a))
    } else {
        (b, FRAC_PI_2 - FRAC_PI_4 * (a / b))
    };
    let (sin, cos) = phi.sin_cos();
    DVec2::new(r * cos, r * sin)
}

/// Unit disk → unit square, inverse of [`square_to_disk`]; the result is clamped to \[0, 1\].
#[inline]
pub fn disk_to_square(d: DVec2) -> DVec2 {
    let r = d.length();
    if r == 0.0 {
        return DVec2::splat(0.5);
    }
    let (a, b) = if d.x.abs() > d.y.abs() {
        let a = r.copysign(d.x);
        (a, a * (d.y / d.x).atan() / FRAC_PI_4)
    } else {
        let b = r.copysign(d.y);
        (b * (d.x / d.y).atan() / FRAC_PI_4, b)
    };
    DVec2::new((a + 1.0) * 0.5, (b + 1.0) * 0.5).clamp(DVec2::ZERO, DVec2::ONE)
}

/// Unit disk → unit vector on `side`: (x, y) are kept (orthographic projection).
///
/// Equal areas of the disk are equal projected solid angles.
#[inline]
pub fn disk_to_hemisphere(d: DVec2, side: Side) -> DVec3 {
    DVec3::new(d.x, d.y, side.sign() * (1.0 - d.length_squared()).max(0.0).sqrt())
}

/// Unit square → unit vector on `side`; a cell of side w has projected solid angle π w².
#[inline]
pub fn square_to_hemisphere(s: DVec2, side: Side) -> DVec3 {
    disk_to_hemisphere(square_to_disk(s), side)
}

/// Unit vector → unit square, whatever its side.
#[inline]
pub fn hemisphere_to_square(w: DVec3) -> DVec2 {
    disk_to_square(w.truncate())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn square_disk_round_trip() {
        for i in 0..=40 {
            for j in 0..=40 {
                let s = DVec2::new(f64::from(i) / 40.0, f64::from(j) / 40.0);
                let back = disk_to_square(square_to_disk(s));
                assert!((back - s).length() < 1e-14, "{s} came back as {back}");
            }
        }
    }
}
