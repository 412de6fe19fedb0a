//! A detail fitted to scattered points: multilevel B-spline approximation [LWS97].
//!
//! From a coarse lattice to a fine one, each level fits the residual of the levels before, and says
//! nothing where there are no points. The levels are refined into one bicubic lattice.

use std::ops::RangeInclusive;

use bsdfkit_sphere::widest::{Loop, widest};
use bsdfkit_sphere::{DVec2, DVec3};

use super::detail::{Basis, Detail, place};

/// Lattice cells across the map at the coarsest level.
const COARSEST: usize = 6;

/// Cells across of the lattice on which the noise of points is averaged: it differs between bright
/// and dark directions.
const SCATTER: usize = 16;

/// Control values so many places around tell together how much of one is noise: one by one, every
/// third would pass for structure. Of 0, 2, 3 and 5, 0 left a third more noise, the others the
/// same.
const AROUND: usize = 2;

/// What points say of the control values of a lattice; of several values a point, for each of them.
#[derive(Clone, Debug, Default)]
struct Sums {
    /// Control values across.
    side: usize,
    weight: Vec<f64>,
    each: Vec<Sum>,
}

/// Of one value a point.
#[derive(Clone, Debug, Default)]
struct Sum {
    /// Of weight · value.
    value: Vec<f64>,
    /// Of weight² · what noise adds to the square of a value.
    variance: Vec<f64>,
}

impl Sums {
    /// Less says nothing.
    const LEAST: f64 = 1e-9;

    /// Of a lattice with so many `cells` across, of no points yet, for so many values a point.
    fn clear(&mut self, cells: usize, count: usize) {
        self.side = cells + 3;
        self.each.resize_with(count, Sum::default);
        let each = self.each.iter_mut().flat_map(|sum| [&mut sum.value, &mut sum.variance]);
        for sums in each.chain([&mut self.weight]) {
            sums.clear();
            sums.resize(self.side * self.side, 0.0);
        }
    }

    fn value(&self, of: &Sum, k: usize) -> f64 {
        if self.weight[k] > Self::LEAST { of.value[k] / self.weight[k] } else { 0.0 }
    }
}

/// Values a point that are fitted together.
pub(crate) const MOST_TOGETHER: usize = 8;

/// A place on the map: half the memory of points under way.
type Place = [f32; 2];

/// Recomputed whenever it is asked for: kept, bases would take five times what their places take.
#[inline(always)]
fn basis(cells: usize, &[x, y]: &Place) -> Basis {
    Basis::at(cells, DVec2::new(f64::from(x), f64::from(y)))
}

/// The mean square of residuals around each point of the map.
fn scatter(points: &[Place], residual: &[f32]) -> Vec<f32> {
    let mut sums = Sums::default();
    sums.clear(SCATTER, 1);
    for (p, r) in points.iter().zip(residual) {
        let Basis { i, j, x, y } = basis(SCATTER, p);
        let r = f64::from(*r);
        for (dj, y) in y.iter().enumerate() {
            for (di, x) in x.iter().enumerate() {
                let k = (j + dj) * sums.side + i + di;
                let b = f64::from(x * y);
                sums.each[0].value[k] += b * r * r;
                sums.weight[k] += b;
            }
        }
    }
    let control = (0..sums.weight.len()).map(|k| sums.value(&sums.each[0], k) as f32).collect();
    let mean = Detail { cells: SCATTER, control };
    points.iter().map(|p| mean.log_by(basis(SCATTER, p)) as f32).collect()
}

/// The share of each control value that noise does not explain.
fn kept(sums: &Sums, sum: &Sum) -> Vec<f64> {
    let side = sums.side;
    // Squares in units of what noise alone leads to expect, and how many.
    let told = |k: usize| {
        let square = sum.value[k] * sum.value[k] / sum.variance[k].max(1e-300);
        if sums.weight[k] > Sums::LEAST { DVec2::new(square, 1.0) } else { DVec2::ZERO }
    };
    let told: Vec<DVec2> = (0..side * side).map(told).collect();
    let near = |k: usize| k.saturating_sub(AROUND)..(k + AROUND + 1).min(side);
    let around = |k: usize| {
        let row = |j: usize| near(k % side).map(move |i| j * side + i);
        let sum: DVec2 = near(k / side).flat_map(row).map(|n| told[n]).sum();
        (1.0 - sum.y / sum.x.max(1e-30)).max(0.0)
    };
    (0..side * side).map(around).collect()
}

