//! How values vary within a leaf along one axis of the two squares.

use super::super::lookup::CELLS;
use super::super::node::MAX_DEPTH;
use crate::lanes::Sense;

/// 1 + a s + b t + c s t + d (s² − ⅓) + e (t² − ⅓) over s, t in \[−1, 1\]: never negative, of
/// mean 1.
///
/// s is the incident, t the scattered coordinate. Each coefficient has [`BITS`] bits, a to e from
/// the lowest on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Patch(u64);

/// Bits of a coefficient.
const BITS: u32 = 12;

/// The largest coefficient: with d = 3 the middle is 0.
const LARGEST: f64 = 3.0;

/// Steps of rounding in a coefficient of 1.
const ONE: f64 = ((1 << (BITS - 1)) - 1) as f64 / LARGEST;

/// Three-point Gauss–Legendre rule on \[−1, 1\]: its outer nodes, and the weights of a mean.
const NODE: f64 = 0.774_596_669_241_483_4;
const WEIGHTS: [f64; 3] = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];

/// The mean of a square over \[−1, 1\].
const THIRD: f64 = 1.0 / 3.0;

impl Patch {
    /// What is never negative and nearest: the least step towards the bilinear form, whose own
    /// slopes shrink as far as they must.
    fn new(full: [f64; 5]) -> Self {
        let [a, b, c, ..] = full;
        let deepest = (a + b - c).max(a - b + c).max(-a + b + c).max(-a - b - c);
        // Rounding moves a value by at most 3 steps.
        let least = 3.0 / ONE;
        let scale = if deepest > 1.0 - least { (1.0 - least) / deepest } else { 1.0 };
        let flatter = [a * scale, b * scale, c * scale, 0.0, 0.0];
        let mut share: f64 = 1.0;
        for (high, low) in bounds(full).into_iter().zip(bounds(flatter)) {
            if high < least {
                share = share.min((low - least).max(0.0) / (low - high));
            }
        }
        let packed = (0..5).fold(0, |packed, n| {
            let coefficient = flatter[n] + share * (full[n] - flatter[n]);
            let steps = (coefficient.clamp(-LARGEST, LARGEST) * ONE).round() as i64;
            packed | (steps.cast_unsigned() & ((1 << BITS) - 1)) << (BITS * n as u32)
        });
        Self(packed)
    }

    /// The shape of exp(α s + β t + γ s t + δ s² + ε t²), as near in square as this form comes.
    pub(super) fn of_logarithm([alpha, beta, gamma, delta, epsilon]: [f64; 5]) -> Self {
        let three = |x: f64, square: f64| {
            let (e, outer) = ((NODE * x).exp(), (NODE * NODE * square).exp());
            [outer / e, 1.0, outer * e]
        };
        let (along_s, along_t) = (three(alpha, delta), three(beta, epsilon));
        let both = three(NODE * gamma, 0.0);
        let (mut mean, mut moments) = (0.0, [0.0; 5]);
        for i in 0..3 {
            for j in 0..3 {
                let (s, t) = (NODE * (i as f64 - 1.0), NODE * (j as f64 - 1.0));
                let cross = both[if i == 1 || j == 1 { 1 } else { 2 * usize::from(i == j) }];
                let value = WEIGHTS[i] * WEIGHTS[j] * along_s[i] * along_t[j] * cross;
                mean += value;
                for (moment, base) in
                    moments.iter_mut().zip([s, t, s * t, s * s - THIRD, t * t - THIRD])
                {
                    *moment += value * base;
                }
            }
        }
        // The mean of s² is ⅓, that of (s² − ⅓)² is 4/45.
        let norms = [3.0, 3.0, 9.0, 11.25, 11.25];
        Self::new(std::array::from_fn(|n| moments[n] * norms[n] / mean))
    }

    /// a to e.
    #[inline(always)]
    pub(super) fn coefficients(self) -> [f64; 5] {
        [0, 1, 2, 3, 4].map(|n| {
            let top = self.0 << (u64::BITS - BITS * (n + 1));
            (top.cast_signed() >> (u64::BITS - BITS)) as f64 * (1.0 / ONE)
        })
    }

    #[inline(always)]
    pub(super) fn at(self, s: f64, t: f64) -> f64 {
        let [a, b, c, d, e] = self.coefficients();
        1.0 - (d + e) * THIRD + (a + d * s) * s + (b + c * s + e * t) * t
    }

    /// Mean over the sampled coordinate by powers of the known one.
    #[inline(always)]
    pub(super) fn known_powers(self, sense: Sense) -> [f64; 3] {
        let [a, b, _, d, e] = self.coefficients();
        let (slope, curve) = match sense {
            Sense::Forward => (a, d),
            Sense::Reverse => (b, e),
        };
        [1.0 - curve * THIRD, slope, curve]
    }

    /// At a known coordinate: the mean over the sampled one, and the density along it.
    ///
    /// Convention: the square in which an incident direction is sampled is the stored one turned by
    /// half, as the tree is indexed by the travel direction.
    #[inline(always)]
    pub(super) fn sampled(self, sense: Sense, known: f64) -> (f64, Density) {
        let [a, b, c, d, e] = self.coefficients();
        let (mean, slope, curve) = match sense {
            Sense::Forward => (1.0 + a * known + d * (known * known - THIRD), b + c * known, e),
            Sense::Reverse => (1.0 + b * known + e * (known * known - THIRD), -a - c * known, d),
        };
        (mean, Density::new(mean, slope, curve))
    }
}

