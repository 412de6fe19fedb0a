//! Which part of the hemisphere an incidence shows: what lies between its points, and what does
//! not.

use bsdfkit::{DVec2, DVec3, Side};
use bsdfkit_sphere::concentric::{disk_to_square, square_to_disk};

use super::{Directions, Incidence};

/// Cells across the square of directions: equal projected solid angles of 2 degrees.
const CELLS: usize = 48;

/// Points nearer than this (20 degrees) show what is between them. A grid of 15 degrees by 45
/// degrees of azimuth still does at 60 degrees of polar angle; with 10, published scans of 10
/// degrees of azimuth had holes.
const REACH: f64 = 0.349;

/// A direction is between points that leave no more than this open around it (190 degrees). On a
/// line it is half a turn, plus what leaves a strip of 1.7 degrees beside the line to it.
const OPEN: f64 = 3.316;

/// A peak of the specular direction does not hide where points are nearer than this: 10 degrees.
/// Detectors that stand in the light leave holes of 2 to 6 degrees.
const NEAR: f64 = 0.175;

/// Directions farther out than the last polar angle seen are asked for just within it.
const WITHIN: f64 = 0.99;

/// The part of a hemisphere, by cells of equal projected solid angle, in which directions lie
/// between points.
///
/// How near the horizon points reach is another matter: cells past the last polar angle are
/// what those within it, at the same azimuth, are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Seen {
    bits: Vec<u8>,
}

impl Seen {
    /// A total that rests on less than this share of the hemisphere is extrapolated. Instruments
    /// that reach 72 degrees all round see as much; twice the rest is what the totals of a matte
    /// specimen are wrong by.
    pub const ENOUGH: f64 = 0.9;

    /// Bytes of [`Seen::bytes`].
    pub const BYTES: usize = CELLS * CELLS / 8;

    /// Everything.
    pub fn whole() -> Self {
        Self { bits: vec![0xff; Self::BYTES] }
    }

    /// What the points of `incidence` show. Cost: some milliseconds.
    ///
    /// About the specular direction, where a peak may hide, points must be within [`NEAR`].
    pub fn of(incidence: &Incidence) -> Self {
        let points = &incidence.wo;
        let mut nearest: Vec<Option<DVec3>> = vec![None; CELLS * CELLS];
        for w in points.iter() {
            nearest[cell(w.truncate())].get_or_insert(Side::Front.facing(w));
        }
        let limit = limit(points);
        let few: Vec<DVec3> = nearest.iter().flatten().copied().collect();
        let specular = specular(incidence).with_z(incidence.wi.z.abs());
        let hides =
            |w: DVec3| w.dot(specular) > NEAR.cos() && !few.iter().any(|p| p.dot(w) > NEAR.cos());
        let mut seen = Self { bits: vec![0; Self::BYTES] };
        let up = |u: DVec2| u.extend((1.0 - u.length_squared()).max(0.0).sqrt());
        for (k, own) in nearest.iter().enumerate() {
            // A line through the cell may pass by its middle.
            let shown = |u: DVec2| {
                let within = u * (WITHIN * limit / u.length().max(1e-12)).min(1.0);
                is_between(&few, up(within))
            };
            if own.is_some() || !hides(up(middle(k))) && parts(k).into_iter().any(shown) {
                seen.bits[k / 8] |= 1 << (k % 8);
            }
        }
        seen
    }

    /// Whether a total may rest on it: enough is seen, and the `specular` direction, if points
    /// reach out to `limit`.
    pub fn tells(&self, limit: f64, specular: DVec3) -> bool {
        self.share(limit) >= Self::ENOUGH && self.holds(specular)
    }

    /// Whether `w`, of either side, is in a part that is seen.
    pub fn holds(&self, w: DVec3) -> bool {
        let k = cell(w.truncate());
        self.bits[k / 8] >> (k % 8) & 1 == 1
    }

    /// Share of the projected hemisphere that is seen, if points reach out to `limit` (sin θ).
    pub fn share(&self, limit: f64) -> f64 {
        let (mut all, mut seen) = (0u32, 0u32);
        for k in (0..CELLS * CELLS).filter(|&k| middle(k).length() <= limit) {
            all += 1;
            seen += u32::from(self.bits[k / 8] >> (k % 8) & 1);
        }
        limit * limit * f64::from(seen) / f64::from(all.max(1))
    }

    /// One bit a cell, lowest first, rows of the square of directions.
    pub fn bytes(&self) -> &[u8] {
        &self.bits
    }

    /// From what [`Seen::bytes`] gave; `None` if these are not so many.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        (bytes.len() == Self::BYTES).then(|| Self { bits: bytes.to_vec() })
    }

    /// The middles of the cells that are seen out to `limit`.
    pub(super) fn middles(&self, limit: f64, side: Side) -> Vec<DVec3> {
        let up = |u: DVec2| u.extend(side.sign() * (1.0 - u.length_squared()).max(0.0).sqrt());
        let seen = |k: &usize| self.bits[k / 8] >> (k % 8) & 1 == 1;
        let all = (0..CELLS * CELLS).filter(seen).map(middle);
        all.filter(|u| u.length() <= limit).map(up).collect()
    }
}

