//! The coefficient of a peak over incident directions.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use bsdfkit_sphere::{DVec2, DVec3};

use crate::{Error, Result, Xyz};

/// A smooth function of one direction, tabulated on even rings of polar angle and even azimuths.
///
/// Ring k of K stands at 90° k / (K − 1), azimuth j of J at 360° j / J; one azimuth: all are alike. In between it is a
/// cubic through the four nearest of each (Catmull-Rom), kept within the range of these: smooth, exact at the nodes, and
/// never below 0. Directions of either side count by their x and y.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    rings: usize,
    azimuths: usize,
    values: Vec<Xyz>,
}

/// Most values: a node every quarter of a degree.
const MOST_VALUES: usize = 361 * 1440;
/// Largest coefficient: measured ones may pass 1 by their errors, not by this.
const MOST: f64 = 10.0;

impl Curve {
    /// From a table, azimuths fastest.
    ///
    /// Errors: argument for fewer than 2 rings, no azimuth, an odd number of several azimuths (a ring goes on beyond the
    /// normal at the azimuth opposite), another number of values, more than 519,840, or values that are not 0 to 10.
    pub fn new(rings: usize, azimuths: usize, values: Vec<Xyz>) -> Result<Self> {
        let refused = |what: String| Err(Error::argument(format!("specular coefficient: {what}")));
        let azimuths_fit = azimuths == 1 || (azimuths >= 4 && azimuths.is_multiple_of(2));
        if rings < 2 || !azimuths_fit {
            let found = format!("found {rings} and {azimuths}");
            return refused(format!(
                "expected 2 or more rings of 1 azimuth or an even number from 4, {found}"
            ));
        }
        let count = rings.checked_mul(azimuths).filter(|count| *count <= MOST_VALUES);
        if count != Some(values.len()) {
            let found = values.len();
            return refused(format!(
                "expected {rings} × {azimuths} values, at most {MOST_VALUES}, found {found}"
            ));
        }
        let numbers = values.iter().flat_map(|c| [c.x, c.y, c.z]);
        if let Some(wrong) = numbers.into_iter().find(|v| !(0.0..=MOST).contains(v)) {
            return refused(format!("expected values of 0 to {MOST}, found {wrong}"));
        }
        Ok(Self { rings, azimuths, values })
    }

    /// The same value everywhere.
    ///
    /// Errors: argument, outside 0 to 10.
    pub fn constant(value: Xyz) -> Result<Self> {
        Self::new(2, 1, vec![value; 2])
    }

    /// A table of `f`, which is asked for directions of the front.
    ///
    /// Errors: as [`Curve::new`].
    pub fn tabulated(rings: usize, azimuths: usize, f: impl Fn(DVec3) -> Xyz) -> Result<Self> {
        let nodes = Nodes { rings: rings.clamp(2, MOST_VALUES), azimuths: azimuths.max(1) };
        let count = nodes.rings.saturating_mul(nodes.azimuths).min(MOST_VALUES + 1);
        Self::new(rings, azimuths, (0..count).map(|n| f(nodes.direction(n))).collect())
    }

    /// How many rings and azimuths.
    pub fn shape(&self) -> [usize; 2] {
        [self.rings, self.azimuths]
    }

    /// The table, azimuths fastest.
    pub fn values(&self) -> &[Xyz] {
        &self.values
    }

    /// Whether it has colour.
    pub fn is_coloured(&self) -> bool {
        self.values.iter().any(|c| *c != Xyz::grey(c.y))
    }

    /// The value at `w`. NaN in, NaN out.
    pub fn at(&self, w: DVec3) -> Xyz {
        let u = w.truncate();
        if w.is_nan() {
            return Xyz::grey(f64::NAN);
        }
        let theta = u.length().atan2(w.z.abs());
        let along = (theta / FRAC_PI_2 * (self.rings - 1) as f64).min((self.rings - 1) as f64);
        let ring = (along as usize).min(self.rings - 2);
        let place = along - ring as f64;
        let rows = [ring as isize - 1, ring as isize, ring as isize + 1, ring as isize + 2];
        let (azimuth, aside) = self.azimuth(u);
        let columns = rows.map(|row| self.row(row, azimuth));
        let (low, high) = range(columns.as_flattened());
        let ends = columns.map(|row| cubic(row, aside));
        let value = cubic(ends, place);
        each([value, low, high], |[v, low, high]| v.clamp(low, high))
    }

    /// The azimuth at or before that of `u`, and how far beyond it in steps.
    fn azimuth(&self, u: DVec2) -> (usize, f64) {
        if self.azimuths == 1 {
            return (0, 0.0);
        }
        let turn = (u.y.atan2(u.x) / TAU).rem_euclid(1.0) * self.azimuths as f64;
        // A whole turn by rounding is the first again.
        (turn as usize % self.azimuths, turn.fract())
    }

    /// Four nodes of a ring about an azimuth. Before the first ring is the second, seen across the normal; past the last
    /// the table goes on straight.
    fn row(&self, ring: isize, azimuth: usize) -> [Xyz; 4] {
        let count = self.azimuths;
        let last = self.rings as isize - 1;
        if ring > last {
            let (at, before) = (self.row(last, azimuth), self.row(last - 1, azimuth));
            return [0, 1, 2, 3].map(|k| each([at[k], before[k]], |[a, b]| (2.0 * a - b).max(0.0)));
        }
        let turned = if ring < 0 { count / 2 } else { 0 };
        let first = ring.unsigned_abs() * count;
        [0, 1, 2, 3].map(|k| self.values[first + (azimuth + turned + count + k - 1) % count])
    }

