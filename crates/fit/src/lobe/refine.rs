//! Gauss–Newton refinement of all lobe parameters at once (Levenberg–Marquardt).
//!
//! Expectation–maximisation comes near but creeps where lobes overlap or are cut by the horizon.
//! Here unobserved cells simply do not count. Residuals are (f − m) √(area / m₀), between least
//! squares and relative error.

use bsdfkit_sphere::DVec2;

use super::covariance::Covariance;
use super::lobe_set::{Lobe, LobeSet};
use crate::linear::Cholesky;

/// Parameters per lobe: log mass, centre, and the Cholesky factor (log l₁₁, l₂₁, log l₂₂).
const PER_LOBE: usize = 6;
/// Gaussians are cut here (exponent): 1e-8 of the peak.
const CUT: f64 = 18.0;

/// An observed cell: where, what, and how much it counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Datum {
    pub(super) q: DVec2,
    /// f, 1/sr.
    pub(super) f: f64,
    /// Projected solid angle.
    pub(super) area: f64,
    /// 1 / |du/dq|.
    pub(super) inverse_density: f64,
}

/// A lobe as unconstrained parameters, with what its derivatives need.
struct Parameters {
    log_mass: f64,
    mean: DVec2,
    /// Σ = L Lᵀ, L = [[l11, 0], [l21, l22]].
    l11: f64,
    l21: f64,
    l22: f64,
}

impl Parameters {
    fn of(lobe: &Lobe) -> Self {
        let c = lobe.covariance;
        let l11 = c.xx.max(1e-12).sqrt();
        let l21 = c.xy / l11;
        let l22 = (c.yy - l21 * l21).max(1e-12).sqrt();
        Self { log_mass: lobe.mass.max(1e-12).ln(), mean: lobe.mean, l11, l21, l22 }
    }

    fn lobe(&self, floor: f64) -> Lobe {
        let covariance = Covariance {
            xx: self.l11 * self.l11,
            xy: self.l11 * self.l21,
            yy: self.l21 * self.l21 + self.l22 * self.l22,
        };
        Lobe { mass: self.log_mass.exp(), mean: self.mean, covariance: covariance.floored(floor) }
    }

    /// The density at q and its derivatives; `None` beyond [`CUT`].
    fn density(&self, q: DVec2) -> Option<(f64, [f64; PER_LOBE])> {
        let d = q - self.mean;
        // Whitened: y = L⁻¹ d.
        let y0 = d.x / self.l11;
        let y1 = (d.y - self.l21 * y0) / self.l22;
        let e = 0.5 * (y0 * y0 + y1 * y1);
        if e > CUT {
            return None;
        }
        let g = (self.log_mass - e).exp() / (std::f64::consts::TAU * self.l11 * self.l22);
        // Σ⁻¹ d = L⁻ᵀ y.
        let s1 = y1 / self.l22;
        let s0 = (y0 - self.l21 * s1) / self.l11;
        let dl11 = s0 * y0 * self.l11 - 1.0;
        let dl21 = s1 * y0;
        let dl22 = s1 * y1 * self.l22 - 1.0;
        Some((g, [g, g * s0, g * s1, g * dl11, g * dl21, g * dl22]))
    }

    fn step(&self, d: &[f64]) -> Self {
        let limit = |v: f64, m: f64| v.clamp(-m, m);
        // At most a factor e^½ in mass and width, two widths in position, each step.
        let reach = 2.0 * (self.l11 + self.l22 + self.l21.abs());
        Self {
            log_mass: self.log_mass + limit(d[0], 0.7),
            mean: self.mean + DVec2::new(limit(d[1], reach), limit(d[2], reach)),
            l11: self.l11 * limit(d[3], 0.5).exp(),
            l21: self.l21 + limit(d[4], reach),
            l22: self.l22 * limit(d[5], 0.5).exp(),
        }
    }
}

struct Problem<'a> {
    data: &'a [Datum],
    weight: Vec<f64>,
    /// Prior precision pulling parameters to their start: keeps what the data do not see.
    prior: f64,
}

