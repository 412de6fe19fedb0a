//! The place of a peak in one scan: its points, the smooth surround, and the light of the peak above it.

use bsdfkit::{DVec2, DVec3};

use super::signature::Signature;
use bsdfkit_measure::Incidence;
use bsdfkit_measure::linear::Cholesky;

/// The surround is looked at as far as so many footprints from the middle.
pub(super) const AROUND: f64 = 3.0;
/// Points of a surround that decide over a curved one, and over one at all.
const CURVED: usize = 14;
const FLAT: usize = 4;

/// The points of a scan near a direction.
pub(super) struct Near<'a> {
    scan: &'a Incidence,
    pub(super) centre: DVec3,
    axes: [DVec3; 2],
    /// Numbers of the points, and where they are from the centre: radians along the axes.
    points: Vec<(usize, DVec2)>,
}

impl<'a> Near<'a> {
    /// Points within `radius` radians.
    pub(super) fn new(scan: &'a Incidence, centre: DVec3, radius: f64) -> Self {
        let (u, v) = centre.any_orthonormal_pair();
        let least = radius.cos();
        let near = scan.wo.iter().enumerate().filter(|(_, w)| w.dot(centre) >= least);
        let points = near.map(|(k, w)| (k, DVec2::new(w.dot(u), w.dot(v)))).collect();
        Self { scan, centre, axes: [u, v], points }
    }

    /// The direction at a place.
    pub(super) fn direction(&self, at: DVec2) -> DVec3 {
        let [u, v] = self.axes;
        (self.centre * (1.0 - at.length_squared()).max(0.0).sqrt() + at.x * u + at.y * v)
            .normalize()
    }

    /// Light per solid angle of a point, 1/sr: f |cos θo|.
    fn light(&self, k: usize, channel: usize) -> f64 {
        self.scan.value(k, channel) * self.scan.wo.at(k).z.abs()
    }

    /// Distance from `middle` and light of each point.
    pub(super) fn by_distance(
        &self,
        middle: DVec2,
        channel: usize,
    ) -> impl Iterator<Item = (f64, f64)> {
        self.points.iter().map(move |&(k, at)| (at.distance(middle), self.light(k, channel)))
    }

    /// The surround of what lies within `footprint` of `middle`: fitted to the points around.
    ///
    /// `None` where there are too few.
    pub(super) fn surround(
        &self,
        middle: DVec2,
        footprint: f64,
        channel: usize,
    ) -> Option<Surround> {
        let ring: Vec<(DVec2, f64)> = self
            .points
            .iter()
            .map(|&(k, at)| ((at - middle) / footprint, self.light(k, channel)))
            .filter(|(at, _)| (1.0..=AROUND).contains(&at.length()))
            .collect();
        Surround::through(&ring, middle, footprint)
    }

    /// Light of the peak at `middle` above the surround, by least squares of what the signature says of each point, and
    /// what is left unexplained: root mean square over the height.
    pub(super) fn amplitude(
        &self,
        middle: DVec2,
        signature: &Signature,
        surround: &Surround,
        channel: usize,
    ) -> (f64, f64) {
        let reach = signature.footprint() * 1.3;
        let inside = || {
            self.points.iter().filter_map(|&(k, at)| {
                let r = at.distance(middle);
                (r <= reach)
                    .then(|| (signature.at(r), self.light(k, channel) - surround.at(at).max(0.0)))
            })
        };
        let (mut both, mut own, mut count) = (0.0, 0.0, 0usize);
        for (s, y) in inside() {
            both += s * y;
            own += s * s;
            count += 1;
        }
        if own <= 0.0 {
            return (0.0, f64::INFINITY);
        }
        let amplitude = both / own;
        let left: f64 = inside().map(|(s, y)| (y - amplitude * s).powi(2)).sum();
        let height = amplitude * signature.at(0.0);
        (amplitude, (left / count as f64).sqrt() / height.abs().max(1e-12))
    }

