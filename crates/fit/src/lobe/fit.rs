//! Fitting lobes to one incidence: expectation–maximisation on area-weighted leaves.
//!
//! The update is Richardson–Lucy's in the amplitudes (it minimises the generalised
//! Kullback–Leibler divergence, between least squares and log error) and the usual one of
//! mixtures in centres and shapes. Lobes are added where the residual is largest until the data
//! ask for no more.

use bsdfkit_sphere::DVec2;

use super::cells::Cells;
use super::covariance::Covariance;
use super::growth::{grow, split};
use super::leaves::Leaf;
use super::lobe_set::{Lobe, LobeSet};
use super::sweeps::Sweeps;
use bsdfkit_measure::frame::FrameAt;

/// How far the fit goes.
#[derive(Clone, Copy, Debug)]
pub struct FitOptions {
    /// Most lobes of one incidence.
    pub max_lobes: usize,
    /// Stop adding lobes when the relative L1 residual over the leaves is below this.
    pub target: f64,
}

impl Default for FitOptions {
    fn default() -> Self {
        Self { max_lobes: 24, target: 0.01 }
    }
}

/// Up to so many lobes, more are taken as soon as they take 3 % off the residual. Of 6, 8, 10 and
/// 24 (any number), 8 left least between incidences: lobes that the data hardly ask for find no
/// partners there, and what they would explain the detail explains as well.
const FEW: usize = 8;
/// Further ones must leave less than this share of the residual: peaks by themselves do.
const EARNED: f64 = 0.8;
/// Where further lobes take nothing off a residual so many times the target, lobes are split.
const STUCK: f64 = 2.0;

/// Fits lobes to the leaves of one incidence, in the coordinates of `frame`.
///
/// `start`: lobes to begin with (those of a neighbour, say); without, two are made from the data. What is twice as bright
/// has the same lobes, twice as bright: all is measured in [`unit`]s.
/// Cost: about 1 ns × leaves × lobes × sweeps.
pub fn fit(
    leaves: &[Leaf],
    frame: &FrameAt,
    start: Option<&LobeSet>,
    options: &FitOptions,
) -> LobeSet {
    let unit = unit(leaves);
    let over = |leaf: &Leaf| Leaf { value: leaf.value / unit, ..*leaf };
    let leaves: Vec<Leaf> = leaves.iter().map(over).collect();
    let start = start.map(|start| start.times(1.0 / unit));
    fit_of_unit(&leaves, frame, start.as_ref(), options).times(unit)
}

/// The power of two that takes the directional-hemispherical value of leaves to about a half: so that no digit changes, and
/// small numbers (floors, least masses) are small beside any material's.
fn unit(leaves: &[Leaf]) -> f64 {
    let total: f64 = leaves.iter().filter(|l| l.count > 0).map(|l| l.value * l.area).sum();
    if total > 0.0 { (total.log2() + 1.5).floor().clamp(-60.0, 60.0).exp2() } else { 1.0 }
}

/// [`fit`] of leaves in their unit.
fn fit_of_unit(
    leaves: &[Leaf],
    frame: &FrameAt,
    start: Option<&LobeSet>,
    options: &FitOptions,
) -> LobeSet {
    let cells = Cells::new(leaves, frame);
    let mut seen = cells.observed();
    let mut sweeps = Sweeps::new(&cells);
    let mut set = start.cloned().unwrap_or_else(|| initial(leaves, &cells));
    let mut residual = sweeps.settle(&mut set, &mut seen, 15);
    while set.lobes.len() < options.max_lobes && residual > options.target {
        let (most, less) = if set.lobes.len() < FEW { (FEW, 0.97) } else { (usize::MAX, EARNED) };
        let most = most.min(options.max_lobes) - set.lobes.len();
        let room = most.min(1 + set.lobes.len() / 2);
        let mut trial = set.clone();
        if !grow(&mut trial, &sweeps, room) {
            break;
        }
        let mut now = sweeps.settle(&mut trial, &mut seen, 15);
        if now > less * residual && residual > STUCK * options.target {
            sweeps.evaluate(&set);
            for mut other in split(&set, &sweeps) {
                let then = sweeps.settle(&mut other, &mut seen, 15);
                if then < now {
                    (now, trial) = (then, other);
                }
            }
            sweeps.evaluate(&trial);
        }
        if now > less * residual {
            break; // the data ask for no more lobes
        }
        residual = now;
        set = trial;
    }
    set
}

