//! What one gluing says of a moving lobe: its masses, and where it is cut off.

use crate::interpolant::motion::edge_plan::Cliff;

/// What the gluing at one corner says.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Row {
    /// Masses at the corners.
    pub(crate) masses: [f64; 3],
    /// Corners toward which the lobe is cut off instead of fading.
    pub(crate) cut: [bool; 3],
    /// Pull of the corners, negative where the lobe is cut off: it is there where Σ λ pull > 0.
    pull: [f64; 3],
}

/// Half the width, in barycentric weight, of a cut half-way. A guess: a tenth of the spacing.
const CUT: f64 = 0.05;

impl Row {
    /// Without the [`pulled`](Self::pulled) cuts.
    pub(crate) fn new(masses: [f64; 3], cut: [bool; 3]) -> Self {
        Self { masses, cut, ..Self::default() }
    }

    /// Lets the cuts of the edges k, k + 1 of the triangle pass where `cliffs` has them, as shares of
    /// the way from k to k + 1. With one corner cut off the pulls of the others are odds against it,
    /// with two theirs against the third; so the cut is a straight line that meets both edges where
    /// it must.
    pub(crate) fn pulled(mut self, cliffs: [Option<Cliff>; 3]) -> Self {
        let cuts = self.cut.iter().filter(|&&c| c).count();
        self.pull = self.cut.map(|cut| if cut { -1.0 } else { 1.0 });
        if let Some(v) = (0..3).find(|&v| self.cut[v] == (cuts == 1)) {
            for other in [(v + 1) % 3, (v + 2) % 3] {
                let next = other == (v + 1) % 3;
                let way = match (if next { cliffs[v] } else { cliffs[other] }, next == self.cut[v])
                {
                    (Some(cliff), true) => cliff.new,
                    (Some(cliff), false) => cliff.gone,
                    (None, _) => 0.5,
                };
                let way = if next { way } else { 1.0 - way };
                self.pull[other] *= (1.0 - way) / way;
            }
        }
        self
    }

    /// What the cuts leave of the mass at `lambda`, in proportion to a fading lobe's; `way` past the
    /// rim takes the lobe nearer to its end.
    pub(crate) fn kept(&self, lambda: [f64; 3], way: f64) -> f64 {
        let missing: f64 = self.cut.iter().zip(lambda).map(|(&c, l)| f64::from(c) * l).sum();
        let present = 1.0 - missing;
        if present <= 0.0 {
            return 1.0;
        }
        // 1 at the corners that have the lobe, 0 where it ends.
        let (mut sum, mut all) = (0.0, 0.0);
        for (pull, l) in self.pull.iter().zip(lambda) {
            sum += l * pull;
            all += l * pull.abs();
        }
        ((sum / all - way) / (4.0 * CUT) + 0.5).clamp(0.0, 1.0) / present
    }
}
