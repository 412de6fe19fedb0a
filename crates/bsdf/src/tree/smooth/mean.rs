//! Means over the sampled square, as functions of the known direction.

use super::shaped::Shaped;
use crate::DVec2;
use crate::lanes::Sense;

/// A biquadratic function over a cell: coefficients of 1, x, x² times 1, then y, then y², for x, y
/// from −1 to 1.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Mean<T = f64>([T; 9]);

impl Mean {
    /// The same value everywhere.
    pub(super) fn even(value: f64) -> Self {
        Self([value, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    }

    /// Mean of a leaf's value − floor over the sampled square, as a function of the known
    /// direction.
    pub(super) fn of_leaf(shaped: Shaped<'_>, sense: Sense, slot: usize) -> Self {
        let excess = shaped.excess(slot);
        let [x, y] = shaped.patches(slot).map(|patch| patch.known_powers(sense));
        Self(std::array::from_fn(|n| excess * x[n % 3] * y[n / 3]))
    }

    /// The same function over a part of its cell, `levels` down; x and y of the part's corner
    /// in units of its width.
    pub(super) fn within(self, levels: u32, part: [u32; 2]) -> Self {
        let width = 1.0 / f64::from(1_u32 << levels);
        let [x, y] = part.map(|n| (2.0 * f64::from(n % (1 << levels)) + 1.0) * width - 1.0);
        let moved = |[one, slope, curve]: [f64; 3], centre: f64| {
            let slope_there = slope + 2.0 * curve * centre;
            [one + (slope + curve * centre) * centre, slope_there * width, curve * width * width]
        };
        let mut rows = [0, 1, 2].map(|j| moved([0, 1, 2].map(|i| self.0[3 * j + i]), x));
        for i in 0..3 {
            let column = moved([0, 1, 2].map(|j| rows[j][i]), y);
            for j in 0..3 {
                rows[j][i] = column[j];
            }
        }
        Self(std::array::from_fn(|n| rows[n / 3][n % 3]))
    }

    pub(super) fn average(four: [Self; 4]) -> Self {
        Self(std::array::from_fn(|i| 0.25 * four.iter().map(|m| m.0[i]).sum::<f64>()))
    }

    pub(super) fn pack(self) -> Mean<f32> {
        Mean(self.0.map(|c| c as f32))
    }
}

impl<T: Into<f64>> Mean<T> {
    #[inline]
    pub(super) fn at(self, place: DVec2) -> f64 {
        let c = self.0.map(T::into);
        let row = |n: usize| c[n] + (c[n + 1] + c[n + 2] * place.x) * place.x;
        (row(0) + (row(3) + row(6) * place.y) * place.y).max(0.0)
    }
}

impl Mean<f32> {
    /// What it nowhere exceeds, and reaches where it is monotonic: the largest Bernstein
    /// coefficient.
    pub(super) fn largest(self) -> f64 {
        let c = self.0.map(f64::from);
        let bernstein =
            |[one, slope, curve]: [f64; 3]| [one - slope + curve, one - curve, one + slope + curve];
        let rows = [0, 3, 6].map(|n| bernstein([c[n], c[n + 1], c[n + 2]]));
        let all = [0, 1, 2].map(|i| bernstein([0, 1, 2].map(|j| rows[j][i])));
        all.into_iter().flatten().fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_have_the_values_of_the_whole() {
        let mean = Mean([3.0, 0.4, -0.3, -0.2, 0.5, 0.1, 0.3, -0.1, 0.2]);
        // The part 2, 1 of 4 × 4: from 0 to ½ and from −½ to 0.
        let part = mean.within(2, [2, 1]);
        for (x, y) in [(-1.0, -1.0), (1.0, 0.3), (0.2, -0.7)] {
            let whole = mean.at(DVec2::new(0.25 + 0.25 * x, -0.25 + 0.25 * y));
            assert!((part.at(DVec2::new(x, y)) - whole).abs() < 1e-14);
        }
    }

    #[test]
    fn nothing_exceeds_the_largest() {
        // Largest at (0.5, −0.25).
        let peak = Mean([2.0, 1.0, -1.0, -0.5, 0.0, 0.0, -1.0, 0.0, 0.0]);
        let top = peak.at(DVec2::new(0.5, -0.25));
        let largest = peak.pack().largest();
        assert!(largest >= top && largest < 1.8 * top, "{largest} {top}");
        assert_eq!(Mean([2.0, 1.0, 0.25, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]).pack().largest(), 3.25);
    }
}