/// Where a mirror or a clear pane would send the light of `incidence`, on the side of its points.
pub(super) fn specular(incidence: &Incidence) -> DVec3 {
    let (wi, back) = (incidence.wi, incidence.wo.first().is_some_and(|w| w.z < 0.0));
    DVec3::new(-wi.x, -wi.y, if back { -wi.z.abs() } else { wi.z.abs() })
}

/// The largest sine of a polar angle among `points`.
pub(super) fn limit(points: &Directions) -> f64 {
    points.iter().map(|w| w.truncate().length()).fold(0.0, f64::max)
}

fn cell(u: DVec2) -> usize {
    let square = disk_to_square(u) * CELLS as f64;
    let at = |x: f64| (x.max(0.0) as usize).min(CELLS - 1);
    at(square.x) * CELLS + at(square.y)
}

fn middle(k: usize) -> DVec2 {
    place(k, DVec2::splat(0.5))
}

/// The middle of a cell, and those of its quarters.
fn parts(k: usize) -> [DVec2; 5] {
    [(0.5, 0.5), (0.25, 0.25), (0.75, 0.25), (0.25, 0.75), (0.75, 0.75)].map(|p| place(k, p.into()))
}

fn place(k: usize, within: DVec2) -> DVec2 {
    let corner = DVec2::new((k / CELLS) as f64, (k % CELLS) as f64);
    square_to_disk((corner + within) / CELLS as f64)
}

/// Whether points within [`REACH`] of `w` surround it.
fn is_between(points: &[DVec3], w: DVec3) -> bool {
    let (x, y) = w.any_orthonormal_pair();
    let near = REACH.cos();
    let mut around: Vec<f64> =
        points.iter().filter(|p| p.dot(w) >= near).map(|p| p.dot(y).atan2(p.dot(x))).collect();
    around.sort_by(f64::total_cmp);
    let (Some(first), Some(last)) = (around.first(), around.last()) else { return false };
    let behind = first + std::f64::consts::TAU - last;
    around.windows(2).map(|a| a[1] - a[0]).fold(behind, f64::max) <= OPEN
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit_sphere::direction::from_degrees;

    fn grid(thetas: impl Iterator<Item = i32>, phis: impl Fn(i32) -> bool) -> Vec<DVec3> {
        let of = |t: i32| (0..24).map(move |k| (t, 15 * k));
        let angles = thetas.flat_map(of).filter(|&(_, phi)| phis(phi));
        angles.map(|(t, phi)| from_degrees(f64::from(t), f64::from(phi))).collect()
    }

    /// Lit along the normal.
    fn seen(points: &[DVec3]) -> Seen {
        Seen::of(&Incidence::new(DVec3::Z, points.iter().copied(), vec![1.0; points.len()]))
    }

    fn reach(points: &[DVec3]) -> f64 {
        limit(&points.iter().copied().collect())
    }

    fn share(points: &[DVec3]) -> f64 {
        seen(points).share(reach(points))
    }

    #[test]
    fn a_hole_where_a_peak_may_be_is_none_to_look_across() {
        let hole = |degrees: i32| grid((degrees..=80).step_by(5), |_| true);
        let tells = |points: &[DVec3]| seen(points).tells(reach(points), DVec3::Z);
        assert!(tells(&hole(0)) && tells(&hole(5)) && !tells(&hole(15)));
        assert!(share(&hole(15)) > 0.87);
    }

    #[test]
    fn shares_are_those_of_the_regions() {
        let sine = |degrees: f64| degrees.to_radians().sin().powi(2);
        let steps = |to: i32| (0..=to / 10).map(|k| 10 * k);
        assert!((share(&grid(steps(80), |_| true)) - sine(80.0)).abs() < 0.01);
        assert!((share(&grid(steps(30), |_| true)) - sine(30.0)).abs() < 0.01);
        let half = share(&grid(steps(80), |phi| phi <= 180));
        assert!((half - 0.5 * sine(80.0)).abs() < 0.05, "{half}");
        let plane = share(&grid(steps(80), |phi| phi % 180 == 30));
        assert!((0.0..0.08).contains(&plane), "{plane}");
        // As a ring of this radius shows itself and not what it surrounds.
        let ring = share(&grid([50].into_iter(), |_| true));
        assert!((0.0..0.2).contains(&ring), "{ring}");
        assert_eq!(share(&[]), 0.0);
    }

    #[test]
    fn a_plane_shows_its_own_directions_on_either_side() {
        for back in [1.0, -1.0] {
            let points: Vec<DVec3> = (-16..=16)
                .map(|k| from_degrees(5.0 * f64::from(k), 20.0))
                .map(|w| DVec3::new(w.x, w.y, back * w.z))
                .collect();
            let seen = seen(&points);
            for k in -75..75 {
                let w = from_degrees(f64::from(k), 20.0);
                assert!(seen.holds(w) && seen.holds(-w), "{k}");
            }
            assert!(
                !seen.holds(from_degrees(30.0, 110.0)) && !seen.holds(from_degrees(60.0, 60.0))
            );
        }
    }

    #[test]
    fn bytes_come_back() {
        let seen = seen(&grid((0..5).map(|k| 10 * k), |phi| phi < 100));
        assert_eq!(Seen::from_bytes(seen.bytes()), Some(seen.clone()));
        assert_eq!(Seen::from_bytes(&seen.bytes()[1..]), None);
    }
}