impl Problem<'_> {
    fn model(&self, floor: f64, lobes: &[Parameters]) -> Vec<f64> {
        self.data
            .iter()
            .map(|d| {
                let sum: f64 = lobes.iter().filter_map(|l| l.density(d.q)).map(|(g, _)| g).sum();
                floor + sum * d.inverse_density
            })
            .collect()
    }

    fn cost(&self, model: &[f64]) -> f64 {
        let terms = self.data.iter().zip(model).zip(&self.weight);
        terms.map(|((d, m), w)| w * (d.f - m).powi(2)).sum()
    }

    /// Normal equations JᵀWJ and JᵀWr, row-major; the last parameter is log floor.
    fn normal(&self, floor: f64, lobes: &[Parameters]) -> (Vec<f64>, Vec<f64>) {
        let n = lobes.len() * PER_LOBE + 1;
        let (mut a, mut b) = (vec![0.0; n * n], vec![0.0; n]);
        let mut live: Vec<(usize, [f64; PER_LOBE])> = Vec::new();
        for (d, w) in self.data.iter().zip(&self.weight) {
            live.clear();
            let mut m = floor;
            for (k, l) in lobes.iter().enumerate() {
                if let Some((g, mut j)) = l.density(d.q) {
                    m += g * d.inverse_density;
                    j.iter_mut().for_each(|v| *v *= d.inverse_density);
                    live.push((k * PER_LOBE, j));
                }
            }
            let r = d.f - m;
            for (x, &(row, jr)) in live.iter().enumerate() {
                for i in 0..PER_LOBE {
                    let wj = w * jr[i];
                    b[row + i] += wj * r;
                    a[(row + i) * n + n - 1] += wj * floor;
                    for &(col, jc) in &live[x..] {
                        let line = &mut a[(row + i) * n + col..][..PER_LOBE];
                        for (v, j) in line.iter_mut().zip(&jc) {
                            *v += wj * j;
                        }
                    }
                }
            }
            a[n * n - 1] += w * floor * floor;
            b[n - 1] += w * floor * r;
        }
        for i in 0..n {
            for j in 0..i {
                a[i * n + j] = a[j * n + i];
            }
        }
        (a, b)
    }
}

/// Refines `set` to fit `data`; never returns a worse fit.
///
/// `narrowest` gives each lobe's least eigenvalue. Cost: cells × live lobes² × 18 per iteration.
pub(super) fn refine(set: &mut LobeSet, data: &[Datum], narrowest: &[f64], iterations: usize) {
    if set.lobes.is_empty() {
        return;
    }
    let mut floor = set.floor.max(1e-7);
    let mut lobes: Vec<Parameters> = set.lobes.iter().map(Parameters::of).collect();
    let mut problem = Problem { data, weight: Vec::new(), prior: 0.0 };
    let mut model = problem.model(floor, &lobes);
    let mean = data.iter().map(|d| d.f * d.area).sum::<f64>()
        / data.iter().map(|d| d.area).sum::<f64>().max(1e-12);
    let eps = (0.02 * mean).max(1e-6);
    problem.weight =
        data.iter().zip(&model).map(|(d, m)| d.area / (0.5 * (d.f.max(0.0) + m) + eps)).collect();
    let mut cost = problem.cost(&model);
    problem.prior = 1e-6 * data.iter().map(|d| d.f.max(0.0) * d.area).sum::<f64>();
    let mut damping = 1e-3;
    for _ in 0..iterations {
        let (a, b) = problem.normal(floor, &lobes);
        let n = b.len();
        let mut improved = false;
        for _ in 0..6 {
            let mut m = a.clone();
            for i in 0..n {
                m[i * n + i] += damping * m[i * n + i] + problem.prior;
            }
            let Some(factor) = Cholesky::new(&mut m, n, 0.0) else {
                damping *= 10.0;
                continue;
            };
            let mut d = b.clone();
            factor.solve(&mut d);
            let next: Vec<Parameters> =
                lobes.iter().zip(d.chunks(PER_LOBE)).map(|(l, d)| l.step(d)).collect();
            let next_floor = floor * d[n - 1].clamp(-0.7, 0.7).exp();
            // Through lobes and back, so that the widths' floor is part of the step.
            let next: Vec<Parameters> =
                next.iter().zip(narrowest).map(|(p, &f)| Parameters::of(&p.lobe(f))).collect();
            model = problem.model(next_floor, &next);
            let trial = problem.cost(&model);
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

    fn data(truth: &LobeSet) -> Vec<Datum> {
        (0..2500)
            .map(|i| DVec2::new(f64::from(i % 50), f64::from(i / 50)) * 0.04 - DVec2::ONE)
            .map(|q| Datum {
                q,
                f: truth.floor + truth.density(q),
                area: 0.0016,
                inverse_density: 1.0,
            })
            .collect()
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
        refine(&mut set, &data(&truth), &[1e-6, 1e-6], 60);
        for (a, b) in set.lobes.iter().zip(&truth.lobes) {
            assert!((a.mass / b.mass - 1.0).abs() < 1e-2, "{a:?} {b:?}");
            assert!((a.mean - b.mean).length() < 2e-3, "{a:?} {b:?}");
        }
    }

    #[test]
    fn derivatives_match_differences() {
        let lobe = truth().lobes[0];
        let p = Parameters::of(&lobe);
        let q = DVec2::new(0.3, 0.15);
        let (_, j) = p.density(q).expect("near");
        for i in 0..PER_LOBE {
            let mut d = [0.0; PER_LOBE];
            d[i] = 1e-6;
            let up = p.step(&d).density(q).expect("near").0;
            d[i] = -1e-6;
            let down = p.step(&d).density(q).expect("near").0;
            assert!(
                ((up - down) / 2e-6 - j[i]).abs() < 1e-5,
                "{i}: {} {}",
                (up - down) / 2e-6,
                j[i]
            );
        }
    }
}
