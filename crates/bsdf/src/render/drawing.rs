//! What samples are drawn from: a density over the plane of a layer, up to the horizon.
//!
//! Convention: coordinates are the angle a and v = L(ρ) / L(R), L(ρ) = ln(1 + ρ/core), with ρ the distance from the peak and R
//! that to the horizon at the same angle. The density over (a, v) is stored at evenly spaced knots and linear between
//! them along both. Area of the plane is ρ (ρ + core) L(R) α′(a) da dv, α the true angle.

use super::chart::Stencil;
use super::layer::{Half, Shape};
use crate::DVec2;
use crate::words::Words;

/// Radial cells between one stored sum and the next.
pub(crate) const BLOCK: usize = 4;

/// The density tables of a layer, one a node.
#[derive(Clone, Debug)]
pub(crate) struct Drawing {
    pub(crate) angles: usize,
    pub(crate) radii: usize,
    /// The unit of `density`.
    pub(crate) unit: f64,
    /// Angles covered: 4 for a whole turn, 2 for half of one that stands for both.
    pub(crate) span: f64,
    /// (nodes, angles + 1, radii + 1).
    pub(crate) density: Words<Half>,
    /// (nodes, angles + 1, radii / BLOCK + 1): sums over v from 0 to every fourth knot, in cells.
    pub(crate) sums: Words<f32>,
    /// (nodes, angles + 1): sums over angles as well, in cells.
    pub(crate) running: Words<f32>,
}

/// A place drawn.
pub(crate) struct Drawn {
    pub(crate) angle: f64,
    pub(crate) v: f64,
}

impl Drawing {
    /// The sums of densities as they are stored.
    pub(crate) fn sums_of(shape: &Shape, density: &[Half]) -> (Vec<f32>, Vec<f32>) {
        let (columns, knots) = (shape.drawn_angles + 1, shape.drawn_radii + 1);
        let (mut sums, mut running) = (Vec::new(), Vec::new());
        for node in density.chunks_exact(columns * knots) {
            let mut totals = Vec::new();
            for column in node.chunks_exact(knots) {
                let mut sum = 0.0;
                for k in 0..shape.drawn_radii {
                    if k % BLOCK == 0 {
                        sums.push(sum as f32);
                    }
                    sum += 0.5 * (column[k].value() + column[k + 1].value());
                }
                sums.push(sum as f32);
                totals.push(f64::from(sum as f32));
            }
            let mut sum = 0.0;
            running.push(0.0);
            for pair in totals.windows(2) {
                sum += 0.5 * (pair[0] + pair[1]);
                running.push(sum as f32);
            }
        }
        (sums, running)
    }

    #[inline(always)]
    fn knots(&self) -> usize {
        self.radii + 1
    }

    #[inline(always)]
    fn blocks(&self) -> usize {
        self.radii / BLOCK + 1
    }

    #[inline(always)]
    fn half(&self, node: usize, column: usize, knot: usize) -> f64 {
        let at = (node * (self.angles + 1) + column) * self.knots() + knot;
        self.density.get(at).map_or(0.0, |h| h.value())
    }

    #[inline(always)]
    fn sum(&self, node: usize, column: usize, block: usize) -> f64 {
        let at = (node * (self.angles + 1) + column) * self.blocks() + block;
        self.sums.get(at).map_or(0.0, |&s| f64::from(s))
    }

    #[inline(always)]
    fn run(&self, nodes: &Stencil, column: usize) -> f64 {
        let of = |node| self.running.get(node * (self.angles + 1) + column);
        nodes.iter().map(|(node, w)| w * of(node).map_or(0.0, |&s| f64::from(s))).sum()
    }

    #[inline(always)]
    fn column(&self, nodes: &Stencil, column: usize) -> f64 {
        nodes.iter().map(|(node, w)| w * self.sum(node, column, self.blocks() - 1)).sum()
    }

    /// The integral over the whole hemisphere, of the blend of nodes.
    #[inline]
    pub(crate) fn mass(&self, nodes: &Stencil) -> f64 {
        self.run(nodes, self.angles) * self.unit * self.scale()
    }