/// Ratios of one direction are kept within this factor of the model: noise can be anything where
/// the model is nearly dark.
const LIMIT: f32 = 30.0;

impl Detail {
    /// Fits log ratios at scattered directions, each of which counts as its `weight` says.
    /// `finest`: least cells across at the last level, which has 6 times a power of two. Ratios
    /// farther than a factor of 30 from their median count as that.
    ///
    /// How noisy the ratios are, the finest level shows by what it leaves over; what noise explains
    /// is then not believed at any (James and Stein's estimator for the neighbourhood of each
    /// control value [CS01]). One noise for all directions, or one seen at a coarser level, takes
    /// structure of real specimens for noise.
    ///
    /// Cost: 32 multiplications per point and level; 16 bytes a point.
    pub fn fit(
        wo: impl IntoIterator<Item = DVec3>,
        ratio: &[f32],
        weight: &[f32],
        finest: usize,
    ) -> Self {
        let middle = median(ratio).clamp(1e-6, 1e6);
        let bounded = |r: &f32| r.clamp(middle / LIMIT, middle * LIMIT).ln();
        let logs = ratio.iter().map(bounded).collect();
        Self::fit_each(wo, &[logs], weight, finest).pop().unwrap_or_else(Self::none)
    }

    /// [`Detail::fit`] of several logarithms a direction, as they are: `logs` has at most [`MOST_TOGETHER`] lists.
    ///
    /// Cost: less than they cost one by one: each point's place on a lattice is found once.
    pub fn fit_each(
        wo: impl IntoIterator<Item = DVec3>,
        logs: &[Vec<f32>],
        weight: &[f32],
        finest: usize,
    ) -> Vec<Self> {
        let at = |w: DVec3| place(w.truncate()).as_vec2().to_array();
        let places: Vec<Place> = wo.into_iter().map(at).collect();
        let unit = 1.0 / f64::from(median(weight)).max(1e-300);
        let mut points = Points { places: &places, weight, unit, noise: None };
        debug_assert!(logs.len() <= MOST_TOGETHER);
        let mut left = logs.to_vec();
        Self::levels(points, &mut left, (finest / 4).max(COARSEST)..=finest);
        let noise: Vec<Vec<f32>> = left.iter().map(|left| scatter(&places, left)).collect();
        points.noise = Some(&noise);
        left.iter_mut().zip(logs).for_each(|(left, logs)| left.copy_from_slice(logs));
        Self::levels(points, &mut left, COARSEST..=finest)
    }

    /// The sum of lattices with so many `cells` across, doubled each time: each is fitted to what
    /// those before leave of each list of `residuals`.
    fn levels(
        points: Points<'_>,
        residuals: &mut [Vec<f32>],
        cells: RangeInclusive<usize>,
    ) -> Vec<Self> {
        let mut total = vec![Self::none(); residuals.len()];
        let (mut cells, finest) = cells.into_inner();
        let mut sums = Sums::default();
        loop {
            let level = Self::level(points, residuals, cells, &mut sums);
            widest(Subtract { places: points.places, level: &level, residuals });
            for (total, level) in total.iter_mut().zip(level) {
                *total = if total.cells == 1 { level } else { total.refined().plus(&level) };
            }
            if cells >= finest {
                return total;
            }
            cells *= 2;
        }
    }

    /// One lattice fitted to each list of residuals.
    fn level(
        points: Points<'_>,
        residuals: &[Vec<f32>],
        cells: usize,
        sums: &mut Sums,
    ) -> Vec<Self> {
        sums.clear(cells, residuals.len());
        widest(Gather { points, residuals, cells, sums });
        let fitted = |sum: &Sum| {
            let kept = points.noise.is_some().then(|| kept(sums, sum));
            let control = (0..sums.weight.len()).map(|k| {
                let share = kept.as_ref().map_or(1.0, |kept| kept[k]);
                (sums.value(sum, k) * share) as f32
            });
            Self { cells, control: control.collect() }
        };
        sums.each.iter().map(fitted).collect()
    }

