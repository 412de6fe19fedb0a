//! What one plane lets expect beside it: every peak as wide across the plane as along it.
//!
//! That is the least to assume, and no more than a guess: a specimen may scatter anything beside the plane. Which
//! coordinates peaks are round in matters (toward grazing, a circle in direction cosines is narrower across
//! than one on the sphere): a [`Frame`] says, and several of them say how far the guess reaches.

use std::borrow::Cow;
use std::f64::consts::TAU;

use bsdfkit::{DVec2, DVec3, Side};
use bsdfkit_sphere::concentric::square_to_disk;

use super::pattern::plane_normal;
use super::seen::limit;
use super::{Incidence, MERGE_DEGREES};
use crate::frame::{Frame, FrameAt};

/// Peaks told apart on a line; what is lower than this share of the highest is left to the plane.
const MOST_PEAKS: usize = 12;
const LEAST: f64 = 0.005;

/// Peaks around which directions lie in rings: those of this share of the highest.
const RINGED: f64 = 0.05;

/// Rings about a peak, and directions on one.
const MOST_RINGS: usize = 160;
const ON_RING: (f64, f64) = (12.0, 72.0);

/// Cells across the square of what lies between the rings.
const GROUND: usize = 40;

/// A peak of one line, round in the frame: what it has at so far from its centre, falling.
struct Round {
    centre: DVec2,
    radii: Vec<f64>,
    values: Vec<f64>,
}

/// One channel: what all directions have, and the peaks on it.
struct Profile {
    floor: f64,
    peaks: Vec<Round>,
}

/// What is round in a frame, over f: of facets how often their slopes occur, elsewhere f itself.
fn round(frame: Frame, at: &FrameAt, u: DVec2) -> f64 {
    match frame {
        Frame::Half | Frame::Refracted { .. } => at.density(u).max(1e-9),
        Frame::Fixed | Frame::Shift | Frame::Turned | Frame::Back | Frame::Profile { .. } => 1.0,
    }
}

/// The points of a plane as a function of all directions.
pub(super) struct Extension {
    frame: Frame,
    at: FrameAt,
    side: Side,
    /// sin θ of the last polar angle seen.
    limit: f64,
    channels: Vec<Profile>,
}

impl Extension {
    /// That of `incidence`, peaks round in `frame`; `None` where its points are on no plane.
    pub(super) fn of(incidence: &Incidence, frame: Frame) -> Option<Self> {
        let normal = plane_normal(incidence)?;
        let wi = incidence.wi;
        let at = frame.at(wi.with_z(wi.z.abs()));
        let line = Line::of(incidence, normal);
        let place = |w: &DVec3| at.forward(w.truncate());
        let q: Vec<DVec2> = line.directions.iter().map(place).collect();
        let rounded = |values: &Vec<f64>| {
            let of = |(w, v): (&DVec3, &f64)| v * round(frame, &at, w.truncate());
            let values: Vec<f64> = line.directions.iter().zip(values).map(of).collect();
            Profile::of(&q, &values)
        };
        let channels = line.values.iter().map(rounded).collect();
        let (side, limit) = (Side::of(incidence.wo.at(0)), limit(&incidence.wo));
        Some(Self { frame, at, side, limit, channels })
    }

    /// f of channel `channel` at disk coordinates `u`.
    pub(super) fn value(&self, channel: usize, u: DVec2) -> f64 {
        self.channels[channel].at(self.at.forward(u)) / round(self.frame, &self.at, u)
    }

