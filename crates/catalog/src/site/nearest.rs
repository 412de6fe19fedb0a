//! What looks most alike, of all pairs.

use rayon::prelude::*;

use crate::look::Look;

/// The `most` nearest others of each look with their distances, the nearest first.
///
/// Exact: a fine distance is only found where the coarse one, which is never larger, allows it to count.
/// Cost: n² coarse distances of 320 numbers, on all threads: 2 000 looks some tenths of a second.
pub(super) fn nearest(looks: &[Look], most: usize) -> Vec<Vec<(usize, f64)>> {
    let of = |k: usize| {
        let mut bounds: Vec<(usize, f64)> = (0..looks.len())
            .filter(|&other| other != k)
            .filter_map(|other| Some((other, looks[k].least_distance(&looks[other])?)))
            .collect();
        bounds.sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let mut best: Vec<(usize, f64)> = Vec::new();
        for (other, least) in bounds {
            // Single precision may put the bound a little above.
            if best.len() == most && best.last().is_none_or(|(_, worst)| least > worst + 1e-4) {
                break;
            }
            let Some(distance) = looks[k].distance(&looks[other]) else { continue };
            let at = best.partition_point(|(_, d)| *d <= distance);
            best.insert(at, (other, distance));
            best.truncate(most);
        }
        best
    };
    (0..looks.len()).into_par_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use bsdfkit::{Bsdf, Lambertian, Metadata, Xyz};

    use super::*;

    #[test]
    fn as_by_comparing_all() {
        let look = |k: usize| {
            let parts = Lambertian {
                reflection_front: Xyz::grey(0.1 + 0.037 * (k * 7 % 20) as f64),
                transmission_front: Xyz::grey(0.011 * (k * 3 % 11) as f64),
                ..Lambertian::default()
            };
            Look::of(&Bsdf::new(Metadata::default(), Vec::new(), parts)).unwrap()
        };
        let looks: Vec<Look> = (0..24).map(look).collect();
        let found = nearest(&looks, 5);
        for (k, near) in found.iter().enumerate() {
            let others = (0..looks.len()).filter(|&o| o != k);
            let mut all: Vec<f64> = others.map(|o| looks[k].distance(&looks[o]).unwrap()).collect();
            all.sort_by(f64::total_cmp);
            let distances: Vec<f64> = near.iter().map(|n| n.1).collect();
            assert_eq!(distances, all[..5]);
        }
    }
}
