//! Running sums of a matrix: totals and sampling by one search.

use std::hint::select_unpredictable;

use bsdfkit_sphere::octant::at_turns;

use super::klems::KlemsBasis;
use super::numbering::{CHUNK, NO_PATCH};
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
    /// The last sum of each row, near each other.
    whole: Vec<f64>,
    /// Σ Ω(k) over the patches before each patch; one more than patches.
    omega: Vec<f64>,
    patches: Vec<Patch>,
    /// First patch of each ring, then the number of patches.
    rings: Vec<usize>,
}

/// A patch as the image of the unit square: sin²θ = from + u · step, φ = (first + v) / count turns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Patch {
    from: f64,
    step: f64,
    first: f64,
    count: f64,
}

impl Patch {
    pub(super) fn new(basis: &KlemsBasis, k: usize) -> Self {
        let (cosines, number, count) = basis.extent(k);
        let [from, to] = cosines.map(|c| (1.0 - c) * (1.0 + c));
        Self { from, step: to - from, first: number as f64 - 0.5, count: count as f64 }
    }

    /// Point of the unit square → projection of a direction in basis form, uniform in projected
    /// solid angle.
    #[inline(always)]
    pub(super) fn at(&self, point: DVec2) -> DVec2 {
        let sin = (self.from + point.x * self.step).sqrt();
        at_turns((self.first + point.y) / self.count) * sin
    }
}

impl RunningSums {
    /// Of rows of values over `basis`.
    pub(super) fn new(values: &[f32], basis: &KlemsBasis) -> Self {
        let count = basis.directions();
        let solid = basis.projected_solid_angles();
        let mut omega = Vec::with_capacity(count + 1);
        omega.push(0.0);
        omega.extend(solid.iter().scan(0.0, |sum, o| {
            *sum += o;
            Some(*sum)
        }));
        let rows = values.len() / count;
        let (mut sums, mut whole) =
            (Vec::with_capacity(rows * (count + 1)), Vec::with_capacity(rows));
        for row in values.chunks_exact(count) {
            let mut sum = 0.0;
            sums.push(sum);
            for (value, omega) in row.iter().zip(&solid) {
                sum += f64::from(*value) * omega;
                sums.push(sum);
            }
            whole.push(sum);
        }
        let patches = (0..count).map(|k| Patch::new(basis, k)).collect();
        Self { sums, whole, omega, patches, rings: basis.ring_starts().to_vec() }
    }

    /// The extent of a patch.
    #[inline(always)]
    pub(super) fn patch(&self, k: usize) -> Patch {
        self.patches[k]
    }

    /// Σ (f − floor) Ω over the patches before patch k.
    #[inline(always)]
    fn before(&self, row: usize, k: usize, floor: f64) -> f64 {
        self.sums[row * self.omega.len() + k] - floor * self.omega[k]
    }

    /// Σ (f − floor) Ω of a row; 0 where only rounding of the difference would be left.
    #[inline(always)]
    pub(super) fn total(&self, row: usize, floor: f64) -> f64 {
        let whole = self.whole[row];
        let rest = whole - floor * self.omega[self.omega.len() - 1];
        if rest > ROUNDING * whole { rest } else { 0.0 }
    }

    /// One step of a search for the last patch whose sum does not exceed `target`: no branch.
    #[inline(always)]
    fn step(&self, row: usize, low: usize, stride: usize, floor: f64, target: f64) -> usize {
        if self.before(row, low + stride, floor) <= target { low + stride } else { low }
    }

    /// Where in the patch found the target is, as part of its length; the patch before when it is empty.
    #[inline(always)]
    fn place(&self, row: usize, found: usize, floor: f64, target: f64) -> (usize, f64) {
        let (mut k, mut low) = (found, self.before(row, found, floor));
        let mut high = self.before(row, k + 1, floor);
        // u = 1, or rounding, may end in an empty patch behind the last full one.
        while k > 0 && high <= low {
            k -= 1;
            (low, high) = (self.before(row, k, floor), low);
        }
        (k, part(low, high, target))
    }