    /// Directions all over what the plane reaches, in rings round the peaks of channel `luminance`.
    fn directions(&self, luminance: usize) -> Vec<DVec3> {
        let mut all: Vec<DVec2> = (0..GROUND * GROUND)
            .map(|k| DVec2::new((k / GROUND) as f64 + 0.5, (k % GROUND) as f64 + 0.5))
            .map(|cell| square_to_disk(cell / GROUND as f64))
            .collect();
        let peaks = &self.channels[luminance].peaks;
        let highest = peaks.first().map_or(0.0, Round::height);
        for peak in peaks.iter().filter(|p| p.height() >= RINGED * highest) {
            let every = peak.radii.len().div_ceil(MOST_RINGS).max(1);
            let rings: Vec<f64> = peak.radii.iter().step_by(every).copied().collect();
            for ring in rings.windows(2) {
                let round = TAU * ring[1] / (ring[1] - ring[0]).max(1e-9);
                let count = round.clamp(ON_RING.0, ON_RING.1) as usize;
                let at = |n: usize| DVec2::from_angle(TAU * (n as f64 + 0.5) / count as f64);
                let places = (0..count).map(|n| self.at.inverse(peak.centre + ring[1] * at(n)));
                all.extend(places.filter(|(_, z)| *z > 0.0).map(|(u, _)| u));
            }
        }
        let up = |u: DVec2| u.extend(self.side.sign() * (1.0 - u.length_squared()).max(0.0).sqrt());
        all.into_iter().filter(|u| u.length() <= self.limit).map(up).collect()
    }
}

impl Incidence {
    /// The incidence with points beside the plane that its own are on, as peaks round in `frame` would have them; the
    /// same where its points are on no plane. Its own come first.
    pub fn extended(&self, luminance: usize, frame: Frame) -> Cow<'_, Incidence> {
        let Some(extension) = Extension::of(self, frame) else { return Cow::Borrowed(self) };
        let mut all = self.clone();
        for w in extension.directions(luminance) {
            let value = |c: usize| extension.value(c, w.truncate());
            all.values.extend((0..extension.channels.len()).map(|c| value(c) as f32));
            all.wo.push(w);
        }
        Cow::Owned(all)
    }
}

/// Points along a plane.
struct Line {
    directions: Vec<DVec3>,
    /// One list a channel.
    values: Vec<Vec<f64>>,
}

impl Line {
    /// In order along the plane across `normal`; those in one direction are one.
    fn of(incidence: &Incidence, normal: DVec3) -> Self {
        let up = DVec3::Z * Side::of(incidence.wo.at(0)).sign();
        let middle = (up - normal * normal.dot(up)).normalize_or(up.any_orthonormal_vector());
        let ahead = normal.cross(middle);
        let angle = |w: DVec3| w.dot(ahead).atan2(w.dot(middle));
        let mut order: Vec<(f64, usize)> =
            incidence.wo.iter().enumerate().map(|(k, w)| (angle(w), k)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let channels = incidence.channels();
        let mut line = Self { directions: Vec::new(), values: vec![Vec::new(); channels] };
        for same in order.chunk_by(|a, b| b.0 - a.0 < 0.1 * MERGE_DEGREES.to_radians()) {
            line.directions.push(incidence.wo.at(same[0].1));
            for (c, values) in line.values.iter_mut().enumerate() {
                let sum = same.iter().map(|&(_, k)| incidence.value(k, c)).sum::<f64>();
                values.push(sum / same.len() as f64);
            }
        }
        line
    }
}

impl Profile {
    /// Takes peak after peak off the line, the highest first: of each what both its sides have.
    fn of(q: &[DVec2], values: &[f64]) -> Self {
        let floor = values.iter().copied().fold(f64::MAX, f64::min).max(0.0);
        let mut rest: Vec<f64> = values.iter().map(|v| (v - floor).max(0.0)).collect();
        let least = LEAST * rest.iter().copied().fold(0.0, f64::max);
        let mut peaks = Vec::new();
        while peaks.len() < MOST_PEAKS {
            let highest = (0..rest.len()).max_by(|&a, &b| rest[a].total_cmp(&rest[b]));
            let Some(top) = highest.filter(|&k| rest[k] > least) else { break };
            let peak = Round::about(top, q, &rest);
            for (rest, &q) in rest.iter_mut().zip(q) {
                *rest = (*rest - peak.at(q)).max(0.0);
            }
            peaks.push(peak);
        }
        Self { floor, peaks }
    }

