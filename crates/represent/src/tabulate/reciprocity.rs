//! Helmholtz reciprocity, f(ωi, ωo) = f(ωo, ωi): whether a BSDF has it, and averaging a tree over
//! it.

use bsdfkit::matrix::KlemsMatrix;
use bsdfkit::{Error, Result};
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::square_to_hemisphere;
use bsdfkit_sphere::sequence::quintic;
use rayon::prelude::*;

use super::fine::{Fine, Node, Subtree};
use crate::source::Source;

/// Whether f(ωi, ωo) and f(ωo, ωi) are averaged; only reflection has both on one pair of sides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reciprocity {
    /// Where a check on the source finds that they agree.
    #[default]
    Auto,
    /// Always.
    On,
    /// Never.
    Off,
}

/// Disagreement, Σ|f − f'| / Σ(f + f') over pairs, up to which `Auto` averages: below it both are
/// the same within what interpolation errs, and the mean halves their noise; above it one of the
/// two is wrong and the mean spreads its fault. A guess between the two; doubled, averaging blurs
/// peaks that interpolation has misplaced.
pub const AUTO_DISAGREEMENT: f64 = 0.05;

/// Pairs of directions by which reciprocity is checked: 40 ms at 50 µs a slice.
const PAIRS: usize = 400;

/// Σ|f(a, b) − f(b, a)| / Σ(f(a, b) + f(b, a)) over pairs of measured directions; `None` where
/// the sides differ or nothing scatters.
pub fn disagreement(source: &dyn Source) -> Option<f64> {
    if source.incident() != source.scattered() {
        return None;
    }
    let side = source.incident();
    let (mut difference, mut sum) = (0.0, 0.0);
    let channels = source.channels();
    let value = |wi, wo| {
        let mut out = vec![0.0f32; channels];
        source.value(wi, wo, &mut out);
        if out[0].is_finite() { f64::from(out[0].max(0.0)) } else { 0.0 }
    };
    for k in 0..PAIRS {
        let [x, y, z, w] = quintic(k + 1);
        let a = square_to_hemisphere(DVec2::new(x, y), side);
        // Half of the pairs about the mirror direction, where peaks are.
        let b = if k % 2 == 0 {
            square_to_hemisphere(DVec2::new(z, w), side)
        } else {
            let off = DVec2::new(z - 0.5, w - 0.5) * 0.2;
            let mirror = off - a.truncate();
            let mirror = mirror / mirror.length().max(1.0);
            bsdfkit_sphere::concentric::disk_to_hemisphere(mirror, side)
        };
        if source.is_measured(a) && source.is_measured(b) {
            let (f, reverse) = (value(a, b), value(b, a));
            difference += (f - reverse).abs();
            sum += f + reverse;
        }
    }
    (sum > 0.0).then(|| difference / sum)
}

/// Whether to average.
///
/// Errors: argument for `On` with transmission.
pub(super) fn applies(reciprocity: Reciprocity, source: &dyn Source) -> Result<bool> {
    match reciprocity {
        Reciprocity::Off => Ok(false),
        Reciprocity::Auto => Ok(disagreement(source).is_some_and(|d| d <= AUTO_DISAGREEMENT)),
        Reciprocity::On if source.incident() == source.scattered() => Ok(true),
        Reciprocity::On => Err(no_reflection()),
    }
}

/// Of a transmission whose reciprocal values are to be averaged.
pub(super) fn no_reflection() -> Error {
    Error::argument(
        "reciprocity: expected reflection, found transmission, which has its reverse in another component",
    )
}

/// ½ (f(ωi, ωo) + f(ωo, ωi)) of a matrix.
///
/// Convention: incident patches are of travel directions: exchange takes patches (i, o) to the
/// point reflections of (o, i).
///
/// Errors: argument for bases that differ, and for patches that have no mirror image about the
/// normal.
pub(super) fn exchanged_mean(matrix: &KlemsMatrix) -> Result<KlemsMatrix> {
    let basis = matrix.incident();
    if basis != matrix.scattered() {
        return Err(Error::argument(
            "reciprocity: expected one basis for both directions, found two",
        ));
    }
    let mut reflected = Vec::with_capacity(basis.directions());
    for ring in basis.rings() {
        let (first, n) = (reflected.len(), ring.patches);
        if n > 1 && !n.is_multiple_of(2) {
            return Err(Error::argument(format!(
                "reciprocity: expected an even number of azimuths in each ring, found {n} up to {} degrees",
                ring.upper_degrees
            )));
        }
        reflected.extend((0..n).map(|k| first + (k + n / 2) % n));
    }
    let n = basis.directions();
    let mean = |values: &[f32]| -> Vec<f32> {
        let exchanged = |k: usize| values[reflected[k % n] * n + reflected[k / n]];
        (0..n * n).map(|k| 0.5 * (values[k] + exchanged(k))).collect()
    };
    let new = KlemsMatrix::new(basis.clone(), basis.clone(), mean(matrix.values()))?;
    match matrix.chromatic() {
        Some([x, z]) => new.with_colour(mean(x), mean(z)),
        None => Ok(new),
    }
}

/// Rank 4: the mean of a tabulation and of its exchange of incident and scattered direction.
///
/// Incident cells are of travel directions: exchange puts the scattered cell's point reflection in
/// the place of the incident cell, and the other way round.
pub(super) fn average(fine: &Fine) -> Fine {
    let cells = 1usize << (2 * fine.levels.top);
    let subtrees = (0..cells * cells)
        .into_par_iter()
        .map(|k| {
            let (z, s) = (k / cells, k % cells);
            // All bits of a Z-order number flipped: the point reflection.
            let partner = &fine.subtrees[(cells - 1 - s) * cells + (cells - 1 - z)].nodes;
            let mut nodes = vec![fine.subtrees[k].nodes[0]];
            nodes[0] = mean(&fine.subtrees[k].nodes, 0, partner, 0, &mut nodes);
            Subtree { nodes }
        })
        .collect();
    Fine { layout: fine.layout, levels: fine.levels, subtrees }
}

fn mean(a: &[Node], at: usize, b: &[Node], bt: usize, to: &mut Vec<Node>) -> Node {
    let (x, y) = (a[at], b[bt]);
    let both = |f: fn(&Node) -> f32| 0.5 * (f(&x) + f(&y));
    let mut node = Node { value: both(|n| n.value), spread: both(|n| n.spread), first: 0 };
    if x.first != 0 || y.first != 0 {
        let mut children = [node; 16];
        for (c, child) in children.iter_mut().enumerate() {
            let exchanged = 4 * (3 - c % 4) + (3 - c / 4);
            let p = if x.first == 0 {
                (std::slice::from_ref(&a[at]), 0)
            } else {
                (a, x.first as usize + c)
            };
            let q = if y.first == 0 {
                (std::slice::from_ref(&b[bt]), 0)
            } else {
                (b, y.first as usize + exchanged)
            };
            *child = mean(p.0, p.1, q.0, q.1, to);
        }
        node.first = to.len() as u32;
        to.extend_from_slice(&children);
    }
    node
}
