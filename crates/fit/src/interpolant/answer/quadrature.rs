//! Directional-hemispherical values of the interpolant, by quadrature on the square of scattered directions.
//!
//! The square's map to the disk is bent along its diagonals, and at its centre most: midpoints of cells as
//! wide as a lobe's deviation err by 5 % there. So cells near lobes are integrated by Gauss's rule, and those
//! on a diagonal as the two triangles that it makes of them.

use std::ops::Range;

use bsdfkit::{DVec2, DVec3, Side};
use bsdfkit_sphere::concentric::{square_to_disk, square_to_hemisphere};

use crate::interpolant::answer::distribution::Distribution;
use crate::interpolant::answer::lobe_on_disk::Bow;
use bsdfkit_represent::Slice;

/// Cells across the square that are divided whatever there is, to see what is near them.
const ROOTS: usize = 5;
/// Levels below them that keys tell apart: those down to [`FINEST`].
const KEY_BITS: u32 = 9;
/// Largest cell, where there is no narrow lobe.
const LARGEST: f64 = 0.025;
/// Smallest cell: lobes down to 0.05 degrees are integrated to 1 %.
const FINEST: f64 = 1.0 / 2560.0;
/// Cells near a lobe are at most so many of its narrow deviations wide, that is from 0.7 to 1.4. With 2, values
/// jumped by 0.1 % where another lobe let cells be divided, and energy showed creases.
const WIDTH: f64 = 1.4;
/// Distances on the disk are at most so many times those on the square.
const STRETCH: f64 = 2.55;
/// Where energy is to be seen to a few per mille only: the least narrow deviation of lobes, and their least share of it.
const ROUGH: f64 = 0.006;
const ROUGH_SHARE: f64 = 3e-3;
/// Nodes are asked so many at a time: a multiple of what goes through evaluation together.
const BLOCK: usize = 4096;
/// Half the distance of Gauss's two points, as a share of the interval: 1/√12.
const GAUSS: f64 = 0.288_675_134_594_812_9;

/// Directions and their shares of the square, cell by cell.
#[derive(Default)]
pub(crate) struct Nodes {
    /// Unit vectors of the front hemisphere.
    pub(crate) wo: Vec<DVec3>,
    pub(crate) shares: Vec<f64>,
    /// The cells that the square is cut into, and the number of the first node of each.
    pub(crate) cells: Vec<(Cell, u32)>,
}

/// A square part of the unit square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cell {
    pub(crate) middle: DVec2,
    pub(crate) side: f64,
}

impl Cell {
    /// Its quarters, by [`Cell::quarter_of`].
    pub(crate) fn quarters(self) -> [Cell; 4] {
        [(-0.25, -0.25), (0.25, -0.25), (-0.25, 0.25), (0.25, 0.25)].map(|(x, y)| Cell {
            middle: self.middle + self.side * DVec2::new(x, y),
            side: 0.5 * self.side,
        })
    }

    /// The key of a point: cells in the order of [`Nodes::cells`] have keys that rise, and the last cell whose key is
    /// not above a point's holds it.
    pub(crate) fn key_at(s: DVec2) -> u64 {
        let last = (ROOTS - 1) as f64;
        let root = (s * ROOTS as f64).floor().clamp(DVec2::ZERO, DVec2::splat(last));
        let fine = ((s * ROOTS as f64 - root) * f64::from(1u32 << KEY_BITS)).floor();
        let [x, y] =
            fine.to_array().map(|c| c.clamp(0.0, f64::from((1u32 << KEY_BITS) - 1)) as u64);
        let spread = |c: u64| (0..KEY_BITS).map(|bit| (c >> bit & 1) << (2 * bit)).sum::<u64>();
        let root = root.x as u64 + ROOTS as u64 * root.y as u64;
        root << (2 * KEY_BITS) | spread(x) | spread(y) << 1
    }

    /// The key of its first point.
    pub(crate) fn key(self) -> u64 {
        // Not its corner, which rounding may put into a neighbour.
        Self::key_at(self.middle - DVec2::splat(0.4999 * self.side))
    }

    /// The number of the quarter that a point is in.
    pub(crate) fn quarter_of(self, s: DVec2) -> usize {
        usize::from(s.x >= self.middle.x) + 2 * usize::from(s.y >= self.middle.y)
    }
}

impl Nodes {
    fn push(&mut self, s: DVec2, share: f64) {
        self.wo.push(square_to_hemisphere(s, Side::Front));
        self.shares.push(share);
    }

    /// Those of the whole square, on which `lobes` are.
    pub(crate) fn of(lobes: &[Bow]) -> Self {
        let mut nodes = Self::default();
        let side = 1.0 / ROOTS as f64;
        for i in 0..ROOTS * ROOTS {
            let corner = DVec2::new((i % ROOTS) as f64, (i / ROOTS) as f64);
            nodes.cover(Cell { middle: (corner + DVec2::splat(0.5)) * side, side }, lobes);
        }
        nodes
    }

