//! Totals and running sums of a matrix's rows, and one search that samples them.

use std::hint::select_unpredictable;

use crate::DVec2;
use crate::klems::{CHUNK, KlemsBasis, NO_PATCH, Patch};
use crate::unit::BELOW_ONE;

/// Relative error of a difference of running sums, with a decade to spare: a few hundred additions
/// of f64. A larger one would lose the rest of a nearly constant row.
const ROUNDING: f64 = 1e-12;

/// Patches between two sums that are stored: at 4, sums of f64 take half the bytes of the values,
/// and a search ends in values that share a cache line.
const EVERY: usize = 4;

/// For each row, Σ f(row, k) Ω(k) over the patches before every fourth patch; the values tell the
/// rest.
///
/// A constant taken out of f is taken out of the sums as they are looked at (the sums are linear
/// in f), so that no second table is needed.
#[derive(Debug)]
pub(super) struct RunningSums {
    /// Rows of [`RunningSums::marks`] sums, the first 0.
    sums: Vec<f64>,
    /// Ω(k).
    solid: Vec<f64>,
    /// Σ Ω(k) over the patches before each patch; one more than patches.
    omega: Vec<f64>,
    patches: Vec<Patch>,
    /// First patch of each ring, then the number of patches.
    rings: Vec<usize>,
}

/// Values with the known direction as row, whichever it is in the matrix.
#[derive(Clone, Copy)]
pub(super) struct Rows<'a> {
    pub(super) values: &'a [f32],
    /// From a row to the next, and from a patch to the next.
    pub(super) strides: [usize; 2],
}

impl Rows<'_> {
    #[inline(always)]
    pub(super) fn at(&self, row: usize, k: usize) -> f64 {
        f64::from(self.values[row * self.strides[0] + k * self.strides[1]])
    }
}

/// Σ f(row, k) Ω(k) of each row.
#[derive(Debug)]
pub(super) struct RowTotals {
    whole: Vec<f64>,
    /// Σ Ω(k).
    omega: f64,
}

impl RowTotals {
    pub(super) fn new(values: Rows<'_>, rows: usize, basis: &KlemsBasis) -> Self {
        let solid = basis.projected_solid_angles();
        let whole = |row| solid.iter().enumerate().fold(0.0, |s, (k, o)| s + values.at(row, k) * o);
        Self { whole: (0..rows).map(whole).collect(), omega: solid.iter().sum() }
    }

    /// Σ (f − floor) Ω of a row; 0 where only rounding of the difference would be left.
    #[inline(always)]
    pub(super) fn total(&self, row: usize, floor: f64) -> f64 {
        let whole = self.whole[row];
        let rest = whole - floor * self.omega;
        if rest > ROUNDING * whole { rest } else { 0.0 }
    }
}

/// All that samples of a matrix are drawn from.
#[derive(Clone, Copy)]
pub(super) struct Draw<'a> {
    pub(super) values: Rows<'a>,
    pub(super) totals: &'a RowTotals,
    pub(super) sums: &'a RunningSums,
}

impl RunningSums {
    pub(super) fn new(values: Rows<'_>, rows: usize, basis: &KlemsBasis) -> Self {
        let count = basis.directions();
        let solid = basis.projected_solid_angles();
        let mut omega = vec![0.0; count + 1];
        for (k, solid) in solid.iter().enumerate() {
            omega[k + 1] = omega[k] + solid;
        }
        let mut sums = Vec::with_capacity(rows * count.div_ceil(EVERY));
        for row in 0..rows {
            let mut sum = 0.0;
            for (k, solid) in solid.iter().enumerate() {
                if k % EVERY == 0 {
                    sums.push(sum);
                }
                sum += values.at(row, k) * solid;
            }
        }
        let patches = (0..count).map(|k| Patch::new(basis, k)).collect();
        Self { sums, solid, omega, patches, rings: basis.ring_starts().to_vec() }
    }

    /// Sums stored of a row.
    #[inline(always)]
    fn marks(&self) -> usize {
        self.patches.len().div_ceil(EVERY)
    }

    /// The extent of a patch.
    #[inline(always)]
    pub(super) fn patch(&self, k: usize) -> Patch {
        self.patches[k]
    }

    /// Σ (f − floor) Ω over the patches before a mark.
    #[inline(always)]
    fn before_mark(&self, row: usize, mark: usize, floor: f64) -> f64 {
        self.sums[row * self.marks() + mark] - floor * self.omega[mark * EVERY]
    }
}