    /// Area of a cell; twice that where it stands for two.
    #[inline(always)]
    fn scale(&self) -> f64 {
        4.0 / (self.angles * self.radii) as f64
    }

    /// The density over (a, v) of the whole turn.
    #[inline]
    pub(crate) fn density(&self, nodes: &Stencil, angle: f64, v: f64) -> f64 {
        let place = angle * (self.angles as f64 / self.span);
        let i = (place as usize).min(self.angles - 1);
        let tau = (place - i as f64).clamp(0.0, 1.0);
        let place = v.clamp(0.0, 1.0) * self.radii as f64;
        let k = (place as usize).min(self.radii - 1);
        let y = place - k as f64;
        let of = |(node, weight): (usize, f64)| {
            let low = (1.0 - tau) * self.half(node, i, k) + tau * self.half(node, i + 1, k);
            let high =
                (1.0 - tau) * self.half(node, i, k + 1) + tau * self.half(node, i + 1, k + 1);
            weight * ((1.0 - y) * low + y * high)
        };
        nodes.iter().map(of).sum::<f64>() * self.unit
    }

    /// Area over (a, v) of a cell.
    pub(crate) fn cell(&self) -> f64 {
        self.span / (self.angles * self.radii) as f64
    }

    /// A place by two numbers, each in \[0, 1): first the angle, then the distance from the peak.
    pub(crate) fn draw(&self, nodes: &Stencil, u: DVec2) -> Drawn {
        let (x, other_half) = match self.span < 4.0 {
            true if u.x >= 0.5 => (2.0 - 2.0 * u.x, true),
            true => (2.0 * u.x, false),
            false => (u.x, false),
        };
        let target = x * self.run(nodes, self.angles);
        let (mut low, mut high) = (0, self.angles);
        while high - low > 1 {
            let middle = (low + high) / 2;
            if self.run(nodes, middle) <= target { low = middle } else { high = middle }
        }
        let (left, right) = (self.column(nodes, low), self.column(nodes, low + 1));
        let tau = along(left, right, target - self.run(nodes, low));
        // Three nodes, two columns each.
        let mut columns = [(0, 0, 0.0); 6];
        for (n, (node, weight)) in nodes.iter().enumerate() {
            columns[2 * n] = (node, low, weight * (1.0 - tau));
            columns[2 * n + 1] = (node, low + 1, weight * tau);
        }
        let columns = &columns[..2 * nodes.count];
        let sum = |block| columns.iter().map(|&(n, c, w)| w * self.sum(n, c, block)).sum::<f64>();
        let half = |knot| columns.iter().map(|&(n, c, w)| w * self.half(n, c, knot)).sum::<f64>();
        let last = self.blocks() - 1;
        let target = u.y * sum(last);
        let (mut block, mut before) = (0, 0.0);
        while block + 1 < last {
            let next = sum(block + 1);
            if next > target {
                break;
            }
            (block, before) = (block + 1, next);
        }
        let mut rest = target - before;
        let mut k = BLOCK * block;
        let mut first = half(k);
        let mut place = self.radii as f64;
        for step in 0..BLOCK {
            let second = half(k + 1);
            let mass = 0.5 * (first + second);
            if rest < mass || step + 1 == BLOCK {
                place = k as f64 + along(first, second, rest);
                break;
            }
            (rest, first, k) = (rest - mass, second, k + 1);
        }
        let angle = (low as f64 + tau) * (self.span / self.angles as f64);
        let angle = if other_half { 4.0 - angle } else { angle };
        Drawn { angle, v: place / self.radii as f64 }
    }
}

/// Where in \[0, 1\] a density that goes from `left` to `right` has the integral `mass`.
#[inline(always)]
fn along(left: f64, right: f64, mass: f64) -> f64 {
    let root = (left * left + 2.0 * (right - left) * mass).max(0.0).sqrt();
    let sum = left + root;
    if sum > 0.0 { (2.0 * mass / sum).clamp(0.0, 1.0) } else { 0.5 }
}
