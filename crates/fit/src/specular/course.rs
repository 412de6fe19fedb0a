//! How a coefficient goes on between the incidences that it was measured at.

use std::f64::consts::FRAC_PI_2;

use bsdfkit::specular::Curve;
use bsdfkit::{DVec3, Result, Xyz};

use crate::interpolant::Multiquadric;
use bsdfkit_measure::Symmetry;

/// Rings and azimuths of a table: what a cubic through them changes is below a thousandth.
const RINGS: usize = 73;
const AZIMUTHS: usize = 36;
/// Index of refraction of the surfaces whose courses are tried; what another one would change is smooth.
const INDEX: f64 = 1.5;
/// Coefficients below this share of the largest are not looked at by their logarithms.
const DARK: f64 = 0.02;

/// What a coefficient is taken in proportion to.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Base {
    /// Nothing.
    Even,
    /// A pane of glass: (1 − F) / (1 + F).
    Pane,
    /// A surface of glass: F.
    Surface,
    /// Schlick's course toward 1 from a reflectance at the normal.
    Metal(f64),
}

impl Base {
    fn at(self, cosine: f64) -> f64 {
        let cosine = cosine.clamp(0.0, 1.0);
        match self {
            Self::Even => 1.0,
            Self::Pane => ((1.0 - fresnel(cosine)) / (1.0 + fresnel(cosine))).max(1e-4),
            Self::Surface => fresnel(cosine),
            Self::Metal(normal) => normal + (1.0 - normal) * (1.0 - cosine).powi(5),
        }
    }
}

/// Unpolarised reflectance of a surface of glass.
fn fresnel(c: f64) -> f64 {
    let t = (1.0 - (1.0 - c * c) / (INDEX * INDEX)).sqrt();
    let s = (c - INDEX * t) / (c + INDEX * t);
    let p = (INDEX * c - t) / (INDEX * c + t);
    0.5 * (s * s + p * p)
}

/// A coefficient over all incident directions.
pub(super) struct Course {
    pub(super) curve: Curve,
    /// What the other incidences foretell of one, root mean square over the largest; `None` of fewer than four.
    pub(super) residual: Option<f64>,
}

/// The course through measured coefficients, Y first where there is colour; `None` without any.
///
/// Of several courses that it may follow, even or as interfaces reflect and transmit, along the angle or its tangent, by
/// itself or by its logarithm, that by which the others foretell each one best. Past the outermost incidence it goes on as
/// it went.
///
/// Errors: as [`Curve::tabulated`].
pub(super) fn course(
    measured: &[(DVec3, Xyz)],
    symmetry: Symmetry,
    transmitted: bool,
) -> Result<Option<Course>> {
    let Some(first) = measured.iter().min_by(|a, b| b.0.z.abs().total_cmp(&a.0.z.abs())) else {
        return Ok(None);
    };
    let largest = measured.iter().map(|m| m.1.y).fold(0.0, f64::max).max(1e-6);
    let bases: &[Base] = match transmitted {
        true => &[Base::Even, Base::Pane],
        false => &[Base::Even, Base::Surface, Base::Metal(first.1.y.clamp(0.0, 1.0))],
    };
    let luminance: Vec<(DVec3, f64)> = measured.iter().map(|m| (m.0, m.1.y)).collect();
    let dark = luminance.iter().any(|m| m.1 < DARK * largest);
    let kinds = bases.iter().flat_map(|&base| {
        let along = [Along::Angle, Along::Tangent].into_iter();
        let along = along.take(if symmetry == Symmetry::Isotropic { 2 } else { 1 });
        along.flat_map(move |along| {
            let scales = [true, false].into_iter().filter(move |logarithm| !(dark && *logarithm));
            scales.map(move |logarithm| Kind { base, logarithm, along, symmetry })
        })
    });
    let tried = kinds.map(|kind| (kind.foretold(&luminance), kind));
    let best = tried.min_by(|a, b| a.0.unwrap_or(0.0).total_cmp(&b.0.unwrap_or(0.0)));
    let Some((residual, kind)) = best else { return Ok(None) };
    let y = kind.through(&luminance);
    let grey = measured.iter().all(|m| m.1 == Xyz::grey(m.1.y));
    // Colours by their shares of Y: smoother than they are.
    let share = |of: fn(&Xyz) -> f64| {
        let shares = measured.iter().map(|m| (m.0, of(&m.1) / m.1.y.max(1e-9))).collect::<Vec<_>>();
        let kind = Kind { base: Base::Even, logarithm: false, along: Along::Angle, symmetry };
        kind.through(&shares)
    };
    let [x, z] = [share(|c| c.x), share(|c| c.z)];
    let azimuths = if symmetry == Symmetry::Isotropic { 1 } else { AZIMUTHS };
    let most = largest.max(1.0);
    let curve = Curve::tabulated(RINGS, azimuths, |w| {
        let y = y(w).clamp(0.0, most);
        match grey {
            true => Xyz::grey(y),
            false => Xyz::new(y * x(w).clamp(0.0, 5.0), y, y * z(w).clamp(0.0, 5.0)),
        }
    })?;
    Ok(Some(Course { curve, residual: residual.map(|r| r / largest) }))
}

