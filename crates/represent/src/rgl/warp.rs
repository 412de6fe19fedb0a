//! A density on the square, linear between its nodes, and the map that makes it even.

use bsdfkit_sphere::DVec2;

/// Values at nodes, the last of each row and column on the far border; rows are y. Scaled to an integral of 1.
#[derive(Clone, Debug)]
pub(super) struct Warp {
    /// Nodes of a row.
    width: usize,
    values: Vec<f64>,
    /// Integral along each row.
    rows: Vec<f64>,
    /// Integral below each row.
    below: Vec<f64>,
    /// Integral of each row before each node.
    before: Vec<f64>,
}

impl Warp {
    /// `values` are rows of `width` nodes, at least two of each; none is negative, and not all are 0.
    pub(super) fn new(width: usize, mut values: Vec<f64>) -> Self {
        let height = values.len() / width;
        let mut before = vec![0.0; values.len()];
        for (row, before) in values.chunks(width).zip(before.chunks_mut(width)) {
            sums(row, 1.0 / (width - 1) as f64, before);
        }
        let mut rows: Vec<f64> = before.chunks(width).map(|b| b[width - 1]).collect();
        let mut below = vec![0.0; height];
        sums(&rows, 1.0 / (height - 1) as f64, &mut below);
        let scale = 1.0 / below[height - 1];
        for v in [&mut values, &mut rows, &mut below, &mut before].into_iter().flatten() {
            *v *= scale;
        }
        Self { width, values, rows, below, before }
    }

    /// Values at the nodes.
    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// A point spread evenly → one spread as the density, and the density there: first the row, then the column.
    pub(super) fn at(&self, even: DVec2) -> (DVec2, f64) {
        let n = self.width;
        let cells = [n - 1, self.rows.len() - 1].map(|c| c as f64);
        let j = last_not_above(&self.below, even.y);
        let y = place(self.rows[j], self.rows[j + 1], (even.y - self.below[j]) * cells[1]);
        let mix =
            |table: &[f64], i: usize| (1.0 - y) * table[j * n + i] + y * table[(j + 1) * n + i];
        let before: Vec<f64> = (0..n).map(|i| mix(&self.before, i)).collect();
        let target = even.x * before[n - 1];
        let i = last_not_above(&before, target);
        let (left, right) = (mix(&self.values, i), mix(&self.values, i + 1));
        let x = place(left, right, (target - before[i]) * cells[0]);
        let point = DVec2::new((i as f64 + x) / cells[0], (j as f64 + y) / cells[1]);
        (point, (1.0 - x) * left + x * right)
    }

    /// The way back through the density that is `parts`, each with its weight, added up: a point spread as the density →
    /// one spread evenly. All have as many nodes; weights add up to 1.
    pub(super) fn back(parts: &[(f64, &Warp)], point: DVec2) -> DVec2 {
        let Some((_, first)) = parts.first() else { return point };
        let (width, height) = (first.width, first.rows.len());
        let cell = |along: f64, nodes: usize| {
            let along = along.clamp(0.0, 1.0) * (nodes - 1) as f64;
            let k = (along as usize).min(nodes - 2);
            (k, along - k as f64)
        };
        let ((i, x), (j, y)) = (cell(point.x, width), cell(point.y, height));
        let sum = |of: &dyn Fn(&Warp) -> f64| parts.iter().map(|(w, p)| w * of(p)).sum::<f64>();
        // ∫ of what runs from a to b, up to a share t of a step.
        let part =
            |a: f64, b: f64, t: f64, nodes: usize| t * (a + 0.5 * t * (b - a)) / (nodes - 1) as f64;
        let row = |j: usize| sum(&|p| p.rows[j]);
        let even_y = sum(&|p| p.below[j]) + part(row(j), row(j + 1), y, height);
        let mix = |of: &dyn Fn(&Warp, usize) -> f64| {
            (1.0 - y) * sum(&|p| of(p, j * width)) + y * sum(&|p| of(p, (j + 1) * width))
        };
        let [left, right] = [i, i + 1].map(|i| mix(&|p, row| p.values[row + i]));
        let before = mix(&|p, row| p.before[row + i]);
        let all = mix(&|p, row| p.before[row + width - 1]);
        let even_x = (before + part(left, right, x, width)) / all;
        DVec2::new(if all > 0.0 { even_x } else { point.x }, even_y)
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
        assert_eq!(warp.rows.len(), n);
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

    #[test]
    fn the_way_back_leads_back() {
        // Not square, with zeros.
        let of = |width: usize, height: usize, seed: usize| {
            let value = |k: usize| ((k * 7 + seed) % 5) as f64;
            Warp::new(width, (0..width * height).map(value).collect())
        };
        let warp = of(6, 4, 1);
        for k in 0..400 {
            let even = DVec2::new(f64::from(k % 20) + 0.5, f64::from(k / 20) + 0.5) / 20.0;
            let back = Warp::back(&[(1.0, &warp)], warp.at(even).0);
            assert!((back - even).length() < 1e-9, "{even}: {back}");
        }
        // A mixture is the warp of the mixed density.
        let other = of(6, 4, 3);
        let mixed = warp.values.iter().zip(&other.values).map(|(a, b)| 0.3 * a + 0.7 * b);
        let mixed = Warp::new(6, mixed.collect());
        for k in 0..400 {
            let point = DVec2::new(f64::from(k % 20) + 0.5, f64::from(k / 20) + 0.5) / 20.0;
            let parts = [(0.3, &warp), (0.7, &other)];
            let off = Warp::back(&parts, point) - Warp::back(&[(1.0, &mixed)], point);
            assert!(off.length() < 1e-12);
        }
    }
}