impl Draw<'_> {
    /// (f − floor) Ω of patch k.
    #[inline(always)]
    fn length(&self, row: usize, k: usize, floor: f64) -> f64 {
        (self.values.at(row, k) - floor) * self.sums.solid[k]
    }

    /// Σ (f − floor) Ω over the patches before patch k, or over all.
    fn before(&self, row: usize, k: usize, floor: f64) -> f64 {
        let mark = (k / EVERY).min(self.sums.marks() - 1);
        let start = self.sums.before_mark(row, mark, floor);
        (mark * EVERY..k).fold(start, |sum, k| sum + self.length(row, k, floor))
    }

    /// One step of the search from a patch on: the next before `end`, if its sum does not exceed
    /// `target`.
    #[inline(always)]
    fn step(
        &self,
        row: usize,
        (k, low): (usize, f64),
        end: usize,
        floor: f64,
        target: f64,
    ) -> (usize, f64) {
        let high = low + self.length(row, k, floor);
        let on = (high <= target) & (k + 1 < end);
        (select_unpredictable(on, k + 1, k), select_unpredictable(on, high, low))
    }

    /// Of the patches from `first` to `end`, the last whose sum does not exceed `target`, and that
    /// sum.
    #[inline(always)]
    fn find(&self, row: usize, first: usize, end: usize, floor: f64, target: f64) -> (usize, f64) {
        let before = |mark| self.sums.before_mark(row, mark, floor);
        let (from, to) = (first / EVERY, end.div_ceil(EVERY));
        let mark = strides(to - from).fold(from, |low, stride| {
            select_unpredictable(before(low + stride) <= target, low + stride, low)
        });
        let start = (mark * EVERY, before(mark));
        (1..EVERY).fold(start, |found, _| self.step(row, found, end, floor, target))
    }

    /// Where in the patch found the target is, as part of its length; the patch before when it is
    /// empty.
    #[inline(always)]
    fn place(&self, row: usize, found: (usize, f64), floor: f64, target: f64) -> (usize, f64) {
        let (mut k, mut low) = found;
        let mut length = self.length(row, k, floor);
        // u = 1, or rounding, may end in an empty patch behind the last full one.
        while k > 0 && length <= 0.0 {
            k -= 1;
            length = self.length(row, k, floor);
            low -= length;
        }
        (k, part(low, low + length, target))
    }

    /// The patch that u falls into when patches have lengths (f − floor) Ω, and where in it, from
    /// 0 to 1; `None` when all lengths are 0.
    pub(super) fn sample(&self, row: usize, floor: f64, u: f64) -> Option<(usize, f64)> {
        let total = self.totals.total(row, floor);
        if !(total > 0.0 && u >= 0.0) {
            return None;
        }
        let target = u.min(1.0) * total;
        let found = self.find(row, 0, self.sums.patches.len(), floor, target);
        Some(self.place(row, found, floor, target))
    }

    /// The same by two numbers: the ring and the place in it follow the first, the patch of the
    /// ring and the place in it the second.
    pub(super) fn sample2(&self, row: usize, floor: f64, u: DVec2) -> Option<(usize, DVec2)> {
        let total = self.totals.total(row, floor);
        if !(total > 0.0 && u.x >= 0.0 && u.y >= 0.0) {
            return None;
        }
        let (at, rings) =
            (|r: usize| self.before(row, self.sums.rings[r], floor), &self.sums.rings);
        let (target, count) = (u.x.min(1.0) * total, rings.len() - 1);
        let mut ring = strides(count).fold(0, |ring, stride| {
            select_unpredictable(at(ring + stride) <= target, ring + stride, ring)
        });
        let (mut low, mut high) = (at(ring), at(ring + 1));
        while ring > 0 && high <= low {
            ring -= 1;
            (low, high) = (at(ring), low);
        }
        let within = low + u.y.min(1.0) * (high - low);
        let found = self.find(row, rings[ring], rings[ring + 1], floor, within);
        let (patch, y) = self.place(row, found, floor, within);
        Some((patch, DVec2::new(part(low, high, target), y)))
    }

    /// [`Draw::sample`] of [`CHUNK`] rows side by side: a place that is NaN is `None`.
    #[inline(always)]
    pub(super) fn sample_abreast(
        &self,
        rows: &[u32; CHUNK],
        floor: f64,
        u: &[f64],
        (drawn, rest): (&mut [u32; CHUNK], &mut [f64; CHUNK]),
    ) {
        let (mut row, mut target, mut mark) = ([0; CHUNK], [f64::NAN; CHUNK], [0; CHUNK]);
        for (k, u) in u.iter().enumerate().take(CHUNK) {
            if rows[k] != NO_PATCH {
                row[k] = rows[k] as usize;
                let total = self.totals.total(row[k], floor);
                let valid = (total > 0.0) & (*u >= 0.0);
                target[k] = if valid { u.min(1.0) * total } else { f64::NAN };
            }
        }
        for stride in strides(self.sums.marks()) {
            for k in 0..CHUNK {
                let next = mark[k] + stride;
                let before = self.sums.before_mark(row[k], next, floor);
                mark[k] = if before <= target[k] { next } else { mark[k] };
            }
        }
        let (mut found, patches) = ([(0, 0.0); CHUNK], self.sums.patches.len());
        for k in 0..CHUNK {
            found[k] = (mark[k] * EVERY, self.sums.before_mark(row[k], mark[k], floor));
        }
        for _ in 1..EVERY {
            for k in 0..CHUNK {
                found[k] = self.step(row[k], found[k], patches, floor, target[k]);
            }
        }
        for k in 0..u.len().min(CHUNK) {
            if !target[k].is_nan() {
                let (patch, place) = self.place(row[k], found[k], floor, target[k]);
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
    if part > 0.0 { part.min(BELOW_ONE) } else { 0.0 }
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
        let rows = Rows { values: &values, strides: [41, 1] };
        let totals = RowTotals::new(rows, 1, &basis);
        let sums = RunningSums::new(rows, 1, &basis);
        let draw = Draw { values: rows, totals: &totals, sums: &sums };
        for n in 0..=1000 {
            let (patch, _) = draw.sample(0, 0.0, f64::from(n) / 1000.0).unwrap();
            assert!(patch == 3 || patch == 20, "{n}: {patch}");
        }
        assert_eq!(draw.sample(0, 0.0, f64::NAN), None);
        let expected = 2.0 * basis.projected_solid_angle(3) + basis.projected_solid_angle(20);
        assert!((totals.total(0, 0.0) - expected).abs() < 1e-15);
    }

    #[test]
    fn a_floor_is_taken_out_of_total_and_samples() {
        let basis = KlemsBasis::quarter();
        let mut values = vec![0.5f32; 41];
        values[7] = 1.5;
        let rows = Rows { values: &values, strides: [41, 1] };
        let totals = RowTotals::new(rows, 1, &basis);
        let sums = RunningSums::new(rows, 1, &basis);
        let draw = Draw { values: rows, totals: &totals, sums: &sums };
        assert!((totals.total(0, 0.5) - basis.projected_solid_angle(7)).abs() < 1e-14);
        for n in 0..100 {
            assert_eq!(draw.sample(0, 0.5, f64::from(n) / 100.0).unwrap().0, 7);
        }
    }

    /// Slow twin: every patch from the first on. Rows in either order of the values.
    #[test]
    fn searches_find_what_a_walk_finds() {
        let basis = KlemsBasis::quarter();
        let (count, rows) = (basis.directions(), 3);
        // A third of the patches are empty once the floor is taken out.
        let value = |row: usize, k: usize| 0.25 + ((7 * k + 5 * row) % 6 / 2) as f32;
        let straight: Vec<f32> = (0..rows * count).map(|n| value(n / count, n % count)).collect();
        let turned: Vec<f32> = (0..rows * count).map(|n| value(n % rows, n / rows)).collect();
        for (values, strides) in [(&straight, [count, 1]), (&turned, [1, rows])] {
            let values = Rows { values, strides };
            let totals = RowTotals::new(values, rows, &basis);
            let sums = RunningSums::new(values, rows, &basis);
            let draw = Draw { values, totals: &totals, sums: &sums };
            for (row, n) in (0..rows).flat_map(|row| (0..500).map(move |n| (row, n))) {
                let u = (f64::from(n) + 0.5) / 500.0;
                let length = |k| (f64::from(value(row, k)) - 0.25) * basis.projected_solid_angle(k);
                let target = u * (0..count).map(length).sum::<f64>();
                let (mut k, mut low) = (0, 0.0);
                while low + length(k) <= target {
                    low += length(k);
                    k += 1;
                }
                let (found, place) = draw.sample(row, 0.25, u).unwrap();
                assert_eq!(found, k, "{row} {u}");
                assert!((place - (target - low) / length(k)).abs() < 1e-9, "{row} {u}");
                // Two numbers: the first goes outward, the second around the ring that it chose.
                let at = |x: f64, y: f64| {
                    let (patch, point) = draw.sample2(row, 0.25, DVec2::new(x, y)).unwrap();
                    assert!(length(patch) > 0.0, "{row} {x} {y}: empty patch {patch}");
                    sums.patch(patch).at(point).length()
                };
                assert!(at(u, 0.3) <= at(u + 0.001, 0.3), "{row} {u}");
                assert!((at(u, 0.1) - at(u, 0.9)).abs() < 1e-12, "{row} {u}");
            }
        }
    }
}
