//! Continuous BSDF → tensor tree. [WKB14 §2.3]

use std::f64::consts::PI;
use std::sync::atomic::AtomicUsize;

use bsdfkit::tree::{MAX_DEPTH, Rank, TensorTree};
use bsdfkit::{Error, NEGLIGIBLE_TOTAL, Result};
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::{disk_to_square, square_to_hemisphere};
use bsdfkit_sphere::sequence::{golden, plastic};
use rayon::prelude::*;

use super::choice::{BRANCH_BYTES, VALUE_BYTES};
use super::exchange::Exchanged;
use super::fine::{Assembly, Fine, Levels};
use super::layout::Layout;
use super::missed::{Limit, Missed};
use super::mosaic::{Mosaic, Sampling, Seeding};
use super::prune::Pruner;
use super::reciprocity::{self, Reciprocity};
use crate::source::Source;
use crate::watch::Watch;

/// What a tree may cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeSettings {
    /// Rank; by default three for an isotropic source, else four.
    pub rank: Option<Rank>,
    /// L1 that the tree may add: share of an incidence's flux in a wrong place, mean over incidences.
    pub max_error: f64,
    /// Most values in the tree; goes before `max_error`. By default 3 million at rank 4, 1 million where
    /// the source is isotropic, 60,000 at rank 3.
    pub max_leaves: Option<usize>,
    /// Deepest level: leaves are at least 2^−depth wide. By default 7 at rank 4, 8 at rank 3 and where a
    /// matrix is converted; one level more where `max_leaves` is above its default and `max_error` not reached otherwise.
    pub max_depth: Option<u32>,
    /// Values that may be asked of the source. By default 22 million at rank 4 and 4 million at rank 3,
    /// at rank 4 0.6 to 1.5 times as many: more of sources with few peaks, whose values cost less.
    pub max_samples: Option<usize>,
    /// Whether f(ωi, ωo) and f(ωo, ωi) are averaged.
    pub reciprocity: Reciprocity,
}

impl Default for TreeSettings {
    fn default() -> Self {
        Self {
            rank: None,
            max_error: 0.01,
            max_leaves: None,
            max_depth: None,
            max_samples: None,
            reciprocity: Reciprocity::Auto,
        }
    }
}

impl TreeSettings {
    /// Most values that may be asked for: 120 MB of XML.
    pub const MOST_LEAVES: usize = 1 << 24;

    /// Errors: argument, for an error that is none.
    pub(super) fn check(&self) -> Result<()> {
        if self.max_error.is_nan() || self.max_error < 0.0 {
            return Err(Error::argument(format!(
                "tree: expected a largest error of at least 0, found {}",
                self.max_error
            )));
        }
        Ok(())
    }

    /// `max_error` and what stood in its way, if a tree of `leaves` and `error` has not reached it;
    /// `otherwise` where values are left.
    pub(super) fn missed(
        &self,
        error: f64,
        leaves: usize,
        max_leaves: usize,
        otherwise: Limit,
    ) -> Option<Missed> {
        // Pruning aims at most values from inside.
        let full = leaves > max_leaves - max_leaves / 10;
        let limit = if full { Limit::Leaves(max_leaves) } else { otherwise };
        (error > self.max_error).then_some(Missed { target: self.max_error, limit })
    }

    /// Most values in the tree and asked of the source for leaves of `depth`.
    ///
    /// The defaults make files of 21 MB at rank 4 (Radiance's with 2^6 cells have 27) and of
    /// 0.46 MB at rank 3 on six virtual materials, for 5 to 25 s of processor time from interpolants.
    /// Deeper trees have as many samples for an incident direction: with fewer they are worse.
    /// An isotropic source at rank 4, beside an anisotropic one in a file, repeats in every azimuth what
    /// rank 3 has once, and must not double the file: a third of the leaves. A guess: fritted glass
    /// has an L1 of 0.18 with 3 million, 0.23 with 1 million, 0.30 with 300,000.
    pub(super) fn budget(&self, rank: Rank, depth: u32, isotropic: bool) -> (usize, usize) {
        let (leaves, samples) = match (rank, isotropic) {
            (Rank::Three, _) => (60_000, 4_000_000),
            (Rank::Four, false) => (3_000_000, 22_000_000),
            (Rank::Four, true) => (1_000_000, 22_000_000),
        };
        let deeper = depth.saturating_sub(usual_depth(rank)) * rank.incident_dimensions();
        (self.max_leaves.unwrap_or(leaves), self.max_samples.unwrap_or(samples << deeper))
    }
}

