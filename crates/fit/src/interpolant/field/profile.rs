//! Smooth functions of the polar angle, level at the normal, through values along a chain.

use crate::interpolant::field::multiquadric::{Trend, solve};
use bsdfkit::DVec3;
use bsdfkit_sphere::direction::from_degrees;

/// The value at a polar angle, in degrees, that is foretold by those at others.
type Foretold<'a> = dyn Fn(&[(f64, f64)], f64) -> f64 + 'a;

/// A trend toward grazing, and a cubic spline of what it leaves, even about the normal.
///
/// Between the values only: past the last of them it goes on as its last cubic does.
/// Cost: n operations to fit, n to find a value.
#[derive(Clone, Debug)]
pub(crate) struct Profile {
    /// Of [`Trend::Grazing`].
    coefficients: [f64; 3],
    spline: EvenSpline,
}

/// Fewer values than this, and one of them left out, are not told from a line.
const FEWEST: usize = 4;
/// Values nearer than this are taken together: what they differ by is noise, and would be a slope.
const APART_DEGREES: f64 = 2.0;
/// With more values than this, a rival is not asked, which takes time.
const MOST: usize = 30;
/// Terms of the trend: a constant, or all.
const TERMS: [usize; 2] = [1, 3];

impl Profile {
    /// Through `values` at directions, with the trend with which each value within the chain is foretold best by the
    /// others; `None` where there are too few polar angles, or `rival` foretells them better.
    ///
    /// Cost: n² operations, and n times the rival's.
    pub(crate) fn through(
        values: impl Iterator<Item = (DVec3, f64)>,
        rival: &Foretold<'_>,
    ) -> Option<Self> {
        let knots = knots(values);
        if knots.len() < FEWEST {
            return None;
        }
        let error = |foretold: &Foretold<'_>| -> f64 {
            let one = |k: usize| {
                let mut others = knots.clone();
                let (theta, value) = others.remove(k);
                (foretold(&others, theta) - value).powi(2)
            };
            (0..knots.len() - 1).map(one).sum()
        };
        let own = |terms: usize| {
            error(&|others, theta| {
                Self::with_terms(others, terms).map_or(f64::INFINITY, |p| p.at_degrees(theta))
            })
        };
        let errors = TERMS.map(|terms| (own(terms), terms));
        let (least, terms) = errors.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
        if knots.len() <= MOST && error(rival) < least {
            return None;
        }
        Self::with_terms(&knots, terms)
    }

    fn with_terms(knots: &[(f64, f64)], terms: usize) -> Option<Self> {
        let mut normal = vec![vec![0.0; terms + 1]; terms];
        for &(theta, value) in knots {
            let t = trend(theta);
            for i in 0..terms {
                (0..terms).for_each(|j| normal[i][j] += t[i] * t[j]);
                normal[i][terms] += t[i] * value;
            }
        }
        let mut coefficients = [0.0; 3];
        coefficients.iter_mut().zip(solve(normal)?).for_each(|(c, x)| *c = x);
        let left = |&(theta, value): &(f64, f64)| (theta, value - dot(coefficients, trend(theta)));
        let spline = EvenSpline::through(knots.iter().map(left).collect());
        Some(Self { coefficients, spline })
    }

    /// The value at a direction.
    pub(crate) fn at(&self, w: DVec3) -> f64 {
        self.at_degrees(polar_degrees(w))
    }

    fn at_degrees(&self, theta: f64) -> f64 {
        dot(self.coefficients, trend(theta)) + self.spline.at(theta)
    }
}

fn polar_degrees(w: DVec3) -> f64 {
    w.truncate().length().atan2(w.z).to_degrees()
}

