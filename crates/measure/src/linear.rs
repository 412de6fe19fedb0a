//! Systems of linear equations that are symmetric and positive.

/// L of A = L Lᵀ, row-major.
pub struct Cholesky<'a> {
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
    pub fn new(a: &'a mut [f64], n: usize, least: f64) -> Option<Self> {
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
    pub fn solve(&self, b: &mut [f64]) {
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

/// Rounds of [`leading`]: vectors whose values differ by a tenth are apart by then, and others may be mixed.
const ROUNDS: usize = 100;

/// Unit vectors of the `count` largest eigenvalues of A (symmetric, no negative eigenvalue, `n` rows, row-major), the largest
/// first, by orthogonal iteration [GV13 §8.2.4].
///
/// Accuracy: the space that they span is that of the largest but for what differs from the next by less than a tenth.
/// Cost: 100 · `count` · n² multiplications.
pub fn leading(a: &[f64], n: usize, count: usize) -> Vec<Vec<f64>> {
    let mut found: Vec<Vec<f64>> = (0..count.min(n))
        .map(|k| (0..n).map(|i| ((i * (k + 1)) as f64 * 0.7 + 0.3).cos()).collect())
        .collect();
    orthonormalise(&mut found);
    for _ in 0..ROUNDS {
        for v in &mut found {
            let row = |row: &[f64]| row.iter().zip(&*v).map(|(a, x)| a * x).sum::<f64>();
            *v = a.chunks_exact(n).map(row).collect();
        }
        orthonormalise(&mut found);
    }
    found
}

/// Makes vectors orthonormal one after the other; where one has nothing left, an axis takes its place.
fn orthonormalise(vectors: &mut [Vec<f64>]) {
    for k in 0..vectors.len() {
        let (before, rest) = vectors.split_at_mut(k);
        let v = &mut rest[0];
        let n = v.len();
        let axis = |i: usize| (0..n).map(|j| f64::from(u8::from(i == j))).collect::<Vec<f64>>();
        let tries = std::iter::once(std::mem::take(v)).chain((0..n).map(axis));
        for mut candidate in tries {
            let whole = candidate.iter().map(|x| x * x).sum::<f64>().sqrt();
            // Twice, so that what rounding leaves goes, too.
            for b in before.iter().chain(before.iter()) {
                let along: f64 = candidate.iter().zip(b).map(|(x, b)| x * b).sum();
                candidate.iter_mut().zip(b).for_each(|(x, b)| *x -= along * b);
            }
            let length = candidate.iter().map(|x| x * x).sum::<f64>().sqrt();
            if length > 1e-9 * whole && length > 1e-150 {
                candidate.iter_mut().for_each(|x| *x /= length);
                *v = candidate;
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leading_vectors_span_what_a_was_made_of() {
        let n = 7;
        let made = [(9.0, 0.3), (4.0, 1.1), (1.0, 2.3)];
        let mut axes: Vec<Vec<f64>> =
            made.iter().map(|m| (0..n).map(|i| (i as f64 * m.1).sin() + 0.2).collect()).collect();
        orthonormalise(&mut axes);
        let a = |i: usize, j: usize| {
            made.iter().zip(&axes).map(|(m, v)| m.0 * v[i] * v[j]).sum::<f64>()
        };
        let matrix: Vec<f64> = (0..n * n).map(|k| a(k / n, k % n)).collect();
        let found = leading(&matrix, n, 5);
        for (v, truth) in found.iter().zip(&axes) {
            let dot: f64 = v.iter().zip(truth).map(|(a, b)| a * b).sum();
            assert!((dot.abs() - 1.0).abs() < 1e-9, "{dot}");
        }
        // The others have no value of their own; they are still orthonormal, of no matrix, too.
        for found in [found, leading(&vec![0.0; n * n], n, 5)] {
            for (k, v) in found.iter().enumerate() {
                for (l, w) in found.iter().enumerate() {
                    let dot: f64 = v.iter().zip(w).map(|(a, b)| a * b).sum();
                    assert!((dot - f64::from(u8::from(k == l))).abs() < 1e-9, "{k} {l} {dot}");
                }
            }
        }
    }

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