    /// Light of a peak whose place, signature and surround are known: from the points where the signature is level, if
    /// there are some, as an edge tells more of the place than of the light.
    pub(super) fn light_of(
        &self,
        middle: DVec2,
        signature: &Signature,
        surround: &Surround,
        channel: usize,
    ) -> f64 {
        let level = signature.level();
        let sums = |reach: f64| {
            let inside = self.points.iter().filter(|(_, at)| at.distance(middle) <= reach);
            inside.fold((0.0, 0.0, 0), |(both, own, count), &(k, at)| {
                let s = signature.at(at.distance(middle));
                let y = self.light(k, channel) - surround.at(at).max(0.0);
                (both + s * y, own + s * s, count + 1)
            })
        };
        let (both, own, _) = match sums(level) {
            found if found.2 >= FLAT => found,
            _ => sums(signature.footprint()),
        };
        if own > 0.0 { both / own } else { 0.0 }
    }

    /// Points within `radius` of `middle`.
    pub(super) fn within(&self, middle: DVec2, radius: f64) -> Vec<(usize, DVec2)> {
        self.points.iter().copied().filter(|(_, at)| at.distance(middle) <= radius).collect()
    }
}

/// Light per solid angle below a peak as the points around it say: a quadratic of the place, or its exponential.
#[derive(Clone, Debug)]
pub(super) struct Surround {
    middle: DVec2,
    scale: f64,
    coefficients: [f64; 6],
    logarithm: bool,
    /// The median around.
    pub(super) level: f64,
}

impl Surround {
    fn through(ring: &[(DVec2, f64)], middle: DVec2, scale: f64) -> Option<Self> {
        if ring.len() < FLAT {
            return None;
        }
        let mut values: Vec<f64> = ring.iter().map(|p| p.1).collect();
        values.sort_by(f64::total_cmp);
        let level = values[values.len() / 2].max(0.0);
        let flat = Self {
            middle,
            scale,
            coefficients: [level, 0.0, 0.0, 0.0, 0.0, 0.0],
            logarithm: false,
            level,
        };
        if ring.len() < CURVED {
            return Some(flat);
        }
        let curved = |logarithm: bool| -> Option<Self> {
            let rows = ring.iter().map(|&(at, y)| match logarithm {
                // An error of the logarithm counts by what it is an error of.
                true => (at, y.ln(), y * y),
                false => (at, y, 1.0),
            });
            Some(Self { coefficients: quadratic(rows)?, logarithm, ..flat.clone() })
        };
        let missed = |s: &Self| -> f64 {
            ring.iter().map(|&(at, y)| (s.at(at * scale + middle) - y).powi(2)).sum()
        };
        let positive = values[0] > 0.0;
        let tried = [curved(false), curved(true).filter(|_| positive)];
        let best = tried.into_iter().flatten().min_by(|a, b| missed(a).total_cmp(&missed(b)));
        Some(best.unwrap_or(flat))
    }

    /// At a place, 1/sr.
    pub(super) fn at(&self, at: DVec2) -> f64 {
        let p = terms((at - self.middle) / self.scale);
        let sum: f64 = p.iter().zip(&self.coefficients).map(|(a, b)| a * b).sum();
        if self.logarithm { sum.exp() } else { sum }
    }
}

fn terms(at: DVec2) -> [f64; 6] {
    [1.0, at.x, at.y, at.x * at.x, at.x * at.y, at.y * at.y]
}

/// Weighted least squares.
fn quadratic(rows: impl Iterator<Item = (DVec2, f64, f64)>) -> Option<[f64; 6]> {
    let (mut a, mut b, mut whole) = ([0.0; 36], [0.0; 6], 0.0);
    for (at, y, weight) in rows {
        let p = terms(at);
        for i in 0..6 {
            for j in 0..=i {
                a[6 * i + j] += weight * p[i] * p[j];
            }
            b[i] += weight * p[i] * y;
        }
        whole += weight;
    }
    let solver = Cholesky::new(&mut a, 6, 1e-6 * whole)?;
    solver.solve(&mut b);
    Some(b)
}
