//! Where a continuous BSDF is sampled for a tree.

use std::sync::atomic::AtomicUsize;

use bsdfkit::tree::{MAX_DEPTH, Rank};
use bsdfkit::{Error, Result};
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::{disk_to_square, square_to_hemisphere};
use bsdfkit_sphere::sequence::{golden, plastic};
use rayon::prelude::*;

use super::fine::{Assembly, Fine, Levels};
use super::layout::Layout;
use super::mosaic::{Mosaic, Sampling, Seeding};
use super::tree_settings::{TreeSettings, usual_depth};
use crate::source::Source;
use crate::watch::Watch;

/// The middle of each peak down to cells in which a sample sees it: its skirts are found from
/// there. At half the width or with a reach, seeds of many lobes take three times `max_samples`.
const TREE_SEEDING: Seeding = Seeding { width: 6.0, reach: 0.0 };

/// Groups of incidences that set the threshold: 3 % of them at rank 4 ...
const PILOTS: usize = 128;
/// ... and at rank 3 one in so many: pilots take up to six times their share of samples.
const ONE_IN: usize = 8;

/// Each round starts from the threshold of the one before. In the first, where all is refined, the
/// most that a group may take is spent on coarse levels, and the deep ones are not seen: alone it
/// let a prismatic film take three times `max_samples`.
const PILOT_ROUNDS: usize = 3;

/// No group takes more than this many times its share of samples: bounds memory where the pilots
/// misled.
const MOST_OF_MEAN: usize = 4;

/// Peaks of a slice for which the default number of samples is made: 59 and 70 of the slowest of
/// six virtual materials. With 38 peaks a value takes 0.74 of the time, with 17 0.42.
const USUAL_PEAKS: f64 = 60.0;

/// Incidences at which peaks are counted.
const COUNTED: usize = 64;

/// How many times the usual number of samples are drawn, 0.6 to 1.5, by the number of a slice's
/// peaks. Many peaks are slow to tabulate and to fit, too: 0.77 for 70 keeps both below 20 s on two
/// cores. Smooth lookup asks for as many at least: with 0.7 for 70 its error is a third larger; 1.5
/// for 38 is what ridges of two finest cells gain by.
fn sample_factor(source: &dyn Source) -> f64 {
    let mut peaks = Vec::new();
    for k in 1..=COUNTED {
        source.slice(square_to_hemisphere(plastic(k), source.incident())).peaks(&mut peaks);
    }
    match peaks.len() {
        0 => 1.0,
        count => (USUAL_PEAKS * COUNTED as f64 / count as f64).powf(1.6).clamp(0.6, 1.5),
    }
}

/// How many samples of a source are drawn for a tree, and on which levels.
pub(super) struct TreeSampling {
    pub(super) layout: Layout,
    pub(super) levels: Levels,
    pub(super) deepest: u32,
    pub(super) max_leaves: usize,
    pub(super) max_samples: usize,
}

impl TreeSampling {
    pub(super) fn new(
        source: &dyn Source,
        rank: Rank,
        depth: u32,
        settings: &TreeSettings,
    ) -> Result<Self> {
        if rank == Rank::Three && !source.isotropic() {
            return Err(Error::argument(
                "tree: expected an isotropic source for rank 3, found an anisotropic one",
            ));
        }
        settings.check()?;
        // The deepest levels that fit time and memory; beyond 4 and 16 times the default's slices.
        let (limit, coarse) = match rank {
            Rank::Three => (10, 4),
            Rank::Four => (8, 3),
        };
        if depth > limit {
            return Err(Error::limit(format!(
                "tree: rank {}: expected a depth of at most {limit}, found {depth} (files may have {MAX_DEPTH})",
                rank.dimensions()
            )));
        }
        let group = depth.max(usual_depth(rank)) - 1;
        let start = if rank == Rank::Four && group > 6 { coarse } else { coarse + 1 };
        let (leaves, mut samples) = settings.budget(rank, depth, source.isotropic());
        if rank == Rank::Four && settings.max_samples.is_none() {
            samples = (samples as f64 * sample_factor(source)) as usize;
        }
        Ok(Self {
            layout: Layout(rank),
            levels: Levels { top: coarse, group, start },
            deepest: depth,
            max_leaves: leaves,
            max_samples: samples,
        })
    }

