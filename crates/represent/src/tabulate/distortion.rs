//! What a node of a tree loses when it becomes a leaf.

use super::trend::Trend;

/// Contrast, in units of a Lambertian of equal flux, at which an error counts twice, so that
/// glare survives that carries little flux. A guess, not measured.
const GLARE: f64 = 200.0;

/// Share that counts of an error which smooth lookup can follow: it has slopes from neighbours
/// only, and the stored value has none. Measured on brushed metal: smooth lookup errs 6 % more with
/// 1 (stored values alone); at 0.05 stored values err 4 to 8 % more, at 0.15 up to 1 %.
const UNFOLLOWED: f64 = 0.15;

/// What a node costs when it becomes a leaf.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Distortion {
    /// Share of each incidence's flux that lies in a wrong place, mean over incidences: L1 of the
    /// stored value.
    pub(super) error: f32,
    /// The same, less what smooth lookup follows, large errors counted more.
    pub(super) weighted: f32,
}

/// A cell of a subtree: its centre by dimension, −1 to 1 over the subtree, and half its width.
#[derive(Clone, Copy)]
pub(super) struct Cell {
    pub(super) centre: [f32; 4],
    pub(super) half: f32,
}

impl Cell {
    pub(super) const WHOLE: Self = Self { centre: [0.0; 4], half: 1.0 };

    /// One of 8 or 16 children; what lies beyond the third dimension of 8 does not count.
    pub(super) fn child(self, child: usize) -> Self {
        let half = 0.5 * self.half;
        let side = |d: usize| if child >> d & 1 == 1 { half } else { -half };
        Self { centre: std::array::from_fn(|d| self.centre[d] + side(d)), half }
    }
}

/// A value seen from above: mean f, spread, weight.
pub(super) struct Terminal {
    pub(super) value: f64,
    pub(super) spread: f64,
    /// Share of all incidences times projected solid angle.
    pub(super) measure: f64,
    /// 1 / flux.
    pub(super) inverse: f64,
    /// How much its incidences count beside others.
    pub(super) emphasis: f64,
    pub(super) centre: [f32; 4],
}

impl Terminal {
    /// Where the stored value is `mean` and smooth lookup could have `followed`.
    pub(super) fn distortion(&self, mean: f64, followed: f64) -> (f64, f64) {
        let stored = (self.value - mean).abs().max(self.spread) * self.inverse;
        let smooth = (self.value - followed).abs().max(UNFOLLOWED * self.spread) * self.inverse;
        let contrast = UNFOLLOWED * stored + (1.0 - UNFOLLOWED) * smooth;
        let weighted = contrast * (1.0 + contrast * std::f64::consts::PI / GLARE);
        (self.measure * stored, self.emphasis * self.measure * weighted)
    }
}

pub(super) fn distortion(
    terminals: &[Terminal],
    cell: Cell,
    mean: f64,
    trend: &Trend,
) -> Distortion {
    let (error, weighted) = terminals
        .iter()
        .map(|t| {
            let place = |d: usize| (t.centre[d] - cell.centre[d]) / cell.half;
            t.distortion(mean, trend.at(std::array::from_fn(place)))
        })
        .fold((0.0, 0.0), |(e, g), (error, weighted)| (e + error, g + weighted));
    Distortion { error: error as f32, weighted: weighted as f32 }
}