    fn plus(mut self, other: &Self) -> Self {
        for (a, b) in self.control.iter_mut().zip(&other.control) {
            *a += b;
        }
        self
    }
}

/// What is fitted, but for its values.
#[derive(Clone, Copy)]
struct Points<'a> {
    places: &'a [Place],
    /// How much each counts, in units of 1 / `unit`.
    weight: &'a [f32],
    unit: f64,
    /// Mean squares of the noise of each value, once they are known.
    noise: Option<&'a [Vec<f32>]>,
}

/// Every point's say, added to the control values around it.
struct Gather<'a> {
    points: Points<'a>,
    residuals: &'a [Vec<f32>],
    cells: usize,
    sums: &'a mut Sums,
}

impl Loop for Gather<'_> {
    #[inline(always)]
    fn run(self) {
        let Self { points: Points { places, weight, unit, noise }, residuals, cells, sums } = self;
        let side = sums.side;
        for (k, p) in places.iter().enumerate() {
            let Basis { i, j, x, y } = basis(cells, p);
            let [x, y] = [x, y].map(|b| b.map(f64::from));
            let [x2, y2] = [x, y].map(|b| b.map(|b| b * b));
            let square = (x2[0] + x2[1] + x2[2] + x2[3]) * (y2[0] + y2[1] + y2[2] + y2[3]);
            // Of [LWS97]: φ = b z / Σ b², with b = x y, weighs b².
            let mut told = [(0.0, 0.0); MOST_TOGETHER];
            for (n, (told, residual)) in told.iter_mut().zip(residuals).enumerate() {
                let noise = noise.map_or(0.0, |noise| f64::from(noise[n][k]) / (square * square));
                *told = (f64::from(residual[k]) / square, noise);
            }
            let own = unit * f64::from(weight[k]);
            for dj in 0..4 {
                let row = (j + dj) * side + i..(j + dj) * side + i + 4;
                let (of, wy) = (y[dj], own * y2[dj]);
                let (mut w, mut wb) = ([0.0; 4], [0.0; 4]);
                for c in 0..4 {
                    w[c] = wy * x2[c];
                    wb[c] = w[c] * (x[c] * of);
                }
                let weight = &mut sums.weight[row.clone()];
                for c in 0..4 {
                    weight[c] += w[c];
                }
                for (sum, (z, noise)) in sums.each.iter_mut().zip(told) {
                    let value = &mut sum.value[row.clone()];
                    for c in 0..4 {
                        value[c] += wb[c] * z;
                    }
                    let variance = &mut sum.variance[row.clone()];
                    for c in 0..4 {
                        variance[c] += wb[c] * wb[c] * noise;
                    }
                }
            }
        }
    }
}

/// Takes a level off what is still to be fitted.
struct Subtract<'a> {
    places: &'a [Place],
    level: &'a [Detail],
    residuals: &'a mut [Vec<f32>],
}

impl Loop for Subtract<'_> {
    #[inline(always)]
    fn run(self) {
        let Some(first) = self.level.first() else { return };
        for (k, p) in self.places.iter().enumerate() {
            let basis = basis(first.cells, p);
            for (level, residual) in self.level.iter().zip(&mut *self.residuals) {
                residual[k] -= level.log_by(basis) as f32;
            }
        }
    }
}

