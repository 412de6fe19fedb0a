//! Matrices and trees → Klems matrices: their cells regrouped into the new patches.
//!
//! Each value is the mean of f over both patches, V' = R V Sᵀ with the shares that old cells have in new
//! patches: totals of every patch are kept.

use std::f64::consts::{PI, TAU};

use bsdfkit::Result;
use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::tree::TensorTree;
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::square_to_disk;
use rayon::prelude::*;

use super::cells::for_each_leaf;
use super::mosaic::even_bits;
use super::overlap::{Coverage, patches_in, rings_in};

/// Matrix → matrix on `basis` for both directions, in colour if it has any.
///
/// Meaning: exact; where the old basis ends, f is 0.
pub(super) fn of_matrix(matrix: &KlemsMatrix, basis: &KlemsBasis) -> Result<KlemsMatrix> {
    let rows = patches_in(basis, matrix.incident());
    let columns = patches_in(basis, matrix.scattered());
    let (height, width) = (matrix.incident().directions(), matrix.scattered().directions());
    let regrouped = |values: &[f32]| -> Vec<f32> {
        let value = |row: &[(u32, f64)], column: &[(u32, f64)]| {
            let mut sum = 0.0;
            for &(i, a) in row.iter().filter(|s| (s.0 as usize) < height) {
                for &(o, b) in column.iter().filter(|s| (s.0 as usize) < width) {
                    sum += a * b * f64::from(values[i as usize * width + o as usize]);
                }
            }
            sum as f32
        };
        rows.iter().flat_map(|row| columns.iter().map(move |column| value(row, column))).collect()
    };
    let new = KlemsMatrix::new(basis.clone(), basis.clone(), regrouped(matrix.values()))?;
    match matrix.chromatic() {
        Some([x, z]) => new.with_colour(regrouped(x), regrouped(z)),
        None => Ok(new),
    }
}

/// Level down to which the overlaps of leaves and patches are known; what is deeper counts by its mean.
const DEEPEST: u32 = 10;

/// Tree of rank 4 → matrix.
///
/// Meaning: exact for leaves down to level 10.
pub(super) fn of_tree(tree: &TensorTree, basis: &KlemsBasis) -> Result<KlemsMatrix> {
    let coverage = Coverage::new(basis, tree.depth().min(DEEPEST));
    let n = basis.directions();
    let mut sums = vec![0.0; n * n];
    for_each_leaf(tree, DEEPEST, &mut |cell, value| {
        // Share of the square that a cell has, in both directions.
        let value = value * (-4.0 * f64::from(cell.level)).exp2() * PI * PI;
        let within = |z| coverage.of(cell.level, z).iter().filter(|s| (s.0 as usize) < n);
        for &(i, a) in within(cell.incident) {
            for &(o, b) in within(cell.scattered) {
                sums[i as usize * n + o as usize] += a * b * value;
            }
        }
    });
    let omega: Vec<f64> = (0..n).map(|k| basis.projected_solid_angle(k)).collect();
    let value = |(k, sum): (usize, &f64)| (sum / (omega[k / n] * omega[k % n])) as f32;
    KlemsMatrix::new(basis.clone(), basis.clone(), sums.iter().enumerate().map(value).collect())
}

/// Level of the grid on which rank 3 is turned.
const TURNED: u32 = 9;

/// Azimuths of a turned ring: bounds of the usual bases' patches fall between two.
const AZIMUTHS: usize = 5760;

/// Tree of rank 3 → matrix.
///
/// Meaning: totals of incident patches and constants are exact, shares of scattered patches within
/// 1e-3 of them: the tree turns with the incident azimuth, and so do its cells.
pub(super) fn of_isotropic_tree(tree: &TensorTree, basis: &KlemsBasis) -> Result<KlemsMatrix> {
    let turned = Turned::new(basis);
    let rings = 0..basis.rings().len();
    let rows: Vec<Vec<f64>> = rings.into_par_iter().map(|r| turned.rows(tree, r)).collect();
    let values = rows.into_iter().flatten().map(|v| v as f32).collect();
    KlemsMatrix::new(basis.clone(), basis.clone(), values)
}

/// What falls where when the scattered square is turned about its middle.
struct Turned<'a> {
    basis: &'a KlemsBasis,
    /// Parts of the grid's cells: cell, scattered ring, azimuth, share of the cell.
    parts: Vec<(u32, u32, u32, f64)>,
}

