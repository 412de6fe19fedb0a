//! What a tree may cost, and what it has cost.

use bsdfkit::tree::{Rank, TensorTree};
use bsdfkit::{Error, Result};

use super::missed::{Limit, Missed};
use super::reciprocity::Reciprocity;
use super::subtree_cost::{BRANCH_BYTES, VALUE_BYTES};

/// What a tree may cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeSettings {
    /// Rank; by default three for an isotropic source, else four.
    pub rank: Option<Rank>,
    /// L1 that the tree may add: share of an incidence's flux in a wrong place, mean over
    /// incidences; as much is the light of an incidence as a whole off at most, root mean square.
    pub max_error: f64,
    /// Most values in the tree; goes before `max_error`. By default 3 million at rank 4, 1 million
    /// where the source is isotropic, 70,000 at rank 3.
    pub max_leaves: Option<usize>,
    /// Deepest level: leaves are at least 2^−depth wide. By default 7 at rank 4, 9 at rank 3, 8
    /// where a matrix is converted; one level more where `max_leaves` is above its default and
    /// `max_error` not reached otherwise.
    pub max_depth: Option<u32>,
    /// Values that may be asked of the source. By default 22 million at rank 4 and 8 million at
    /// rank 3, at rank 4 0.6 to 1.5 times as many: more of sources with few peaks, whose values
    /// cost less.
    pub max_samples: Option<usize>,
    /// Whether f(ωi, ωo) and f(ωo, ωi) are averaged.
    pub reciprocity: Reciprocity,
    /// Whether the bands of a spectral source are kept, a byte a leaf and coefficient.
    pub bands: bool,
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
            bands: true,
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
    /// The defaults make files of 21 MB at rank 4 (Radiance's with 2^6 cells have 27) and of 0.54
    /// MB at rank 3 on six virtual materials, for 5 to 25 s of processor time from interpolants.
    /// Deeper trees have as many samples for an incident direction: with fewer they are worse. An
    /// isotropic source at rank 4, beside an anisotropic one in a file, repeats in every azimuth
    /// what rank 3 has once, and must not double the file: a third of the leaves. A guess: fritted
    /// glass has an L1 of 0.18 with 3 million, 0.23 with 1 million, 0.30 with 300,000.
    pub(super) fn budget(&self, rank: Rank, depth: u32, isotropic: bool) -> (usize, usize) {
        let (leaves, samples) = match (rank, isotropic) {
            (Rank::Three, _) => (70_000, 8_000_000),
            (Rank::Four, false) => (3_000_000, 22_000_000),
            (Rank::Four, true) => (1_000_000, 22_000_000),
        };
        let deeper = depth.saturating_sub(usual_depth(rank)) * rank.incident_dimensions();
        (self.max_leaves.unwrap_or(leaves), self.max_samples.unwrap_or(samples << deeper))
    }
}

/// Deepest level unless more is asked for: what default sizes of trees have a use for.
pub(super) fn usual_depth(rank: Rank) -> u32 {
    match rank {
        // At 8 the last cell is that from 83 degrees on, and the last but one begins at 80.
        Rank::Three => 9,
        Rank::Four => 7,
    }
}

/// What a tree has cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeReport {
    /// Estimate of the L1 that the tree adds.
    pub error: f64,
    /// How far the light of an incident cell is from the source's, root mean square of the ratio less 1.
    pub energy_error: f64,
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
            energy_error: 0.0,
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
