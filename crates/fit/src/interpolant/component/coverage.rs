//! What rests on measured points, what lies between them, and what is a guess beyond them.

use std::fmt;

use bsdfkit::{DVec3, Side};
use bsdfkit_sphere::DVec2;
use bsdfkit_sphere::concentric::square_to_hemisphere;

use crate::interpolant::component::component::Component;
use crate::interpolant::incidence::fitted::FittedIncidence;
use bsdfkit_measure::Seen;

/// How the value for a pair of directions was come by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Coverage {
    /// At a measured incidence (or its image), where its points are.
    Measured,
    /// Between measured incidences, where their points are.
    Interpolated,
    /// Past the outermost measured incidences, closer to the horizon than the instrument reaches, or where no points
    /// were: beside a plane, in the other half.
    Extrapolated,
}

/// An incidence closer than this is the measured one: 0.1 degrees, what an instrument repeats.
const SAME: f64 = 1.75e-3;

/// Incident directions by which shares are counted: right to about 0.1 %.
const COUNTED: u32 = 4096;

/// Share of all pairs of directions, weighted by |cos θᵢ cos θₒ|, that are extrapolated, and what
/// the rest rests on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Number of measured incidences.
    pub incidences: usize,
    /// Largest polar angle of a measured incidence, radians.
    pub incident: f64,
    /// Largest measured polar angle of scattered light, least and most over the incidences, radians.
    pub scattered: (f64, f64),
    /// Share of the incident hemisphere, by projected solid angle, outside the measured incidences.
    pub incidence_extrapolated: f64,
    /// Share of the pairs of directions that are [`Coverage::Extrapolated`].
    pub extrapolated: f64,
    /// Share of the projected hemisphere that lies between points, least over the incidences.
    pub seen: f64,
}

impl Component {
    /// How f(wi, wo) was come by.
    ///
    /// Gaps within the instrument's reach (the detector in front of the lamp) are filled by the lobes
    /// around them and count as interpolated or measured.
    pub fn coverage(&self, wi: DVec3, wo: DVec3) -> Coverage {
        if !self.is_measured(wi) || wo.truncate().length() > self.scattered_limit(wi) + SAME {
            return Coverage::Extrapolated;
        }
        let (folded, fold) = self.symmetry().fold(DVec3::new(wi.x, wi.y, wi.z.abs()));
        let mesh = self.mesh();
        let unseen = |v: &u32| {
            let vertex = &mesh.vertices[*v as usize];
            let own = vertex.image.inverse().apply(fold.apply(wo));
            !self.incidences()[vertex.incidence].seen.holds(own)
        };
        let corners = mesh.locate(folded).weights(&mesh.topology);
        let guessed = corners.iter().filter(|(v, _)| unseen(v)).map(|(_, weight)| weight);
        if guessed.sum::<f64>() > 0.5 {
            return Coverage::Extrapolated;
        }
        let same = self.mesh().vertices.iter().any(|v| v.wi.distance(folded) < SAME);
        if same { Coverage::Measured } else { Coverage::Interpolated }
    }

    /// The largest measured sin θₒ, interpolated between incidences.
    fn scattered_limit(&self, wi: DVec3) -> f64 {
        self.blended(wi, &|i| i.limit)
    }

    /// Whether the directional-hemispherical value at `wi` rests on points all over the hemisphere, at all incidences
    /// about it. Otherwise it is extrapolated.
    pub fn tells(&self, wi: DVec3) -> bool {
        let (folded, _) = self.symmetry().fold(DVec3::new(wi.x, wi.y, wi.z.abs()));
        let mesh = self.mesh();
        let corners = mesh.locate(folded).weights(&mesh.topology);
        let told = |v: u32| self.incidences()[mesh.vertices[v as usize].incidence].tells();
        self.is_measured(wi) && corners.iter().all(|&(v, weight)| weight < 1e-6 || told(v))
    }

    /// Share of the projected hemisphere of `wo` that was seen at the incidences about `wi`; 0 past the outermost.
    pub fn seen(&self, wi: DVec3) -> f64 {
        if self.is_measured(wi) { self.blended(wi, &FittedIncidence::seen_share) } else { 0.0 }
    }

    /// A figure of the incidences about `wi`, by their weights.
    fn blended(&self, wi: DVec3, figure: &dyn Fn(&FittedIncidence) -> f64) -> f64 {
        let (folded, _) = self.symmetry().fold(DVec3::new(wi.x, wi.y, wi.z.abs()));
        let mesh = self.mesh();
        let corners = mesh.locate(folded).weights(&mesh.topology);
        let of = |v: u32| figure(&self.incidences()[mesh.vertices[v as usize].incidence]);
        corners.iter().map(|&(v, weight)| weight * of(v)).sum()
    }

