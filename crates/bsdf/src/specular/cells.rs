//! Peaks of no width in the narrowest cells of trees and matrices: for programs that know no others.

use std::sync::Arc;

use super::Specular;
use crate::klems::KlemsBasis;
use crate::matrix::{KlemsMatrix, deposits};
use crate::tree::{Change, Deposits, Rank, TensorTree, TreeDistribution};
use crate::{Bsdf, Component, DVec3, Distribution, Error, Result, Side, Xyz};

/// Depths of trees that peaks are put into: cells of rank 3 at most .8 degrees wide at the normal, of rank 4 1.8. Where
/// trees are finer already, their peaks are too, up to the second of each.
const DEPTHS_3: (u32, u32) = (8, 9);
const DEPTHS_4: (u32, u32) = (6, 7);

/// A BSDF whose peaks are in cells, and what was there before.
pub(crate) struct InCells {
    /// Without peaks of no width.
    pub(crate) bsdf: Bsdf,
    /// The components that were changed, by their sides.
    pub(crate) changed: Vec<((Side, Side), Below)>,
}

/// Entries of a matrix, each with its value.
type Entries = Vec<(usize, f32)>;

/// What a component held where peaks changed it.
pub(crate) enum Below {
    /// There was no such component.
    Nothing,
    /// Trees of [`TensorTree::beneath`]: Y, and u′ and v′ where there is colour.
    Trees(Vec<TensorTree>),
    /// Entries with their values: Y, and X and Z where there is colour.
    Entries(Vec<Entries>),
}

impl Bsdf {
    /// The same light without peaks of no width: each is spread over the narrowest cells of trees or matrices that it
    /// falls in, with the right energy.
    ///
    /// Errors: argument, for components that are neither trees nor matrices.
    /// Cost: 0.1 s a peak beside trees of rank 4.
    pub fn with_peaks_in_cells(&self) -> Result<Bsdf> {
        Ok(InCells::of(self)?.bsdf)
    }
}

impl InCells {
    pub(crate) fn of(bsdf: &Bsdf) -> Result<Self> {
        let mut components: Vec<Component> = bsdf.components().to_vec();
        let mut changed = Vec::new();
        for sides in pairs(bsdf.specular()) {
            let peaks: Vec<&Specular> =
                bsdf.specular().iter().filter(|s| (s.incident, s.scattered) == sides).collect();
            let at = components.iter().position(|c| (c.incident, c.scattered) == sides);
            let old = match at {
                Some(at) => components[at].clone(),
                None => empty_like(bsdf.components().first(), &peaks, sides)?,
            };
            let (new, below) = with_peaks(&old, &peaks)?;
            // Where a Lambertian part will be added there is something below.
            let nothing =
                at.is_none() && bsdf.explicit_lambertian().get(sides.0, sides.1) == Xyz::ZERO;
            changed.push((sides, if nothing { Below::Nothing } else { below }));
            match at {
                Some(at) => components[at] = new,
                None => components.push(new),
            }
        }
        let bands = bsdf.bands().to_vec();
        let bsdf = Bsdf::new(bsdf.metadata().clone(), components, *bsdf.explicit_lambertian());
        Ok(Self { bsdf: bsdf.with_bands(bands), changed })
    }
}

/// The pairs of sides that peaks are between.
fn pairs(specular: &[Specular]) -> Vec<(Side, Side)> {
    let mut pairs: Vec<(Side, Side)> = Vec::new();
    for s in specular {
        if !pairs.contains(&(s.incident, s.scattered)) {
            pairs.push((s.incident, s.scattered));
        }
    }
    pairs
}

/// A black component of the structure of another one, or of what suits the peaks; in colour where one of these is.
fn empty_like(
    other: Option<&Component>,
    peaks: &[&Specular],
    (incident, scattered): (Side, Side),
) -> Result<Component> {
    let coloured = peaks.iter().any(|p| p.coefficient.is_coloured());
    let distribution = other.map(Component::distribution);
    if let Some(matrix) = distribution.and_then(|d| d.downcast_ref::<KlemsMatrix>()) {
        let (i, o): (KlemsBasis, KlemsBasis) =
            (matrix.incident().clone(), matrix.scattered().clone());
        let values = vec![0.0; i.directions() * o.directions()];
        let matrix = KlemsMatrix::new(i, o, values.clone())?;
        let matrix = if coloured { matrix.with_colour(values.clone(), values)? } else { matrix };
        return Ok(Component::new(incident, scattered, matrix));
    }
    let rank = match distribution.and_then(|d| d.downcast_ref::<TreeDistribution>()) {
        Some(tree) => tree.luminance().rank(),
        None if peaks.iter().all(|p| p.is_isotropic()) => Rank::Three,
        None => Rank::Four,
    };
    let of = |value: f64| TensorTree::constant(rank, value as f32);
    let (u, v) = Xyz::grey(1.0).uv();
    let tree = match coloured {
        true => TreeDistribution::with_chromaticity(of(0.0)?, of(u)?, of(v)?)?,
        false => TreeDistribution::new(of(0.0)?),
    };
    Ok(Component::new(incident, scattered, tree))
}

