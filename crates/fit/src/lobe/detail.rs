//! What the lobes leave over: the smooth ratio of data to model on the disk of directions.
//!
//! Multilevel B-spline approximation of scattered data [LWS97]: from a coarse
//! lattice to a fine one, each level fits the residual of the levels before, and says nothing
//! where there are no points. The levels are refined into one bicubic lattice.

use bsdfkit_sphere::{DVec2, DVec3};

/// Lattice cells across the disk at the coarsest level.
const COARSEST: usize = 4;

/// A bicubic spline of log(data / model) over the disk of direction cosines.
#[derive(Clone, Debug, PartialEq)]
pub struct Detail {
    /// Cells across.
    cells: usize,
    /// (cells + 3)² control values, row-major in y.
    control: Vec<f32>,
}

/// Ratios of one direction are kept within this factor of the model: noise can be anything where
/// the model is nearly dark.
const LIMIT: f64 = 30.0;

impl Detail {
    /// No correction.
    pub fn none() -> Self {
        Self { cells: 1, control: vec![0.0; 16] }
    }

    /// From a stored lattice of (cells + 3)² control values; `None` if the size is not such.
    pub fn from_control(control: Vec<f32>) -> Option<Self> {
        let n = control.len().isqrt();
        (n >= 4 && n * n == control.len()).then_some(Self { cells: n - 3, control })
    }

    /// The lattice, row-major in y.
    pub fn control(&self) -> &[f32] {
        &self.control
    }

    /// Fits log ratios at scattered directions. `noise`: relative scatter of one value, below
    /// which a local deviation is not believed. `finest`: cells across at the last level.
    /// Ratios farther than a factor of 30 from their median count as that.
    ///
    /// Cost: 16 multiplications per point and level.
    pub fn fit(wo: &[DVec3], ratio: &[f64], noise: f64, finest: usize) -> Self {
        let mut sorted = ratio.to_vec();
        sorted.sort_by(f64::total_cmp);
        let median = sorted.get(sorted.len() / 2).map_or(1.0, |m| m.clamp(1e-6, 1e6));
        let bounded = |r: &f64| r.clamp(median / LIMIT, median * LIMIT).ln();
        let mut residual: Vec<f64> = ratio.iter().map(bounded).collect();
        let mut total = Self::none();
        let mut cells = COARSEST;
        let mut seen = Vec::new();
        loop {
            let level = Self::level(wo, &residual, noise, cells, &mut seen);
            for (w, r) in wo.iter().zip(&mut residual) {
                *r -= level.log_at(w.truncate());
            }
            total = if total.cells == 1 { level } else { total.refined().plus(&level) };
            if cells >= finest {
                return total;
            }
            cells *= 2;
        }
    }

    /// One lattice fitted to the residual.
    fn level(
        wo: &[DVec3],
        residual: &[f64],
        noise: f64,
        cells: usize,
        sums: &mut Vec<(f64, f64, f64)>,
    ) -> Self {
        let side = cells + 3;
        sums.clear();
        sums.resize(side * side, (0.0, 0.0, 0.0));
        for (w, &z) in wo.iter().zip(residual) {
            let (i, j, bx, by) = Self::basis(cells, w.truncate());
            let square: f64 =
                bx.iter().map(|b| b * b).sum::<f64>() * by.iter().map(|b| b * b).sum::<f64>();
            for (dj, y) in by.iter().enumerate() {
                for (di, x) in bx.iter().enumerate() {
                    let b = x * y;
                    let s = &mut sums[(j + dj) * side + i + di];
                    let b2 = b * b;
                    s.0 += b2 * b * z / square;
                    s.1 += b2;
                    s.2 += b2 * b2 * b2 / (square * square);
                }
            }
        }
        let control = sums
            .iter()
            .map(|&(z, w, v)| {
                if w <= 1e-9 {
                    return 0.0;
                }
                // Shrink what noise alone explains (positive-part James–Stein).
                let (value, variance) = (z / w, noise * noise * v / (w * w));
                (value * (1.0 - variance / (value * value).max(1e-30)).max(0.0)) as f32
            })
            .collect();
        Self { cells, control }
    }

    /// Lattice corner and the four cubic B-spline weights per axis at `u`.
    #[inline]
    fn basis(cells: usize, u: DVec2) -> (usize, usize, [f64; 4], [f64; 4]) {
        let t = (u + DVec2::ONE) * (0.5 * cells as f64);
        let last = cells as f64 - 1.0;
        let (fx, fy) = (t.x.floor().clamp(0.0, last), t.y.floor().clamp(0.0, last));
        (fx as usize, fy as usize, bspline(t.x - fx), bspline(t.y - fy))
    }