    fn at(&self, q: DVec2) -> f64 {
        self.floor + self.peaks.iter().map(|p| p.at(q)).sum::<f64>()
    }
}

impl Round {
    /// The peak about point `top` of the line.
    fn about(top: usize, q: &[DVec2], values: &[f64]) -> Self {
        let (centre, height) = vertex(top, q, values);
        // Outward on either side of the centre: distances and values, the former rising, the latter falling.
        let side = |indices: &mut dyn Iterator<Item = usize>| {
            let mut side = vec![(0.0, height)];
            for k in indices {
                let (radius, value) = side[side.len() - 1];
                side.push((f64::max(radius, q[k].distance(centre)), f64::min(value, values[k])));
            }
            side
        };
        let after =
            (centre - q[top]).dot(q[(top + 1).min(q.len() - 1)] - q[top.saturating_sub(1)]) > 0.0;
        let first = top + usize::from(after);
        let (left, right) = (side(&mut (0..first).rev()), side(&mut (first..q.len())));
        let reach = |side: &[(f64, f64)]| side[side.len() - 1].0;
        let mut radii: Vec<f64> = left.iter().chain(&right).map(|p| p.0).collect();
        radii.sort_by(f64::total_cmp);
        radii.dedup_by(|a, b| *a - *b < 1e-9);
        let mut lowest = height;
        let value = |&r: &f64| {
            for side in [&left, &right] {
                if r <= reach(side) {
                    lowest = lowest.min(interpolated(side, r));
                }
            }
            lowest
        };
        let values = radii.iter().map(value).collect();
        Self { centre, radii, values }
    }

    fn height(&self) -> f64 {
        self.values[0]
    }

    fn at(&self, q: DVec2) -> f64 {
        let r = q.distance(self.centre);
        let next = self.radii.partition_point(|&radius| radius <= r);
        if next == self.radii.len() {
            return self.values[next - 1];
        }
        let (r0, r1) = (self.radii[next - 1], self.radii[next]);
        let t = (r - r0) / (r1 - r0);
        self.values[next - 1] * (1.0 - t) + self.values[next] * t
    }
}

/// Between places in order, linear.
fn interpolated(side: &[(f64, f64)], r: f64) -> f64 {
    let next = side.partition_point(|p| p.0 <= r).min(side.len() - 1);
    let ((r0, v0), (r1, v1)) = (side[next.saturating_sub(1)], side[next]);
    let t = if r1 > r0 { ((r - r0) / (r1 - r0)).clamp(0.0, 1.0) } else { 1.0 };
    v0 * (1.0 - t) + v1 * t
}

/// Where the parabola through the logarithms of a highest point and its neighbours is highest, and its height.
fn vertex(top: usize, q: &[DVec2], values: &[f64]) -> (DVec2, f64) {
    let plain = (q[top], values[top]);
    if top == 0 || top + 1 == q.len() || values[top - 1] <= 0.0 || values[top + 1] <= 0.0 {
        return plain;
    }
    let [a, b, c] = [top - 1, top, top + 1].map(|k| values[k].ln());
    let (before, after) = (q[top].distance(q[top - 1]), q[top + 1].distance(q[top]));
    // Slopes on either side meet in the vertex.
    let (rise, fall) = ((b - a) / before, (c - b) / after);
    let curvature = 2.0 * (fall - rise) / (before + after);
    let slope = (rise * after + fall * before) / (before + after);
    if !(curvature < 0.0 && slope.is_finite()) {
        return plain;
    }
    let aside = (-slope / curvature).clamp(-0.5 * before, 0.5 * after);
    let toward =
        if aside < 0.0 { (q[top] - q[top - 1]) / before } else { (q[top + 1] - q[top]) / after };
    (q[top] + aside * toward, (b + slope * aside + 0.5 * curvature * aside * aside).exp())
}
