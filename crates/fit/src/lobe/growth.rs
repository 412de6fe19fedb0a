//! Adds lobes where the residual is largest, and splits lobes that fit badly.

use bsdfkit_sphere::DVec2;

use super::covariance::Covariance;
use super::lobe_set::{Lobe, LobeSet};
use super::sweeps::Sweeps;

/// How many lobes are split: those that fit worst.
const SPLIT: usize = 2;

/// Adds up to `room` lobes where the model falls short most (Pearson χ²); false if nowhere.
pub(super) fn grow(set: &mut LobeSet, sweeps: &Sweeps, room: usize) -> bool {
    let c = sweeps.cells;
    let mut chi: Vec<f64> = (0..c.len())
        .map(|k| {
            let d = f64::from(c.f[k] - sweeps.model[k]);
            if c.observed[k] > 0.0 && d > 0.0 {
                f64::from(c.disk_area[k]) * d * d / f64::from(sweeps.model[k]).max(1e-4)
            } else {
                0.0
            }
        })
        .collect();
    let mut added = false;
    for _ in 0..room {
        let Some((k, &worst)) = chi.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)) else {
            break;
        };
        if worst <= 0.0 {
            break;
        }
        let at = DVec2::new(f64::from(c.x[k]), f64::from(c.y[k]));
        let variance = (4.0 * f64::from(c.frame_area[k])).max(2e-5);
        let mut mass = 0.0;
        for j in 0..c.len() {
            let d = DVec2::new(f64::from(c.x[j]), f64::from(c.y[j])) - at;
            if d.length_squared() < 9.0 * variance {
                let excess = f64::from((c.f[j] - sweeps.model[j]) * c.observed[j]);
                mass += excess * f64::from(c.disk_area[j]);
                chi[j] = 0.0;
            }
        }
        let covariance = Covariance::isotropic(variance);
        set.lobes.push(Lobe { mass: (0.5 * mass).max(1e-6), mean: at, covariance });
        added = true;
    }
    added
}

/// The set with one lobe replaced by two, for each of those that misfit most and every way that
/// lobes split.
///
/// `sweeps` are those of `set`. Where peaks overlap (two threads of a fabric cross in one), lobes
/// added at the residual only creep into what a lobe in the wrong place already explains in part;
/// and of a mirrored incidence a lobe on the mirror never leaves it.
pub(super) fn split(set: &LobeSet, sweeps: &Sweeps) -> Vec<LobeSet> {
    let mut order: Vec<usize> = (0..set.lobes.len()).collect();
    let misfit: Vec<f64> = order.iter().map(|&i| sweeps.misfit(i)).collect();
    order.sort_by(|&a, &b| misfit[b].total_cmp(&misfit[a]));
    let with = |i: usize, pair: [Lobe; 2]| {
        let mut other = set.clone();
        other.lobes.remove(i);
        other.lobes.extend(pair);
        other
    };
    let worst = order.into_iter().take(SPLIT);
    worst.flat_map(|i| halves(&set.lobes[i]).map(|pair| with(i, pair))).collect()
}

/// Two lobes for one, with its mass: side by side along it, across each other, one within the
/// other.
fn halves(lobe: &Lobe) -> [[Lobe; 2]; 3] {
    let [long, short] = lobe.covariance.axes();
    let of = |mean: DVec2, long: DVec2, short: DVec2| Lobe {
        mass: 0.5 * lobe.mass,
        mean,
        covariance: Covariance::of_axes(long, short),
    };
    let beside = |way: f64| of(lobe.mean + way * long, 0.7 * long, short);
    let turned = |angle: f64| {
        let turn = DVec2::from_angle(angle);
        of(lobe.mean, turn.rotate(long), 0.5 * turn.rotate(short))
    };
    let scaled = |by: f64| of(lobe.mean, by * long, by * short);
    [[beside(0.6), beside(-0.6)], [turned(0.6), turned(-0.6)], [scaled(0.6), scaled(1.5)]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_have_the_lobes_mass_and_centre() {
        let covariance = Covariance { xx: 0.02, xy: 0.006, yy: 0.01 };
        let lobe = Lobe { mass: 0.4, mean: DVec2::new(0.1, -0.2), covariance };
        for [a, b] in halves(&lobe) {
            assert!((a.mass + b.mass - lobe.mass).abs() < 1e-12);
            assert!((0.5 * (a.mean + b.mean)).distance(lobe.mean) < 1e-12);
            for half in [a, b] {
                let ratio = half.covariance.determinant() / covariance.determinant();
                assert!(ratio > 0.1 && ratio < 6.0, "{ratio}");
            }
        }
        // Side by side they are as long as the lobe: 0.6² + 0.7² = 0.85 of its variance.
        let [beside, _, _] = halves(&lobe);
        let long = covariance.axes()[0];
        let variance =
            0.36 * long.length_squared() + beside[0].covariance.axes()[0].length_squared();
        assert!((variance / long.length_squared() - 0.85).abs() < 1e-9, "{variance}");
    }
}
