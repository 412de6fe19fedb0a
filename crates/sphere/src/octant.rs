//! Angles within an eighth of a turn, as polynomials: no branch and no library call, so that loops
//! over arrays of directions compile to vector instructions, with the same bits as single calls.
//!
//! Source of the coefficients: minimax fits, computed with 40 digits.

use std::f64::consts::FRAC_PI_4;

use glam::DVec2;

/// tan(π/8): from here on the angle is taken from the eighth's other end.
const HALF_WAY: f64 = 0.414_213_562_373_095_05;

/// (4/π) atan(t) / t in powers of t², for |t| ≤ tan(π/8); error below 2e-18.
const ATAN: [f64; 12] = [
    1.273_239_544_735_162_684_5,
    -0.424_413_181_578_384_860_62,
    0.254_647_908_946_279_943_95,
    -0.181_891_363_451_291_946_15,
    0.141_471_055_863_634_799_88,
    -0.115_748_893_144_070_249_22,
    0.097_938_162_952_001_809_785,
    -0.084_835_337_337_775_365_698,
    0.074_444_766_614_153_163_181,
    -0.064_108_915_595_375_886_36,
    0.048_338_867_116_296_262_993,
    -0.022_670_535_831_637_882_586,
];

/// sin(π t/4) / t in powers of t², for |t| ≤ 1; error below 3e-18.
const SIN: [f64; 7] = [
    FRAC_PI_4,
    -0.080_745_512_188_280_539_466,
    0.002_490_394_570_188_843_847_9,
    -0.000_036_576_204_158_913_874_935,
    3.133_616_225_433_422_121_1e-7,
    -1.757_150_074_698_393_409_2e-9,
    6.877_360_573_166_325_627_2e-12,
];

/// cos(π t/4) in powers of t², for |t| ≤ 1; error below 4e-20.
const COS: [f64; 8] = [
    1.0,
    -0.308_425_137_534_042_452_96,
    0.015_854_344_243_815_419_319,
    -0.000_325_991_886_926_737_642_24,
    3.590_860_446_027_952_034_5e-6,
    -2.461_136_403_365_259_613_7e-8,
    1.150_051_202_821_734_133_8e-10,
    -3.858_189_007_341_667_731e-13,
];

/// The angle of (large, small) in eighths of a turn, (4/π) atan(small/large), for 0 ≤ small ≤ large.
///
/// Exactly 0 for small = 0 and 1 for small = large. NaN in, NaN out.
/// Accuracy: 3e-16.
#[inline(always)]
pub fn eighths(small: f64, large: f64) -> f64 {
    let upper = small > HALF_WAY * large;
    let numerator = if upper { small - large } else { small };
    let denominator = if upper { small + large } else { large };
    // 0/0 would be NaN.
    let denominator = if denominator == 0.0 { 1.0 } else { denominator };
    let t = numerator / denominator;
    let z = t * t;
    let (z2, c) = (z * z, &ATAN);
    let z4 = z2 * z2;
    let low = (c[0] + c[1] * z) + (c[2] + c[3] * z) * z2;
    let middle = (c[4] + c[5] * z) + (c[6] + c[7] * z) * z2;
    let high = (c[8] + c[9] * z) + (c[10] + c[11] * z) * z2;
    let whole = if upper { 1.0 } else { 0.0 };
    whole + t * (low + (middle + high * z4) * z4)
}

/// (cos, sin) of t eighths of a turn, −1 ≤ t ≤ 1: inverse of [`eighths`].
///
/// Accuracy: 2e-16.
#[inline(always)]
pub fn unit(t: f64) -> DVec2 {
    let z = t * t;
    let (z2, s, c) = (z * z, &SIN, &COS);
    let z4 = z2 * z2;
    let sin = (s[0] + s[1] * z) + (s[2] + s[3] * z) * z2 + ((s[4] + s[5] * z) + s[6] * z2) * z4;
    let cos = (c[0] + c[1] * z)
        + (c[2] + c[3] * z) * z2
        + ((c[4] + c[5] * z) + (c[6] + c[7] * z) * z2) * z4;
    DVec2::new(cos, t * sin)
}

/// The azimuth of (x, y) in turns, 0 to 1, from +X toward +Y; 0 at the centre.
///
/// 1 itself only by rounding, just below the X axis. NaN in, NaN out. Accuracy: 2e-16.
#[inline(always)]
pub fn turns(x: f64, y: f64) -> f64 {
    let (ax, ay) = (x.abs(), y.abs());
    let steep = ay > ax;
    let (small, large) = if steep { (ax, ay) } else { (ay, ax) };
    let turn = 0.125 * eighths(small, large);
    let turn = if steep { 0.25 - turn } else { turn };
    let turn = if x < 0.0 { 0.5 - turn } else { turn };
    if y < 0.0 { 1.0 - turn } else { turn }
}

/// (cos, sin) of an azimuth in turns, within ±2²⁰: inverse of [`turns`].
///
/// Accuracy: 2e-16, for azimuths within ±1.
#[inline(always)]
pub fn at_turns(turns: f64) -> DVec2 {
    // From here to its double a f64 has no fraction: adding it rounds, and leaves the integer in the low bits.
    const INTEGERS: f64 = 6_755_399_441_055_744.0;
    let shifted = 4.0 * turns + INTEGERS;
    let d = unit(2.0 * (4.0 * turns - (shifted - INTEGERS)));
    let quarter = shifted.to_bits();
    let (x, y) = if quarter & 1 == 0 { (d.x, d.y) } else { (d.y, d.x) };
    // The second and third quarter have negative x, the third and fourth negative y.
    let x = if (quarter + 1) & 2 == 0 { x } else { -x };
    DVec2::new(x, if quarter & 2 == 0 { y } else { -y })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn agree_with_the_standard_library() {
        for k in 0..=100_000 {
            let t = f64::from(k) / 100_000.0;
            assert!((eighths(t, 1.0) - t.atan() / FRAC_PI_4).abs() < 4e-16, "{t}");
            let (sin, cos) = (t * FRAC_PI_4).sin_cos();
            assert!((unit(-t) - DVec2::new(cos, -sin)).length() < 4e-16, "{t}");
            let azimuth = TAU * (t - 0.5);
            let expected = if azimuth < 0.0 { 1.0 + t - 0.5 } else { t - 0.5 };
            let (sin, cos) = azimuth.sin_cos();
            let error = (turns(cos, sin) - expected).abs();
            assert!(error < 4e-16 || (1.0 - error) < 4e-16, "{t}: {error}");
            assert!((at_turns(t - 0.5) - DVec2::new(cos, sin)).length() < 6e-16, "{t}");
        }
    }

    #[test]
    fn ends_are_exact() {
        assert_eq!((eighths(0.0, 0.3), eighths(0.3, 0.3), eighths(0.0, 0.0)), (0.0, 1.0, 0.0));
        assert_eq!(
            [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)].map(|(x, y)| turns(x, y)),
            [0.0, 0.25, 0.5, 0.75]
        );
        assert_eq!(turns(1.0, -0.0), 0.0);
        assert!(eighths(f64::NAN, 1.0).is_nan() && turns(1.0, f64::NAN).is_nan());
        assert_eq!(unit(0.0), DVec2::X);
    }
}
