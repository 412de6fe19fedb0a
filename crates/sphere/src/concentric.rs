//! The concentric map of Shirley and Chiu: square ↔ disk ↔ hemisphere. [SC97], [WKB14 §2.3]

use glam::{DVec2, DVec3};

use crate::{Side, octant};

/// Unit square → unit disk, area-preserving up to the factor π.
///
/// Convention: +X ↔ (1, ½), +Y ↔ (½, 1); the square's corners map to the diagonals.
#[inline(always)]
pub fn square_to_disk(s: DVec2) -> DVec2 {
    let a = 2.0 * s.x - 1.0;
    let b = 2.0 * s.y - 1.0;
    let wide = a.abs() > b.abs();
    let (small, large) = if wide { (b, a) } else { (a, b) };
    let t = if large == 0.0 { 0.0 } else { small / large };
    let d = octant::unit(t) * large;
    if wide { d } else { DVec2::new(d.y, d.x) }
}

/// Unit disk → unit square, inverse of [`square_to_disk`]; the result is clamped to \[0, 1\].
///
/// Invalid: NaN in any coordinate gives a point without meaning.
#[inline(always)]
pub fn disk_to_square(d: DVec2) -> DVec2 {
    let (x, y) = (d.x.abs(), d.y.abs());
    let wide = x > y;
    let (small, large) = if wide { (y, x) } else { (x, y) };
    let long = (x * x + y * y).sqrt();
    let short = long * octant::eighths(small, large);
    let (a, b) = if wide { (long, short) } else { (short, long) };
    DVec2::new(to_unit(a.copysign(d.x)), to_unit(b.copysign(d.y)))
}

/// −1…1 → 0…1, clamped.
#[inline(always)]
fn to_unit(a: f64) -> f64 {
    let c = (a + 1.0) * 0.5;
    let c = if c > 0.0 { c } else { 0.0 };
    if c < 1.0 { c } else { 1.0 }
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