/// What a coefficient is smooth along.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Along {
    /// The polar angle.
    Angle,
    /// Its tangent: what slats, holes and layers hide of what lies below them.
    Tangent,
}

impl Along {
    fn of(self, w: DVec3) -> f64 {
        match self {
            Self::Angle => polar(w),
            Self::Tangent => polar(w).tan().clamp(0.0, STEEPEST),
        }
    }
}

/// Tangents beyond this are grazing.
const STEEPEST: f64 = 50.0;

#[derive(Clone, Copy)]
struct Kind {
    base: Base,
    logarithm: bool,
    along: Along,
    symmetry: Symmetry,
}

impl Kind {
    fn shape(self, (w, value): (DVec3, f64)) -> f64 {
        let ratio = value / self.base.at(w.z.abs());
        if self.logarithm { ratio.max(1e-9).ln() } else { ratio }
    }

    fn through(self, known: &[(DVec3, f64)]) -> Box<dyn Fn(DVec3) -> f64> {
        let back = move |w: DVec3, shape: f64| {
            self.base.at(w.z.abs()) * if self.logarithm { shape.exp() } else { shape }
        };
        if self.symmetry == Symmetry::Isotropic {
            let along = self.along;
            let spline = Spline::through(known.iter().map(|&k| (along.of(k.0), self.shape(k))));
            return Box::new(move |w| back(w, spline.at(along.of(w))));
        }
        let (mut places, mut values) = (Vec::<DVec3>::new(), Vec::new());
        for &(w, value) in known {
            let front = DVec3::new(w.x, w.y, w.z.abs());
            for image in self.symmetry.images() {
                let place = image.apply(front);
                if places.iter().all(|p| p.distance(place) > 1e-3) {
                    places.push(place);
                    values.push(self.shape((w, value)));
                }
            }
        }
        let smooth = Multiquadric::smooth_through(&places, &values);
        Box::new(move |w| back(w, smooth.at(DVec3::new(w.x, w.y, w.z.abs()))))
    }

    /// Root mean square of what each is off when foretold by the others, the outermost left out.
    fn foretold(self, known: &[(DVec3, f64)]) -> Option<f64> {
        if known.len() < 4 {
            return None;
        }
        let outermost = known.iter().map(|k| polar(k.0)).fold(0.0, f64::max);
        let inside = known.iter().enumerate().filter(|(_, k)| polar(k.0) < outermost - 1e-3);
        let errors: Vec<f64> = inside
            .map(|(n, &(w, value))| {
                let others = known.iter().enumerate().filter(|(m, _)| *m != n).map(|(_, k)| *k);
                let others: Vec<(DVec3, f64)> = others.collect();
                (self.through(&others)(w) - value).powi(2)
            })
            .collect();
        (!errors.is_empty()).then(|| (errors.iter().sum::<f64>() / errors.len() as f64).sqrt())
    }
}

fn polar(w: DVec3) -> f64 {
    w.truncate().length().atan2(w.z.abs()).min(FRAC_PI_2)
}

/// A natural cubic spline of the polar angle or its tangent, even about the normal; beyond its last knot a line.
struct Spline {
    knots: Vec<(f64, f64)>,
    /// Second derivatives.
    bends: Vec<f64>,
}