    /// How far the measurement reaches. Cost: some milliseconds.
    pub fn extent(&self) -> Extent {
        let polar = |sin: f64| sin.clamp(0.0, 1.0).asin();
        let limits = self.incidences().iter().map(|i| polar(i.limit));
        let all = f64::from(COUNTED);
        let shares: Vec<f64> = self.incidences().iter().map(FittedIncidence::seen_share).collect();
        let mesh = self.mesh();
        let (mut outside, mut extrapolated) = (0.0, 0.0);
        for wi in evenly(COUNTED) {
            if self.is_measured(wi) {
                let corners = mesh.locate(self.symmetry().fold(wi).0).weights(&mesh.topology);
                let of = |v: u32| shares[mesh.vertices[v as usize].incidence];
                extrapolated += 1.0 - corners.iter().map(|&(v, w)| w * of(v)).sum::<f64>();
            } else {
                (outside, extrapolated) = (outside + 1.0, extrapolated + 1.0);
            }
        }
        Extent {
            incidences: self.incidences().len(),
            incident: self
                .incidences()
                .iter()
                .map(|i| polar(i.wi.truncate().length()))
                .fold(0.0, f64::max),
            scattered: (limits.clone().fold(f64::MAX, f64::min), limits.fold(0.0, f64::max)),
            incidence_extrapolated: outside / all,
            extrapolated: extrapolated / all,
            seen: shares.into_iter().fold(1.0, f64::min),
        }
    }
}

/// Directions of the front hemisphere, each for the same projected solid angle: a lattice whose columns are a golden
/// ratio apart, no two directions on one ring.
fn evenly(count: u32) -> impl Iterator<Item = DVec3> {
    let place = move |k: u32| {
        let at = f64::from(k) + 0.5;
        let golden = (0.618_033_988_749_895 * at).fract();
        square_to_hemisphere(DVec2::new(at / f64::from(count), golden), Side::Front)
    };
    (0..count).map(place)
}

/// Limits that differ by less are told as one: half a degree.
const DIFFERENT: f64 = 0.0087;

impl fmt::Display for Extent {
    /// One sentence, angles in degrees.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "measured at {} incidences up to {:.1} degrees, scattered light up to {:.1}",
            self.incidences,
            self.incident.to_degrees(),
            self.scattered.0.to_degrees()
        )?;
        if self.scattered.1 - self.scattered.0 > DIFFERENT {
            write!(f, " to {:.1}", self.scattered.1.to_degrees())?;
        }
        if self.seen < Seen::ENOUGH {
            write!(f, ", of which at least {:.0} % of the hemisphere was seen", 100.0 * self.seen)?;
        }
        write!(
            f,
            "; {:.1} % of the pairs of directions are extrapolated, the others interpolated",
            100.0 * self.extrapolated
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interpolant::{Fitted, Frame, Motion};
    use crate::lobe::LobeSet;
    use crate::lobe::detail::Detail;
    use bsdfkit_measure::Symmetry;
    use bsdfkit_sphere::direction::from_degrees;

    /// Incidences out to 60 degrees all round, scattered light out to 80.
    fn component() -> Component {
        let detail = Detail::fit([DVec3::Z], &[1.0], &[1.0], 8);
        let incidence = |wi: DVec3| FittedIncidence {
            wi,
            lobes: LobeSet { floor: 0.1, lobes: Vec::new() },
            details: vec![detail.clone()],
            coefficients: Vec::new(),
            points: 1,
            hemispherical: 0.3,
            fit_error: 0.0,
            limit: 80.0_f64.to_radians().sin(),
            seen: Seen::whole(),
        };
        let mut incidences = vec![incidence(DVec3::Z)];
        for theta in [30.0, 60.0] {
            for k in 0..24 {
                incidences.push(incidence(from_degrees(theta, 15.0 * f64::from(k))));
            }
        }
        let motion = Motion::straight(Frame::Fixed);
        let (incident, scattered) = (Side::Front, Side::Front);
        let symmetry = Symmetry::None;
        let fitted =
            Fitted { incident, scattered, symmetry, epsilon: 1e-3, spectra: None, incidences };
        Component::new(fitted, motion).expect("component")
    }

    #[test]
    fn what_lies_past_the_rim_or_the_instrument_is_extrapolated() {
        let c = component();
        let of = |ti, pi, to| c.coverage(from_degrees(ti, pi), from_degrees(to, 77.0));
        assert_eq!(of(30.0, 45.0, 40.0), Coverage::Measured);
        assert_eq!(of(33.0, 45.0, 79.9), Coverage::Interpolated);
        assert_eq!(of(33.0, 45.0, 81.0), Coverage::Extrapolated);
        assert_eq!(of(30.0, 45.0, 81.0), Coverage::Extrapolated);
        assert_eq!(of(61.0, 45.0, 40.0), Coverage::Extrapolated);
    }

    #[test]
    fn shares_are_those_of_the_disks() {
        let extent = component().extent();
        // The mesh is a polygon of 24 sides in the disk of radius sin 60°.
        let polygon = 12.0 * (std::f64::consts::TAU / 24.0).sin() * 0.75 / std::f64::consts::PI;
        let reached = polygon * 80.0_f64.to_radians().sin().powi(2);
        assert!((1.0 - extent.incidence_extrapolated - polygon).abs() < 2e-3, "{extent:?}");
        assert!((1.0 - extent.extrapolated - reached).abs() < 2e-3, "{extent:?}");
        let text = extent.to_string();
        let start = "measured at 49 incidences up to 60.0 degrees, scattered light up to 80.0; ";
        assert!(text.starts_with(start), "{text}");
    }
}
