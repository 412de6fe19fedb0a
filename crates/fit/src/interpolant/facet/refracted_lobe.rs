//! What becomes of the lobes of a peak that is carried elsewhere.

use bsdfkit::{DVec2, DVec3};

use crate::lobe::{Covariance, Lobe};
use bsdfkit_measure::frame::{Frame, FrameAt};

/// What a peak keeps on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Its extent in frame coordinates.
    Frame,
    /// Its extent in angle, which the disk of directions shows foreshortened.
    Angle,
}

/// The way of a peak from one place to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Carried {
    pub(crate) from: Place,
    pub(crate) to: Place,
}

/// Where a peak is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// In frame coordinates.
    centre: DVec2,
    /// What directions about it are foreshortened by.
    foreshortening: Covariance,
}

/// Cosine below which nothing gets any shorter: 3 degrees above the horizon.
const FLAT: f64 = 0.05;

impl Shape {
    /// What peaks keep that are at these places of the disk with these extents: that which differs
    /// less between them. Other frames than those that shift the disk do not foreshorten.
    pub(crate) fn kept(peaks: &[(DVec2, Covariance)], frame: Frame) -> Self {
        let spread = |extents: Vec<f64>| {
            let mean = extents.iter().sum::<f64>() / extents.len().max(1) as f64;
            extents.iter().map(|e| (e - mean).powi(2)).sum::<f64>()
        };
        let extent = |shape: Self| {
            let area = |&(u, c): &(DVec2, Covariance)| {
                c.determinant().ln() - 2.0 * shape.foreshortening(u).determinant().ln()
            };
            spread(peaks.iter().map(area).collect())
        };
        let shifts = matches!(frame, Frame::Shift | Frame::Fixed);
        if shifts && extent(Self::Angle) < extent(Self::Frame) { Self::Angle } else { Self::Frame }
    }

    fn foreshortening(self, u: DVec2) -> Covariance {
        let shorter = match self {
            Self::Frame => 0.0,
            Self::Angle => 1.0 - (1.0 - u.length_squared()).max(FLAT * FLAT).sqrt(),
        };
        let e = u.normalize_or_zero();
        Covariance {
            xx: 1.0 - shorter * e.x * e.x,
            xy: -shorter * e.x * e.y,
            yy: 1.0 - shorter * e.y * e.y,
        }
    }

    /// The place at `u` of the disk.
    pub(crate) fn at(self, u: DVec2, frame: &FrameAt) -> Place {
        Place { centre: frame.forward(u), foreshortening: self.foreshortening(u) }
    }
}

impl Carried {
    /// The lobe, with the mass it had, as it is there.
    pub(crate) fn lobe(&self, lobe: Lobe) -> Lobe {
        let (open, close) = (self.from.foreshortening.inverse(), self.to.foreshortening);
        let off = close.apply(open.apply(lobe.mean - self.from.centre));
        let covariance = lobe.covariance.congruence(open).congruence(close);
        Lobe { mass: lobe.mass, mean: self.to.centre + off, covariance }
    }
}

/// Mass times mean direction of a lobe, from four points that have its first two moments: the disk
/// shows what is inclined foreshortened, so its mean there is nearer the normal.
pub(crate) fn direction(lobe: &Lobe, at: &FrameAt) -> DVec3 {
    let root = lobe.covariance.sqrt();
    let axes = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y];
    let points = axes.map(|a| at.inverse(lobe.mean + std::f64::consts::SQRT_2 * root.apply(a)));
    points.iter().map(|(u, z)| 0.25 * lobe.mass * u.extend(*z)).sum()
}

