//! Peaks of no width that trees and matrices hold in narrow cells, found again.

use super::{Curve, Law, Specular};
use crate::matrix::KlemsMatrix;
use crate::tree::{Change, Deposits, Rank, TensorTree, TreeDistribution};
use crate::{Bsdf, Component, DVec2, DVec3, Distribution, Result, Side, Xyz};
use bsdfkit_sphere::concentric::{disk_to_square, square_to_disk, square_to_hemisphere};

/// A peak's cell must hold so many times what the cells around it hold: as Radiance asks of a peak through a device.
const RISES: f64 = 8.0;
/// It must have so much of the incident light.
const LEAST: f64 = 2e-3;
/// Of the incident cells, so many must show it: by their projected solid angle.
const MOST_OF: f64 = 0.5;
/// Deepest cells of trees that are looked at: of rank 3 and 4.
const DEEPEST: [u32; 2] = [9, 7];
/// Cells from the middle, along either axis, that a peak may lie in, and that tell the surround. A peak that is not
/// aligned with cells lies in up to 2 × 2 of them.
const PEAK: i64 = 1;
const AROUND: std::ops::RangeInclusive<i64> = 2..=3;
/// The table of a coefficient: of isotropic trees, else.
const TABLES: [[usize; 2]; 2] = [[73, 1], [37, 24]];

/// What one incident cell shows.
struct Shown {
    wi: DVec3,
    /// Its projected solid angle, sr.
    weight: f64,
    coefficient: Xyz,
    /// Numbers of cells with what they hold instead of the peak.
    instead: Vec<([u32; 2], f64)>,
    /// The incident cell.
    incident: [u32; 2],
}

impl Bsdf {
    /// The same light with peaks taken out of narrow cells: mirror-like, straight through and back to the light.
    ///
    /// A peak counts where, of most incident cells, the narrowest cells in its place hold eight times what those around
    /// do, and two thousandths of the light. What is taken out is what they hold more. Components from which a peak has
    /// been taken are left alone: doing it again changes nothing.
    ///
    /// Accuracy: of what [`Bsdf::with_peaks_in_cells`] has put there, the coefficient within a hundredth.
    /// Errors: limit, for trees of too many branches.
    /// Cost: 0.1 s a tree of rank 4.
    pub fn with_peaks_extracted(&self) -> Result<Bsdf> {
        let mut specular = self.specular().to_vec();
        let mut components = Vec::new();
        for component in self.components() {
            let sides = (component.incident, component.scattered);
            let done = self.specular().iter().any(|s| (s.incident, s.scattered) == sides);
            let mut component = component.clone();
            let laws: &[Law] = match sides.0 == sides.1 {
                true => &[Law::OPPOSITE, Law::RETRO],
                false => &[Law::OPPOSITE],
            };
            for law in laws.iter().filter(|_| !done) {
                if let Some((without, coefficient)) = extracted(&component, law)? {
                    component = without;
                    specular.push(Specular::new(sides, *law, coefficient));
                }
            }
            components.push(component);
        }
        let explicit = *self.explicit_lambertian();
        let bsdf = Bsdf::new(self.metadata().clone(), components, explicit);
        Ok(bsdf.with_bands(self.bands().to_vec()).with_specular(specular))
    }
}

