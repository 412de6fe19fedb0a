//! How values vary within a leaf along one axis of the two squares.

use super::super::lookup::CELLS;
use super::super::node::MAX_DEPTH;
use crate::distribution::Sense;

/// 1 + a s + b t + c s t over s, t in \[−1, 1\]: never negative, of mean 1.
///
/// s is the incident, t the scattered coordinate. A factor of that form has |a|, |b|, |c| ≤ 1: each is
/// kept in [`BITS`] bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Patch(u32);

/// Bits of a coefficient. A guess: 8 bits add 3 % to the error, 16 take twice the memory.
const BITS: u32 = 10;

/// The coefficient 1.
const ONE: f64 = ((1 << (BITS - 1)) - 1) as f64;

/// Three-point Gauss–Legendre rule on \[−1, 1\]: its outer nodes, and the weights of a mean.
const NODE: f64 = 0.774_596_669_241_483_4;
const WEIGHTS: [f64; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

impl Patch {
    /// The largest that keeps its shape and is not negative.
    fn new(coefficients: [f64; 3]) -> Self {
        let [a, b, c] = coefficients;
        let deepest = (a + b - c).max(a - b + c).max(-a + b + c).max(-a - b - c);
        // Rounding moves a corner by at most 1.5 steps.
        let room = 1.0 - 2.0 / ONE;
        let scale = if deepest > room { room / deepest } else { 1.0 };
        let pack = |c: f64| ((c * scale * ONE).round() as i32).cast_unsigned() & ((1 << BITS) - 1);
        Self(pack(a) | pack(b) << BITS | pack(c) << (2 * BITS))
    }

    /// The shape of exp(α s + β t + γ s t), as near in square as this form comes.
    pub(super) fn of_logarithm([alpha, beta, gamma]: [f64; 3]) -> Self {
        let three = |x: f64| {
            let e = (NODE * x).exp();
            [e.recip(), 1.0, e]
        };
        let (along_s, along_t, both) = (three(alpha), three(beta), three(NODE * gamma));
        let (mut mean, mut s_mean, mut t_mean, mut st_mean) = (0.0, 0.0, 0.0, 0.0);
        for i in 0..3 {
            for j in 0..3 {
                let (s, t) = (i as f64 - 1.0, j as f64 - 1.0);
                let cross = both[if i == 1 || j == 1 { 1 } else { 2 * usize::from(i == j) }];
                let value = WEIGHTS[i] * WEIGHTS[j] * along_s[i] * along_t[j] * cross;
                mean += value;
                s_mean += value * s;
                t_mean += value * t;
                st_mean += value * s * t;
            }
        }
        // ∫s² is a third of that of 1.
        let scale = 3.0 * NODE / mean;
        Self::new([scale * s_mean, scale * t_mean, 3.0 * NODE * scale * st_mean])
    }

    /// a, b, c.
    #[inline(always)]
    pub(super) fn coefficients(self) -> [f64; 3] {
        let unpack = |n: u32| {
            let top = self.0 << (u32::BITS - BITS * (n + 1));
            f64::from(top.cast_signed() >> (u32::BITS - BITS)) * (1.0 / ONE)
        };
        [unpack(0), unpack(1), unpack(2)]
    }

    #[inline(always)]
    pub(super) fn at(self, s: f64, t: f64) -> f64 {
        let [a, b, c] = self.coefficients();
        1.0 + a * s + (b + c * s) * t
    }

    /// Along the known coordinate, in the middle of the other: 1 + this · s.
    #[inline(always)]
    pub(super) fn known_slope(self, sense: Sense) -> f64 {
        let [a, b, _] = self.coefficients();
        match sense {
            Sense::Forward => a,
            Sense::Reverse => b,
        }
    }

    /// At a known coordinate: the mean over the sampled one, and the slope along it of
    /// the density 1 + slope · t.
    ///
    /// Convention: the square in which an incident direction is sampled is the stored one turned by
    /// half, as the tree is indexed by the travel direction.
    #[inline(always)]
    pub(super) fn sampled(self, sense: Sense, known: f64) -> (f64, f64) {
        let [a, b, c] = self.coefficients();
        let (mean, slope) = match sense {
            Sense::Forward => (1.0 + a * known, b + c * known),
            Sense::Reverse => (1.0 + b * known, -a - c * known),
        };
        (mean, if mean > 0.0 { (slope / mean).clamp(-1.0, 1.0) } else { 0.0 })
    }
}

/// A point's place in a cell, −1 to 1; `finest` is the point's cell of 2⁻¹⁶, `level` that of the cell.
#[inline(always)]
pub(super) fn place(point: f64, finest: u32, level: u32) -> f64 {
    let width = (1 << MAX_DEPTH) >> level;
    let first = finest & !(width - 1);
    (2.0 * (point * CELLS - f64::from(first)) / f64::from(width) - 1.0).clamp(-1.0, 1.0)
}

/// u in \[0, 1\] → x in \[0, 1\] with density 1 + slope (2x − 1), |slope| ≤ 1; rising.
#[inline(always)]
pub(super) fn warp(u: f64, slope: f64) -> f64 {
    let rest = 1.0 - slope;
    let root = (rest * rest + 4.0 * slope * u).max(0.0).sqrt();
    if rest + root > 0.0 { (2.0 * u / (rest + root)).min(1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn never_negative_and_of_mean_one() {
        for i in 0..20_000 {
            let x = |k: f64| ((f64::from(i) * k).fract() - 0.5) * 6.0;
            let patch = Patch::of_logarithm([x(0.618_034), x(0.754_877), x(0.569_840)]);
            let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
            let values = corners.map(|(s, t)| patch.at(s, t));
            assert!(values.iter().all(|v| *v >= 0.0), "{values:?}");
            // Bilinear: the mean of the corners is that of the patch.
            assert!((values.iter().sum::<f64>() - 4.0).abs() < 1e-14);
        }
    }

    /// For small exponents the exponential is nearly of the patch's form.
    #[test]
    fn follows_a_gentle_exponential() {
        let (alpha, beta, gamma) = (0.02, -0.03, 0.01);
        let patch = Patch::of_logarithm([alpha, beta, gamma]);
        for (s, t) in [(-1.0, 0.5), (0.3, 0.9), (1.0, 1.0), (0.0, -1.0)] {
            let exact = f64::exp(alpha * s + beta * t + gamma * s * t);
            assert!((patch.at(s, t) - exact).abs() < 4e-3, "{} {exact}", patch.at(s, t));
        }
        assert_eq!(Patch::of_logarithm([0.0; 3]), Patch::default());
    }

    #[test]
    fn warp_is_the_inverse_of_the_running_integral() {
        for slope in [-1.0, -0.7, -1e-9, 0.0, 1e-3, 0.5, 1.0] {
            for k in 0..=100 {
                let u = f64::from(k) / 100.0;
                let x = warp(u, slope);
                assert!((x + slope * (x * x - x) - u).abs() < 1e-15, "{slope} {u} {x}");
            }
        }
    }

    #[test]
    fn places_run_from_minus_one_to_one() {
        assert_eq!(place(0.25, 1 << 14, 1), 0.0);
        assert_eq!(place(0.25, 1 << 14, 2), -1.0);
        assert_eq!(place(1.0, (1 << 16) - 1, 0), 1.0);
        assert_eq!(place(0.0, 0, 16), -1.0);
    }
}
