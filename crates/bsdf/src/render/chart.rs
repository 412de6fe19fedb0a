//! Incident directions ↔ nodes.

use serde::{Deserialize, Serialize};

use super::incidence::{Incidence, LOWEST, Turn};
use crate::{DVec2, DVec3, Error, Result};

/// What leaves f as it is when applied to both directions, so that fewer nodes do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fold {
    /// Nothing.
    None,
    /// x → −x.
    MirrorX,
    /// y → −y.
    MirrorY,
    /// Both of these.
    Quadrants,
    /// (x, y) → (−x, −y).
    HalfTurn,
    /// Every rotation about the normal.
    Isotropic,
    /// Every rotation about the normal and every reflection.
    IsotropicMirrored,
}

impl Fold {
    /// All of them, the one that does nothing first.
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::MirrorX,
        Self::MirrorY,
        Self::Quadrants,
        Self::HalfTurn,
        Self::Isotropic,
        Self::IsotropicMirrored,
    ];

    /// Whether incident directions are told apart by their polar angle alone.
    pub fn is_isotropic(self) -> bool {
        matches!(self, Self::Isotropic | Self::IsotropicMirrored)
    }

    /// How far the squares' coordinates go: from these to 1.
    fn lowest(self) -> DVec2 {
        match self {
            Self::None => DVec2::NEG_ONE,
            Self::MirrorX => DVec2::new(0.0, -1.0),
            Self::MirrorY | Self::HalfTurn => DVec2::new(-1.0, 0.0),
            Self::Quadrants | Self::Isotropic | Self::IsotropicMirrored => DVec2::ZERO,
        }
    }

    #[inline(always)]
    fn turn(self, xy: DVec2) -> Turn {
        let flip = |on: bool| if on { -1.0 } else { 1.0 };
        let (x, y) = (xy.x < 0.0, xy.y < 0.0);
        let (x, y) = match self {
            Self::None => return Turn::IDENTITY,
            Self::MirrorX => (flip(x), 1.0),
            Self::MirrorY => (1.0, flip(y)),
            Self::Quadrants => (flip(x), flip(y)),
            Self::HalfTurn => (flip(y), flip(y)),
            Self::Isotropic | Self::IsotropicMirrored => {
                let length = xy.length();
                let r = if length > 0.0 { xy / length } else { DVec2::X };
                return Turn { x: r, y: DVec2::new(-r.y, r.x) };
            }
        };
        Turn { x: DVec2::new(x, 0.0), y: DVec2::new(0.0, y) }
    }
}

/// Where the nodes of incident directions are: on a square, or along a line for isotropic materials.
///
/// Convention: with r = sin θ, u = r (1 + grazing·z₀) / (√(1 + z) (1 + grazing·z)) up to a factor, 0 at the normal and 1 at
/// 89.4 degrees; on the square the larger of |X| and |Y| is u, and X : Y as x : y. `grazing` draws nodes
/// from the normal to the horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chart {
    pub(crate) fold: Fold,
    /// From the normal to the horizon.
    pub(crate) intervals: usize,
    pub(crate) grazing: f64,
    /// 1 / u at the horizon.
    scale: f64,
    /// Where the first node is on the square.
    lowest: DVec2,
    /// Nodes along x and along y.
    sides: (usize, usize),
}

/// The nodes about an incident direction and their weights, which sum to 1. Of a line the third is the first again, and
/// weighs nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stencil {
    pub(crate) nodes: [usize; 3],
    pub(crate) weights: [f64; 3],
}

impl Stencil {
    #[inline(always)]
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, f64)> {
        self.nodes.into_iter().zip(self.weights)
    }
}

/// A whole number from 0 to `most`, whatever x is.
#[inline(always)]
pub(crate) fn whole(x: f64, most: usize) -> usize {
    (x as u32 as usize).min(most)
}