/// A component without the peak of a law, and the peak's coefficient; `None` where it has none.
fn extracted(component: &Component, law: &Law) -> Result<Option<(Component, Curve)>> {
    let sides = (component.incident, component.scattered);
    let distribution = component.distribution();
    if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
        let rank = tree.luminance().rank();
        let depth = tree.luminance().depth().min(DEEPEST[(rank == Rank::Four) as usize]);
        if depth < 3 {
            return Ok(None);
        }
        let shown = tree_cells(tree, law, rank, depth);
        let Some(found) = agreed(shown) else { return Ok(None) };
        let cells = found.iter().flat_map(|s| s.instead.iter().map(|c| (s.incident, c.0, c.1)));
        let deposits = Deposits::of_cells(depth, cells);
        let y: TensorTree = tree.luminance().deposited(&deposits, Change::Replaced)?;
        let tree = match tree.chromaticity() {
            Some([u, v]) => TreeDistribution::with_chromaticity(y, u.clone(), v.clone())?,
            None => TreeDistribution::new(y),
        };
        let curve = curve(&found, TABLES[(rank == Rank::Four) as usize])?;
        return Ok(Some((Component::new(sides.0, sides.1, tree), curve)));
    }
    let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() else { return Ok(None) };
    let Some(found) = agreed(matrix_cells(matrix, law)) else { return Ok(None) };
    let mut y: Vec<(usize, f64)> = Vec::new();
    let columns = matrix.scattered().directions();
    for s in &found {
        let row = s.incident[0] as usize * columns;
        y.extend(s.instead.iter().map(|(cell, value)| (row + cell[0] as usize, *value)));
    }
    let values = matrix.values();
    let scaled = |channel: &[f32]| -> Vec<(usize, f64)> {
        let share = |&(entry, value): &(usize, f64)| {
            let was = f64::from(values[entry]).max(1e-30);
            (entry, f64::from(channel[entry]) * value / was)
        };
        y.iter().map(share).collect()
    };
    let (x, z) = match matrix.chromatic() {
        Some([x, z]) => (scaled(x), scaled(z)),
        None => (Vec::new(), Vec::new()),
    };
    let without = matrix.changed([&y, &x, &z], false)?;
    let curve = curve(&found, TABLES[1])?;
    Ok(Some((Component::new(sides.0, sides.1, without), curve)))
}

/// Those that show a peak, if most do.
fn agreed(cells: Vec<(f64, Option<Shown>)>) -> Option<Vec<Shown>> {
    let all: f64 = cells.iter().map(|c| c.0).sum();
    let found: Vec<Shown> = cells.into_iter().filter_map(|c| c.1).collect();
    let shown: f64 = found.iter().map(|s| s.weight).sum();
    (shown > MOST_OF * all).then_some(found)
}

/// The median.
fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}

fn tree_cells(
    tree: &TreeDistribution,
    law: &Law,
    rank: Rank,
    depth: u32,
) -> Vec<(f64, Option<Shown>)> {
    let count = 1_i64 << depth;
    let size = std::f64::consts::PI / (count * count) as f64;
    let centre =
        |cell: [i64; 2]| DVec2::new(cell[0] as f64 + 0.5, cell[1] as f64 + 0.5) / count as f64;
    let incident: Vec<[i64; 2]> = match rank {
        Rank::Three => (0..count / 2).map(|x| [x, 0]).collect(),
        Rank::Four => (0..count * count).map(|n| [n / count, n % count]).collect(),
    };
    let of = |cell: [i64; 2]| {
        let wi = match rank {
            Rank::Three => {
                let sine = 1.0 - 2.0 * (cell[0] as f64 + 0.5) / count as f64;
                DVec3::new(sine, 0.0, (1.0 - sine * sine).sqrt())
            }
            Rank::Four => {
                let u = -square_to_disk(centre(cell));
                u.extend((1.0 - u.length_squared()).max(0.0).sqrt())
            }
        };
        // Rings of rank 3 are as long as their radius.
        let weight = if rank == Rank::Three { wi.x } else { 1.0 };
        let shown = law.scattered(wi, Side::Front).and_then(|wo| {
            // Rank 3 sees scattered light with the travel direction along +X.
            let turn = if rank == Rank::Three { -1.0 } else { 1.0 };
            let square = disk_to_square(turn * wo.truncate());
            // A place on a border has two middles; this one and that above it both count as the peak's.
            let place = (square * count as f64 - 1e-6).max(DVec2::ZERO);
            let middle_cell = [(place.x as i64).min(count - 1), (place.y as i64).min(count - 1)];
            let far = *AROUND.end();
            let (mut peak, mut around) = (Vec::new(), Vec::new());
            for n in 0..(2 * far + 1) * (2 * far + 1) {
                let off = [n / (2 * far + 1) - far, n % (2 * far + 1) - far];
                let cell = [middle_cell[0] + off[0], middle_cell[1] + off[1]];
                if !cell.iter().all(|c| (0..count).contains(c)) {
                    continue;
                }
                let w = square_to_hemisphere(centre(cell), Side::Front);
                let w = DVec3::new(turn * w.x, turn * w.y, w.z);
                let value = tree.value_xyz(wi, w);
                match off[0].abs().max(off[1].abs()) {
                    r if r <= PEAK => peak.push((cell, value)),
                    r if AROUND.contains(&r) => around.push(value.y),
                    _ => {}
                }
            }
            let highest = around.iter().copied().fold(0.0, f64::max);
            let level = middle(around);
            let largest = peak.iter().map(|p| p.1.y).fold(0.0, f64::max);
            let above = peak.iter().filter(|p| p.1.y > level);
            let coefficient = above
                .fold(Xyz::ZERO, |sum, (_, v)| sum + *v * (size * (v.y - level) / v.y.max(1e-30)));
            let cell = |c: [i64; 2]| [c[0] as u32, c[1] as u32];
            let instead =
                peak.iter().filter(|p| p.1.y > level).map(|p| (cell(p.0), level)).collect();
            let is_peak = largest > RISES * highest.max(level) && coefficient.y > LEAST;
            is_peak.then(|| Shown {
                wi,
                weight,
                coefficient,
                instead,
                incident: cell(cell_of(wi, rank, count)),
            })
        });
        (weight, shown)
    };
    incident.into_iter().map(of).collect()
}