    /// log ratio at disk coordinates `u`, |u| ≤ 1.
    #[inline]
    pub fn log_at(&self, u: DVec2) -> f64 {
        let (i, j, bx, by) = Self::basis(self.cells, u);
        let side = self.cells + 3;
        let mut sum = 0.0;
        for (dj, y) in by.iter().enumerate() {
            let row = &self.control[(j + dj) * side + i..][..4];
            let r = bx[0] * f64::from(row[0])
                + bx[1] * f64::from(row[1])
                + bx[2] * f64::from(row[2])
                + bx[3] * f64::from(row[3]);
            sum += y * r;
        }
        sum
    }

    /// The same spline on a lattice twice as fine (cubic B-spline subdivision).
    pub(crate) fn refined(&self) -> Self {
        let (old, cells) = (self.cells + 3, self.cells * 2);
        let side = cells + 3;
        let halve = |get: &dyn Fn(usize) -> f32, k: usize| -> f32 {
            // New control k sits at old (k + 1)/2 in units of old controls.
            let i = k.div_ceil(2);
            if k % 2 == 1 {
                (get(i - 1) + 6.0 * get(i) + get((i + 1).min(old - 1))) / 8.0
            } else {
                (get(i) + get((i + 1).min(old - 1))) / 2.0
            }
        };
        let mut rows = vec![0.0f32; old * side];
        for j in 0..old {
            for k in 0..side {
                rows[j * side + k] = halve(&|i| self.control[j * old + i], k);
            }
        }
        let mut control = vec![0.0f32; side * side];
        for k in 0..side {
            for i in 0..side {
                control[k * side + i] = halve(&|j| rows[j * side + i], k);
            }
        }
        Self { cells, control }
    }

    fn plus(mut self, other: &Self) -> Self {
        for (a, b) in self.control.iter_mut().zip(&other.control) {
            *a += b;
        }
        self
    }
}

/// The four uniform cubic B-spline weights at t in [0, 1].
#[inline]
fn bspline(t: f64) -> [f64; 4] {
    let (t, s) = (t.clamp(0.0, 1.0), 1.0 - t.clamp(0.0, 1.0));
    [
        s * s * s / 6.0,
        (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
        (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0,
        t * t * t / 6.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> Vec<DVec3> {
        (0..20_000)
            .map(|i| {
                let t = f64::from(i);
                DVec2::new((t * 0.754_877_666_2).fract(), (t * 0.569_840_290_998).fract())
            })
            .map(|d| (d * 2.0 - DVec2::ONE).extend(0.0))
            .filter(|d| d.length() < 0.99)
            .collect()
    }

    #[test]
    fn refinement_keeps_the_spline() {
        let wo = points();
        let ratio: Vec<f64> = wo.iter().map(|w| 1.0 + 0.3 * (5.0 * w.x).sin() * w.y).collect();
        let a = Detail::fit(&wo, &ratio, 0.0, 8);
        let b = a.refined();
        for w in wo.iter().step_by(53) {
            let u = w.truncate();
            assert!((a.log_at(u) - b.log_at(u)).abs() < 1e-6, "{u}");
        }
    }

    #[test]
    fn a_smooth_ratio_is_reproduced() {
        let wo = points();
        let f = |w: &DVec3| 1.0 + 0.3 * (5.0 * w.x).sin() * w.y;
        let ratio: Vec<f64> = wo.iter().map(f).collect();
        let d = Detail::fit(&wo, &ratio, 0.0, 64);
        for w in wo.iter().step_by(31) {
            assert!((d.log_at(w.truncate()).exp() - f(w)).abs() < 0.004, "{w}");
        }
    }

    #[test]
    fn pure_noise_is_not_believed() {
        let wo = points();
        let mut state = 1u64;
        let ratio: Vec<f64> = wo
            .iter()
            .map(|_| {
                state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                1.0 + 0.1 * ((state >> 40) as f64 / 8_388_608.0 - 1.0)
            })
            .collect();
        let d = Detail::fit(&wo, &ratio, 0.058, 64);
        let rms = wo.iter().map(|w| d.log_at(w.truncate()).powi(2)).sum::<f64>() / wo.len() as f64;
        assert!(rms.sqrt() < 0.02, "{}", rms.sqrt());
    }
}