/// Values of which none of a patch is less: its Bernstein coefficients.
fn bounds([a, b, c, d, e]: [f64; 5]) -> [f64; 9] {
    std::array::from_fn(|k| {
        let (s, t) = ((k % 3) as f64 - 1.0, (k / 3) as f64 - 1.0);
        // The square of a coordinate has 1, −1, 1.
        let square = |x: f64| 2.0 * x * x - 1.0 - THIRD;
        1.0 + a * s + b * t + c * s * t + d * square(s) + e * square(t)
    })
}

/// The density 1 + slope · t + curve · (t² − ⅓) over t in \[−1, 1\].
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Density {
    slope: f64,
    curve: f64,
}

impl Density {
    /// Of mean + slope · t + curve · (t² − ⅓); even where there is no light.
    #[inline]
    pub(super) fn new(mean: f64, slope: f64, curve: f64) -> Self {
        match mean > 0.0 {
            true => Self { slope: slope / mean, curve: curve / mean },
            false => Self::default(),
        }
    }

    /// u in \[0, 1\] → (t + 1) / 2 in \[0, 1\] with this density; rising.
    #[inline]
    pub(super) fn warp(self, u: f64) -> f64 {
        // Slopes alone have a closed form, from which Newton's steps start.
        let slope = self.slope.clamp(-1.0, 1.0);
        let rest = 1.0 - slope;
        let root = (rest * rest + 4.0 * slope * u).max(0.0).sqrt();
        let mut x = if rest + root > 0.0 { (2.0 * u / (rest + root)).min(1.0) } else { 0.0 };
        if self.curve == 0.0 && slope == self.slope {
            return x;
        }
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..64 {
            let t = 2.0 * x - 1.0;
            let below = x + self.slope * x * (x - 1.0) + self.curve * t * (t * t - 1.0) / 6.0;
            if below > u {
                high = x;
            } else {
                low = x;
            }
            let density = 1.0 + self.slope * t + self.curve * (t * t - THIRD);
            let next = x - (below - u) / density;
            let next = if next > low && next < high { next } else { 0.5 * (low + high) };
            let step = (next - x).abs();
            x = next;
            if step <= 1e-15 {
                break;
            }
        }
        x
    }
}

/// A point's place in a cell, −1 to 1; `finest` is the point's cell of 2⁻¹⁶, `level` that of the
/// cell.
#[inline(always)]
pub(super) fn place(point: f64, finest: u32, level: u32) -> f64 {
    let width = (1 << MAX_DEPTH) >> level;
    let first = finest & !(width - 1);
    (2.0 * (point * CELLS - f64::from(first)) / f64::from(width) - 1.0).clamp(-1.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn never_negative_and_of_mean_one() {
        let mut touching = 0;
        for i in 0..20_000 {
            let x = |k: f64| ((f64::from(i) * k).fract() - 0.5) * 6.0;
            let squares = [x(0.437_016), x(0.324_718)].map(|x| 0.25 * x);
            let [alpha, beta, gamma] = [x(0.618_034), x(0.754_877), x(0.569_840)];
            let patch = Patch::of_logarithm([alpha, beta, gamma, squares[0], squares[1]]);
            let (mut mean, mut least) = (0.0, f64::INFINITY);
            for k in 0..441 {
                let value =
                    patch.at(f64::from(k % 21) / 10.0 - 1.0, f64::from(k / 21) / 10.0 - 1.0);
                least = least.min(value);
            }
            for k in 0..9 {
                let [s, t] = [k % 3, k / 3].map(|i| NODE * (i as f64 - 1.0));
                mean += WEIGHTS[k % 3] * WEIGHTS[k / 3] * patch.at(s, t);
            }
            assert!(least >= 0.0, "{least} of {patch:?}");
            assert!((mean - 1.0).abs() < 1e-14);
            touching += u32::from(least < 0.01);
        }
        assert!(touching > 1000, "only {touching} come near 0");
    }

    /// For small exponents the exponential is nearly of the patch's form.
    #[test]
    fn follows_a_gentle_exponential() {
        let (alpha, beta, gamma, delta, epsilon) = (0.02, -0.03, 0.01, -0.05, 0.04);
        let patch = Patch::of_logarithm([alpha, beta, gamma, delta, epsilon]);
        let exact = |s: f64, t: f64| {
            f64::exp(alpha * s + beta * t + gamma * s * t + delta * s * s + epsilon * t * t)
        };
        let mean = 1.0 + (delta + epsilon) / 3.0;
        for (s, t) in [(-1.0, 0.5), (0.3, 0.9), (1.0, 1.0), (0.0, -1.0)] {
            let (found, exact) = (patch.at(s, t), exact(s, t) / mean);
            assert!((found - exact).abs() < 5e-3, "{found} {exact}");
        }
        assert_eq!(Patch::of_logarithm([0.0; 5]), Patch::default());
    }

    #[test]
    fn warp_is_the_inverse_of_the_running_integral() {
        let slopes = [-1.0, -0.7, -1e-9, 0.0, 1e-3, 0.5, 1.0].map(|slope| (slope, 0.0));
        let curves = [(1.5, 0.75), (-1.5, 0.75), (0.0, 3.0), (0.0, -1.5), (0.4, -0.8), (0.0, 1e-9)];
        for (slope, curve) in slopes.into_iter().chain(curves) {
            let density = Density::new(2.0, 2.0 * slope, 2.0 * curve);
            let mut last = 0.0;
            for k in 0..=100 {
                let u = f64::from(k) / 100.0;
                let x = density.warp(u);
                let t = 2.0 * x - 1.0;
                let below = x + slope * (x * x - x) + curve * (t * t * t - t) / 6.0;
                assert!((below - u).abs() < 1e-14, "{slope} {curve} {u} {x}");
                assert!(x >= last, "{slope} {curve} {u} {x}");
                last = x;
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