impl Chart {
    /// Most intervals from the normal to the horizon.
    pub const MOST: usize = 512;

    /// A chart of so many intervals from the normal to the horizon.
    ///
    /// Errors: argument, unless 1 ≤ `intervals` ≤ [`Chart::MOST`] and 0 ≤ `grazing` ≤ 100.
    pub fn new(fold: Fold, intervals: usize, grazing: f64) -> Result<Self> {
        if !(1..=Self::MOST).contains(&intervals) {
            let most = Self::MOST;
            return Err(Error::argument(format!(
                "intervals: expected 1 to {most}, found {intervals}"
            )));
        }
        if !(0.0..=100.0).contains(&grazing) {
            return Err(Error::argument(format!("grazing: expected 0 to 100, found {grazing}")));
        }
        let lowest = fold.lowest();
        let mut chart = Self { fold, intervals, grazing, scale: 1.0, lowest, sides: (0, 0) };
        chart = chart.with_intervals(intervals);
        chart.scale = 1.0 / chart.radius((1.0 - LOWEST * LOWEST).sqrt(), LOWEST);
        Ok(chart)
    }

    /// The same with so many times as many intervals, at most [`Chart::MOST`].
    #[must_use]
    pub fn refined(self, times: usize) -> Self {
        self.with_intervals(self.intervals.saturating_mul(times).clamp(1, Self::MOST))
    }

    /// The same, as if it had that fold: one that has the same nodes.
    #[inline(always)]
    pub(crate) fn with_fold(self, fold: Fold) -> Self {
        Self { fold, ..self }
    }

    fn with_intervals(self, intervals: usize) -> Self {
        let along = |lowest: f64| if lowest < 0.0 { 2 * intervals + 1 } else { intervals + 1 };
        let rows = if self.fold.is_isotropic() { 1 } else { along(self.lowest.y) };
        Self { intervals, sides: (along(self.lowest.x), rows), ..self }
    }

    /// The symmetry that folds incident directions together.
    pub fn fold(&self) -> Fold {
        self.fold
    }

    /// How much finer nodes stand toward the horizon.
    pub fn grazing(&self) -> f64 {
        self.grazing
    }

    /// Intervals from the normal to the horizon.
    pub fn intervals(&self) -> usize {
        self.intervals
    }

    /// How many nodes.
    pub fn nodes(&self) -> usize {
        self.sides.0 * self.sides.1
    }

    /// The nodes whose blend stands for an incident direction, and their weights.
    pub fn blend(&self, wi: DVec3) -> Vec<(usize, f64)> {
        let found = self.around(self.square(&self.incidence(wi)));
        found.iter().filter(|(_, weight)| *weight > 0.0).collect()
    }

    #[inline(always)]
    fn radius(&self, r: f64, z: f64) -> f64 {
        r * self.scale / ((1.0 + z).sqrt() * (1.0 + self.grazing * z))
    }

    /// The incident direction of a node.
    pub fn direction(&self, node: usize) -> DVec3 {
        let columns = self.sides.0;
        let at = DVec2::new((node % columns) as f64, (node / columns) as f64);
        let square = (self.lowest + at / self.intervals as f64).clamp(DVec2::NEG_ONE, DVec2::ONE);
        let u = square.abs().max_element();
        let z = self.cosine(u);
        let along = if u > 0.0 { square.normalize() } else { DVec2::X };
        (along * (1.0 - z * z).max(0.0).sqrt()).extend(z)
    }

    /// The cosine at which u is reached, by halving.
    fn cosine(&self, u: f64) -> f64 {
        let (mut low, mut high) = (LOWEST, 1.0);
        for _ in 0..60 {
            let z: f64 = 0.5 * (low + high);
            if self.radius((1.0 - z * z).max(0.0).sqrt(), z) > u { low = z } else { high = z }
        }
        if u <= 0.0 { 1.0 } else { 0.5 * (low + high) }
    }