/// Two lobes: a narrow one at the peak and a wide one around the centroid; a low quantile as floor.
fn initial(leaves: &[Leaf], cells: &Cells) -> LobeSet {
    let mut seen: Vec<f64> =
        leaves.iter().filter(|l| l.count > 0).map(|l| l.value.max(0.0)).collect();
    seen.sort_by(f64::total_cmp);
    let floor = seen.get(seen.len() / 50).map_or(0.0, |v| 0.9 * v).max(1e-7);
    let (mut mass, mut mean, mut square) = (0.0, DVec2::ZERO, DVec2::ZERO);
    let (mut peak, mut peak_value) = (DVec2::ZERO, -1.0);
    for k in 0..cells.len() {
        let q = DVec2::new(f64::from(cells.x[k]), f64::from(cells.y[k]));
        let w = (f64::from(cells.f[k]) - floor).max(0.0) * f64::from(cells.disk_area[k]);
        mass += w;
        mean += w * q;
        square += w * q * q;
        if f64::from(cells.f[k]) > peak_value {
            peak_value = f64::from(cells.f[k]);
            peak = q;
        }
    }
    if mass <= 0.0 {
        return LobeSet { floor, lobes: Vec::new() };
    }
    mean /= mass;
    let v = square / mass - mean * mean + DVec2::splat(1e-4);
    let shape = |s: f64| Covariance { xx: v.x * s, xy: 0.0, yy: v.y * s };
    LobeSet {
        floor,
        lobes: vec![
            Lobe { mass: 0.7 * mass, mean: peak, covariance: shape(0.2) },
            Lobe { mass: 0.3 * mass, mean, covariance: shape(2.0) },
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobe::leaves::bin;
    use bsdfkit_measure::frame::Frame;
    use bsdfkit_simulate::{Goniophotometer, registry};
    use bsdfkit_sphere::{DVec3, sequence::plastic};

    fn points(f: impl Fn(DVec2) -> f64) -> (Vec<DVec3>, Vec<f64>) {
        let mut wo = Vec::new();
        for i in 0..40_000 {
            let d = plastic(i) * 2.0 - DVec2::ONE;
            if d.length() < 0.99 {
                wo.push(d.extend((1.0 - d.length_squared()).sqrt()));
            }
        }
        let values = wo.iter().map(|w| f(w.truncate())).collect();
        (wo, values)
    }

    #[test]
    fn two_gaussians_and_a_floor_are_found_again() {
        let truth = LobeSet {
            floor: 0.05,
            lobes: vec![
                Lobe {
                    mass: 0.4,
                    mean: DVec2::new(-0.3, 0.1),
                    covariance: Covariance { xx: 0.01, xy: 0.004, yy: 0.02 },
                },
                Lobe {
                    mass: 0.2,
                    mean: DVec2::new(0.4, -0.2),
                    covariance: Covariance::isotropic(0.005),
                },
            ],
        };
        let (wo, values) = points(|u| truth.floor + truth.density(u));
        let frame = Frame::Fixed.at(DVec3::Z);
        let found = fit(
            &bin(wo.iter().copied().zip(values.iter().copied())),
            &frame,
            None,
            &FitOptions::default(),
        );
        let mass: f64 = found.lobes.iter().map(|l| l.mass).sum();
        assert!((mass - 0.6).abs() < 0.01, "mass {mass}");
        assert!((found.floor - 0.05).abs() < 0.005, "floor {}", found.floor);
        for (w, v) in wo.iter().zip(&values).step_by(97) {
            let m = found.floor + found.density(w.truncate());
            assert!((m - v).abs() < 0.03 * v + 0.02, "{w}: {m} {v}");
        }
    }

    #[test]
    fn crossing_threads_of_a_fabric_are_found_though_the_data_are_mirrored() {
        let fabric = registry().into_iter().find(|m| m.name() == "fabric").expect("fabric");
        let scan = Goniophotometer::default().scan(&*fabric, 0.0, 0.0);
        let points = scan.wo.iter().zip(&scan.values);
        let mirrored = points.flat_map(|(w, v)| [(*w, *v), (DVec3::new(w.x, -w.y, w.z), *v)]);
        let frame = Frame::Half.at(DVec3::Z);
        let leaves = bin(mirrored);
        let found = fit(&leaves, &frame, None, &FitOptions::default());
        let (mut misfit, mut all) = (0.0, 0.0);
        for leaf in leaves.iter().filter(|l| l.count > 0) {
            let model = found.floor + found.density(frame.forward(leaf.u)) / frame.density(leaf.u);
            misfit += (model - leaf.value).abs() * leaf.area;
            all += leaf.value * leaf.area;
        }
        let misfit = misfit / all;
        assert!(misfit < 0.02, "{misfit}, {} lobes", found.lobes.len());
    }
}
