//! Sequences whose every prefix is about even: over \[0, 1), the unit square, and more dimensions.
//!
//! Term k is k times an irrational step, modulo 1. The steps are powers of 1/x with x the real root
//! above 1 of x^(d + 1) = x + 1: the golden ratio in one dimension. [Rob18]

use crate::DVec2;

/// (√5 − 1) / 2.
const GOLDEN: f64 = 0.618_033_988_749_894_9;
/// 1 / x and 1 / x² for x³ = x + 1.
const PLASTIC: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
/// x⁵ = x + 1.
const QUINTIC: f64 = 1.167_303_978_261_418_7;

/// Term `k` in \[0, 1).
pub fn golden(k: usize) -> f64 {
    (k as f64 * GOLDEN).fract()
}

/// Term `k` in the unit square.
pub fn plastic(k: usize) -> DVec2 {
    plastic_from(DVec2::ZERO, k)
}

/// Term `k` in the unit square of the sequence that begins at `start`, which has no negative
/// coordinate.
pub fn plastic_from(start: DVec2, k: usize) -> DVec2 {
    (start + k as f64 * DVec2::from(PLASTIC)).fract()
}

/// Term `k` in four dimensions of the sequence that begins in the middle.
pub fn quintic(k: usize) -> [f64; 4] {
    [-1, -2, -3, -4].map(|power| (0.5 + k as f64 * QUINTIC.powi(power)).fract())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_solve_their_equations() {
        let x = 1.0 / GOLDEN;
        assert!((x * x - x - 1.0).abs() < 1e-15);
        let x = 1.0 / PLASTIC[0];
        assert!((x.powi(3) - x - 1.0).abs() < 1e-14 && (PLASTIC[1] * x * x - 1.0).abs() < 1e-14);
        assert!((QUINTIC.powi(5) - QUINTIC - 1.0).abs() < 1e-14);
    }

    /// Each of n equal intervals, or squares, or halves has about its share of the first terms.
    #[test]
    fn prefixes_are_even() {
        for n in [16, 100, 1000] {
            let most = |cells: usize, cell: &dyn Fn(usize) -> usize| {
                let mut counts = vec![0; cells];
                (1..=n).for_each(|k| counts[cell(k)] += 1);
                counts.into_iter().map(|c| (c * cells) as f64 / n as f64).fold(0.0, f64::max)
            };
            assert!(most(8, &|k| (golden(k) * 8.0) as usize) < 1.05);
            let square = |p: DVec2| (p.x * 2.0) as usize + 2 * (p.y * 2.0) as usize;
            assert!(most(4, &|k| square(plastic(k))) < 1.26);
            assert!(most(4, &|k| square(plastic_from(DVec2::splat(0.3), k))) < 1.26);
            let corner = |k| quintic(k).iter().fold(0, |c, x| 2 * c + (x * 2.0) as usize);
            assert!(n < 1000 || most(16, &corner) < 1.2);
        }
    }
}
