//! Lobes on the disk of scattered directions: bent ellipses, for telling what is near them.

use bsdfkit::DVec2;
use bsdfkit_sphere::concentric::disk_to_square;

use crate::lobe::Lobe;
use bsdfkit_represent::Peak;

/// A lobe on the disk; on the square, along whose diagonals the map is bent, a long one may have corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bow {
    centre: DVec2,
    /// Its longer axis, one standard deviation long: t deviations on, it is at centre + t along + t² bend.
    along: DVec2,
    /// Across it: how fast the disk goes by along the axis only shifts t.
    bend: DVec2,
    /// How far the middle of a circle as wide as the lobe moves within it, in deviations along.
    last: f64,
    /// The greatest standard deviation across.
    across: f64,
    /// The least standard deviation of all, on the square.
    pub(crate) narrow: f64,
}

/// Lobes are seen out to so many deviations. At 3, what lies beyond is seen by coarse cells, which miss 1 %.
const REACH: f64 = 4.5;
/// Steps in deviations, and directions, in which the flank of a lobe above the horizon is looked for.
const FLANK: f64 = 0.25;
const AROUND: u32 = 24;
/// Deviations from the centre at which the bend is seen; the first that are above the horizon.
const BENT: [f64; 3] = [2.25, 1.0, 0.4];

impl Bow {
    /// `place`: where frame coordinates are on the disk; `None` below the horizon. None of a lobe that is there
    /// with all that is seen of it.
    pub(crate) fn of(lobe: &Lobe, place: &impl Fn(DVec2) -> Option<DVec2>) -> Option<Self> {
        let [long, short] = lobe.covariance.axes();
        let ratio = (long.length() / short.length().max(1e-12)).max(1.0);
        let Some(centre) = place(lobe.mean) else {
            return Self::of_flank(lobe, place);
        };
        let end = |t: f64| place(lobe.mean + t * long);
        let both = |t: f64| Some((t, end(t)?, end(-t)?));
        let one = |t: f64| Some((t.abs(), (end(t)? - centre) / t));
        let (seen, along, bend) = if let Some((t, a, b)) = BENT.into_iter().find_map(both) {
            let along = (a - b) / (2.0 * t);
            (t, along, (a + b - 2.0 * centre).reject_from(along) / (2.0 * t * t))
        } else {
            // The horizon cuts it off close to its centre: it goes on to one side only.
            let (t, along) =
                BENT.into_iter().flat_map(|t| [t, -t]).find_map(one).unwrap_or_default();
            (t, along, DVec2::ZERO)
        };
        // The greater of both sides: near the horizon the disk flattens one of them.
        let greater = |q: DVec2, d: DVec2, distance: &dyn Fn(DVec2, DVec2) -> f64| {
            let at = place(q)?;
            [d, -d].into_iter().filter_map(|d| Some(distance(at, place(q + d)?))).reduce(f64::max)
        };
        let on_disk = |a: DVec2, b: DVec2| a.distance(b);
        let on_square = |a, b| disk_to_square(a).distance(disk_to_square(b));
        let across = [-seen, 0.0, seen].into_iter().flat_map(|t| [(t, short), (t, long / ratio)]);
        let across = across.filter_map(|(t, d)| greater(lobe.mean + t * long, d, &on_disk));
        let across = across.fold(0.0, f64::max);
        let narrow =
            [short, long / ratio].into_iter().filter_map(|d| greater(lobe.mean, d, &on_square));
        let narrow = narrow.fold(1.0, f64::min);
        let last = REACH * (1.0 - 1.0 / ratio);
        Some(Self { centre, along, bend, last, across, narrow })
    }

    /// Of a lobe whose centre is below the horizon: a round one about the place above it where most of it is left.
    fn of_flank(lobe: &Lobe, place: &impl Fn(DVec2) -> Option<DVec2>) -> Option<Self> {
        let axes = lobe.covariance.axes();
        let at = |k: u32| {
            let v = DVec2::from_angle(std::f64::consts::TAU * f64::from(k) / f64::from(AROUND));
            v.x * axes[0] + v.y * axes[1]
        };
        let rings = (1..=(REACH / FLANK) as u32).map(|k| FLANK * f64::from(k));
        let above =
            |r: f64| (0..AROUND).find(|&k| place(lobe.mean + r * at(k)).is_some()).map(|k| (r, k));
        let (r, k) = rings.into_iter().find_map(above)?;
        let q = lobe.mean + r * at(k);
        let centre = place(q)?;
        let steps = || axes.into_iter().flat_map(|a| [a, -a]).filter_map(|d| place(q + d));
        let across = steps().map(|u| u.distance(centre)).fold(0.0, f64::max);
        let square = disk_to_square(centre);
        let narrow = axes.map(|a| {
            let far = [a, -a].into_iter().filter_map(|d| place(q + d));
            far.map(|u| disk_to_square(u).distance(square)).fold(0.0, f64::max)
        });
        let narrow = narrow.into_iter().filter(|n| *n > 0.0).fold(1.0, f64::min);
        Some(Self { centre, along: DVec2::ZERO, bend: DVec2::ZERO, last: 0.0, across, narrow })
    }

