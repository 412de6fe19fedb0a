//! What is done to the components of one band.

use super::light::largest_total;
use crate::matrix::KlemsMatrix;
use crate::reciprocity::reciprocal_mean;
use crate::tree::{Rank, TensorTree, TreeDistribution};
use crate::{Bsdf, Component, Lambertian, Metadata, Side};

/// Scattered light beyond the incident that is scaled away; more is no matter of calibration. A guess.
const MOST: f64 = 1.2;

/// The same matrix with `f(incident, scattered, value)` in every channel.
fn mapped(matrix: &KlemsMatrix, f: impl Fn(usize, usize, f64) -> f64) -> Option<KlemsMatrix> {
    let columns = matrix.scattered().directions();
    let channel = |values: &[f32]| -> Vec<f32> {
        let at = |(k, v): (usize, &f32)| f(k / columns, k % columns, f64::from(*v)) as f32;
        values.iter().enumerate().map(at).collect()
    };
    let (incident, scattered) = (matrix.incident().clone(), matrix.scattered().clone());
    let new = KlemsMatrix::new(incident, scattered, channel(matrix.values())).ok()?;
    match matrix.chromatic() {
        Some([x, z]) => new.with_colour(channel(x), channel(z)).ok(),
        None => Some(new),
    }
}

fn matrix(c: &Component) -> Option<&KlemsMatrix> {
    c.distribution().downcast_ref()
}

fn tree(c: &Component) -> Option<&TreeDistribution> {
    c.distribution().downcast_ref()
}

/// Shares of light by patch → values in 1/sr; `None` for a tree, whose cells are none of the file's patches.
pub(super) fn from_shares(c: &Component) -> Option<Component> {
    let shares = matrix(c)?;
    let basis = shares.scattered();
    let values = mapped(shares, |_, o, share| share / basis.projected_solid_angle(o))?;
    Some(Component::new(c.incident, c.scattered, values))
}

/// Gives those of `sides` that a reader left out as dummies a matrix again, as programs want every direction: a
/// transmission is the other one reversed, anything else 0.
pub(super) fn fill(list: &mut Vec<Component>, sides: &[(Side, Side)]) {
    for &(incident, scattered) in sides {
        let between = |i, s| move |c: &&Component| (c.incident, c.scattered) == (i, s);
        if list.iter().any(|c| between(incident, scattered)(&c)) {
            continue;
        }
        let Some(some) = list.iter().find_map(matrix) else { return };
        let zeros = || mapped(some, |_, _, _| 0.0);
        let opposite = list.iter().filter(|_| incident != scattered);
        let opposite = opposite.filter(between(scattered, incident)).find_map(matrix);
        let Some(new) = opposite.and_then(|m| m.reversed().ok()).or_else(zeros) else { continue };
        list.push(Component::new(incident, scattered, new));
    }
}

/// Scaled down so that no side scatters more than arrives: a matrix by incident patch, else the whole component.
///
/// What scatters far too much is left as it is.
pub(super) fn scaled(mut list: Vec<Component>) -> Vec<Component> {
    for side in [Side::Front, Side::Back] {
        let bsdf = Bsdf::new(Metadata::default(), list.clone(), Lambertian::default());
        let Some(most) = largest_total(&bsdf, side).map(|most| most.total) else { continue };
        if !(most > 1.0 && most <= MOST) {
            continue;
        }
        let factors = by_patch(&list, side);
        let touches =
            |c: &Component| c.incident == side || (c.is_transmission() && factors.is_none());
        for c in list.iter_mut().filter(|c| touches(c)) {
            let new = match (&factors, matrix(c), tree(c)) {
                (Some(factors), Some(m), _) => {
                    mapped(m, |i, _, v| v * factors[i]).map(|m| of(c, m))
                }
                (None, Some(m), _) => mapped(m, |_, _, v| v / most).map(|m| of(c, m)),
                (_, _, Some(t)) => divided(t, most).map(|t| of(c, t)),
                _ => None,
            };
            if let Some(new) = new {
                *c = new;
            }
        }
    }
    list
}

