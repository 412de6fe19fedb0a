//! What families scatter at an incident direction: each corner's share, where the law has it.

use bsdfkit::DVec2;

use crate::lobe::{Covariance, Lobe};
use bsdfkit_measure::frame::FrameAt;

/// A law at an incident direction and at the corners of its cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Law<'a> {
    pub(crate) here: FrameAt,
    pub(crate) there: [&'a FrameAt; 3],
    /// 1 over the weight of the corners that could see the family.
    pub(crate) per_seen: f64,
}

impl<'a> Law<'a> {
    /// `lobes` of the family at each corner; `lambda`: the corners' weights.
    ///
    /// A corner that has none of them because it would have them below its horizon has no say.
    pub(crate) fn new(
        here: FrameAt,
        there: [&'a FrameAt; 3],
        lobes: [&[Standing]; 3],
        lambda: [f64; 3],
    ) -> Self {
        let own = || {
            let corners = (0..3).filter(|&c| lambda[c] > 0.0);
            corners
                .flat_map(|c| lobes[c].iter().map(move |l| (c, lambda[c] * l.lobe.mass, l.place)))
        };
        let seen = |c: usize| {
            if !lobes[c].is_empty() || lambda[c] <= 0.0 {
                return lambda[c];
            }
            let (mut whole, mut above) = (0.0, 0.0);
            for (from, mass, place) in own() {
                whole += mass;
                if there[c].inverse(there[from].forward(place)).1 > 0.0 {
                    above += mass;
                }
            }
            if whole > 0.0 { lambda[c] * above / whole } else { lambda[c] }
        };
        let seen: f64 = (0..3).map(seen).sum();
        Self { here, there, per_seen: 1.0 / seen.max(1e-3) }
    }

    /// Where at a corner what is at `u` comes from, and what f changes by on the way; `None`: from below its horizon.
    #[inline(always)]
    pub(crate) fn from(&self, corner: usize, u: DVec2) -> Option<(DVec2, f64)> {
        let there = self.there[corner];
        let (v, z) = there.inverse(self.here.forward(u));
        (z > 0.0).then(|| (v, there.density(v) / self.here.density(u)))
    }

    /// Where what is at `v` of a corner goes; `None`: below the horizon.
    pub(crate) fn to(&self, corner: usize, v: DVec2) -> Option<DVec2> {
        let (u, z) = self.here.inverse(self.there[corner].forward(v));
        (z > 0.0).then_some(u)
    }
}

/// A lobe of a family at its corner.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Standing {
    pub(crate) lobe: Lobe,
    /// Where it is on the disk.
    place: DVec2,
    /// Inverse covariance.
    precision: Covariance,
    /// Peak value.
    peak: f64,
}

/// Beyond this exponent, exp(−40) of the peak, there is nothing.
const FAR: f64 = 80.0;

impl Standing {
    /// `lobe` in coordinates of `frame`.
    pub(crate) fn new(lobe: Lobe, frame: &FrameAt) -> Self {
        let peak = lobe.mass / (std::f64::consts::TAU * lobe.covariance.determinant().sqrt());
        let place = frame.inverse(lobe.mean).0;
        Self { lobe, place, precision: lobe.covariance.inverse(), peak }
    }
}

/// f of lobes with these `frame` coordinates, at `v`.
#[inline(always)]
pub(crate) fn value(lobes: &[Standing], frame: &FrameAt, v: DVec2) -> f64 {
    let q = frame.forward(v);
    let mut sum = 0.0;
    for lobe in lobes {
        let e = lobe.precision.quadratic(q - lobe.lobe.mean);
        if e < FAR {
            sum += lobe.peak * (-0.5 * e).exp();
        }
    }
    if sum > 0.0 { sum / frame.density(v) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bsdfkit::DVec3;
    use bsdfkit_measure::frame::Frame;
    use bsdfkit_sphere::direction::from_degrees;

    fn lobe(u: DVec2) -> Lobe {
        Lobe { mass: 0.2, mean: u, covariance: Covariance::isotropic(1e-3) }
    }

    fn standing(u: DVec2, wi: DVec3) -> Standing {
        Standing::new(lobe(u), &Frame::Fixed.at(wi))
    }

    #[test]
    fn a_peak_is_where_its_law_has_it_and_keeps_its_energy() {
        let wi = [20.0, 50.0, 60.0].map(|t| from_degrees(t, 30.0));
        let here = from_degrees(40.0, 10.0);
        let lobes = wi.map(|w| vec![standing(-w.truncate(), w)]);
        let of = [&lobes[0][..], &lobes[1][..], &lobes[2][..]];
        let there = wi.map(|w| Frame::Shift.at(w));
        let law =
            Law::new(Frame::Shift.at(here), [&there[0], &there[1], &there[2]], of, [0.2, 0.3, 0.5]);
        assert!((law.per_seen - 1.0).abs() < 1e-12);
        for corner in 0..3 {
            let to = law.to(corner, -wi[corner].truncate()).expect("above");
            assert!((to + here.truncate()).length() < 1e-12);
            let (from, brighter) = law.from(corner, to).expect("above");
            assert!((from + wi[corner].truncate()).length() < 1e-12 && brighter == 1.0);
        }
    }

    /// ∫ f du over the disk is the lobe's mass there as here, though the disk shows the peak foreshortened.
    #[test]
    fn on_the_way_a_peak_loses_no_light() {
        let (there, here) = (from_degrees(20.0, 0.0), from_degrees(60.0, 0.0));
        let lobes = [standing(-there.truncate(), there)];
        let frame = Frame::Fixed.at(there);
        let turned = Frame::Turned.at(there);
        let of = [&lobes[..], &[], &[]];
        let law = Law::new(Frame::Turned.at(here), [&turned; 3], of, [1.0, 0.0, 0.0]);
        let (step, mut light) = (1.0 / 400.0, 0.0);
        for k in 0..800 * 800 {
            let u = DVec2::new(f64::from(k % 800) + 0.5, f64::from(k / 800) + 0.5) * step - 1.0;
            if u.length_squared() < 1.0
                && let Some((v, brighter)) = law.from(0, u)
            {
                light += brighter * value(&lobes, &frame, v) * step * step;
            }
        }
        assert!((light / 0.2 - 1.0).abs() < 0.01, "{light}");
    }

    #[test]
    fn a_corner_that_would_have_it_below_the_horizon_has_no_say() {
        let wi = [30.0, 45.0, 60.0].map(|t| from_degrees(t, 0.0));
        // A diffracted peak, at u = −p − 0.4: below the horizon from 45 degrees on.
        let order = DVec2::new(-0.4, 0.0);
        let first = [standing(order - wi[0].truncate(), wi[0])];
        let there = wi.map(|w| Frame::Shift.at(w));
        let law = |lobes: [&[Standing]; 3]| {
            Law::new(
                Frame::Shift.at(wi[0]),
                [&there[0], &there[1], &there[2]],
                lobes,
                [0.5, 0.25, 0.25],
            )
            .per_seen
        };
        assert!((law([&first, &[], &[]]) - 2.0).abs() < 1e-12);
        // Where it would be seen and is not, it has faded.
        let near = [standing(DVec2::new(0.1, 0.0) - wi[0].truncate(), wi[0])];
        assert!((law([&near, &[], &[]]) - 1.0).abs() < 1e-12);
    }
}