    /// A known direction as tables see it.
    #[inline(always)]
    pub(crate) fn incidence(&self, w: DVec3) -> Incidence {
        let (xy, z) = Incidence::raised(w);
        let turn = self.fold.turn(xy);
        Incidence { xy: turn.apply(xy), z, turn }
    }

    /// The place of an incidence on the square; of isotropic materials along x.
    #[inline(always)]
    pub(crate) fn square(&self, at: &Incidence) -> DVec2 {
        let rise = 1.0 + at.z;
        let radius = (at.xy.length_squared() * rise).sqrt() * self.scale;
        let below = rise * (1.0 + self.grazing * at.z);
        if self.fold.is_isotropic() {
            return DVec2::new(radius / below, 0.0);
        }
        let largest = at.xy.abs().max_element().max(f64::MIN_POSITIVE.sqrt());
        at.xy * (radius / (below * largest))
    }

    /// The nodes about a place of the square.
    #[inline(always)]
    pub(crate) fn around(&self, square: DVec2) -> Stencil {
        let n = self.intervals;
        let (columns, rows) = self.sides;
        let place = (square - self.lowest) * n as f64;
        let i = whole(place.x, columns - 2);
        let x = (place.x - i as f64).clamp(0.0, 1.0);
        if self.fold.is_isotropic() {
            return Stencil { nodes: [i, i + 1, i], weights: [1.0 - x, x, 0.0] };
        }
        let j = whole(place.y, rows - 2);
        let y = (place.y - j as f64).clamp(0.0, 1.0);
        // Lines of equal u have a corner on the diagonals: there cells are parted, in the direction from the middle.
        let half = |lowest: f64, k: usize| lowest >= 0.0 || k >= n;
        let main = half(self.lowest.x, i) == half(self.lowest.y, j);
        let x = if main { x } else { 1.0 - x };
        let (near, far) = if main { (i, i + 1) } else { (i + 1, i) };
        let row = j * columns;
        let wide = x >= y;
        let (large, small) = if wide { (x, y) } else { (y, x) };
        let middle = if wide { row + far } else { row + columns + near };
        Stencil {
            nodes: [row + near, middle, row + columns + far],
            weights: [1.0 - large, large - small, small],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_found_where_it_is() {
        for fold in Fold::ALL {
            let chart = Chart::new(fold, 5, 1.0).unwrap();
            for node in 0..chart.nodes() {
                let at = chart.incidence(chart.direction(node));
                let found = chart.around(chart.square(&at));
                let share: f64 = found.iter().filter(|(n, _)| *n == node).map(|(_, w)| w).sum();
                // Below y = 0 a half turn has two names for one direction.
                let twice = fold == Fold::HalfTurn && at.xy.y.abs() < 1e-9;
                assert!(share > 1.0 - 1e-6 || twice, "{fold:?} {node}: {found:?}");
            }
        }
    }

    #[test]
    fn weights_are_linear_on_the_square() {
        let chart = Chart::new(Fold::None, 4, 0.7).unwrap();
        for k in 0..2000 {
            let angle = f64::from(k) * 0.37;
            let z = 0.011 + 0.98 * f64::from(k % 97) / 97.0;
            let w = (DVec2::from_angle(angle) * (1.0 - z * z).sqrt()).extend(z);
            let found = chart.around(chart.square(&chart.incidence(w)));
            let sum: f64 = found.iter().map(|(_, w)| w).sum();
            assert!((sum - 1.0).abs() < 1e-12 && found.iter().all(|(_, w)| w >= -1e-12));
            // u of the nodes, blended, is u.
            let u = |w: DVec3| chart.radius(w.truncate().length(), w.z.max(LOWEST));
            let blended: f64 = found.iter().map(|(n, weight)| weight * u(chart.direction(n))).sum();
            assert!((blended - u(w)).abs() < 1e-6, "{blended} {}", u(w));
        }
    }
}