impl Spline {
    fn through(values: impl Iterator<Item = (f64, f64)>) -> Self {
        let mut knots: Vec<(f64, f64)> = values.collect();
        knots.sort_by(|a, b| a.0.total_cmp(&b.0));
        knots.dedup_by(|a, b| (a.0 - b.0).abs() < 1e-6);
        // Even: what lies on the other side of the normal is the same.
        let mirrored = knots.iter().rev().filter(|k| k.0 > 1e-6).map(|&(t, v)| (-t, v));
        let knots: Vec<(f64, f64)> = mirrored.chain(knots.iter().copied()).collect();
        let n = knots.len();
        let mut bends = vec![0.0; n];
        // Thomas' elimination of the tridiagonal system.
        let (mut upper, mut right) = (vec![0.0; n], vec![0.0; n]);
        for k in 1..n.saturating_sub(1) {
            let (before, after) = (knots[k].0 - knots[k - 1].0, knots[k + 1].0 - knots[k].0);
            let slopes =
                (knots[k + 1].1 - knots[k].1) / after - (knots[k].1 - knots[k - 1].1) / before;
            let pivot = 2.0 * (before + after) - before * upper[k - 1];
            upper[k] = after / pivot;
            right[k] = (6.0 * slopes - before * right[k - 1]) / pivot;
        }
        for k in (1..n.saturating_sub(1)).rev() {
            bends[k] = right[k] - upper[k] * bends[k + 1];
        }
        Self { knots, bends }
    }

    fn at(&self, t: f64) -> f64 {
        let (knots, bends) = (&self.knots, &self.bends);
        match knots.len() {
            0 => 0.0,
            1 => knots[0].1,
            n => {
                let k = knots.partition_point(|k| k.0 < t).clamp(1, n - 1);
                let ((t0, a), (t1, b)) = (knots[k - 1], knots[k]);
                let h = t1 - t0;
                let bend = |u: f64, at: f64| bends[at as usize] * (u * u * u - u) * h * h / 6.0;
                let inside = |t: f64| {
                    let u = (t - t0) / h;
                    (1.0 - u) * a + u * b + bend(1.0 - u, (k - 1) as f64) + bend(u, k as f64)
                };
                if t <= t1 {
                    return inside(t);
                }
                let slope = (b - a) / h + h / 6.0 * (bends[k - 1] + 2.0 * bends[k]);
                b + slope * (t - t1)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;

    use super::*;

    #[test]
    fn a_spline_goes_through_and_is_level_at_the_normal() {
        let f = |t: f64| (2.0 * t).cos();
        let spline = Spline::through((0..7).map(|k| f64::from(k) * 0.2).map(|t| (t, f(t))));
        // Bends end with the last knot: before it the spline errs by one order more.
        for k in 0..=20 {
            let t = f64::from(k) * 0.05;
            assert!((spline.at(t) - f(t)).abs() < 5e-3, "{t}: {}", spline.at(t));
        }
        assert!((spline.at(0.4) - f(0.4)).abs() < 1e-12);
        assert!((spline.at(0.001) - spline.at(0.0)).abs() < 1e-5);
    }

    /// A pane measured every 15 degrees, with another index than that of the courses tried.
    #[test]
    fn a_pane_is_known_between_incidences() {
        let n = 1.62;
        let pane = |theta: f64| {
            let c = theta.to_radians().cos();
            let t = (1.0 - (1.0 - c * c) / (n * n)).sqrt();
            let (s, p) = ((c - n * t) / (c + n * t), (n * c - t) / (n * c + t));
            let f = 0.5 * (s * s + p * p);
            (1.0 - f) / (1.0 + f)
        };
        let at = |theta: f64| (from_degrees(theta, 0.0), Xyz::grey(pane(theta)));
        let known = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0].map(at);
        let course = course(&known, Symmetry::Isotropic, true).unwrap().unwrap();
        for theta in [0.0, 7.0, 40.0, 52.0, 67.0, 72.0, 75.0, 80.0] {
            let found = course.curve.at(from_degrees(theta, 123.0)).y;
            let off = found / pane(theta) - 1.0;
            let bar = if theta > 75.0 { 0.05 } else { 0.01 };
            assert!(off.abs() < bar, "{theta}: {off}");
        }
        assert!(course.residual.unwrap() < 0.01, "{:?}", course.residual);
    }
}