/// Where light goes and how much of it, in one channel.
fn to<'a>(
    peak: &'a Specular,
    channel: impl Fn(Xyz) -> f64 + 'a,
) -> impl Fn(DVec3) -> Option<(DVec3, f64)> + 'a {
    move |wi| {
        let wo = peak.law.scattered(wi, Side::Front)?;
        Some((wo, channel(peak.coefficient.at(wi)))).filter(|(_, share)| *share > 0.0)
    }
}

fn with_peaks(component: &Component, peaks: &[&Specular]) -> Result<(Component, Below)> {
    let sides = (component.incident, component.scattered);
    let distribution = component.distribution();
    if let Some(tree) = distribution.downcast_ref::<TreeDistribution>() {
        let (tree, below) = tree_with_peaks(tree, peaks)?;
        return Ok((Component::new(sides.0, sides.1, tree), Below::Trees(below)));
    }
    if let Some(matrix) = distribution.downcast_ref::<KlemsMatrix>() {
        let (matrix, below) = matrix_with_peaks(matrix, peaks)?;
        let matrix: Arc<dyn Distribution> = Arc::new(matrix);
        return Ok((Component::shared(sides.0, sides.1, matrix), Below::Entries(below)));
    }
    Err(Error::argument("peaks in cells: expected trees or matrices, found another representation"))
}

fn tree_with_peaks(
    tree: &TreeDistribution,
    peaks: &[&Specular],
) -> Result<(TreeDistribution, Vec<TensorTree>)> {
    let y = tree.luminance();
    let (rank, (least, most)) = (
        y.rank(),
        match y.rank() {
            Rank::Three => DEPTHS_3,
            Rank::Four => DEPTHS_4,
        },
    );
    if rank == Rank::Three
        && let Some(peak) = peaks.iter().find(|p| !p.is_isotropic())
    {
        return Err(Error::argument(format!(
            "peaks in cells: expected an isotropic law beside trees of rank 3, found {}",
            peak.name()
        )));
    }
    let depth = y.depth().clamp(least, most);
    let all = |channel: fn(Xyz) -> f64| {
        let one = |p: &&Specular| Deposits::new(rank, depth, to(p, channel));
        peaks.iter().map(one).fold(Deposits::none(depth), Deposits::with)
    };
    let luminance = all(|c| c.y);
    let mut below = vec![y.beneath(&luminance)?];
    let new = y.deposited(&luminance, Change::Added)?;
    let Some([u, v]) = tree.chromaticity() else {
        return Ok((TreeDistribution::new(new), below));
    };
    let mut chromatic = |old: &TensorTree, channel: fn(Xyz) -> f64| -> Result<TensorTree> {
        let mean = all(channel).over(&luminance);
        below.push(old.beneath(&mean)?);
        old.deposited(&mean, Change::Replaced)
    };
    let new_u = chromatic(u, |c| c.y * c.uv().0)?;
    let new_v = chromatic(v, |c| c.y * c.uv().1)?;
    Ok((TreeDistribution::with_chromaticity(new, new_u, new_v)?, below))
}

fn matrix_with_peaks(
    matrix: &KlemsMatrix,
    peaks: &[&Specular],
) -> Result<(KlemsMatrix, Vec<Entries>)> {
    let bases = (matrix.incident(), matrix.scattered());
    let all = |channel: fn(Xyz) -> f64| -> Vec<(usize, f64)> {
        peaks.iter().flat_map(|p| deposits(bases, to(p, channel))).collect()
    };
    let (y, x, z) = (all(|c| c.y), all(|c| c.x), all(|c| c.z));
    let new = matrix.changed([&y, &x, &z], true)?;
    let was = |values: &[f32], entries: &[(usize, f64)]| {
        let mut was: Vec<(usize, f32)> = entries.iter().map(|e| (e.0, values[e.0])).collect();
        was.sort_by_key(|e| e.0);
        was.dedup_by_key(|e| e.0);
        was
    };
    let mut below = vec![was(matrix.values(), &y)];
    if let Some([old_x, old_z]) = matrix.chromatic() {
        below.extend([was(old_x, &x), was(old_z, &z)]);
    }
    Ok((new, below))
}
