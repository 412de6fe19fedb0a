//! What the lobes leave over: the smooth ratio of data to model over the hemisphere.

use bsdfkit_sphere::DVec2;

/// A bicubic spline of log(data / model) over the equal-area map of the hemisphere.
///
/// On the disk of direction cosines cells would be four times as high at 75 degrees as at the
/// normal: peaks there were pulled 2 % toward what surrounds them, and fits erred three times as
/// much.
#[derive(Clone, Debug, PartialEq)]
pub struct Detail {
    /// Cells across.
    pub(super) cells: usize,
    /// (cells + 3)² control values, row-major in y.
    pub(super) control: Vec<f32>,
}

/// Lattice corner and the four cubic B-spline weights per axis.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Basis {
    pub(super) i: usize,
    pub(super) j: usize,
    pub(super) x: [f32; 4],
    pub(super) y: [f32; 4],
}

impl Basis {
    /// Of a lattice with so many `cells` across at `p` of the map.
    #[inline(always)]
    pub(super) fn at(cells: usize, p: DVec2) -> Self {
        let t = (p + DVec2::ONE) * (0.5 * cells as f64);
        let last = cells as f64 - 1.0;
        // Not `floor`, which is a call on the plainest processors.
        let (i, j) = (t.x.clamp(0.0, last) as i32, t.y.clamp(0.0, last) as i32);
        let weights = |t: f64, i: i32| bspline((t - f64::from(i)) as f32);
        Self { i: i as usize, j: j as usize, x: weights(t.x, i), y: weights(t.y, j) }
    }
}

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

    /// log ratio at disk coordinates `u`, |u| ≤ 1, to 1e-6 of the control values around.
    #[inline(always)]
    pub fn log_at(&self, u: DVec2) -> f64 {
        self.log_each([u])[0]
    }

    /// [`Detail::log_at`] of several places.
    #[inline(always)]
    pub(crate) fn log_each<const N: usize>(&self, u: [DVec2; N]) -> [f64; N] {
        // All bases first: their square roots and divisions then overlap.
        let mut bases = [Basis::default(); N];
        for (basis, u) in bases.iter_mut().zip(u) {
            *basis = Basis::at(self.cells, place(u));
        }
        let mut logs = [0.0; N];
        for (log, basis) in logs.iter_mut().zip(bases) {
            *log = self.log_by(basis);
        }
        logs
    }

    #[inline(always)]
    pub(super) fn log_by(&self, Basis { i, j, x, y }: Basis) -> f64 {
        let side = self.cells + 3;
        let rows = &self.control[j * side + i..][..3 * side + 4];
        // Four columns side by side.
        let mut columns = [0.0f32; 4];
        for (k, y) in y.into_iter().enumerate() {
            for (sum, c) in columns.iter_mut().zip(&rows[k * side..][..4]) {
                *sum += y * c;
            }
        }
        for (sum, x) in columns.iter_mut().zip(x) {
            *sum *= x;
        }
        let [a, b, c, d] = columns;
        f64::from((a + b) + (c + d))
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
}

/// Where disk coordinates `u` are on Lambert's equal-area map of the hemisphere, scaled to the unit
/// disk.
#[inline(always)]
pub(super) fn place(u: DVec2) -> DVec2 {
    let z = (1.0 - u.length_squared()).max(0.0).sqrt();
    u / (1.0 + z).sqrt()
}

/// The four uniform cubic B-spline weights at t in [0, 1].
#[inline(always)]
fn bspline(t: f32) -> [f32; 4] {
    const SIXTH: f32 = 1.0 / 6.0;
    let t = t.clamp(0.0, 1.0);
    let s = 1.0 - t;
    let (t2, s2) = (t * t, s * s);
    let inner = |x2: f32, x: f32| (2.0 / 3.0) - x2 * (1.0 - 0.5 * x);
    [SIXTH * s2 * s, inner(t2, t), inner(s2, s), SIXTH * t2 * t]
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::sequence::plastic;

    #[test]
    fn refinement_keeps_the_spline() {
        let control = (0..11 * 11).map(|k| (k as f32 * 0.7).sin()).collect();
        let a = Detail::from_control(control).expect("square");
        let b = a.refined();
        for u in (0..400).map(|k| plastic(k) * 2.0 - DVec2::ONE).filter(|u| u.length() < 1.0) {
            assert!((a.log_at(u) - b.log_at(u)).abs() < 2e-6, "{u}");
        }
    }
}
