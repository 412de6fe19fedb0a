//! What samples are drawn from: a density over the plane of a layer, up to the horizon.
//!
//! Convention: coordinates are the angle a and v = L(ρ) / L(R), L(ρ) = ln(1 + ρ/core), with ρ the distance from the peak and R
//! that to the horizon at the same angle. The density over (a, v) is stored at evenly spaced knots and linear between
//! them along both. Area of the plane is ρ (ρ + core) L(R) α′(a) da dv, α the true angle.

use super::chart::Stencil;
use super::half::Half;
use super::layer::Read;
use super::shape::Shape;
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

    /// The integral over the whole hemisphere, of the blend of nodes.
    #[inline(always)]
    pub(crate) fn mass(&self, nodes: &Stencil) -> f64 {
        let runs = self.runs(nodes);
        blended(&runs, nodes, self.angles) * self.unit * self.scale()
    }

    /// Running sums of each node.
    #[inline(always)]
    fn runs(&self, nodes: &Stencil) -> [&[f32]; 3] {
        part_of(&self.running, nodes.nodes, self.angles + 1)
    }

    /// Area of a cell; twice that where it stands for two.
    #[inline(always)]
    pub(crate) fn scale(&self) -> f64 {
        4.0 / (self.angles * self.radii) as f64
    }

    /// The density over (a, v) of the whole turn.
    #[inline(always)]
    pub(crate) fn density(&self, nodes: &Stencil, angle: f64, v: f64) -> f64 {
        self.read(angle, v).blend(&self.density, nodes) * self.unit
    }

    /// Where it is read.
    #[inline(always)]
    pub(crate) fn read(&self, angle: f64, v: f64) -> Read {
        Read::new(angle / self.span, v.clamp(0.0, 1.0), self.angles, self.radii)
    }

    /// Area over (a, v) of a cell.
    pub(crate) fn cell(&self) -> f64 {
        self.span / (self.angles * self.radii) as f64
    }

    /// A place by two numbers, each in \[0, 1): first the angle, then the distance from the peak.
    #[inline]
    pub(crate) fn draw(&self, nodes: &Stencil, u: DVec2) -> Drawn {
        let (x, other_half) = match self.span < 4.0 {
            true if u.x >= 0.5 => (2.0 - 2.0 * u.x, true),
            true => (2.0 * u.x, false),
            false => (u.x, false),
        };
        let runs = self.runs(nodes);
        let run = |column| blended(&runs, nodes, column);
        let target = x * run(self.angles);
        // How many do not exceed the target: of every eighth, then of those between. None waits for another.
        let mut low = 0;
        for column in (STRIDE..self.angles).step_by(STRIDE) {
            low += if run(column) <= target { STRIDE } else { 0 };
        }
        let begin = low;
        for column in begin + 1..(begin + STRIDE).min(self.angles) {
            low += usize::from(run(column) <= target);
        }
        // Three nodes, two columns each.
        let blocks = self.radii / BLOCK + 1;
        let row = |n: usize| nodes.nodes[n / 2] * (self.angles + 1) + low + n % 2;
        let rows: [usize; 6] = std::array::from_fn(row);
        let sums = part_of(&self.sums, rows, blocks);
        let last = blocks - 1;
        let at = |n: usize| sums[n].get(last).map_or(0.0, |&sum| f64::from(sum));
        let side = |side: usize| (0..3).map(|n| nodes.weights[n] * at(2 * n + side)).sum::<f64>();
        let (left, right) = (side(0), side(1));
        let tau = along(left, right, target - run(low));
        let share = [1.0 - tau, tau];
        let weights: [f64; 6] = std::array::from_fn(|n| nodes.weights[n / 2] * share[n % 2]);
        let sum = |block: usize| {
            let of = |n: usize| sums[n].get(block).map_or(0.0, |&sum| weights[n] * f64::from(sum));
            (0..6).map(of).sum::<f64>()
        };
        let target = u.y * sum(last);
        let (mut block, mut before) = (0, 0.0);
        while block + 1 < last {
            let next = sum(block + 1);
            if next > target {
                break;
            }
            (block, before) = (block + 1, next);
        }
        let knots = part_of(&self.density, rows, self.radii + 1);
        let first = BLOCK * block;
        let knot = |k: usize| {
            let of = |n: usize| knots[n].get(first + k).map_or(0.0, |h| weights[n] * h.value());
            (0..6).map(of).sum::<f64>()
        };
        let five: [f64; BLOCK + 1] = std::array::from_fn(knot);
        let (mut rest, mut k) = (target - before, 0);
        for step in 0..BLOCK - 1 {
            let mass = 0.5 * (five[step] + five[step + 1]);
            if rest < mass {
                break;
            }
            (rest, k) = (rest - mass, step + 1);
        }
        let place = (first + k) as f64 + along(five[k], five[k + 1], rest);
        let angle = (low as f64 + tau) * (self.span / self.angles as f64);
        let angle = if other_half { 4.0 - angle } else { angle };
        Drawn { angle, v: place / self.radii as f64 }
    }
}

/// Columns that are looked at first. A guess: the root of usual numbers of them.
const STRIDE: usize = 8;

/// Rows of `length` elements; empty where there are none.
#[inline(always)]
fn part_of<T, const N: usize>(all: &[T], rows: [usize; N], length: usize) -> [&[T]; N] {
    rows.map(|row| all.get(row * length..(row + 1) * length).unwrap_or_default())
}

/// An element of each node, blended.
#[inline(always)]
fn blended(of: &[&[f32]; 3], nodes: &Stencil, at: usize) -> f64 {
    let one = |n: usize| of[n].get(at).map_or(0.0, |&v| nodes.weights[n] * f64::from(v));
    one(0) + one(1) + one(2)
}

/// Where in \[0, 1\] a density that goes from `left` to `right` has the integral `mass`.
#[inline(always)]
fn along(left: f64, right: f64, mass: f64) -> f64 {
    let root = (left * left + 2.0 * (right - left) * mass).max(0.0).sqrt();
    let sum = left + root;
    if sum > 0.0 { (2.0 * mass / sum).clamp(0.0, 1.0) } else { 0.5 }
}
