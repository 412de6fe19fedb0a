//! Cells in blocks that lie close together: a lobe costs nothing on a block that it does not reach.

/// Cells go through the loops so many at once.
pub(super) const BLOCK: usize = 128;
/// Gaussians are cut here (exponent): 1e-8 of the peak.
pub(super) const CUT: f32 = 18.0;
/// What fills the last block lies here, out of reach.
pub(super) const FAR: f32 = 1e6;

/// Where the cells of each block lie.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    boxes: Vec<Bounds>,
}

/// Least and largest coordinates.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: [f32; 2],
    high: [f32; 2],
}

impl Blocks {
    /// Of cells at `x`, `y`, a whole number of blocks.
    pub(super) fn of(x: &[f32], y: &[f32]) -> Self {
        let around = |(x, y): (&[f32], &[f32])| {
            let none = Bounds { low: [f32::MAX; 2], high: [f32::MIN; 2] };
            x.iter().zip(y).filter(|(x, _)| **x < FAR).fold(none, |b, (&x, &y)| Bounds {
                low: [b.low[0].min(x), b.low[1].min(y)],
                high: [b.high[0].max(x), b.high[1].max(y)],
            })
        };
        Self { boxes: x.chunks(BLOCK).zip(y.chunks(BLOCK)).map(around).collect() }
    }

    /// Whether a Gaussian with variances `xx` and `yy` along the axes is above its cut somewhere in the block that begins
    /// with cell `first`. Of a slanted one it may be said that is not.
    #[inline(always)]
    pub(super) fn reached(&self, first: usize, mean: [f32; 2], variance: [f32; 2]) -> bool {
        let Bounds { low, high } = self.boxes[first / BLOCK];
        (0..2).all(|i| {
            let d = (low[i] - mean[i]).max(mean[i] - high[i]).max(0.0);
            // A little more, for rounding.
            d * d <= 2.001 * CUT * variance[i]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_out_of_reach_is_below_the_cut() {
        let x: Vec<f32> = (0..4 * BLOCK).map(|k| (k % 32) as f32 * 0.05).collect();
        let mut y: Vec<f32> = (0..4 * BLOCK).map(|k| (k / 32) as f32 * 0.05).collect();
        let mut x = x;
        x[4 * BLOCK - 1] = FAR;
        y[4 * BLOCK - 1] = FAR;
        let blocks = Blocks::of(&x, &y);
        let (mut skipped, mut near) = (0, 0);
        for (mean, (xx, xy, yy)) in [
            ([0.4, 0.1], (0.0004_f32, 0.0001_f32, 0.0009_f32)),
            ([1.0, 0.9], (0.001, -0.0012, 0.002)),
            ([-3.0, 0.0], (0.5, 0.0, 0.1)),
        ] {
            let determinant = xx * yy - xy * xy;
            for first in (0..x.len()).step_by(BLOCK) {
                let exponent = |k: usize| {
                    let (dx, dy) = (x[k] - mean[0], y[k] - mean[1]);
                    0.5 * (yy * dx * dx - 2.0 * xy * dx * dy + xx * dy * dy) / determinant
                };
                let least = (first..first + BLOCK).map(exponent).fold(f32::MAX, f32::min);
                if blocks.reached(first, mean, [xx, yy]) {
                    near += 1;
                } else {
                    skipped += 1;
                    assert!(least > CUT, "{mean:?} {first}: {least}");
                }
            }
        }
        assert!(skipped > 3 && near > 2, "{skipped} {near}");
    }
}