impl<'a> Turned<'a> {
    fn new(basis: &'a KlemsBasis) -> Self {
        let mut parts = Vec::new();
        for z in 0..1u32 << (2 * TURNED) {
            let corner = DVec2::new(even_bits(z).into(), even_bits(z >> 1).into());
            let middle = square_to_disk((corner + 0.5) / f64::from(1u32 << TURNED));
            let turns = (middle.y.atan2(middle.x) / TAU).rem_euclid(1.0);
            let azimuth = ((turns * AZIMUTHS as f64) as usize).min(AZIMUTHS - 1) as u32;
            for (ring, share) in rings_in(basis, TURNED, z) {
                parts.push((z, ring, azimuth, share));
            }
        }
        Self { basis, parts }
    }

    /// Rows of the patches of incident ring `r`.
    fn rows(&self, tree: &TensorTree, r: usize) -> Vec<f64> {
        let grid = ring_mean(tree, self.basis, r);
        let counts: Vec<usize> = self.basis.rings().iter().map(|ring| ring.patches).collect();
        // The grid is alike for all; what a constant 1 becomes by it is divided out.
        let (mut light, mut area) =
            (vec![0.0; counts.len() * AZIMUTHS], vec![0.0; counts.len() * AZIMUTHS]);
        for &(z, ring, azimuth, share) in &self.parts {
            let at = ring as usize * AZIMUTHS + azimuth as usize;
            light[at] += share * grid[z as usize];
            area[at] += share;
        }
        let total: f64 = light.iter().sum::<f64>() * PI / f64::from(1u32 << (2 * TURNED));
        let omega = (0..self.basis.directions()).map(|k| self.basis.projected_solid_angle(k));
        let omega: Vec<f64> = omega.collect();
        let mut rows = Vec::with_capacity(counts[r] * omega.len());
        for k in 0..counts[r] {
            let mut row = Vec::with_capacity(omega.len());
            for (ring, &count) in counts.iter().enumerate() {
                let of = |sums: &[f64]| {
                    smeared(&sums[ring * AZIMUTHS..][..AZIMUTHS], k, counts[r], count)
                };
                let (light, area) = (of(&light), of(&area));
                row.extend(
                    light.iter().zip(&area).map(|(l, a)| if *a > 0.0 { l / a } else { 0.0 }),
                );
            }
            let sum: f64 = row.iter().zip(&omega).map(|(value, omega)| value * omega).sum();
            let scale = if sum > 0.0 { total / sum } else { 0.0 };
            rows.extend(row.into_iter().map(|value| value * scale));
        }
        rows
    }
}

/// By azimuth patch of `count`: what falls there when a ring is turned by the azimuths of patch `k` of `among`.
fn smeared(ring: &[f64], k: usize, among: usize, count: usize) -> Vec<f64> {
    let mut sums = vec![0.0; count];
    let half = 0.5 * count as f64 / among as f64;
    for (azimuth, value) in ring.iter().enumerate().filter(|a| *a.1 > 0.0) {
        let turns = (azimuth as f64 + 0.5) / AZIMUTHS as f64 + k as f64 / among as f64;
        let middle = turns * count as f64 + 0.5;
        let (from, to) = (middle - half, middle + half);
        let mut column = from.floor();
        while column < to {
            let overlap = (to.min(column + 1.0) - from.max(column)) / (to - from);
            sums[(column as i64).rem_euclid(count as i64) as usize] += overlap * value;
            column += 1.0;
        }
    }
    sums
}

/// Mean f over the incident polar angles of ring `r`, on the grid of level [`TURNED`].
fn ring_mean(tree: &TensorTree, basis: &KlemsBasis, r: usize) -> Vec<f64> {
    let (lower, upper) = basis.ring_bounds_degrees(r);
    let ring = [lower, upper].map(|degrees| degrees.to_radians().sin().powi(2));
    let mut levels: Vec<Vec<f64>> = (0..=TURNED).map(|level| vec![0.0; 1 << (2 * level)]).collect();
    for_each_leaf(tree, TURNED, &mut |cell, value| {
        let at = |z: usize| 1.0 - 2.0 * z as f64 / f64::from(1u32 << cell.level);
        let bounds = [at(cell.incident + 1), at(cell.incident)].map(|sin| sin.max(0.0).powi(2));
        let shared = ring[1].min(bounds[1]) - ring[0].max(bounds[0]);
        if shared > 0.0 {
            levels[cell.level as usize][cell.scattered] += value * shared / (ring[1] - ring[0]);
        }
    });
    for level in 0..TURNED as usize {
        let (above, below) = levels.split_at_mut(level + 1);
        for (z, value) in below[0].iter_mut().enumerate() {
            *value += above[level][z / 4];
        }
    }
    levels.pop().unwrap_or_default()
}
