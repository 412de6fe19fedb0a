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
        let column = self.column(nodes, u.x);
        let strip = self.strip(nodes, &column);
        let within = self.within(&strip, u.y);
        self.place(&column, &strip, &within)
    }

    /// The column in which the angle of `u` falls.
    #[inline(always)]
    pub(crate) fn column(&self, nodes: &Stencil, u: f64) -> Column {
        let (x, other_half) = match self.span < 4.0 {
            true if u >= 0.5 => (2.0 - 2.0 * u, true),
            true => (2.0 * u, false),
            false => (u, false),
        };
        let runs = self.runs(nodes);
        let target = x * blended(&runs, nodes, self.angles);
        let number = at_most(runs, nodes.weights, self.angles, target);
        Column { number, rest: target - blended(&runs, nodes, number), other_half }
    }

    /// Where between that column and the next.
    #[inline(always)]
    pub(crate) fn strip(&self, nodes: &Stencil, column: &Column) -> Strip {
        let (blocks, last) = (self.radii / BLOCK + 1, self.radii / BLOCK);
        let (mut rows, mut weights, mut sides) = ([0; 6], [0.0; 6], [0.0; 2]);
        for n in 0..6 {
            rows[n] = nodes.nodes[n / 2] * (self.angles + 1) + column.number + n % 2;
            let whole = self.sums.get(rows[n] * blocks + last).copied().unwrap_or(0.0);
            sides[n % 2] += nodes.weights[n / 2] * f64::from(whole);
        }
        let tau = along(sides[0], sides[1], column.rest);
        let share = [1.0 - tau, tau];
        for n in 0..6 {
            weights[n] = nodes.weights[n / 2] * share[n % 2];
        }
        Strip { rows, weights, tau }
    }

    /// The block of radial cells in which the distance of `u` falls.
    #[inline(always)]
    pub(crate) fn within(&self, strip: &Strip, u: f64) -> Within {
        let last = self.radii / BLOCK;
        let sums = part_of(&self.sums, strip.rows, last + 1);
        let sum = |block: usize| {
            let mut sum = 0.0;
            for n in 0..6 {
                sum += strip.weights[n] * f64::from(sums[n].get(block).copied().unwrap_or(0.0));
            }
            sum
        };
        let target = u * sum(last);
        let block = at_most(sums, strip.weights, last, target);
        Within { block, rest: target - sum(block) }
    }

    /// The place within that block.
    #[inline(always)]
    pub(crate) fn place(&self, column: &Column, strip: &Strip, within: &Within) -> Drawn {
        let knots = part_of(&self.density, strip.rows, self.radii + 1);
        let first = BLOCK * within.block;
        let mut five = [0.0; BLOCK + 1];
        for (row, weight) in knots.iter().zip(strip.weights) {
            let Some(found) = row.get(first..=first + BLOCK) else { continue };
            for k in 0..=BLOCK {
                five[k] += weight * found[k].value();
            }
        }
        let (mut rest, mut k, mut sum) = (within.rest, 0, 0.0);
        for step in 0..BLOCK - 1 {
            sum += 0.5 * (five[step] + five[step + 1]);
            let beyond = within.rest >= sum;
            (rest, k) = if beyond { (within.rest - sum, step + 1) } else { (rest, k) };
        }
        let place = (first + k) as f64 + along(five[k], five[k + 1], rest);
        let angle = (column.number as f64 + strip.tau) * (self.span / self.angles as f64);
        let angle = if column.other_half { 4.0 - angle } else { angle };
        Drawn { angle, v: place / self.radii as f64 }
    }
}

/// Where the angle of a sample falls.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Column {
    number: usize,
    /// What is left of the running sum.
    rest: f64,
    /// Whether it is in the half that the table stands for, too.
    other_half: bool,
}

/// Densities along the radius at the angle of a sample: of three nodes, of two columns each.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Strip {
    rows: [usize; 6],
    weights: [f64; 6],
    tau: f64,
}

/// Where the distance of a sample falls.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Within {
    block: usize,
    rest: f64,
}

/// Of the blend of rising rows from element 1 to before `end`, how many do not exceed `target`.
///
/// All are looked at: none waits for another.
#[inline(always)]
fn at_most<const N: usize>(rows: [&[f32]; N], weights: [f64; N], end: usize, target: f64) -> usize {
    const LANES: usize = 8;
    let mut length = end.saturating_sub(1);
    let mut rising: [&[f32]; N] = [&[]; N];
    for n in 0..N {
        rising[n] = rows[n].get(1..end).unwrap_or_default();
        length = length.min(rising[n].len());
    }
    let rows = rising;
    let whole = length - length % LANES;
    let mut counts = [0_u64; LANES];
    for first in (0..whole).step_by(LANES) {
        let mut sums = [0.0; LANES];
        for n in 0..N {
            let Some(eight) = rows[n].get(first..first + LANES) else { continue };
            for l in 0..LANES {
                sums[l] += weights[n] * f64::from(eight[l]);
            }
        }
        for l in 0..LANES {
            counts[l] += u64::from(sums[l] <= target);
        }
    }
    let mut count = 0;
    for lane in counts {
        count += lane as usize;
    }
    for k in whole..length {
        let mut sum = 0.0;
        for n in 0..N {
            sum += weights[n] * f64::from(rows[n].get(k).copied().unwrap_or(0.0));
        }
        count += usize::from(sum <= target);
    }
    count
}

/// Rows of `length` elements; empty where there are none.
#[inline(always)]
fn part_of<T, const N: usize>(all: &[T], rows: [usize; N], length: usize) -> [&[T]; N] {
    let mut parts: [&[T]; N] = [&[]; N];
    for n in 0..N {
        parts[n] = all.get(rows[n] * length..(rows[n] + 1) * length).unwrap_or_default();
    }
    parts
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