    /// The table of the values that `from` leads to; 0 where it leads nowhere.
    pub(super) fn moved(&self, from: impl Fn(DVec3) -> Option<DVec3>) -> Self {
        let nodes = Nodes { rings: self.rings, azimuths: self.azimuths };
        let value = |n| {
            let w: DVec3 = nodes.direction(n);
            // The horizon itself is on no side.
            let w = if w.z < 1e-9 { DVec3::new(w.x, w.y, 1e-6).normalize() } else { w };
            from(w).map_or(Xyz::ZERO, |w| self.at(w))
        };
        Self { values: (0..self.values.len()).map(value).collect(), ..*self }
    }
}

struct Nodes {
    rings: usize,
    azimuths: usize,
}

impl Nodes {
    fn direction(&self, n: usize) -> DVec3 {
        let (ring, azimuth) = (n / self.azimuths, n % self.azimuths);
        let theta = FRAC_PI_2 * ring as f64 / (self.rings - 1) as f64;
        let phi = 2.0 * PI * azimuth as f64 / self.azimuths as f64;
        let (sine, cosine) = theta.sin_cos();
        (DVec2::from_angle(phi) * sine).extend(if ring + 1 == self.rings { 0.0 } else { cosine })
    }
}

/// A function of each of three channels.
fn each<const N: usize>(colours: [Xyz; N], f: impl Fn([f64; N]) -> f64) -> Xyz {
    Xyz::new(f(colours.map(|c| c.x)), f(colours.map(|c| c.y)), f(colours.map(|c| c.z)))
}

/// Catmull-Rom between the middle two of four even nodes.
fn cubic(nodes: [Xyz; 4], t: f64) -> Xyz {
    each(nodes, |[a, b, c, d]| {
        let slope = 0.5 * (c - a);
        let bend = a - 2.5 * b + 2.0 * c - 0.5 * d;
        let twist = 0.5 * (d - a) + 1.5 * (b - c);
        b + t * (slope + t * (bend + t * twist))
    })
}

fn range(values: &[Xyz]) -> (Xyz, Xyz) {
    let first = values[0];
    values.iter().fold((first, first), |(low, high), v| {
        (each([low, *v], |[a, b]| a.min(b)), each([high, *v], |[a, b]| a.max(b)))
    })
}

#[cfg(test)]
mod tests {
    use bsdfkit_sphere::direction::from_degrees;

    use super::*;

    /// Smooth on the hemisphere, normal included.
    fn smooth(w: DVec3) -> Xyz {
        let y = 0.5 + 0.3 * w.x + 0.1 * w.y * w.y;
        Xyz::new(0.9 * y, y, 1.1 * y)
    }

    #[test]
    fn nodes_are_exact_and_between_them_it_is_near() {
        let curve = Curve::tabulated(37, 72, smooth).unwrap();
        let mut worst = 0.0f64;
        for k in 0..2000 {
            let w = from_degrees(f64::from(k) * 0.0449, f64::from(k) * 17.7);
            worst = worst.max((curve.at(w).y - smooth(w).y).abs());
        }
        assert!(worst < 1e-4, "{worst}");
        for (theta, phi) in [(0.0, 0.0), (2.5, 5.0), (45.0, 180.0), (87.5, 355.0), (90.0, 90.0)] {
            let w = from_degrees(theta, phi);
            assert!((curve.at(w).x - smooth(w).x).abs() < 1e-12, "{theta} {phi}");
        }
    }

    #[test]
    fn one_azimuth_is_all() {
        let curve = Curve::tabulated(10, 1, |w| Xyz::grey(w.z)).unwrap();
        let [a, b] = [0.0, 123.0].map(|phi| curve.at(from_degrees(33.0, phi)));
        assert!((a.y - b.y).abs() < 1e-12 && (a.y - 33f64.to_radians().cos()).abs() < 1e-3);
        assert!(!curve.is_coloured());
    }

    /// A step overshoots without the range.
    #[test]
    fn it_stays_within_its_nodes() {
        let curve = Curve::tabulated(19, 1, |w| Xyz::grey(f64::from(w.z > 0.5))).unwrap();
        for k in 0..900 {
            let value = curve.at(from_degrees(f64::from(k) * 0.1, 0.0)).y;
            assert!((0.0..=1.0).contains(&value), "{k}: {value}");
        }
    }

    #[test]
    fn tables_are_checked() {
        assert!(Curve::new(1, 1, vec![Xyz::ZERO]).is_err());
        assert!(Curve::new(2, 3, vec![Xyz::ZERO; 6]).is_err());
        assert!(Curve::new(2, 1, vec![Xyz::ZERO; 3]).is_err());
        assert!(Curve::new(usize::MAX, 4, Vec::new()).is_err());
        assert!(Curve::constant(Xyz::grey(-0.1)).is_err());
        assert!(Curve::constant(Xyz::grey(f64::NAN)).is_err());
        assert!(Curve::tabulated(1_000_000, 1_000_000, smooth).is_err());
    }
}
