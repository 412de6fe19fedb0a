//! Continuous BSDF → Klems matrix, by converged quadrature over both patches. [WKB14 §2.4]

use std::f64::consts::PI;
use std::sync::atomic::AtomicUsize;

use bsdfkit::matrix::{KlemsBasis, KlemsMatrix};
use bsdfkit::{Error, Result};
use bsdfkit_sphere::{DVec2, DVec3, Side};
use rayon::prelude::*;

use super::missed::{Limit, Missed};
use super::mosaic::{Mosaic, Sampling, Seeding, even_bits};
use super::patches::Patches;
use super::reciprocity::{exchanged_mean, no_reflection};
use crate::source::Source;
use crate::watch::Watch;

/// How well a matrix is averaged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KlemsSettings {
    /// L1 of a row as a share of its flux at which averaging stops.
    pub tolerance: f64,
    /// Whether f(ωi, ωo) and f(ωo, ωi) are averaged: of reflection only.
    pub reciprocal: bool,
}

impl Default for KlemsSettings {
    /// 1 % of the flux; nothing averaged.
    fn default() -> Self {
        Self { tolerance: 0.01, reciprocal: false }
    }
}

/// How well a matrix was averaged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MatrixReport {
    /// Estimate of the L1 of a row as a share of its flux, mean over patches or rings; 0 where
    /// means are exact.
    pub error: f64,
    /// The tolerance where it was not reached, and why.
    pub missed: Option<Missed>,
    /// Whether reciprocal values were averaged.
    pub reciprocity: bool,
}

/// How much goes into a quadrature.
struct Effort {
    /// Levels of incident groups: a patch has 4^level of four slices, a ring 2^level.
    levels: std::ops::RangeInclusive<u32>,
    /// Half the difference of two halves of the groups, in tolerances, at which their mean is
    /// good enough. It would be 1 were their errors independent; being interleaved they cancel.
    difference: f64,
    /// Spread of a scattered cell that is not refined: share of the flux, in tolerances over the
    /// root of the number of groups, whose errors cancel.
    spread: f64,
}

/// Effort for one incident patch. Chosen by L1 against brute force and time on six virtual
/// materials: at 2.5 times the spread, 2 % of the flux are lost beside narrow peaks, as cells that
/// show too much are refined and cells that show too little are not.
const PATCH: Effort = Effort { levels: 2..=3, difference: 1.5, spread: 0.08 };

/// Effort for one incident ring of an isotropic source: there are few, so it is ample.
const RING: Effort = Effort { levels: 4..=6, difference: 0.5, spread: 0.04 };

/// At a width of 4, 2 % of the flux of a peak of σ = 1.5° is lost, and as much at a reach of 1.5,
/// as its skirts slip between samples; at half the width seeds cost up to four times the values.
const KLEMS_SEEDING: Seeding = Seeding { width: 3.0, reach: 2.5 };

/// No group takes more values than this. A guess: 30 × the least.
const MOST_PER_GROUP: usize = 20_000;

/// Continuous BSDF → Klems matrix on `basis` for both directions.
///
/// Meaning: each value is the mean of f over the projected solid angles of both patches; three
/// channels make a coloured matrix (luminance, X, Z).
/// Accuracy: rows to 1.5 % of the flux in L1 (tests against brute force) for peaks of σ ≥ 1.5°
/// that slices tell of ([`Slice::peaks`](super::Slice::peaks)), to 2 % for σ ≥ 6° without hints;
/// 1 % of the flux may be lost, as cells that by chance show too little are not refined. Patches
/// past 65° were not compared.
/// Errors: argument for a tolerance that is not positive, and for transmission whose reciprocal
/// values are to be averaged; limit when cancelled.
/// Cost: Klems full: 9 k to 41 k slices and 7 M to 14 M values, 3 to 10 s of processor time from
/// interpolants; isotropic sources 1 k slices, 0.3 s. The same matrix at any number of threads.
pub fn klems_matrix(
    source: &dyn Source,
    basis: &KlemsBasis,
    settings: &KlemsSettings,
    watch: &Watch<'_>,
) -> Result<(KlemsMatrix, MatrixReport)> {
    if settings.tolerance.is_nan() || settings.tolerance <= 0.0 {
        return Err(Error::argument(format!(
            "Klems matrix: expected a tolerance above 0, found {}",
            settings.tolerance
        )));
    }
    if settings.reciprocal && source.incident() != source.scattered() {
        return Err(no_reflection());
    }
    let quadrature = Quadrature {
        source,
        patches: Patches::new(basis),
        tolerance: settings.tolerance,
        effort: if source.isotropic() { RING } else { PATCH },
        channels: if source.channels() == 3 { 3 } else { 1 },
        watch,
    };
    let done = AtomicUsize::new(0);
    let jobs = if source.isotropic() { basis.rings().len() } else { basis.directions() };
    let blocks = (0..jobs)
        .into_par_iter()
        .map(|job| {
            let rows = if source.isotropic() {
                quadrature.converged(|level| quadrature.ring(job, level))
            } else {
                quadrature.converged(|level| quadrature.patch(job, level))
            }?;
            watch.finished(&done, jobs);
            Ok(rows)
        })
        .collect::<Result<Vec<_>>>()?;
    let channel = |c: usize| -> Vec<f32> {
        blocks.iter().flat_map(|(rows, _)| &rows[c]).map(|&v| v as f32).collect()
    };
    let mut matrix = KlemsMatrix::new(basis.clone(), basis.clone(), channel(0))?;
    if quadrature.channels == 3 {
        matrix = matrix.with_colour(channel(1), channel(2))?;
    }
    if settings.reciprocal {
        matrix = exchanged_mean(&matrix)?;
    }
    let beyond = blocks.iter().filter(|(_, error)| *error > settings.tolerance).count();
    let missed = Missed { target: settings.tolerance, limit: Limit::Averaging(beyond) };
    let report = MatrixReport {
        error: blocks.iter().map(|(_, error)| error).sum::<f64>() / jobs as f64,
        missed: (beyond > 0).then_some(missed),
        reciprocity: settings.reciprocal,
    };
    Ok((matrix, report))
}

