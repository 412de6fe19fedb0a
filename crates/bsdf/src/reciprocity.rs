//! Helmholtz reciprocity f(i, o) = f(o, i): how far data are from it, and their nearest kin that
//! has it.
//!
//! Convention: between the two travel directions of a transmission no index of refraction
//! enters, as in the reference library.

use bsdfkit_sphere::{concentric, hilbert, sequence::golden};

use crate::component::Components;
use crate::error::{Error, Result};
use crate::tree::{Rank, Slot, TensorTree, TreeBuilder};
use crate::{Bsdf, Side};

/// ∫∫ |f(i, o) − f(o, i)| / ∫∫ (f(i, o) + f(o, i)) over projected solid angles: 0 reciprocal, 1
/// one-way.
///
/// For light from `incident` to `scattered`; equal sides mean reflection. A lone transmission
/// component answers both ways and has 0. `None` when nothing is scattered that way.
///
/// Accuracy: a mean over `pairs` directions spread evenly over incidences and, in each, drawn from
/// f; the standard error is about 1/√pairs at most, and what f never scatters is found from the
/// other end of the pair. Deterministic.
///
/// Cost: one sample and two look-ups a pair.
pub fn defect(bsdf: &Bsdf, incident: Side, scattered: Side, pairs: u32) -> Option<f64> {
    let way = if incident == scattered { Components::REFLECTION } else { Components::TRANSMISSION };
    // With (i, o) drawn from f, the mean of |f − f′| / (f + f′) is ½ ∫ |f − f′| / ∫ f, as
    // exchanging i and o maps one half of the integral onto the other.
    let (mut sum, mut mass) = (0.0, 0.0);
    for k in 0..pairs {
        let disk = concentric::square_to_disk(hilbert::unfold(f64::from(k) / f64::from(pairs)));
        let wi = concentric::disk_to_hemisphere(disk, incident);
        let Some(sample) = bsdf.sample(wi, golden(k as usize), way) else { continue };
        let (there, back) = (bsdf.eval(wi, sample.wo), bsdf.eval(sample.wo, wi));
        mass += sample.weight;
        sum += sample.weight * (there - back).abs() / (there + back).max(f64::MIN_POSITIVE);
    }
    (mass > 0.0).then(|| sum / mass)
}

/// ½ (f(i, o) + g(o, i)) as a tree: reciprocal with the same call for g and f.
///
/// For a reflection component f and g are one tree, and the result is reciprocal by itself; for
/// the two travel directions of a transmission call it twice. The mean of the values is kept (of f
/// and g together), the total of a single incidence is not.
///
/// Errors: argument, for rank 3: there the two polar angles have different grids.
pub fn reciprocal_mean(f: &TensorTree, g: &TensorTree) -> Result<TensorTree> {
    for tree in [f, g] {
        if tree.rank() != Rank::Four {
            return Err(Error::argument("reciprocal mean: expected trees of rank 4, found rank 3"));
        }
    }
    let mut builder = TreeBuilder::new(Rank::Four);
    mean([f, g], [f.root(), g.root()], &mut builder)?;
    builder.finish()
}

/// Exchanging the directions takes the cell (a, b) of incident and scattered square to (1 − b, 1 −
/// a): the incident square is that of the travel direction, hence mirrored at its centre.
fn mean(trees: [&TensorTree; 2], slots: [Slot; 2], builder: &mut TreeBuilder) -> Result<()> {
    if let [Slot::Leaf(f), Slot::Leaf(g)] = slots {
        return builder.leaf(0.5 * f + 0.5 * g);
    }
    builder.open_branch()?;
    for child in 0..16 {
        let (a, b) = (child & 3, child >> 2);
        let exchanged = (3 - b) | (3 - a) << 2;
        let below = [trees[0].child(slots[0], child), trees[1].child(slots[1], exchanged)];
        mean(trees, below, builder)?;
    }
    builder.close_branch()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tree::TreeDistribution;
    use crate::{Component, Lambertian, Metadata};

    /// Rank 4, two cells a dimension, values from `f(incident quadrant, scattered quadrant)`.
    fn tree(f: impl Fn(usize, usize) -> f32) -> TensorTree {
        let mut b = TreeBuilder::new(Rank::Four);
        b.open_branch().unwrap();
        (0..16).for_each(|child| b.leaf(f(child & 3, child >> 2)).unwrap());
        b.close_branch().unwrap();
        b.finish().unwrap()
    }

    fn reflection(tree: TensorTree) -> Bsdf {
        let c = Component::new(Side::Front, Side::Front, TreeDistribution::new(tree));
        Bsdf::new(Metadata::default(), vec![c], Lambertian::default())
    }

    #[test]
    fn defect_has_its_closed_form() {
        let of = |t| defect(&reflection(t), Side::Front, Side::Front, 4096).unwrap();
        // One way only: incident quadrant 0 (travel) to scattered 0; back would be 3 to 3.
        assert_eq!(of(tree(|a, b| f32::from(a == 0 && b == 0))), 1.0);
        // On the diagonal both ways: i's quadrant mirrored is o's.
        assert_eq!(of(tree(|a, b| f32::from(a == b))), 0.0);
        // 3 one way, 1 the other: |3 − 1| / (3 + 1).
        let uneven = tree(|a, b| [0.0, 3.0, 0.0, 1.0][(a == b) as usize * (a | 1)]);
        assert!((of(uneven) - 0.5).abs() < 1e-12);
        assert!(defect(&reflection(tree(|_, _| 0.0)), Side::Front, Side::Front, 64).is_none());
    }

    #[test]
    fn the_mean_is_reciprocal_and_keeps_the_mean() {
        let uneven = tree(|a, b| (3 * a + b) as f32);
        let even = reciprocal_mean(&uneven, &uneven).unwrap();
        assert_eq!(even.mean(), uneven.mean());
        assert!(defect(&reflection(uneven), Side::Front, Side::Front, 4096).unwrap() > 0.05);
        assert_eq!(defect(&reflection(even), Side::Front, Side::Front, 4096), Some(0.0));
    }

    #[test]
    fn rank_three_is_refused() {
        let flat = TensorTree::constant(Rank::Three, 1.0).unwrap();
        assert!(reciprocal_mean(&flat, &flat).is_err());
    }
}