    /// A round one where a peak is.
    pub(crate) fn of_peak(peak: &Peak) -> Self {
        let (centre, across) = (peak.direction.truncate(), peak.radius);
        let on_square = |d: DVec2| disk_to_square(centre).distance(disk_to_square(centre + d));
        let around = [DVec2::X, DVec2::Y, -DVec2::X, -DVec2::Y].map(|d| on_square(across * d));
        let narrow = around.into_iter().fold(0.0, f64::max);
        Self { centre, along: DVec2::ZERO, bend: DVec2::ZERO, last: 0.0, across, narrow }
    }

    /// Whether the lobe is less than `margin` from `u`.
    pub(crate) fn is_near(&self, u: DVec2, margin: f64) -> bool {
        let d = u - self.centre;
        let t = d.dot(self.along) / self.along.length_squared().max(1e-24);
        let t = t.clamp(-self.last, self.last);
        let reach = REACH * self.across + margin;
        (d - t * (self.along + t * self.bend)).length_squared() < reach * reach
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolant::Frame;
    use crate::lobe::Covariance;
    use bsdfkit_sphere::direction::from_degrees;

    /// Of long lobes near the mirror or straight-through direction, and as the horizon cuts them off: all but 1.5 % of
    /// what is scattered within 4.5 deviations is near, and little else of the disk.
    #[test]
    fn what_is_near_is_the_lobe_however_it_bends() {
        let lattice =
            (-50..=50).flat_map(|i| (-50..=50).map(move |j| DVec2::new(i.into(), j.into()) / 50.0));
        let disk: Vec<DVec2> = lattice.filter(|p| p.length() < 1.0).collect();
        let (mut areas, mut count) = (0.0, 0.0);
        for frame in [Frame::Half, Frame::Turned, Frame::Refracted { index: 1.5 }] {
            for (theta, turn) in
                [20.0, 50.0, 65.0, 75.0].into_iter().flat_map(|t| [(t, 0.0), (t, 0.7), (t, 1.57)])
            {
                let at = frame.at(from_degrees(theta, 20.0));
                let place = |q: DVec2| {
                    let (u, z) = at.inverse(q);
                    (z > 0.0).then_some(u)
                };
                for [wide, narrow] in [[0.25, 0.05], [0.1, 0.006], [0.2, 0.02]] {
                    let (long, short) = (
                        wide * DVec2::from_angle(0.35 + turn),
                        narrow * DVec2::from_angle(0.35 + turn).perp(),
                    );
                    let outer =
                        |v: DVec2| Covariance { xx: v.x * v.x, xy: v.x * v.y, yy: v.y * v.y };
                    let covariance = Covariance::combine(1.0, outer(long), 1.0, outer(short));
                    let lobe = Lobe { mass: 1.0, mean: DVec2::new(0.02, 0.01), covariance };
                    let bow = Bow::of(&lobe, &place).expect("above the horizon");
                    let (mut all, mut missed) = (0.0, 0.0);
                    for k in 0..4000 {
                        let r = REACH * f64::from(k) / 4000.0;
                        let (s, c) = (0.1 * f64::from(k)).sin_cos();
                        if let Some(u) = place(lobe.mean + r * (c * long + s * short)) {
                            let weight = r * (-0.5 * r * r).exp();
                            all += weight;
                            missed += if bow.is_near(u, 0.0) { 0.0 } else { weight };
                        }
                    }
                    assert!(
                        missed < 0.015 * all,
                        "{frame:?} {theta} {turn} {wide}: {}",
                        missed / all
                    );
                    areas += disk.iter().filter(|u| bow.is_near(**u, 0.0)).count() as f64
                        / disk.len() as f64;
                    count += 1.0;
                }
            }
        }
        assert!(areas / count < 0.12, "{}", areas / count);
    }
}
