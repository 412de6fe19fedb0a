//! Spectra of a tree's leaves.

use bsdfkit::Result;
use bsdfkit::spectrum::Hue;
use bsdfkit::tree::{Leaf, Rank, TensorTree, TreeHues};
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::{DVec2, DVec3};
use rayon::prelude::*;

use super::layout::Layout;
use super::mosaic::even_bits;
use crate::source::Source;
use crate::watch::Watch;

/// Quarters of a leaf's scattered cell in which its bands are looked at, each by an incidence of its own: in a tree of rank 4, of which
/// there are many leaves, two that lie across.
fn quarters(rank: Rank) -> &'static [usize] {
    match rank {
        Rank::Three => &[0, 1, 2, 3],
        Rank::Four => &[0, 3],
    }
}

/// Leaves of one incident cell that are looked at together.
const TOGETHER: usize = 4096;

/// The hues of the leaves of `tree`, made of `source`: each is that of the mean over a few pairs in its cells.
///
/// Errors: limit when cancelled. Cost: two or four spectra a leaf.
pub(super) fn tree_hues(
    source: &dyn Source,
    tree: &TensorTree,
    hue: Hue,
    watch: &Watch<'_>,
) -> Result<TreeHues> {
    let mut leaves = tree.leaf_cells();
    leaves.sort_unstable_by_key(|l| (l.level, l.incident, l.row));
    let same = |a: &Leaf, b: &Leaf| (a.level, a.incident) == (b.level, b.incident);
    let jobs: Vec<&[Leaf]> =
        leaves.chunk_by(same).flat_map(|group| group.chunks(TOGETHER)).collect();
    let found = jobs.par_iter().map(|leaves| {
        watch.check()?;
        Ok(told(source, Layout(tree.rank()), &hue, leaves))
    });
    let found = found.collect::<Result<Vec<Vec<f64>>>>()?;
    let rank = hue.basis().rank();
    let mut coefficients = vec![f32::NAN; tree.hue_rows() * rank];
    for (leaves, found) in jobs.iter().zip(&found) {
        for (leaf, found) in leaves.iter().zip(found.chunks_exact(rank)) {
            let row = &mut coefficients[leaf.row as usize * rank..][..rank];
            row.iter_mut().zip(found).for_each(|(row, found)| *row = *found as f32);
        }
    }
    // Branches and what no direction reaches.
    let some: Vec<f32> = found.iter().flatten().take(rank).map(|v| *v as f32).collect();
    for row in coefficients.chunks_exact_mut(rank).filter(|row| row[0].is_nan()) {
        row.copy_from_slice(&some);
    }
    TreeHues::new(hue, &coefficients)
}

/// Coefficients of leaves of one incident cell.
fn told(source: &dyn Source, layout: Layout, hue: &Hue, leaves: &[Leaf]) -> Vec<f64> {
    let bands = hue.basis().bands().count();
    let mut sums = vec![0.0; bands * leaves.len()];
    let mut spectra = vec![0.0; bands * leaves.len()];
    let Some(first) = leaves.first() else { return Vec::new() };
    for &quarter in quarters(layout.0) {
        let slice = layout.slice_of()[quarter];
        let wi = layout.incident(first.level, first.incident as usize, slice, source.incident());
        let middle = |leaf: &Leaf| -> DVec3 {
            let z = leaf.scattered;
            let corner = DVec2::new(even_bits(z).into(), even_bits(z >> 1).into());
            let within = DVec2::new((quarter & 1) as f64, (quarter >> 1) as f64) * 0.5 + 0.25;
            let point = (corner + within) / f64::from(1u32 << leaf.level);
            square_to_hemisphere(point, source.scattered())
        };
        let wo: Vec<DVec3> = leaves.iter().map(middle).collect();
        source.spectra(wi, &wo, &mut spectra);
        sums.iter_mut().zip(&spectra).for_each(|(sum, f)| *sum += f);
    }
    let count = quarters(layout.0).len() as f64;
    sums.iter_mut().for_each(|sum| *sum /= count);
    let mut coefficients = Vec::with_capacity(leaves.len() * hue.basis().rank());
    sums.chunks_exact(bands).for_each(|f| hue.tell(f, &mut coefficients));
    coefficients
}
