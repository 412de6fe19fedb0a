//! What samples of a continuous distribution are drawn from: its means over the quarters of cells.

use std::f64::consts::PI;

use bsdfkit::DVec2;
use bsdfkit_sphere::concentric::{disk_to_square, square_to_disk};
use bsdfkit_sphere::hilbert;

use crate::interpolant::answer::quadrature::{Cell, Nodes};

/// A table that is near f over the square of directions, whose cells are small where lobes are.
///
/// Equal areas of the square are equal projected solid angles, so a mean over a quarter of a cell is that
/// of f over its directions.
#[derive(Debug)]
pub(crate) struct Draws {
    /// Cells in the order of their keys, each with the density of its quarters, 1/sr.
    cells: Vec<(u64, Cell, [f64; 4])>,
    /// Numbers of cells along the Hilbert curve, and the sums of the totals of all down to each.
    order: Vec<(u32, f64)>,
    /// ∫ f |cos θ| dω.
    total: f64,
}

/// Part of a quarter's density that is the mean of its cell, and of every cell's that is the mean of all: where the
/// nodes saw nothing there may be something. Guesses; larger ones draw more often where there is little light.
const SHARED: [f64; 2] = [0.1, 1e-3];

/// Points of the square along a side that keys of the Hilbert curve tell apart.
const CURVE: f64 = (1u64 << 40) as f64;

impl Draws {
    /// Of the values at `nodes`, 1/sr.
    pub(crate) fn new(nodes: &Nodes, values: impl Fn(usize) -> f64) -> Self {
        let sum: f64 = nodes.shares.iter().enumerate().map(|(n, share)| share * values(n)).sum();
        let mut cells: Vec<(u64, Cell, [f64; 4])> = (0..nodes.cells.len())
            .map(|c| {
                let (cell, numbers) = (nodes.cells[c].0, nodes.of_cell(c));
                let mut quarters = [(0.0, 0.0); 4];
                for n in numbers {
                    let s = disk_to_square(nodes.wo[n].truncate());
                    let (value, share) = &mut quarters[cell.quarter_of(s)];
                    *value += nodes.shares[n] * values(n).max(0.0);
                    *share += nodes.shares[n];
                }
                let [all, area] = quarters.iter().fold([0.0, 0.0], |[v, s], q| [v + q.0, s + q.1]);
                let mean = all / area;
                let densities = quarters.map(|(value, share)| {
                    let own = if share > 0.0 { value / share } else { mean };
                    let [of_cell, of_all] = SHARED;
                    of_all * sum + (1.0 - of_all) * (of_cell * mean + (1.0 - of_cell) * own)
                });
                (cell.key(), cell, densities)
            })
            .collect();
        // Points of two triangles do not weigh the quarters alike: what is drawn adds up to the total all the same.
        let of = |(_, cell, quarters): &(u64, Cell, [f64; 4])| {
            0.25 * cell.side * cell.side * quarters.iter().sum::<f64>()
        };
        let drawn: f64 = cells.iter().map(of).sum();
        let scale = if drawn > 0.0 { sum / drawn } else { 0.0 };
        cells.iter_mut().for_each(|c| c.2 = c.2.map(|density| density * scale));
        let mut order: Vec<(u32, f64)> = (0..cells.len() as u32).map(|c| (c, 0.0)).collect();
        order.sort_by_cached_key(|&(c, _)| {
            (hilbert::fold(cells[c as usize].1.middle) * CURVE) as u64
        });
        let mut down = 0.0;
        for (c, sum) in &mut order {
            down += of(&cells[*c as usize]);
            *sum = down;
        }
        Self { cells, order, total: sum * PI }
    }

    /// ∫ f |cos θ| dω.
    pub(crate) fn total(&self) -> f64 {
        self.total
    }

    /// The cell that a point of the disk is in.
    fn find(&self, disk: DVec2) -> Option<(Cell, usize, &[f64; 4])> {
        let s = disk_to_square(disk);
        let after = self.cells.partition_point(|c| c.0 <= Cell::key_at(s));
        let (_, cell, quarters) = self.cells.get(after.saturating_sub(1))?;
        Some((*cell, cell.quarter_of(s), quarters))
    }

    /// The density per projected solid angle at a point of the disk, times the total: 1/sr.
    pub(crate) fn density(&self, disk: DVec2) -> f64 {
        self.find(disk).map_or(0.0, |(_, quarter, quarters)| quarters[quarter])
    }

    /// The projected solid angle of the quarter that a point of the disk is in.
    pub(crate) fn projected_solid_angle(&self, disk: DVec2) -> Option<f64> {
        self.find(disk).map(|(cell, ..)| 0.25 * PI * cell.side * cell.side)
    }

    /// The least and the greatest of all.
    pub(crate) fn projected_solid_angles(&self) -> (f64, f64) {
        let sizes = self.cells.iter().map(|c| 0.25 * PI * c.1.side * c.1.side);
        sizes.fold((f64::INFINITY, 0.0), |(least, most), s| (s.min(least), s.max(most)))
    }

    /// The point of the disk for `u` in [0, 1); `None` where nothing scatters.
    pub(crate) fn sample(&self, u: f64) -> Option<DVec2> {
        let all = self.order.last()?.1;
        if all.is_nan() || all <= 0.0 {
            return None;
        }
        let aim = (u.clamp(0.0, 1.0 - f64::EPSILON)) * all;
        let at = self.order.partition_point(|o| o.1 <= aim).min(self.order.len() - 1);
        let before = if at > 0 { self.order[at - 1].1 } else { 0.0 };
        let (_, cell, quarters) = &self.cells[self.order[at].0 as usize];
        let quarter_area = 0.25 * cell.side * cell.side;
        let mut left = (aim - before) / quarter_area;
        // Once round, so that neighbours in u stay close.
        let mut chosen = (3, 0.5);
        for quarter in [0, 1, 3, 2] {
            let density = quarters[quarter];
            if left < density {
                chosen = (quarter, left / density);
                break;
            }
            left -= density;
        }
        let quarter = cell.quarters()[chosen.0];
        let within = hilbert::unfold(chosen.1.clamp(0.0, 1.0 - f64::EPSILON));
        let s = quarter.middle + quarter.side * (within - DVec2::splat(0.5));
        Some(square_to_disk(s.clamp(DVec2::ZERO, DVec2::ONE)))
    }
}