/// The incident cell of a direction.
fn cell_of(wi: DVec3, rank: Rank, count: i64) -> [i64; 2] {
    let square = match rank {
        Rank::Three => DVec2::new(0.5 - 0.5 * wi.x, 0.0),
        Rank::Four => disk_to_square(-wi.truncate()),
    };
    let cell = |c: f64| ((c * count as f64) as i64).clamp(0, count - 1);
    [cell(square.x), cell(square.y)]
}

fn matrix_cells(matrix: &KlemsMatrix, law: &Law) -> Vec<(f64, Option<Shown>)> {
    let (incident, scattered) = (matrix.incident(), matrix.scattered());
    let columns = scattered.directions();
    let near = |o: usize| -> Vec<usize> {
        let centre = scattered.centre(o);
        let mut others: Vec<usize> = (0..columns).filter(|k| *k != o).collect();
        let apart = |k: &usize| scattered.centre(*k).distance(centre);
        others.sort_by(|a, b| apart(a).total_cmp(&apart(b)));
        others.truncate(6);
        others
    };
    let of = |i: usize| {
        let travel = incident.centre(i);
        let wi = DVec3::new(-travel.x, -travel.y, travel.z);
        let weight = incident.projected_solid_angle(i);
        let shown = law.scattered(wi, Side::Front).and_then(|wo| {
            let o = scattered.index(wo)?;
            let value = |o: usize| f64::from(matrix.values()[i * columns + o]);
            let around: Vec<f64> = near(o).into_iter().map(value).collect();
            let highest = around.iter().copied().fold(0.0, f64::max);
            let (level, own) = (middle(around), value(o));
            let share = (own - level) / own.max(1e-30) * scattered.projected_solid_angle(o);
            let colour = match matrix.chromatic() {
                Some([x, z]) => {
                    let entry = i * columns + o;
                    Xyz::new(f64::from(x[entry]), own, f64::from(z[entry]))
                }
                None => Xyz::grey(own),
            };
            let coefficient = colour * share;
            let is_peak = own > RISES * highest && coefficient.y > LEAST;
            let instead = vec![([o as u32, 0], level)];
            is_peak.then_some(Shown { wi, weight, coefficient, instead, incident: [i as u32, 0] })
        });
        (weight, shown)
    };
    (0..incident.directions()).map(of).collect()
}

/// A curve near what cells show: between them by their distances.
fn curve(found: &[Shown], [rings, azimuths]: [usize; 2]) -> Result<Curve> {
    Curve::tabulated(rings, azimuths, |w| {
        let (mut sum, mut weights) = (Xyz::ZERO, 0.0);
        for shown in found {
            let wi = match azimuths {
                1 => DVec3::new(shown.wi.truncate().length(), 0.0, shown.wi.z),
                _ => shown.wi,
            };
            let w = if azimuths == 1 { DVec3::new(w.truncate().length(), 0.0, w.z) } else { w };
            let near = w.distance_squared(wi) + 1e-8;
            let weight = shown.weight / (near * near);
            sum += shown.coefficient * weight;
            weights += weight;
        }
        let mean = sum * (1.0 / f64::max(weights, f64::MIN_POSITIVE));
        Xyz::new(mean.x.clamp(0.0, 2.0), mean.y.clamp(0.0, 2.0), mean.z.clamp(0.0, 2.0))
    })
}
