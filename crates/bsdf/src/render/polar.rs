//! Polar coordinates without trigonometry.

use super::logarithm::ln;
use crate::DVec2;

/// The angle of `q` in quarters of a turn, 0 to 4, linear along the square |x| + |y| = 1; 0 for the origin.
#[inline(always)]
pub(crate) fn angle(q: DVec2) -> f64 {
    let sum = q.x.abs() + q.y.abs();
    let part = if sum > 0.0 { q.y.abs() / sum } else { 0.0 };
    let half = if q.x >= 0.0 { part } else { 2.0 - part };
    if q.y >= 0.0 { half } else { 4.0 - half }
}

/// The unit vector at an angle, and radians of the true angle per unit of this one.
#[inline(always)]
pub(crate) fn unit(angle: f64) -> (DVec2, f64) {
    let (half, sign) = if angle > 2.0 { (4.0 - angle, -1.0) } else { (angle, 1.0) };
    let x = 1.0 - half;
    let y = 1.0 - x.abs();
    let squared = x * x + y * y;
    (DVec2::new(x, y * sign) / squared.sqrt(), 1.0 / squared)
}

/// How far a distance from the peak, in cores, is on a scale that widens in proportion to it from 1 on: ln(1 + ρ).
#[inline(always)]
pub(crate) fn scale(cores: f64) -> f64 {
    ln(1.0 + cores)
}

/// The distance of a place on that scale.
#[inline(always)]
pub(crate) fn distance(scale: f64, core: f64) -> f64 {
    core * (scale.exp() - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for k in 0..400 {
            let a = f64::from(k) / 100.0;
            let (e, rate) = unit(a);
            assert!((angle(e * 0.3) - a).abs() < 1e-12, "{a}");
            let after = unit(a + 1e-6).0;
            let turned = e.perp_dot(after).asin();
            assert!((turned / 1e-6 - rate).abs() < 1e-5 * rate, "{a}: {turned} {rate}");
        }
        assert_eq!(angle(DVec2::ZERO), 0.0);
    }
}