/// Rows of the matrix, one after the other, by channel.
type Rows = Vec<Vec<f64>>;

struct Quadrature<'a> {
    source: &'a dyn Source,
    patches: Patches<'a>,
    tolerance: f64,
    effort: Effort,
    channels: usize,
    watch: &'a Watch<'a>,
}

impl Quadrature<'_> {
    /// Rows of the first level at which two halves of its groups agree in luminance, and their L1.
    fn converged(&self, groups: impl Fn(u32) -> Result<Vec<Rows>>) -> Result<(Rows, f64)> {
        let n = self.patches.count();
        let mut level = *self.effort.levels.start();
        loop {
            let groups = groups(level)?;
            // By the parity of the bits of their number: interleaved in one and two dimensions.
            let half = |odd| {
                let of = move |z: &usize| z.count_ones() % 2 == odd;
                mean((0..groups.len()).filter(of).map(|z| &groups[z]))
            };
            let [a, b] = [half(0), half(1)];
            let (mut flux, mut difference) = (0.0, 0.0);
            for (k, (a, b)) in a[0].iter().zip(&b[0]).enumerate() {
                let omega = 0.5 * self.patches.projected_solid_angle(k % n);
                flux += (a + b) * omega;
                difference += (a - b).abs() * omega;
            }
            level += 1;
            let enough = self.effort.difference * self.tolerance * flux;
            if difference <= enough || level > *self.effort.levels.end() {
                let error = difference / (self.effort.difference * flux).max(f64::MIN_POSITIVE);
                return Ok((mean([a, b].iter()), error));
            }
        }
    }

    /// The row of one incident patch from each of 4^level groups of four slices.
    fn patch(&self, patch: usize, level: u32) -> Result<Vec<Rows>> {
        let groups = 1u32 << (2 * level);
        let rows = (0..groups).into_par_iter().map(|z| {
            self.watch.check()?;
            let corner = DVec2::new(even_bits(z).into(), even_bits(z >> 1).into());
            let incident = [0u32, 1, 2, 3].map(|s| {
                let offset = DVec2::new((s & 1).into(), (s >> 1).into()) * 0.5 + 0.25;
                self.patches.place(patch, (corner + offset) / f64::from(1u32 << level))
            });
            // Another pairing of slices and quadrants in each group: together they have all.
            let slice_of = [1, 3, 0, 2].map(|slice| slice ^ (z as usize & 3));
            let mosaic = self.mosaic(incident, slice_of, z, groups);
            Ok((0..self.channels)
                .map(|c| (0..self.patches.count()).map(|k| mosaic.mean_of_root(k, c)).collect())
                .collect())
        });
        rows.collect()
    }

    /// The rows of one ring from each of 2^level groups of four polar angles: f depends on the
    /// difference of azimuths, so a sample counts in each column by the share of the incident
    /// patch's azimuths from which it falls there.
    fn ring(&self, ring: usize, level: u32) -> Result<Vec<Rows>> {
        let groups = 1u32 << level;
        let (n, incident_patches) = (self.patches.count(), self.patches.ring(ring).len());
        let rows = (0..groups).into_par_iter().map(|g| {
            self.watch.check()?;
            let incident = [0u32, 1, 2, 3].map(|s| {
                let u = (f64::from(g) + (f64::from(s) + 0.5) * 0.25) / f64::from(groups);
                self.patches.polar(ring, u)
            });
            let mosaic = self.mosaic(incident, [0, 2, 3, 1], g, groups);
            let mut rows = vec![vec![0.0; n * incident_patches]; self.channels];
            mosaic.for_each_sample(|patch, point, share, values| {
                let w = self.patches.place(patch, point);
                let scattered = self.patches.ring(self.patches.ring_of(patch));
                let turns = w.y.atan2(w.x) / std::f64::consts::TAU;
                for row in 0..incident_patches {
                    let turned = turns + row as f64 / incident_patches as f64;
                    // In columns: the sample smeared over the width of the incident patch.
                    let middle = turned * scattered.len() as f64 + 0.5;
                    let half = 0.5 * scattered.len() as f64 / incident_patches as f64;
                    let (from, to) = (middle - half, middle + half);
                    let mut column = from.floor();
                    while column < to {
                        let overlap = (to.min(column + 1.0) - from.max(column)) / (to - from);
                        let k = (column as i64).rem_euclid(scattered.len() as i64) as usize;
                        for (rows, value) in rows.iter_mut().zip(values) {
                            rows[row * n + scattered.start + k] += share * overlap * value;
                        }
                        column += 1.0;
                    }
                }
            });
            Ok(rows)
        });
        rows.collect()
    }

    /// Samples four slices near each other; `incident` are travel directions in basis form.
    fn mosaic(
        &self,
        incident: [DVec3; 4],
        slice_of: [usize; 4],
        group: u32,
        groups: u32,
    ) -> Mosaic {
        let slices = incident.map(|travel| {
            let wi = DVec3::new(-travel.x, -travel.y, travel.z);
            self.source.slice(to_side(wi, self.source.incident()))
        });
        let mut peaks = Vec::new();
        slices[0].peaks(&mut peaks);
        let hinted = !peaks.is_empty();
        Mosaic::sample(
            std::array::from_fn(|s| &*slices[s]),
            &Sampling {
                place: &|k, point| to_side(self.patches.place(k, point), self.source.scattered()),
                find: &|w| self.patches.find(w),
                roots: self.patches.count(),
                width: &|k| self.patches.width(k),
                measure: &|k| self.patches.projected_solid_angle(k) / PI,
                // Without hints four samples a patch would miss what is narrow.
                start: u32::from(!hinted),
                deepest: 7,
                stratified: u32::MAX,
                within: within(group, groups),
                slice_of,
                channels: self.source.channels(),
                kept: self.channels,
                seeding: KLEMS_SEEDING,
                threshold: self.effort.spread * self.tolerance * f64::from(groups).sqrt(),
                most: MOST_PER_GROUP,
            },
        )
    }
}