/// About the share of a lobe that is above the horizon.
pub(crate) fn visible(lobe: &Lobe, at: &FrameAt) -> f64 {
    let (u, z) = at.inverse(lobe.mean);
    let outward = u.try_normalize().unwrap_or(DVec2::X);
    let deviation = lobe.covariance.sqrt().apply(outward).length().max(1e-9);
    let inside = (1.0 - u.length()).abs().copysign(z) / deviation;
    // The normal distribution within 1 %; of a wide lobe what the disk can hold.
    let share = 1.0 / (1.0 + (-1.702 * inside).exp());
    share.min(0.5 / lobe.covariance.determinant().max(1e-300).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit::DVec3;
    use bsdfkit_sphere::direction::from_degrees;

    /// A lobe in the disk that is 0.05 wide in angle about a direction.
    fn round(u: DVec2) -> Covariance {
        Covariance::isotropic(0.0025).congruence(Shape::Angle.foreshortening(u))
    }

    #[test]
    fn what_is_round_in_angle_stays_so_and_what_keeps_its_extent_keeps_it() {
        let frame = Frame::Shift.at(from_degrees(20.0, 30.0));
        let (here, there) = (DVec2::new(0.3, 0.1), DVec2::new(-0.2, 0.85));
        let of = |shape: Shape| {
            let places = [here, there].map(|u| shape.at(u, &frame));
            let carried = Carried { from: places[0], to: places[1] };
            let mean = frame.forward(here);
            carried.lobe(Lobe { mass: 0.3, mean, covariance: round(here) })
        };
        let close = |a: Covariance, b: Covariance| {
            (a.xx - b.xx).abs() + (a.xy - b.xy).abs() + (a.yy - b.yy).abs() < 1e-12
        };
        for shape in [Shape::Frame, Shape::Angle] {
            let lobe = of(shape);
            assert!(lobe.mean.distance(frame.forward(there)) < 1e-12 && lobe.mass == 0.3);
            let wanted = if shape == Shape::Angle { there } else { here };
            assert!(close(lobe.covariance, round(wanted)), "{shape:?}");
        }
    }

    #[test]
    fn peaks_themselves_tell_what_they_keep() {
        let places: Vec<DVec2> = (0..9).map(|k| DVec2::new(0.1 * f64::from(k), 0.2)).collect();
        let angle: Vec<_> = places.iter().map(|&u| (u, round(u))).collect();
        let still: Vec<_> = places.iter().map(|&u| (u, round(places[0]))).collect();
        assert_eq!(Shape::kept(&angle, Frame::Shift), Shape::Angle);
        assert_eq!(Shape::kept(&still, Frame::Shift), Shape::Frame);
        assert_eq!(Shape::kept(&angle, Frame::Turned), Shape::Frame);
    }

    #[test]
    fn the_mean_direction_is_not_drawn_toward_the_normal() {
        let at = Frame::Fixed.at(DVec3::Z);
        let wo = from_degrees(60.0, 0.0);
        // The mean of the disk's x over angles 0.1 about it: sin θ exp(−0.1²) or so.
        let mean = wo.truncate() * (-0.01f64).exp();
        let covariance = Covariance { xx: 0.01 * wo.z * wo.z, xy: 0.0, yy: 0.01 };
        let found = direction(&Lobe { mass: 2.0, mean, covariance }, &at);
        let off = |u: DVec2| (u - wo.truncate()).length();
        assert!(off(found.normalize().truncate()) < 0.2 * off(mean), "{found}");
    }

    #[test]
    fn half_of_a_lobe_on_the_horizon_is_visible() {
        let at = Frame::Shift.at(DVec3::Z);
        let lobe = |x: f64, s: f64| Lobe {
            mass: 1.0,
            mean: DVec2::new(x, 0.0),
            covariance: Covariance::isotropic(s * s),
        };
        for (x, s, share) in
            [(1.0, 0.05, 0.5), (0.8, 0.05, 1.0), (1.1, 0.05, 0.023), (0.0, 3.0, 1.0 / 18.0)]
        {
            let found = visible(&lobe(x, s), &at);
            assert!((found - share).abs() < 0.012, "{x} {s}: {found}");
        }
    }
}
