//! Gauss–Newton refinement of all lobe parameters at once (Levenberg–Marquardt).
//!
//! Expectation–maximisation comes near but creeps where lobes overlap or are cut by the horizon.
//! Here unobserved cells simply do not count. Residuals are (f − m) √(area / m₀), between least
//! squares and relative error.

use super::lobe_set::LobeSet;
use super::observed::Observed;
use super::parameters::{PER_LOBE, Parameters};
use bsdfkit_measure::linear::Cholesky;

/// Refines `set` to fit what was seen; never returns a worse fit.
///
/// `narrowest` gives each lobe's least eigenvalue. Cost: cells × live lobes² × 18 per iteration, eight to sixteen cells at a
/// time.
pub(super) fn refine(set: &mut LobeSet, seen: &mut Observed, narrowest: &[f64], iterations: usize) {
    if set.lobes.is_empty() {
        return;
    }
    let mut floor = set.floor.max(1e-7);
    let mut lobes: Vec<Parameters> = set.lobes.iter().map(Parameters::of).collect();
    let (integral, area) = seen.integral();
    seen.weigh(floor, &lobes, (0.02 * integral / area.max(1e-12)).max(1e-6));
    let mut cost = seen.cost(floor, &lobes);
    // Pulls parameters to their start: keeps what the data do not see.
    let prior = 1e-6 * integral;
    let mut damping = 1e-3;
    for _ in 0..iterations {
        let (a, b) = seen.normal(floor, &lobes);
        let n = b.len();
        let mut improved = false;
        for _ in 0..6 {
            let mut m = a.clone();
            for i in 0..n {
                m[i * n + i] += damping * m[i * n + i] + prior;
            }
            let Some(factor) = Cholesky::new(&mut m, n, 0.0) else {
                damping *= 10.0;
                continue;
            };
            let mut d = b.clone();
            factor.solve(&mut d);
            let next = lobes.iter().zip(d.chunks(PER_LOBE)).map(|(l, d)| l.step(d));
            let next_floor = floor * d[n - 1].clamp(-0.7, 0.7).exp();
            // Through lobes and back, so that the widths' floor is part of the step.
            let next = next.zip(narrowest).map(|(p, &f)| Parameters::of(&p.lobe(f)));
            let next: Vec<Parameters> = next.collect();
            let trial = seen.cost(next_floor, &next);
            if trial < cost {
                improved = trial < cost * (1.0 - 1e-4);
                (cost, lobes, floor) = (trial, next, next_floor);
                damping = (damping * 0.2).max(1e-7);
                break;
            }
            damping *= 6.0;
        }
        if !improved {
            break;
        }
    }
    set.floor = floor;
    set.lobes = lobes.iter().zip(narrowest).map(|(p, &f)| p.lobe(f)).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lobe::{Covariance, Lobe};
    use bsdfkit_sphere::DVec2;

    fn truth() -> LobeSet {
        let lobe = |mass, x, y, xx, xy, yy| Lobe {
            mass,
            mean: DVec2::new(x, y),
            covariance: Covariance { xx, xy, yy },
        };
        LobeSet {
            floor: 0.02,
            lobes: vec![
                lobe(0.5, 0.2, 0.1, 0.02, 0.005, 0.01),
                // Half of this one is never seen.
                lobe(0.3, 1.0, -0.1, 0.02, -0.004, 0.03),
            ],
        }
    }

    fn seen(truth: &LobeSet) -> Observed {
        let at = |i: i32| DVec2::new(f64::from(i % 50), f64::from(i / 50)) * 0.04 - DVec2::ONE;
        let f = |q: DVec2| (truth.floor + truth.density(q)) as f32;
        let cell = |q: DVec2| [q.x as f32, q.y as f32, f(q), 0.0016, 1.0];
        Observed::new((0..2500).map(at).map(cell))
    }

    #[test]
    fn parameters_are_found_from_a_rough_start_even_when_cut() {
        let truth = truth();
        let mut set = truth.clone();
        for l in &mut set.lobes {
            l.mass *= 1.4;
            l.mean += DVec2::new(-0.06, 0.05);
            l.covariance = Covariance::isotropic(0.02);
        }
        refine(&mut set, &mut seen(&truth), &[1e-6, 1e-6], 60);
        for (a, b) in set.lobes.iter().zip(&truth.lobes) {
            assert!((a.mass / b.mass - 1.0).abs() < 1e-2, "{a:?} {b:?}");
            assert!((a.mean - b.mean).length() < 2e-3, "{a:?} {b:?}");
        }
    }
}
