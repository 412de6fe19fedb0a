//! A logarithm that is inlined.

use std::f64::consts::LN_2;

/// ln x of x ≥ 1.
///
/// Accuracy: 3e-12, relative, of x - 1. Invalid: some number for infinity and NaN. Cost: a division and twenty sums and products, a third of
/// the system's.
#[inline(always)]
pub(crate) fn ln(x: f64) -> f64 {
    /// The bits of √½: mantissas go from there to √2.
    const LOW: u64 = 0x3fe6_a09e_0000_0000;
    let bits = x.to_bits().wrapping_add(0x3ff0_0000_0000_0000 - LOW);
    let exponent = (bits >> 52) as i32 - 1023;
    let f = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) + LOW) - 1.0;
    // ln(1 + f) = 2 artanh s.
    let s = f / (2.0 + f);
    let z = s * s;
    let (z2, low) = (z * z, 2.0 / 3.0 + z * (2.0 / 5.0));
    let middle = 2.0 / 7.0 + z * (2.0 / 9.0);
    let high = 2.0 / 11.0 + z * (2.0 / 13.0);
    let series = z * (low + z2 * (middle + z2 * high));
    f64::from(exponent) * LN_2 + s * (2.0 + series)
}

#[cfg(test)]
mod tests {
    use super::ln;

    #[test]
    fn it_is_the_logarithm() {
        for k in 0..200_000 {
            for x in [1.0 + f64::from(k) * 1e-5, 1.0 + 1e-9 * f64::from(k), 1.001_f64.powi(k / 20)]
            {
                let expected = x.ln();
                assert!((ln(x) - expected).abs() <= 4e-12 * expected, "{x}: {} {expected}", ln(x));
            }
        }
        assert!(ln(f64::INFINITY).is_finite() && ln(f64::NAN).is_finite());
    }
}
