//! How noisy an incidence is, from how far points lie off a smooth surface through their
//! neighbours.

use super::Incidence;
use super::neighbours::Neighbours;
use crate::linear::Cholesky;

/// Neighbours through which a surface is laid: three for each of its six coefficients.
const NEIGHBOURS: usize = 18;

/// Coefficients of a quadratic in two variables.
const TERMS: usize = 6;

/// Of 18 neighbours' unit-sized rows a sum below this has no digits left for a surface.
const SINGULAR: f64 = 1e-4;

/// Of the residuals the smallest quarter is trusted: up to three quarters may be structure. A
/// median reads 10 % of noise where a steep rim has 2 %.
const TRUSTED: f64 = 0.25;

/// The quantile [`TRUSTED`] of |x| of a normal distribution of standard deviation 1.
const NORMAL_QUARTILE: f64 = 0.318_639_36;

/// (relative, absolute) standard deviation of the noise in `channel`, seen at points `queries`.
///
/// σ² = (relative f)² + absolute². The brightest tenth of the points shows the first, the dimmest
/// the second.
/// Accuracy: 15 % of its value where points are denser than the structure; elsewhere the structure
/// counts as noise.
pub(super) fn estimate(
    incidence: &Incidence,
    tree: &Neighbours,
    queries: impl Iterator<Item = usize>,
    channel: usize,
) -> (f64, f64) {
    let mut found: Vec<Residual> =
        queries.filter_map(|i| Residual::at(incidence, tree, i, channel)).collect();
    found.sort_by(|a, b| a.level.total_cmp(&b.level));
    let tenth = found.len().div_ceil(10);
    let (dim, bright) = (&found[..tenth], &found[found.len() - tenth..]);
    let deviation = |part: &[Residual], of: &dyn Fn(&Residual) -> f64| {
        quantile(&mut part.iter().map(of).collect::<Vec<_>>(), TRUSTED) / NORMAL_QUARTILE
    };
    let relative = |absolute: f64| {
        let ratio = |r: &Residual| if r.level > 0.0 { r.size / r.level } else { 0.0 };
        let level = median(&mut bright.iter().map(|r| r.level).collect::<Vec<_>>());
        let share = if level > 0.0 { absolute / level } else { 0.0 };
        (deviation(bright, &ratio).powi(2) - share * share).max(0.0).sqrt()
    };
    let absolute = |relative: f64| {
        let level = median(&mut dim.iter().map(|r| r.level).collect::<Vec<_>>());
        (deviation(dim, &|r| r.size).powi(2) - (relative * level).powi(2)).max(0.0).sqrt()
    };
    // each is seen through the other: a second look separates them
    let first = absolute(relative(0.0));
    let share = relative(first);
    (share, absolute(share))
}

/// The middle value; 0 of none.
pub(super) fn median(values: &mut [f64]) -> f64 {
    quantile(values, 0.5)
}

/// The value that `fraction` of all are below; 0 of none.
pub(super) fn quantile(values: &mut [f64], fraction: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let place = (fraction * values.len() as f64) as usize;
    *values.select_nth_unstable_by(place, f64::total_cmp).1
}

/// How far one point lies off its neighbours.
struct Residual {
    /// The neighbours' surface at the point.
    level: f64,
    /// |point − level|, the surface's own error taken out.
    size: f64,
}

impl Residual {
    /// `None` where neighbours are too few or lie on a line.
    fn at(
        incidence: &Incidence,
        tree: &Neighbours,
        index: usize,
        channel: usize,
    ) -> Option<Residual> {
        let w = incidence.wo.at(index);
        let near = tree.nearest::<NEIGHBOURS>(w, Some(index));
        let reach = near.items().last()?.0.sqrt();
        if near.items().len() < NEIGHBOURS || reach == 0.0 {
            return None;
        }
        let (u, v) = w.any_orthonormal_pair();
        let mut matrix = [0.0; TERMS * TERMS];
        let mut right = [0.0; TERMS];
        for &(_, other) in near.items() {
            let offset = (incidence.wo.at(other) - w) / reach;
            let (x, y) = (u.dot(offset), v.dot(offset));
            let row = [1.0, x, y, x * x, x * y, y * y];
            for i in 0..TERMS {
                for j in 0..TERMS {
                    matrix[i * TERMS + j] += row[i] * row[j];
                }
                right[i] += row[i] * incidence.value(other, channel);
            }
        }
        // The surface's value at the point is `weights · right`, of variance weights[0].
        let mut weights = [0.0; TERMS];
        weights[0] = 1.0;
        Cholesky::new(&mut matrix, TERMS, SINGULAR)?.solve(&mut weights);
        let level: f64 = weights.iter().zip(right).map(|(w, r)| w * r).sum();
        let own = (incidence.value(index, channel) - level).abs();
        Some(Residual { level, size: own / (1.0 + weights[0]).sqrt() })
    }
}