/// Where in a quadrant the sample of a group lies: together the groups' samples are even, and their mean is the middle.
///
/// 16 groups are a net: every strip of a sixteenth, however wide and high, has one of them. Its coordinates do not follow
/// those of the incident groups, which are single bits of the number, nor the halves, which are the parity of all. Places
/// that are even but not in the middle, as (0.41, 0.46), shift all patches toward the normal: totals of a peak of
/// σ = 9° were 2 % too large.
fn within(group: u32, groups: u32) -> DVec2 {
    let digits = |masks: [u32; 4]| -> f64 {
        let bits = masks.map(|mask| (group & mask).count_ones() & 1);
        bits.iter()
            .zip([0.5, 0.25, 0.125, 0.0625])
            .map(|(&bit, width)| f64::from(bit) * width)
            .sum()
    };
    let (rest, finer) = (group >> 4, f64::from((groups >> 4).max(1)));
    let inside = DVec2::new(rest.into(), (rest ^ (rest >> 1)).into());
    DVec2::new(digits([3, 5, 7, 9]), digits([9, 7, 5, 3])) + (inside + 0.5) / (16.0 * finer)
}

fn mean<'a>(groups: impl Iterator<Item = &'a Rows>) -> Rows {
    let mut sum = Rows::new();
    let mut count = 0.0;
    for group in groups {
        if sum.is_empty() {
            sum = group.iter().map(|rows| vec![0.0; rows.len()]).collect();
        }
        for (sum, value) in sum.iter_mut().flatten().zip(group.iter().flatten()) {
            *sum += value;
        }
        count += 1.0;
    }
    sum.iter_mut().flatten().for_each(|value| *value /= count);
    sum
}

fn to_side(w: DVec3, side: Side) -> DVec3 {
    DVec3::new(w.x, w.y, side.sign() * w.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_groups_lie_about_the_middle() {
        for groups in [16u32, 32, 64] {
            let places: Vec<_> = (0..groups).map(|z| within(z, groups)).collect();
            let mean = places.iter().sum::<DVec2>() / f64::from(groups);
            assert!(mean.distance(DVec2::splat(0.5)) < 1e-12, "{groups}: {mean}");
            for (columns, rows) in [(16, 1), (8, 2), (4, 4), (2, 8), (1, 16)] {
                let mut counts = [0; 16];
                for p in &places {
                    counts[(p.x * f64::from(columns)) as usize * rows
                        + (p.y * rows as f64) as usize] += 1;
                }
                assert!(counts.iter().all(|&n| n == groups / 16), "{groups}: {columns} by {rows}");
            }
        }
    }
}