    /// Those of a cell. `lobes`: those that may be near it.
    fn cover(&mut self, cell: Cell, lobes: &[Bow]) {
        let Cell { middle, side } = cell;
        let u = square_to_disk(middle);
        let near: Vec<Bow> =
            lobes.iter().filter(|l| l.is_near(u, STRETCH * 0.7 * side)).copied().collect();
        let narrow = near.iter().any(|l| side > WIDTH * l.narrow) && side > FINEST;
        if side > 1.01 * LARGEST || narrow {
            return cell.quarters().into_iter().for_each(|quarter| self.cover(quarter, &near));
        }
        self.cells.push((cell, self.wo.len() as u32));
        if near.is_empty() {
            self.push(middle, side * side);
        } else {
            self.gauss(middle, side);
        }
    }

    /// Numbers of the nodes of a cell.
    pub(crate) fn of_cell(&self, cell: usize) -> Range<usize> {
        let first = |cell: usize| self.cells.get(cell).map_or(self.wo.len(), |c| c.1 as usize);
        first(cell)..first(cell + 1)
    }

    fn gauss(&mut self, middle: DVec2, side: f64) {
        let off = middle - DVec2::splat(0.5);
        if (off.x.abs() - off.y.abs()).abs() > 0.25 * side {
            for (x, y) in [(-GAUSS, -GAUSS), (GAUSS, -GAUSS), (-GAUSS, GAUSS), (GAUSS, GAUSS)] {
                self.push(middle + side * DVec2::new(x, y), 0.25 * side * side);
            }
            return;
        }
        let along = 0.5 * side * DVec2::new(1.0, off.x.signum() * off.y.signum());
        for across in [along.perp(), -along.perp()] {
            let corners = [along, -along, across];
            for corner in corners {
                // Two thirds of the way to a corner, one sixth to either of the others.
                let s = corners.iter().sum::<DVec2>() / 6.0 + 0.5 * corner;
                self.push(middle + s, side * side / 6.0);
            }
        }
    }
}

impl Distribution<'_> {
    /// ∫ f cos θₒ dωₒ over the scattered hemisphere.
    ///
    /// Accuracy: 0.3 % of lobes wider than 0.3 degrees. Cost: 2000 values of broad lobes, 10,000 and more of long narrow ones.
    pub fn directional_hemispherical(&self) -> f64 {
        self.added_up(&Nodes::of(&self.bows()))
    }

    /// The same to a few per mille: what lobes of little energy do within a cell is not looked at.
    pub(crate) fn roughly_hemispherical(&self) -> f64 {
        let mut bows = self.bows_of(ROUGH_SHARE);
        bows.iter_mut().for_each(|bow| bow.narrow = bow.narrow.max(ROUGH));
        self.added_up(&Nodes::of(&bows))
    }

    fn added_up(&self, nodes: &Nodes) -> f64 {
        let channels = self.channels();
        let mut values = vec![0.0f32; channels * BLOCK];
        let mut sum = 0.0;
        for (wo, shares) in nodes.wo.chunks(BLOCK).zip(nodes.shares.chunks(BLOCK)) {
            let wo: Vec<DVec3> = wo.iter().map(|&w| self.unfolded(w)).collect();
            let values = &mut values[..channels * wo.len()];
            Slice::eval(self, &wo, values);
            let luminance = values.iter().step_by(channels);
            sum += luminance.zip(shares).map(|(v, share)| f64::from(*v) * share).sum::<f64>();
        }
        sum * std::f64::consts::PI
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobe::{Covariance, Lobe};
    use std::f64::consts::FRAC_PI_2;

    /// ∫ over the disk of normal distributions that lie within it, by the nodes.
    fn integral(centre: DVec2, [narrow, wide]: [f64; 2]) -> f64 {
        let axis = |along: f64, deviation: f64| DVec2::from_angle(along) * deviation;
        let (n, w) = (axis(0.4, narrow), axis(0.4 + FRAC_PI_2, wide));
        let outer = |v: DVec2| Covariance { xx: v.x * v.x, xy: v.x * v.y, yy: v.y * v.y };
        let covariance = Covariance::combine(1.0, outer(n), 1.0, outer(w));
        let lobe = Lobe { mass: 1.0, mean: centre, covariance };
        let place = |q: DVec2| (q.length() < 1.0).then_some(q);
        let nodes = Nodes::of(&[Bow::of(&lobe, &place).unwrap()]);
        assert!((nodes.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let f = |w: &DVec3| {
            let d = DVec2::from_angle(-0.4).rotate(w.truncate() - centre);
            (-0.5 * ((d.x / narrow).powi(2) + (d.y / wide).powi(2))).exp()
        };
        let sum: f64 = nodes.wo.iter().map(f).zip(&nodes.shares).map(|(f, s)| f * s).sum();
        sum / (2.0 * narrow * wide)
    }

    #[test]
    fn lobes_are_whole_wherever_they_are() {
        let places =
            [(0.0, 0.0), (0.01, 0.005), (0.05, 0.05), (0.3, 0.3), (0.3, -0.1), (-0.5, 0.5)];
        for (x, y) in places {
            for extent in [
                [0.005, 0.005],
                [0.012, 0.012],
                [0.03, 0.03],
                [0.05, 0.1],
                [0.02, 0.08],
                [0.004, 0.09],
            ] {
                let off = integral(DVec2::new(x, y), extent) - 1.0;
                assert!(off.abs() < 3e-3, "{x} {y} {extent:?}: {off}");
            }
        }
    }
}