/// Deepest level unless more is asked for: what default sizes of trees have a use for.
fn usual_depth(rank: Rank) -> u32 {
    match rank {
        Rank::Three => 8,
        Rank::Four => 7,
    }
}

/// What a tree has cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeReport {
    /// Estimate of the L1 that the tree adds.
    pub error: f64,
    /// Values in the tree.
    pub leaves: usize,
    /// Estimated size of the tree in the XML.
    pub bytes: f64,
    /// Slices asked of the source.
    pub slices: usize,
    /// Values asked of the source.
    pub samples: usize,
    /// Whether reciprocal values were averaged.
    pub reciprocity: bool,
    /// Whether the source is one leaf because it scatters too little to count:
    /// [`NEGLIGIBLE_TOTAL`](bsdfkit::NEGLIGIBLE_TOTAL) at most at any incidence.
    pub negligible: bool,
    /// The largest error that was not reached, and why.
    pub missed: Option<Missed>,
}

impl TreeReport {
    /// Of a tree that holds exact means and adds nothing.
    pub(super) fn exact(tree: &TensorTree) -> Self {
        let (leaves, branches) = (tree.leaf_count(), tree.branch_count());
        Self {
            error: 0.0,
            leaves,
            bytes: VALUE_BYTES * leaves as f64 + BRANCH_BYTES * branches as f64,
            slices: 0,
            samples: 0,
            reciprocity: false,
            negligible: false,
            missed: None,
        }
    }

    /// The one leaf of a source that does not count.
    pub(super) fn negligible(tree: &TensorTree) -> Self {
        Self { negligible: true, ..Self::exact(tree) }
    }
}

/// Peaks of a slice for which the default number of samples is made: 59 and 70 of the slowest of six virtual
/// materials. With 38 peaks a value takes 0.74 of the time, with 17 0.42.
const USUAL_PEAKS: f64 = 60.0;

/// Incidences at which peaks are counted.
const COUNTED: usize = 64;

/// How many times the usual number of samples are drawn, 0.6 to 1.5, by the number of a slice's peaks. Many
/// peaks are slow to tabulate and to fit, too: 0.77 for 70 keeps both below 20 s on two cores. Smooth lookup asks
/// for as many at least: with 0.7 for 70 its error is a third larger; 1.5 for 38 is what ridges of two finest cells
/// gain by.
fn ease(source: &dyn Source) -> f64 {
    let mut peaks = Vec::new();
    for k in 1..=COUNTED {
        source.slice(square_to_hemisphere(plastic(k), source.incident())).peaks(&mut peaks);
    }
    match peaks.len() {
        0 => 1.0,
        count => (USUAL_PEAKS * COUNTED as f64 / count as f64).powf(1.6).clamp(0.6, 1.5),
    }
}

/// Defaults and levels by rank.
struct Plan {
    layout: Layout,
    levels: Levels,
    deepest: u32,
    max_leaves: usize,
    max_samples: usize,
}