fn of(c: &Component, distribution: impl crate::Distribution) -> Component {
    Component::new(c.incident, c.scattered, distribution)
}

/// Of each incident patch the factor that leaves 1; `None` where light from `side` is not all stored in matrices of one
/// incident basis.
fn by_patch(list: &[Component], side: Side) -> Option<Vec<f64>> {
    let lone = list.iter().any(|c| c.is_transmission() && c.scattered == side)
        && !list.iter().any(|c| c.is_transmission() && c.incident == side);
    let of_side = || list.iter().filter(|c| c.incident == side);
    let first = matrix(of_side().next()?)?.incident();
    if lone || !of_side().all(|c| matrix(c).is_some_and(|m| m.incident() == first)) {
        return None;
    }
    let mut totals = vec![0.0; first.directions()];
    for m in of_side().filter_map(matrix) {
        let (basis, columns) = (m.scattered(), m.scattered().directions());
        let omega: Vec<f64> = (0..columns).map(|o| basis.projected_solid_angle(o)).collect();
        for (total, row) in totals.iter_mut().zip(m.values().chunks(columns)) {
            *total += row.iter().zip(&omega).map(|(v, omega)| f64::from(*v) * omega).sum::<f64>();
        }
    }
    Some(totals.iter().map(|total| 1.0 / total.max(1.0)).collect())
}

fn divided(tree: &TreeDistribution, by: f64) -> Option<TreeDistribution> {
    let y = tree.luminance();
    // A slot with its highest bit numbers a branch.
    let value = |slot: u32| (f64::from(f32::from_bits(slot)) / by) as f32;
    let new = |slot: u32| if slot >> 31 == 0 { value(slot).to_bits() } else { slot };
    let slots = y.slots().iter().map(|slot| new(*slot)).collect();
    let y = TensorTree::from_slots(y.rank(), new(y.root_slot()), slots).ok()?;
    match tree.chromaticity() {
        Some([u, v]) => TreeDistribution::with_chromaticity(y, u.clone(), v.clone()).ok(),
        None => Some(TreeDistribution::new(y)),
    }
}

/// The mean of both directions of travel, of reflection and of a transmission stored both ways.
///
/// What has no reverse on its own grid (trees of rank 3 or with colour, odd rings) stays as it is.
pub(super) fn averaged(list: &[Component]) -> Vec<Component> {
    let mean = |c: &Component| {
        let back = list.iter().find(|o| (o.incident, o.scattered) == (c.scattered, c.incident))?;
        if let (Some(m), Some(back)) = (matrix(c), matrix(back)) {
            return mean_of_matrices(m, back).map(|m| of(c, m));
        }
        let grey =
            |c| tree(c).filter(|t| t.chromaticity().is_none()).map(TreeDistribution::luminance);
        let (f, g) = (grey(c)?, grey(back)?);
        let both = f.rank() == Rank::Four && g.rank() == Rank::Four;
        both.then(|| reciprocal_mean(f, g).ok()).flatten().map(|t| of(c, TreeDistribution::new(t)))
    };
    list.iter().map(|c| mean(c).unwrap_or_else(|| c.clone())).collect()
}

fn mean_of_matrices(m: &KlemsMatrix, back: &KlemsMatrix) -> Option<KlemsMatrix> {
    let back = back.reversed().ok()?;
    if back.incident() != m.incident() || back.scattered() != m.scattered() {
        return None;
    }
    let channel = |a: &[f32], b: &[f32]| -> Vec<f32> {
        a.iter().zip(b).map(|(a, b)| 0.5 * a + 0.5 * b).collect()
    };
    let (incident, scattered) = (m.incident().clone(), m.scattered().clone());
    let mean = KlemsMatrix::new(incident, scattered, channel(m.values(), back.values())).ok()?;
    match (m.chromatic(), back.chromatic()) {
        (Some([x, z]), Some([bx, bz])) => mean.with_colour(channel(x, bx), channel(z, bz)).ok(),
        (None, None) => Some(mean),
        _ => None,
    }
}