fn trend(theta_degrees: f64) -> [f64; 3] {
    Trend::Grazing.at(from_degrees(theta_degrees, 0.0))
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Polar angles (degrees, ascending) and values, those that lie together as their mean.
fn knots(values: impl Iterator<Item = (DVec3, f64)>) -> Vec<(f64, f64)> {
    let mut sorted: Vec<(f64, f64)> = values.map(|(w, v)| (polar_degrees(w), v)).collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    sorted
        .chunk_by(|a, b| b.0 - a.0 < APART_DEGREES)
        .map(|group| {
            let sum = group.iter().fold((0.0, 0.0), |s, k| (s.0 + k.0, s.1 + k.1));
            (sum.0 / group.len() as f64, sum.1 / group.len() as f64)
        })
        .collect()
}

/// An even cubic spline, whose last two pieces are one cubic.
#[derive(Clone, Debug)]
struct EvenSpline {
    knots: Vec<(f64, f64)>,
    /// Second derivatives at the knots.
    bends: Vec<f64>,
}

impl EvenSpline {
    /// Through three knots or more, ascending from 0 or above.
    fn through(knots: Vec<(f64, f64)>) -> Self {
        let n = knots.len();
        // The knot before the first is its image, or that of the second where the first is at the normal.
        let mirrored = if knots[0].0 > 0.0 { knots[0] } else { knots[1] };
        let before = |k: usize| if k == 0 { (-mirrored.0, mirrored.1) } else { knots[k - 1] };
        let slope = |a: (f64, f64), b: (f64, f64)| (b.1 - a.1) / (b.0 - a.0);
        // Rows (below, diagonal, above | right) for all but the last bend, which lies on the line through the two before.
        let mut rows: Vec<[f64; 4]> = (0..n - 1)
            .map(|k| {
                let (a, b, c) = (before(k), knots[k], knots[k + 1]);
                let (h, g) = (b.0 - a.0, c.0 - b.0);
                [h, 2.0 * (h + g), g, 6.0 * (slope(b, c) - slope(a, b))]
            })
            .collect();
        let [below, diagonal, above, _] = rows[0];
        rows[0] = if knots[0].0 > 0.0 {
            [0.0, diagonal + below, above, rows[0][3]]
        } else {
            [0.0, diagonal, above + below, rows[0][3]]
        };
        let on = (knots[n - 1].0 - knots[n - 2].0) / (knots[n - 2].0 - knots[n - 3].0);
        let last = &mut rows[n - 2];
        last[0] -= last[2] * on;
        last[1] += last[2] * (1.0 + on);
        for k in 1..n - 1 {
            let f = rows[k][0] / rows[k - 1][1];
            let (above, right) = (rows[k - 1][2], rows[k - 1][3]);
            rows[k][1] -= f * above;
            rows[k][3] -= f * right;
        }
        let mut bends = vec![0.0; n];
        for k in (0..n - 1).rev() {
            let next = if k + 1 < n - 1 { rows[k][2] * bends[k + 1] } else { 0.0 };
            bends[k] = (rows[k][3] - next) / rows[k][1];
        }
        bends[n - 1] = bends[n - 2] + on * (bends[n - 2] - bends[n - 3]);
        Self { knots, bends }
    }

    fn at(&self, x: f64) -> f64 {
        let k = self.knots.partition_point(|knot| knot.0 <= x).min(self.knots.len() - 1);
        let (b, n) = (self.knots[k], self.bends[k]);
        let (a, m) = match k {
            0 => ((-b.0, b.1), n),
            _ => (self.knots[k - 1], self.bends[k - 1]),
        };
        let h = b.0 - a.0;
        let (s, t) = ((b.0 - x) / h, (x - a.0) / h);
        s * a.1 + t * b.1 + ((s.powi(3) - s) * m + (t.powi(3) - t) * n) * h * h / 6.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: &Foretold<'_> = &|_, _| f64::INFINITY;

    #[test]
    fn a_rival_that_foretells_better_is_left_to_it() {
        let f = |t: f64| (t / 10.0).sin();
        let chain = || (1..8).map(|k| 10.0 * f64::from(k)).map(|t| (from_degrees(t, 0.0), f(t)));
        assert!(Profile::through(chain(), &|_, t| f(t)).is_none());
        assert!(Profile::through(chain(), &|_, t| f(t) + 1.0).is_some());
    }

    #[test]
    fn an_even_cubic_piece_is_found_again() {
        // x² is its own even spline, wherever the knots lie.
        for first in [0.0, 7.0] {
            let knots: Vec<(f64, f64)> =
                [first, 15.0, 33.0, 50.0, 61.0].map(|x| (x, x * x)).to_vec();
            let s = EvenSpline::through(knots);
            for x in [0.0, 3.0, 20.0, 40.0, 60.0, 61.0, 65.0] {
                assert!((s.at(x) - x * x).abs() < 1e-9, "{first} {x}: {}", s.at(x));
            }
        }
    }

    /// Transmittances of rough and of smooth glass.
    #[test]
    fn interfaces_are_foretold_from_few_polar_angles() {
        let rough = |z: f64| (0.93 / (1.0 + (-10.0 * (z - 0.4)).exp())).ln();
        let smooth = |z: f64| (0.957 * (1.0 - (1.0 - z).powi(5))).ln();
        for f in [&rough as &dyn Fn(f64) -> f64, &smooth] {
            let chain = [20.1, 38.8, 52.7, 64.5, 75.0].map(|t| from_degrees(t, 0.0));
            let profile =
                Profile::through(chain.into_iter().map(|w| (w, f(w.z))), NONE).expect("five");
            let off = |degrees: u32| {
                let w = from_degrees(f64::from(degrees), 70.0);
                (profile.at(w) - f(w.z)).abs()
            };
            let mean = (0..=75).map(off).sum::<f64>() / 76.0;
            assert!(mean < 0.008 && off(0) < 0.008, "{mean}, at the normal {}", off(0));
        }
    }

    #[test]
    fn values_that_lie_together_are_one() {
        let noisy = [0.0, 15.0, 15.1, 30.0, 45.0, 60.0, 60.2];
        let value = |k: usize| if k.is_multiple_of(2) { 0.01 } else { -0.01 };
        let at = noisy.iter().enumerate().map(|(k, &t)| (from_degrees(t, 0.0), value(k)));
        let profile = Profile::through(at, NONE).expect("five");
        for k in 0..=60 {
            let v = profile.at(from_degrees(f64::from(k), 0.0));
            assert!(v.abs() < 0.03, "{k}: {v}");
        }
        let few = [0.0, 30.0, 60.0].map(|t| (from_degrees(t, 0.0), 1.0));
        assert!(Profile::through(few.into_iter(), NONE).is_none());
    }
}
