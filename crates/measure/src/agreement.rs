//! How far two measured distributions differ beyond what their noise and sampling explain.

use super::neighbours::Neighbours;
use super::{Image, Incidence};

/// Points at which two distributions are compared: 2 % of an L1 distance remain as its own scatter.
const QUERIES: usize = 2500;

/// An L1 distance between two distributions, relative to their light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Disagreement {
    /// Σ |a − b| / Σ |b|, weighed by projected solid angle.
    pub(super) distance: f64,
    /// The same sum for b against its own neighbouring points: noise and interpolation.
    pub(super) floor: f64,
}

impl Disagreement {
    /// What noise does not explain.
    pub(super) fn excess(self) -> f64 {
        (self.distance - self.floor).max(0.0)
    }
}

/// Compares `a`, seen through `image`, with `b`; `None` where they share no region.
///
/// Cost: O(n log n).
pub(super) fn compare(
    a: &Incidence,
    b: &Incidence,
    image: Image,
    channel: usize,
) -> Option<Disagreement> {
    let (tree_a, tree_b) = rayon::join(|| Neighbours::new(&a.wo), || Neighbours::new(&b.wo));
    let back = image.inverse();
    let step = b.wo.len().div_ceil(QUERIES).max(1);
    let (mut light, mut distance, mut floor) = (0.0, 0.0, 0.0);
    for index in (0..b.wo.len()).step_by(step) {
        let w = b.wo.at(index);
        let own = tree_b.nearest::<6>(w, Some(index));
        let Some(&(reach, _)) = own.items().last() else { continue };
        let other = tree_a.nearest::<6>(back.apply(w), None);
        // where `a` has a hole there is nothing to compare
        if other.items().first().is_none_or(|&(d, _)| d > reach) {
            continue;
        }
        let value = b.value(index, channel);
        let weight = reach * w.z.abs();
        light += weight * value.abs();
        distance += weight * (blend(a, other.items(), channel) - value).abs();
        floor += weight * (blend(b, own.items(), channel) - value).abs();
    }
    (light > 0.0).then(|| Disagreement { distance: distance / light, floor: floor / light })
}

/// Mean of the neighbours' values, by inverse squared distance.
fn blend(incidence: &Incidence, items: &[(f64, usize)], channel: usize) -> f64 {
    /// Squared chord below which points coincide: files carry a thousandth of a degree.
    const COINCIDENT: f64 = 1e-10;
    let (mut sum, mut weights) = (0.0, 0.0);
    for &(d, index) in items {
        let weight = 1.0 / (d + COINCIDENT);
        sum += weight * incidence.value(index, channel);
        weights += weight;
    }
    sum / weights
}
