//! Lobes on the disk of scattered directions: bent ellipses, for telling what is near them.

use bsdfkit::DVec2;
use bsdfkit_sphere::concentric::disk_to_square;

use crate::lobe::Lobe;

/// A lobe on the disk; on the square, along whose diagonals the map is bent, a long one may have corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bow {
    centre: DVec2,
    /// Its longer axis: where it is t standard deviations from the centre is centre + t along + t² bend.
    along: DVec2,
    bend: DVec2,
    /// How far the middle of a circle as wide as the lobe moves within it, in deviations along.
    last: f64,
    /// The greatest standard deviation across.
    across: f64,
    /// The least standard deviation of all, on the square.
    pub(super) narrow: f64,
}

/// Lobes are seen out to so many deviations. At 3, what lies beyond is seen by coarse cells, which miss 1 %.
const REACH: f64 = 4.5;
/// Deviations from the centre at which the bend is seen; the first that are above the horizon.
const BENT: [f64; 3] = [2.25, 1.0, 0.4];

impl Bow {
    /// `place`: where frame coordinates are on the disk; `None` below the horizon. None of a lobe whose centre is
    /// there.
    pub(super) fn of(lobe: &Lobe, place: &impl Fn(DVec2) -> Option<DVec2>) -> Option<Self> {
        let [long, short] = lobe.covariance.axes();
        let ratio = (long.length() / short.length().max(1e-12)).max(1.0);
        let centre = place(lobe.mean)?;
        let ends = |t: f64| Some((t, place(lobe.mean + t * long)?, place(lobe.mean - t * long)?));
        let (along, bend, seen) =
            BENT.into_iter().find_map(ends).map_or((DVec2::ZERO, DVec2::ZERO, 0.0), |(t, a, b)| {
                ((a - b) / (2.0 * t), (a + b - 2.0 * centre) / (2.0 * t * t), t)
            });
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

    /// Whether the lobe is less than `margin` from `u`.
    pub(super) fn is_near(&self, u: DVec2, margin: f64) -> bool {
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

    /// Of a long lobe about the mirror direction at 50 degrees, bent by the frame: all of it out to four deviations
    /// is near, and little else.
    #[test]
    fn what_is_near_is_the_lobe_however_it_bends() {
        let at = Frame::Half.at(from_degrees(50.0, 20.0));
        let covariance = Covariance { xx: 0.0036, xy: 0.0, yy: 0.000_16 };
        let lobe = Lobe { mass: 1.0, mean: DVec2::ZERO, covariance };
        let place = |q: DVec2| {
            let (u, z) = at.inverse(q);
            (z > 0.0).then_some(u)
        };
        let bow = Bow::of(&lobe, &place).expect("above the horizon");
        let [long, short] = covariance.axes();
        for k in 0..2000 {
            let (s, c) = (f64::from(k) * 0.1).sin_cos();
            let r = 4.0 * f64::from(k) / 2000.0;
            let q = lobe.mean + r * (c * long + s * short);
            assert!(place(q).is_none_or(|u| bow.is_near(u, 0.0)), "{q}");
        }
        let lattice =
            (-100..=100).flat_map(|i| (-100..=100).map(move |j| DVec2::new(i.into(), j.into())));
        let disk: Vec<DVec2> = lattice.map(|p| p / 100.0).filter(|p| p.length() < 1.0).collect();
        let near = disk.iter().filter(|u| bow.is_near(**u, 0.0)).count() as f64;
        assert!(near / (disk.len() as f64) < 0.25, "{near} of {}", disk.len());
    }
}