impl Plan {
    fn new(source: &dyn Source, rank: Rank, depth: u32, settings: &TreeSettings) -> Result<Self> {
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
            samples = (samples as f64 * ease(source)) as usize;
        }
        Ok(Self {
            layout: Layout(rank),
            levels: Levels { top: coarse, group, start },
            deepest: depth,
            max_leaves: leaves,
            max_samples: samples,
        })
    }

    fn groups(&self) -> usize {
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
                seeding: SEEDING,
                threshold,
                most,
            },
        )
    }

    /// The threshold at which sampling every group takes `max_samples`, from a few groups.
    ///
    /// Errors: limit when cancelled.
    fn threshold(&self, source: &dyn Source, least: f64, watch: &Watch<'_>) -> Result<f64> {
        let mean = self.max_samples / self.groups();
        let groups: Vec<usize> = (0..PILOTS.min(self.groups()))
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
    fn fine(
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

/// The middle of each peak down to cells in which a sample sees it: its skirts are found from
/// there. At half the width or with a reach, seeds of many lobes take three times `max_samples`.
const SEEDING: Seeding = Seeding { width: 6.0, reach: 0.0 };

/// Groups of incidences that set the threshold: 3 % of them.
const PILOTS: usize = 128;

/// Each round starts from the threshold of the one before. In the first, where all is refined, the
/// most that a group may take is spent on coarse levels, and the deep ones are not seen: alone it
/// let a prismatic film take three times `max_samples`.
const PILOT_ROUNDS: usize = 3;

/// No group takes more than this many times its share of samples: bounds memory where the pilots misled.
const MOST_OF_MEAN: usize = 4;

/// Share of `max_error` below which no cell is refined, whatever samples are left. A guess:
/// thousands of cells make an incidence.
const LEAST_SCORE: f64 = 1e-5;

/// Continuous BSDF → tensor tree of at most `max_leaves` values, of `max_error` if these suffice.
///
/// Meaning: leaf values are means over incident and scattered cell, so integrals are kept;
/// refined top-down from the source, then pruned bottom-up, rate against distortion.
/// Convention: see [`Rank`]; the tree is of the source's one (incident, scattered) pair of sides.
/// Accuracy: the stated error is that of unseen incidences to 20 % of itself (tests).
/// Errors: argument for contradictory settings; limit for too deep a tree, or cancelled.
/// Cost: the same tree at any number of threads; 16 k slices and 13 to 33 M values at rank 4, a
/// hundredth of the slices and 4 M values at rank 3.
pub fn tensor_tree(
    source: &dyn Source,
    settings: &TreeSettings,
    watch: &Watch<'_>,
) -> Result<(TensorTree, TreeReport)> {
    let rank = settings.rank.unwrap_or(if source.isotropic() { Rank::Three } else { Rank::Four });
    let usual = usual_depth(rank);
    let plan = Plan::new(source, rank, settings.max_depth.unwrap_or(usual), settings)?;
    let average = reciprocity::applies(settings.reciprocity, source)?;
    let exchanged;
    let source = if average && rank == Rank::Three {
        exchanged = Exchanged::new(source);
        &exchanged
    } else {
        source
    };
    let (tree, report) = pruned_tree(source, &plan, settings, average, watch)?;
    // Half of the values that may be had are not for want of values.
    let wanted = report.error > settings.max_error && report.leaves < plan.max_leaves / 2;
    let default_leaves =
        TreeSettings { max_leaves: None, ..*settings }.budget(rank, usual, source.isotropic()).0;
    if wanted && settings.max_depth.is_none() && plan.max_leaves > default_leaves {
        let deeper = Plan::new(source, rank, usual + 1, settings)?;
        return pruned_tree(source, &deeper, settings, average, watch);
    }
    Ok((tree, report))
}

/// The tree that `plan` leads to; `average`: with its exchange of incident and scattered direction.
fn pruned_tree(
    source: &dyn Source,
    plan: &Plan,
    settings: &TreeSettings,
    average: bool,
    watch: &Watch<'_>,
) -> Result<(TensorTree, TreeReport)> {
    let threshold = plan.threshold(source, LEAST_SCORE * settings.max_error, watch)?;
    let (mut fine, samples) = plan.fine(source, threshold, watch)?;
    if average && plan.layout.0 == Rank::Four {
        fine = reciprocity::average(&fine);
    }
    watch.check()?;
    let fluxes = fine.hemispherical();
    if fluxes.iter().all(|&flux| flux <= NEGLIGIBLE_TOTAL) {
        let mean = fluxes.iter().sum::<f64>() / (fluxes.len() as f64 * PI);
        let tree = TensorTree::constant(plan.layout.0, mean as f32)?;
        let report = TreeReport::negligible(&tree);
        return Ok((tree, TreeReport { slices: 4 * plan.groups(), samples, ..report }));
    }
    let pruner = Pruner::new(&fine, plan.deepest);
    let pruned = pruner.search(settings.max_error, plan.max_leaves);
    watch.check()?;
    let tree = pruner.build(pruned.lambda)?;
    let shallow = plan.deepest < usual_depth(plan.layout.0);
    let otherwise = match samples > plan.max_samples - plan.max_samples / 10 && !shallow {
        true => Limit::Samples(samples),
        false => Limit::Depth(plan.deepest),
    };
    let report = TreeReport {
        error: pruned.error,
        leaves: pruned.values,
        bytes: pruned.bytes,
        slices: 4 * plan.groups(),
        samples,
        reciprocity: average,
        negligible: false,
        missed: settings.missed(pruned.error, pruned.values, plan.max_leaves, otherwise),
    };
    Ok((tree, report))
}
