//! Running sums of a matrix: totals and sampling by one search.

use bsdfkit_sphere::hilbert;

use super::klems::KlemsBasis;
use crate::DVec2;

/// Relative error of a difference of running sums, with a decade to spare: a few hundred additions
/// of f64. A larger one would lose the rest of a nearly constant row.
const ROUNDING: f64 = 1e-12;

/// For each row, Σ f(row, k) Ω(k) over the patches before each patch.
///
/// A constant taken out of f is taken out of the sums as they are looked at (the sums are linear
/// in f), so that no second table is needed.
#[derive(Debug)]
pub(super) struct RunningSums {
    /// Rows of `omega.len()` sums, the first 0.
    sums: Vec<f64>,
    /// Σ Ω(k) over the patches before each patch; one more than patches.
    omega: Vec<f64>,
}

impl RunningSums {
    /// Of rows of values over `basis`.
    pub(super) fn new(values: &[f32], basis: &KlemsBasis) -> Self {
        let patches = basis.directions();
        let solid: Vec<f64> = (0..patches).map(|k| basis.projected_solid_angle(k)).collect();
        let mut omega = Vec::with_capacity(patches + 1);
        omega.push(0.0);
        omega.extend(solid.iter().scan(0.0, |sum, o| {
            *sum += o;
            Some(*sum)
        }));
        let mut sums = Vec::with_capacity(values.len() / patches * (patches + 1));
        for row in values.chunks_exact(patches) {
            let mut sum = 0.0;
            sums.push(sum);
            for (value, omega) in row.iter().zip(&solid) {
                sum += f64::from(*value) * omega;
                sums.push(sum);
            }
        }
        Self { sums, omega }
    }

    fn row(&self, row: usize) -> &[f64] {
        let length = self.omega.len();
        &self.sums[row * length..][..length]
    }

    /// Σ (f − floor) Ω of a row; 0 where only rounding of the difference would be left.
    pub(super) fn total(&self, row: usize, floor: f64) -> f64 {
        let last = self.omega.len() - 1;
        let whole = self.row(row)[last];
        let rest = whole - floor * self.omega[last];
        if rest > ROUNDING * whole { rest } else { 0.0 }
    }

    /// The patch that u falls into when patches have lengths (f − floor) Ω, and where in the
    /// patch's unit square; `None` when all lengths are 0.
    pub(super) fn sample(&self, row: usize, floor: f64, u: f64) -> Option<(usize, DVec2)> {
        let total = self.total(row, floor);
        if !(total > 0.0 && u >= 0.0) {
            return None;
        }
        let sums = self.row(row);
        let at = |k: usize| sums[k] - floor * self.omega[k];
        let target = u.min(1.0) * total;
        let (mut low, mut high) = (0, self.omega.len() - 1);
        while high - low > 1 {
            let middle = low.midpoint(high);
            if at(middle) <= target { low = middle } else { high = middle }
        }
        // u = 1, or rounding, may end in an empty patch behind the last full one.
        while low > 0 && at(low + 1) <= at(low) {
            low -= 1;
        }
        let fraction = (target - at(low)) / (at(low + 1) - at(low));
        Some((low, hilbert::unfold(fraction.clamp(0.0, 1.0 - f64::EPSILON))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_patches_are_never_drawn() {
        let basis = KlemsBasis::quarter();
        let mut values = vec![0.0f32; 41];
        values[3] = 2.0;
        values[20] = 1.0;
        let sums = RunningSums::new(&values, &basis);
        for n in 0..=1000 {
            let (patch, _) = sums.sample(0, 0.0, f64::from(n) / 1000.0).unwrap();
            assert!(patch == 3 || patch == 20, "{n}: {patch}");
        }
        assert_eq!(sums.sample(0, 0.0, f64::NAN), None);
        let expected = 2.0 * basis.projected_solid_angle(3) + basis.projected_solid_angle(20);
        assert!((sums.total(0, 0.0) - expected).abs() < 1e-15);
    }

    #[test]
    fn a_floor_is_taken_out_of_total_and_samples() {
        let basis = KlemsBasis::quarter();
        let mut values = vec![0.5f32; 41];
        values[7] = 1.5;
        let sums = RunningSums::new(&values, &basis);
        assert!((sums.total(0, 0.5) - basis.projected_solid_angle(7)).abs() < 1e-14);
        for n in 0..100 {
            assert_eq!(sums.sample(0, 0.5, f64::from(n) / 100.0).unwrap().0, 7);
        }
    }
}
