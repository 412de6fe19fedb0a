//! Energy of a pruned tree: how far the light of each incidence is from the source's.
//!
//! A leaf holds the mean over its incident cell. Where leaves are wide and peaks move, the leaves that a single incidence sees
//! add up to more or less than what it scatters. L1 of an incidence is as large at least, but its mean over incidences
//! hides those that are off.

use bsdfkit::tree::{MAX_DEPTH, TensorTree};

use super::cells::for_each_leaf;
use super::layout::Layout;
use super::measured::LEAST_FLUX;

/// Root mean square over incident cells of `level` of the light that the tree scatters over that `wanted`, less 1.
///
/// `level`: none of the tree's leaves is below it. `wanted`: ∫ f cos θ dω by incident cell, Z order.
pub(super) fn error(tree: &TensorTree, layout: Layout, level: u32, wanted: &[f64]) -> f64 {
    let mut light: Vec<Vec<f64>> =
        (0..=level).map(|l| vec![0.0; layout.incident_cells(l)]).collect();
    for_each_leaf(tree, MAX_DEPTH, &mut |cell, value| {
        let area = std::f64::consts::PI / f64::from(1u32 << (2 * cell.level));
        light[cell.level as usize][cell.incident] += area * value;
    });
    for level in 1..light.len() {
        let (above, here) = light.split_at_mut(level);
        let used = here[0].len() / above[level - 1].len();
        for (z, sum) in here[0].iter_mut().enumerate() {
            *sum += above[level - 1][z / used];
        }
    }
    let least = LEAST_FLUX * wanted.iter().sum::<f64>() / wanted.len() as f64;
    let lit = light[level as usize].iter().zip(wanted).filter(|(_, wanted)| **wanted > least);
    let squares: Vec<f64> = lit.map(|(light, wanted)| (light / wanted - 1.0).powi(2)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use bsdfkit::tree::{Rank, TreeBuilder};

    use super::*;

    /// Two halves of the polar angles, each with one value; the incidences of one of them want a tenth more.
    #[test]
    fn what_is_off_is_found_at_the_incidences_where_it_is() {
        let mut builder = TreeBuilder::new(Rank::Four);
        builder.open_branch().unwrap();
        for child in 0..16 {
            builder.leaf(if child & 1 == 0 { 0.1 } else { 0.2 }).unwrap();
        }
        builder.close_branch().unwrap();
        let tree = builder.finish().unwrap();
        let of = |wanted: &[f64]| error(&tree, Layout(Rank::Four), 1, wanted);
        let (low, high) = (0.1 * std::f64::consts::PI, 0.2 * std::f64::consts::PI);
        assert!(of(&[low, high, low, high]) < 1e-7);
        let off = of(&[low, high / 1.1, low, high / 1.1]);
        assert!((off - (0.5f64 * 0.01).sqrt()).abs() < 1e-6, "{off}");
        // The dark do not count.
        assert!(of(&[low, high, low, 0.0]) < 1e-7);
    }
}
