//! Systems of linear equations that are symmetric and positive.

/// L of A = L Lᵀ, row-major.
pub(crate) struct Cholesky<'a> {
    l: &'a [f64],
    n: usize,
}

impl<'a> Cholesky<'a> {
    /// Factors A (`n` rows, row-major) in place; of it only the lower triangle is read.
    ///
    /// `None` where what a pivot is the root of does not exceed `least`: A is not positive, or
    /// nearly singular.
    /// Cost: n³ / 6 multiplications.
    #[inline]
    pub(crate) fn new(a: &'a mut [f64], n: usize, least: f64) -> Option<Self> {
        for j in 0..n {
            for i in j..n {
                let (upper, lower) = a.split_at(i * n);
                let row_j = if i == j { &lower[..j] } else { &upper[j * n..j * n + j] };
                let dot: f64 = lower[..j].iter().zip(row_j).map(|(x, y)| x * y).sum();
                let rest = a[i * n + j] - dot;
                if i > j {
                    a[i * n + j] = rest / a[j * n + j];
                } else if rest > least {
                    a[i * n + i] = rest.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(Self { l: a, n })
    }

    /// x of A x = b, in the place of b.
    #[inline]
    pub(crate) fn solve(&self, b: &mut [f64]) {
        let (l, n) = (self.l, self.n);
        for i in 0..n {
            let dot: f64 = (0..i).map(|k| l[i * n + k] * b[k]).sum();
            b[i] = (b[i] - dot) / l[i * n + i];
        }
        for i in (0..n).rev() {
            let dot: f64 = (i + 1..n).map(|k| l[k * n + i] * b[k]).sum();
            b[i] = (b[i] - dot) / l[i * n + i];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_what_it_was_made_of() {
        let n = 5;
        // M Mᵀ + 1 is positive.
        let m = |i: usize, j: usize| ((3 * i + 7 * j) % 5) as f64 - 2.0;
        let a = |i: usize, j: usize| {
            (0..n).map(|k| m(i, k) * m(j, k)).sum::<f64>() + f64::from(u8::from(i == j))
        };
        let mut matrix: Vec<f64> = (0..n * n).map(|k| a(k / n, k % n)).collect();
        let truth: Vec<f64> = (0..n).map(|k| k as f64 - 1.5).collect();
        let mut x: Vec<f64> = (0..n).map(|i| (0..n).map(|j| a(i, j) * truth[j]).sum()).collect();
        Cholesky::new(&mut matrix, n, 0.0).expect("positive").solve(&mut x);
        assert!(x.iter().zip(&truth).all(|(x, t)| (x - t).abs() < 1e-12), "{x:?}");
    }

    #[test]
    fn singular_negative_and_nan_are_refused() {
        assert!(Cholesky::new(&mut [1.0, 2.0, 2.0, 4.0], 2, 1e-12).is_none());
        assert!(Cholesky::new(&mut [-1.0], 1, 0.0).is_none());
        assert!(Cholesky::new(&mut [f64::NAN], 1, 0.0).is_none());
        assert!(Cholesky::new(&mut [1e-5], 1, 1e-4).is_none());
    }
}