    pub(super) fn groups(&self) -> usize {
        self.layout.incident_cells(self.levels.group)
    }

    /// Samples group `z`.
    fn mosaic(&self, source: &dyn Source, z: usize, threshold: f64, most: usize) -> Mosaic {
        let slices = [0, 1, 2, 3].map(|s| {
            source.slice(self.layout.incident(self.levels.group, z, s, source.incident()))
        });
        let side = source.scattered();
        Mosaic::sample(
            std::array::from_fn(|s| &*slices[s]),
            &Sampling {
                place: &|_, point| square_to_hemisphere(point, side),
                find: &|w| Some((0, disk_to_square(w.truncate()))),
                roots: 1,
                width: &|_| 2.0,
                measure: &|_| 1.0,
                start: self.levels.start,
                // One level below the deepest, so that its cells have four samples where it counts.
                deepest: self.levels.group + 2,
                stratified: self.levels.group,
                within: DVec2::splat(0.5),
                slice_of: self.layout.slice_of(),
                channels: source.channels(),
                kept: 1,
                seeding: TREE_SEEDING,
                threshold,
                most,
            },
        )
    }

    /// The threshold at which sampling every group takes `max_samples`, from a few groups.
    ///
    /// Errors: limit when cancelled.
    pub(super) fn threshold(
        &self,
        source: &dyn Source,
        least: f64,
        watch: &Watch<'_>,
    ) -> Result<f64> {
        let mean = self.max_samples / self.groups();
        let groups: Vec<usize> = (0..PILOTS.min(self.groups() / ONE_IN).max(1))
            // In Z order: even over the square.
            .map(|k| (golden(k) * self.groups() as f64) as usize)
            .collect();
        let start = 4usize << (2 * self.levels.start);
        let mut threshold = least;
        for _ in 0..PILOT_ROUNDS {
            let mosaics = groups
                .par_iter()
                .map(|&z| {
                    watch.check()?;
                    Ok(self.mosaic(source, z, threshold, MOST_OF_MEAN * mean))
                })
                .collect::<Result<Vec<Mosaic>>>()?;
            let seeded = mosaics.iter().map(|m| m.seeded).sum::<usize>();
            let refinements =
                (mean.saturating_sub(start) * groups.len() / 16).saturating_sub(seeded);
            let mut scores: Vec<f64> = mosaics.into_iter().flat_map(|m| m.scores).collect();
            scores.sort_by(|a, b| b.total_cmp(a));
            match scores.get(refinements) {
                Some(&score) => threshold = score,
                None => break,
            }
        }
        Ok(threshold)
    }

    /// Samples everything; subtrees are assembled job by job.
    pub(super) fn fine(
        &self,
        source: &dyn Source,
        threshold: f64,
        watch: &Watch<'_>,
    ) -> Result<(Fine, usize)> {
        let jobs = self.layout.incident_cells(self.levels.top);
        let share = self.groups() / jobs;
        let most = MOST_OF_MEAN * self.max_samples / self.groups();
        let done = AtomicUsize::new(0);
        let parts = (0..jobs)
            .into_par_iter()
            .map(|job| {
                let mut mosaics = Vec::with_capacity(share);
                for z in job * share..(job + 1) * share {
                    watch.check()?;
                    mosaics.push(self.mosaic(source, z, threshold, most));
                }
                let samples: usize = mosaics.iter().map(Mosaic::spent).sum();
                let assembly = Assembly {
                    layout: self.layout,
                    levels: self.levels,
                    mosaics: &mosaics,
                    threshold,
                };
                let subtrees = assembly.subtrees();
                watch.finished(&done, jobs);
                Ok((subtrees, samples))
            })
            .collect::<Result<Vec<_>>>()?;
        let samples = parts.iter().map(|p| p.1).sum();
        let subtrees = parts.into_iter().flat_map(|p| p.0).collect();
        Ok((Fine { layout: self.layout, levels: self.levels, subtrees }, samples))
    }
}