    /// The patch that u falls into when patches have lengths (f − floor) Ω, and where in it, from
    /// 0 to 1; `None` when all lengths are 0.
    pub(super) fn sample(&self, row: usize, floor: f64, u: f64) -> Option<(usize, f64)> {
        let total = self.total(row, floor);
        if !(total > 0.0 && u >= 0.0) {
            return None;
        }
        let target = u.min(1.0) * total;
        let step = |low, stride| self.step(row, low, stride, floor, target);
        let found = strides(self.patches.len()).fold(0, step);
        Some(self.place(row, found, floor, target))
    }

    /// The same by two numbers: the ring and the place in it follow the first, the patch of the ring and the
    /// place in it the second.
    pub(super) fn sample2(&self, row: usize, floor: f64, u: DVec2) -> Option<(usize, DVec2)> {
        if !(self.total(row, floor) > 0.0 && u.x >= 0.0 && u.y >= 0.0) {
            return None;
        }
        let at = |k: usize| self.before(row, k, floor);
        let (ring, x) = search(self.rings.len() - 1, |r| at(self.rings[r]), u.x)?;
        let (first, end) = (self.rings[ring], self.rings[ring + 1]);
        let (patch, y) = search(end - first, |k| at(first + k), u.y)?;
        Some((first + patch, DVec2::new(x, y)))
    }

    /// [`RunningSums::sample`] of [`CHUNK`] rows side by side: a place that is NaN is `None`.
    #[inline(always)]
    pub(super) fn sample_abreast(
        &self,
        rows: &[u32; CHUNK],
        floor: f64,
        u: &[f64],
        (drawn, rest): (&mut [u32; CHUNK], &mut [f64; CHUNK]),
    ) {
        let (mut row, mut target, mut low) = ([0; CHUNK], [f64::NAN; CHUNK], [0; CHUNK]);
        for (k, u) in u.iter().enumerate().take(CHUNK) {
            if rows[k] != NO_PATCH {
                row[k] = rows[k] as usize;
                let total = self.total(row[k], floor);
                let valid = (total > 0.0) & (*u >= 0.0);
                target[k] = if valid { u.min(1.0) * total } else { f64::NAN };
            }
        }
        // As `step`, with what it looks up again and again kept at hand.
        let (sums, omega) = (&*self.sums, &*self.omega);
        let start = row.map(|row| row * omega.len());
        for stride in strides(self.patches.len()) {
            for k in 0..CHUNK {
                let next = low[k] + stride;
                let before = sums[start[k] + next] - floor * omega[next];
                low[k] = if before <= target[k] { next } else { low[k] };
            }
        }
        for k in 0..u.len().min(CHUNK) {
            if !target[k].is_nan() {
                let (patch, place) = self.place(row[k], low[k], floor, target[k]);
                (drawn[k], rest[k]) = (patch as u32, place);
            }
        }
    }
}

/// How far a search among `count` places moves on at most, step by step.
fn strides(count: usize) -> impl Iterator<Item = usize> {
    let mut left = count;
    std::iter::from_fn(move || {
        let stride = left / 2;
        left -= stride;
        (stride > 0).then_some(stride)
    })
}

/// Where between two sums the target is, in \[0, 1).
#[inline(always)]
fn part(low: f64, high: f64, target: f64) -> f64 {
    let part = (target - low) / (high - low);
    // NaN becomes 0.
    if part > 0.0 { part.min(1.0 - f64::EPSILON) } else { 0.0 }
}

/// Of `count` lengths that `u` falls into, and where in it; `sum(k)` is that of those before number k.
/// A length of 0 is never chosen; `None` when all are.
fn search(count: usize, sum: impl Fn(usize) -> f64, u: f64) -> Option<(usize, f64)> {
    let (start, end) = (sum(0), sum(count));
    let target = start + u.min(1.0) * (end - start);
    let mut k = strides(count)
        .fold(0, |k, stride| select_unpredictable(sum(k + stride) <= target, k + stride, k));
    while k > 0 && sum(k + 1) <= sum(k) {
        k -= 1;
    }
    (end > start).then(|| (k, part(sum(k), sum(k + 1), target)))
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