/// 1 of none.
fn median(values: &[f32]) -> f32 {
    if values.is_empty() {
        return 1.0;
    }
    let mut values = values.to_vec();
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;
    use bsdfkit_sphere::sequence::plastic;

    fn direction_of(w: DVec3) -> DVec3 {
        w.with_z((1.0 - w.truncate().length_squared()).max(0.0).sqrt())
    }

    fn points() -> Vec<DVec3> {
        (0..20_000)
            .map(|i| (plastic(i) * 2.0 - DVec2::ONE).extend(0.0))
            .filter(|d| d.length() < 0.99)
            .collect()
    }

    #[test]
    fn a_smooth_ratio_is_reproduced() {
        let wo = points();
        let f = |w: &DVec3| 1.0 + 0.3 * (5.0 * w.x).sin() * w.y;
        let ratio: Vec<f32> = wo.iter().map(|w| f(w) as f32).collect();
        let d = Detail::fit(wo.iter().copied(), &ratio, &vec![1.0; wo.len()], 64);
        for w in wo.iter().step_by(31) {
            assert!((d.log_at(w.truncate()).exp() - f(w)).abs() < 0.004, "{w}");
        }
    }

    #[test]
    fn polar_angles_are_resolved_near_the_horizon() {
        let turn = |k: i32| {
            from_degrees(65.0 + 15.0 * (f64::from(k) * 0.7549).fract(), f64::from(k) * 0.5698)
        };
        let wo: Vec<DVec3> = (0..60_000).map(turn).collect();
        let f = |w: &DVec3| 1.0 + 0.3 * (w.z.acos().to_degrees()).sin();
        let ratio: Vec<f32> = wo.iter().map(|w| f(w) as f32).collect();
        let d = Detail::fit(wo.iter().copied(), &ratio, &vec![1.0; wo.len()], 192);
        let missed = |w: &DVec3| (d.log_at(w.truncate()).exp() - f(w)).abs();
        let mean = wo.iter().map(missed).sum::<f64>() / wo.len() as f64;
        assert!(mean < 0.06, "{mean}");
    }

    /// A lobe that fits, at 75 degrees, and its tail, four times as bright as the model has it.
    #[test]
    fn bright_directions_are_not_pulled_by_dark_ones() {
        let mut wo = points();
        for k in 0..4000 {
            let (x, y) =
                ((f64::from(k) * 0.7549).fract() - 0.5, (f64::from(k) * 0.5698).fract() - 0.5);
            wo.push(from_degrees(75.0 + 14.0 * x, 40.0 + 14.0 * y));
        }
        let peak = from_degrees(75.0, 40.0);
        let off = |w: &DVec3| direction_of(*w).angle_between(peak).to_degrees() / 2.0;
        let f = |w: &DVec3| 1.0 + 3.0 * (off(w) - 2.0).clamp(0.0, 1.0);
        let weight: Vec<f32> =
            wo.iter().map(|w| ((-0.5 * off(w).powi(2)).exp() + 1e-3) as f32).collect();
        let ratio: Vec<f32> = wo.iter().map(|w| f(w) as f32).collect();
        let d = Detail::fit(wo.iter().copied(), &ratio, &weight, 192);
        let near: Vec<&DVec3> = wo.iter().filter(|w| off(w) < 1.0).collect();
        let missed =
            near.iter().map(|w| d.log_at(w.truncate()).abs()).sum::<f64>() / near.len() as f64;
        assert!(missed < 0.01, "{missed} of {}", near.len());
    }

    /// Uniform between −0.1 and 0.1: a standard deviation of 0.058.
    fn noise() -> impl Iterator<Item = f64> {
        let mut state = 1u64;
        std::iter::repeat_with(move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            0.1 * ((state >> 40) as f64 / 8_388_608.0 - 1.0)
        })
    }

    #[test]
    fn structure_is_found_in_noise() {
        let wo = points();
        let f = |w: &DVec3| 1.0 + 0.3 * (5.0 * w.x).sin() * w.y;
        let ratio: Vec<f32> =
            wo.iter().zip(noise()).map(|(w, n)| (f(w) * (1.0 + n)) as f32).collect();
        let d = Detail::fit(wo.iter().copied(), &ratio, &vec![1.0; wo.len()], 64);
        let miss = |w: &DVec3| (d.log_at(w.truncate()) - f(w).ln()).powi(2);
        let rms = (wo.iter().map(miss).sum::<f64>() / wo.len() as f64).sqrt();
        assert!(rms < 0.01, "{rms}");
    }

    #[test]
    fn pure_noise_is_not_believed() {
        let wo = points();
        let ratio: Vec<f32> = noise().take(wo.len()).map(|n| (1.0 + n) as f32).collect();
        let d = Detail::fit(wo.iter().copied(), &ratio, &vec![1.0; wo.len()], 64);
        let rms = wo.iter().map(|w| d.log_at(w.truncate()).powi(2)).sum::<f64>() / wo.len() as f64;
        assert!(rms.sqrt() < 0.006, "{}", rms.sqrt());
    }
}
