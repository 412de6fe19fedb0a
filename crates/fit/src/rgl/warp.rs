//! A density on the square, linear between its nodes, and the map that makes it even.

use bsdfkit_sphere::DVec2;

/// Values at n × n nodes, the last on the far border; rows are y. Scaled to an integral of 1.
#[derive(Clone, Debug)]
pub(super) struct Warp {
    n: usize,
    values: Vec<f64>,
    /// Integral along each row.
    rows: Vec<f64>,
    /// Integral below each row.
    below: Vec<f64>,
    /// Integral of each row before each node.
    before: Vec<f64>,
}

impl Warp {
    /// `values` are above 0.
    pub(super) fn new(n: usize, mut values: Vec<f64>) -> Self {
        let step = 1.0 / (n - 1) as f64;
        let mut before = vec![0.0; n * n];
        for (row, before) in values.chunks(n).zip(before.chunks_mut(n)) {
            sums(row, step, before);
        }
        let mut rows: Vec<f64> = before.chunks(n).map(|b| b[n - 1]).collect();
        let mut below = vec![0.0; n];
        sums(&rows, step, &mut below);
        let scale = 1.0 / below[n - 1];
        for v in [&mut values, &mut rows, &mut below, &mut before].into_iter().flatten() {
            *v *= scale;
        }
        Self { n, values, rows, below, before }
    }

    /// Values at the nodes.
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// A point spread evenly → one spread as the density, and the density there: first the row, then the column.
    pub(super) fn at(&self, even: DVec2) -> (DVec2, f64) {
        let n = self.n;
        let cells = (n - 1) as f64;
        let j = last_not_above(&self.below, even.y);
        let y = place(self.rows[j], self.rows[j + 1], (even.y - self.below[j]) * cells);
        let mix =
            |table: &[f64], i: usize| (1.0 - y) * table[j * n + i] + y * table[(j + 1) * n + i];
        let before: Vec<f64> = (0..n).map(|i| mix(&self.before, i)).collect();
        let target = even.x * before[n - 1];
        let i = last_not_above(&before, target);
        let (left, right) = (mix(&self.values, i), mix(&self.values, i + 1));
        let x = place(left, right, (target - before[i]) * cells);
        let point = DVec2::new(i as f64 + x, j as f64 + y) / cells;
        (point, (1.0 - x) * left + x * right)
    }
}

/// Running integrals of what is linear between nodes.
fn sums(values: &[f64], step: f64, out: &mut [f64]) {
    let mut sum = 0.0;
    for (k, out) in out.iter_mut().enumerate() {
        if k > 0 {
            sum += 0.5 * (values[k - 1] + values[k]) * step;
        }
        *out = sum;
    }
}

/// The last but one at most of rising numbers that is not above `target`.
fn last_not_above(rising: &[f64], target: f64) -> usize {
    let after = rising.partition_point(|v| *v <= target);
    after.saturating_sub(1).min(rising.len() - 2)
}

/// Where between 0 and 1 the integral of what runs from `a` to `b` is `mass`.
fn place(a: f64, b: f64, mass: f64) -> f64 {
    let even = (a - b).abs() < 1e-6 * (a + b);
    let found = if even {
        2.0 * mass / (a + b)
    } else {
        (a - (a * a - 2.0 * mass * (a - b)).max(0.0).sqrt()) / (a - b)
    };
    if found.is_finite() { found.clamp(0.0, 1.0) } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warped_grid_has_the_density() {
        let n = 5;
        let values: Vec<f64> = (0..n * n).map(|k| 0.2 + ((k * 7) % 11) as f64).collect();
        let warp = Warp::new(n, values);
        let mean = |f: &dyn Fn(DVec2) -> f64| {
            let m = 400;
            let points = (0..m * m).map(|k| DVec2::new((k % m) as f64 + 0.5, (k / m) as f64 + 0.5));
            points.map(|p| f(p / m as f64)).sum::<f64>() / (m * m) as f64
        };
        // Means of 1 / density and of x y / density over warped points are those over the square.
        let ones = mean(&|p| 1.0 / warp.at(p).1);
        let products = mean(&|p| {
            let (q, density) = warp.at(p);
            q.x * q.y / density
        });
        assert!((ones - 1.0).abs() < 1e-3, "{ones}");
        assert!((products - 0.25).abs() < 1e-3, "{products}");
    }

    #[test]
    fn corners_stay() {
        let warp = Warp::new(3, vec![1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0]);
        for corner in [DVec2::ZERO, DVec2::ONE, DVec2::X, DVec2::Y] {
            assert!((warp.at(corner).0 - corner).length() < 1e-9);
        }
    }
}
