//! χ² of draws against the density that they should follow.

use std::f64::consts::PI;

/// The level of each of `tests` tests, at which all pass together with 99 % when they should. [Šidák 1967]
pub(crate) fn level(tests: usize) -> f64 {
    1.0 - 0.99_f64.powf(1.0 / tests as f64)
}

/// Upper tail of the standard normal distribution. [Abramowitz & Stegun 26.2.17]
fn normal_tail(z: f64) -> f64 {
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let coefficients =
        [1.330_274_429, -1.821_255_978, 1.781_477_937, -0.356_563_782, 0.319_381_530];
    let polynomial = coefficients.iter().fold(0.0, |sum, c| (sum + c) * t);
    let tail = (-0.5 * z * z).exp() / (2.0 * PI).sqrt() * polynomial;
    if z >= 0.0 { tail } else { 1.0 - tail }
}

/// How likely as large a χ² is with k degrees of freedom. [Wilson & Hilferty 1931]
fn tail(x: f64, k: f64) -> f64 {
    let v = 2.0 / (9.0 * k);
    normal_tail(((x / k).cbrt() - (1.0 - v)) / v.sqrt())
}

/// Draws counted by bin, against the numbers expected there: those below 5 are pooled.
///
/// Panics, with `name`, where the observed numbers are less likely than `level`.
pub(crate) fn expect(name: &str, observed: &[f64], expected: &[f64], level: f64) {
    let (mut chi, mut bins, mut rare) = (0.0, 0.0, (0.0, 0.0));
    for (o, e) in observed.iter().zip(expected) {
        if *e >= 5.0 {
            chi += (o - e) * (o - e) / e;
            bins += 1.0;
        } else {
            rare = (rare.0 + o, rare.1 + e);
        }
    }
    if rare.1 >= 5.0 {
        chi += (rare.0 - rare.1).powi(2) / rare.1;
        bins += 1.0;
    } else {
        assert!(rare.0 < 30.0, "{name}: {} draws where {} belong", rare.0, rare.1);
    }
    let p = tail(chi, bins - 1.0);
    assert!(p > level, "{name}: χ² = {chi} over {bins} bins, p = {p} ≤ {level}");
}
