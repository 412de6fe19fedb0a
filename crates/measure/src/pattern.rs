//! Where the points of an incidence lie, in words: a plane, a ring, a cone, some azimuths, or all over.

use std::fmt;

use bsdfkit::DVec3;
use bsdfkit_sphere::direction::to_degrees;

use super::seen::{Seen, limit, specular};
use super::{Directions, Incidence, MERGE_DEGREES};

/// Fewer directions fit no lobe: a floor, and of one lobe mass, centre and shape.
pub const FEWEST: usize = 7;

/// Points nearer than this to a plane or a ring lie on it: what a stage wobbles, and a detector's width.
const ON_DEGREES: f64 = 2.0;

/// A line is so many times as long as it is wide.
const LONG: f64 = 4.0;

/// Wider ones are no cones.
const WIDEST_CONE_DEGREES: f64 = 60.0;

/// A cone is seen but for less than this share of it.
const CONE_MISSED: f64 = 0.35;

/// A cone about the specular direction may be so many times as wide as the narrowest.
const NEARLY: f64 = 1.15;

/// The least azimuth without points that is told.
const GAP_DEGREES: f64 = 60.0;

/// The arrangement of one incidence's points, as they were measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pattern {
    /// All in one direction.
    Direction {
        /// That direction.
        at: DVec3,
    },
    /// So many directions, fewer than [`FEWEST`].
    Few {
        /// How many.
        directions: usize,
    },
    /// On one great circle.
    Plane {
        /// Its unit normal.
        normal: DVec3,
        /// Azimuth of the plane, 0–180, of half a plane 0–360; where it is tilted, of the side that it leans to.
        azimuth_degrees: f64,
        /// Between the plane and the specimen's normal.
        tilt_degrees: f64,
        /// Whether points lie on both sides of the specimen's normal.
        both_sides: bool,
        /// Whether it holds the incident direction.
        incident: bool,
    },
    /// On one circle around a direction.
    Ring {
        /// Its middle, on the side of the points.
        middle: DVec3,
        /// Angle from there.
        radius_degrees: f64,
    },
    /// Within one angle of a direction.
    Cone {
        /// Its middle.
        middle: DVec3,
        /// Angle from there.
        radius_degrees: f64,
        /// Whether the middle is where a mirror or a clear pane would send the light.
        specular: bool,
    },
    /// Azimuths about the normal from one to another, counter-clockwise.
    Sector {
        /// First azimuth, 0–360.
        from_degrees: f64,
        /// Last azimuth, at most 360 further.
        to_degrees: f64,
    },
    /// In parts of the hemisphere.
    Parts,
    /// All over the hemisphere.
    Whole,
}

impl Pattern {
    /// That of `incidence`, of which its points show `seen`.
    pub(super) fn of(incidence: &Incidence, seen: &Seen) -> Self {
        let points = &incidence.wo;
        match distinct(points) {
            1 => return Self::Direction { at: points.at(0) },
            few if few < FEWEST => return Self::Few { directions: few },
            _ => {}
        }
        let line = plane(points, incidence.wi).or_else(|| ring(points));
        if let Some(line) = line.or_else(|| of_mirrored(incidence)) {
            return line;
        }
        let limit = limit(points);
        if seen.share(limit) >= Seen::ENOUGH {
            return Self::Whole;
        }
        cone(incidence, seen, limit).or_else(|| sector(points)).unwrap_or(Self::Parts)
    }

    /// Which kind it is, whatever its figures: incidences of one kind are told together.
    pub(super) fn kind(&self) -> std::mem::Discriminant<Self> {
        std::mem::discriminant(self)
    }
}

/// The unit normal of the plane that the points are on, if they are on one.
pub(super) fn plane_normal(incidence: &Incidence) -> Option<DVec3> {
    if distinct(&incidence.wo) < FEWEST {
        return None;
    }
    match plane(&incidence.wo, incidence.wi)? {
        Pattern::Plane { normal, .. } => Some(normal),
        _ => None,
    }
}

/// How many directions there are, counted to [`FEWEST`].
pub(super) fn distinct(points: &Directions) -> usize {
    let near = MERGE_DEGREES.to_radians();
    let mut found: Vec<DVec3> = Vec::new();
    for w in points.iter() {
        if found.len() < FEWEST && found.iter().all(|f| f.distance(w) > near) {
            found.push(w);
        }
    }
    found.len()
}

/// Orthogonal axes along which `points` extend most, less and least from `middle`.
fn axes(points: &Directions, middle: DVec3) -> [DVec3; 3] {
    let mut matrix = [[0.0; 3]; 3];
    for w in points.iter() {
        let d = (w - middle).to_array();
        for (row, a) in matrix.iter_mut().zip(d) {
            for (cell, b) in row.iter_mut().zip(d) {
                *cell += a * b;
            }
        }
    }
    let apply = |v: DVec3| DVec3::from_array(matrix.map(|row| DVec3::from_array(row).dot(v)));
    // Power iteration; ties make any of the tied axes as good.
    let longest = |without: Option<DVec3>| {
        let within = |v: DVec3| without.map_or(v, |w| v - w * w.dot(v));
        let start = [DVec3::X, DVec3::Y, DVec3::Z].map(|v| within(apply(within(v))));
        let start = start.into_iter().max_by(|a, b| a.length().total_cmp(&b.length()));
        (0..200).fold(start.unwrap_or(DVec3::X), |v, _| within(apply(v)).normalize_or(v))
    };
    let first = longest(None).normalize_or(DVec3::X);
    let second = longest(Some(first)).normalize_or(first.any_orthonormal_vector());
    [first, second, first.cross(second)]
}

/// The line of points that were mirrored where they lay on one side of the plane of incidence.
fn of_mirrored(incidence: &Incidence) -> Option<Pattern> {
    let wi = incidence.wi;
    let across = wi.truncate().perp().normalize_or(bsdfkit::DVec2::Y).extend(0.0);
    // What single precision leaves of a plane.
    let own: Directions = incidence.wo.iter().filter(|w| w.dot(across) > -1e-6).collect();
    let on = own.iter().filter(|w| w.dot(across).abs() < MERGE_DEGREES.to_radians()).count();
    let mirrored = 2 * own.len() - on == incidence.wo.len() && distinct(&own) == FEWEST;
    mirrored.then(|| plane(&own, wi).or_else(|| ring(&own))).flatten()
}

fn plane(points: &Directions, wi: DVec3) -> Option<Pattern> {
    let [.., normal] = axes(points, DVec3::ZERO);
    let off = |w: DVec3| w.dot(normal).abs().asin().to_degrees();
    let width = points.iter().map(off).fold(0.0, f64::max);
    let sum = points.iter().sum::<DVec3>();
    let middle = (sum - normal * normal.dot(sum)).normalize_or_zero();
    let ahead = normal.cross(middle);
    let angles = points.iter().map(|w| w.dot(ahead).atan2(w.dot(middle)).to_degrees());
    let (least, most) =
        angles.fold((f64::MAX, f64::MIN), |(a, b), angle| (a.min(angle), b.max(angle)));
    if width > ON_DEGREES || most - least < 2.0 * LONG * width {
        return None;
    }
    let tilt = normal.z.abs().asin().to_degrees();
    let upright = tilt < ON_DEGREES;
    // An upright plane has a line on the ground, a tilted one leans to one side of it.
    let ground = normal.truncate().perp().normalize_or(bsdfkit::DVec2::X);
    let beyond = ON_DEGREES.to_radians().sin();
    let beside = |sign: f64| points.iter().any(|w| sign * w.truncate().dot(ground) > beyond);
    let both_sides = beside(1.0) && beside(-1.0);
    let toward = match (upright, both_sides) {
        (true, true) => ground,
        (true, false) => middle.truncate(),
        (false, _) => -normal.truncate() * (normal.z * points.at(0).z).signum(),
    };
    let azimuth = toward.y.atan2(toward.x).to_degrees();
    let turn = if upright && both_sides { 180.0 } else { 360.0 };
    // A hair below a whole turn is none.
    let azimuth_degrees = ((azimuth + 0.01).rem_euclid(turn) - 0.01).max(0.0);
    let incident = wi.dot(normal).abs() < beyond;
    let tilt_degrees = if upright { 0.0 } else { tilt };
    Some(Pattern::Plane { normal, azimuth_degrees, tilt_degrees, both_sides, incident })
}

fn ring(points: &Directions) -> Option<Pattern> {
    let mean = points.iter().sum::<DVec3>() / points.len() as f64;
    let [.., normal] = axes(points, mean);
    let middle = normal * normal.dot(mean).signum();
    let radii = || points.iter().map(|w| w.angle_between(middle).to_degrees());
    let (least, most) = radii().fold((f64::MAX, f64::MIN), |(a, b), r| (a.min(r), b.max(r)));
    let radius_degrees = 0.5 * (least + most);
    let thin = most - least <= ON_DEGREES.min(radius_degrees / LONG);
    (thin && radius_degrees < 90.0 - ON_DEGREES).then_some(Pattern::Ring { middle, radius_degrees })
}

fn cone(incidence: &Incidence, seen: &Seen, limit: f64) -> Option<Pattern> {
    let side = bsdfkit::Side::of(incidence.wo.at(0));
    let mirror = specular(incidence);
    // Cells are alike when projected; here solid angles count.
    let middles = seen.middles(limit, side);
    let mean = middles.iter().map(|w| *w / w.z.abs().max(0.1)).sum::<DVec3>();
    let reach =
        |middle: DVec3| incidence.wo.iter().map(|w| w.angle_between(middle)).fold(0.0, f64::max);
    let mean = mean.normalize_or(mirror);
    let (own, is_specular) = (reach(mean), reach(mirror) < NEARLY * reach(mean));
    let (middle, reach) = if is_specular { (mirror, reach(mirror)) } else { (mean, own) };
    let radius_degrees = reach.to_degrees();
    // Projected, a cone that does not meet the horizon takes sin² of its radius times the cosine of its middle.
    let cap = reach.sin().powi(2) * middle.z.abs();
    if radius_degrees > WIDEST_CONE_DEGREES || seen.share(limit) < (1.0 - CONE_MISSED) * cap {
        return None;
    }
    Some(Pattern::Cone { middle, radius_degrees, specular: is_specular })
}

fn sector(points: &Directions) -> Option<Pattern> {
    let off_normal = points.iter().filter(|w| w.truncate().length() > ON_DEGREES.to_radians());
    let mut azimuths: Vec<f64> =
        off_normal.map(|w| w.y.atan2(w.x).to_degrees().rem_euclid(360.0)).collect();
    azimuths.sort_by(f64::total_cmp);
    let (&first, &last) = (azimuths.first()?, azimuths.last()?);
    let (mut widest, mut from, mut to) = (first + 360.0 - last, first, last);
    for pair in azimuths.windows(2) {
        if pair[1] - pair[0] > widest {
            (widest, from, to) = (pair[1] - pair[0], pair[1], pair[0] + 360.0);
        }
    }
    let sector = Pattern::Sector { from_degrees: from, to_degrees: to };
    (widest >= GAP_DEGREES).then_some(sector)
}

impl fmt::Display for Pattern {
    /// A noun with its figures, angles in degrees.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = |w: DVec3| {
            let (theta, phi) = to_degrees(w);
            let phi = phi.round().rem_euclid(360.0);
            if w.truncate().length() < ON_DEGREES.to_radians() {
                "the normal".to_owned()
            } else {
                format!("theta {theta:.0} phi {phi:.0}")
            }
        };
        match *self {
            Self::Direction { at } => write!(f, "one direction ({})", place(at)),
            Self::Few { directions } => write!(f, "{directions} directions"),
            Self::Plane { azimuth_degrees: a, tilt_degrees, both_sides, incident, .. } => {
                let which = if incident { ", that of incidence" } else { "" };
                let half = if both_sides { "one plane" } else { "half of one plane" };
                if tilt_degrees > 0.0 {
                    let tilt = format!("leaning {tilt_degrees:.0} degrees from the normal");
                    return write!(f, "{half} ({tilt} toward azimuth {a:.0}{which})");
                }
                let other = if both_sides {
                    format!("s {a:.0} and {:.0}", a + 180.0)
                } else {
                    format!(" {a:.0}")
                };
                write!(f, "{half} (azimuth{other}{which})")
            }
            Self::Ring { middle, radius_degrees } => {
                write!(f, "one ring ({radius_degrees:.0} degrees about {})", place(middle))
            }
            Self::Cone { middle, radius_degrees, specular } => {
                let which = if specular { "the specular direction, " } else { "" };
                write!(f, "a cone ({radius_degrees:.0} degrees about {which}{})", place(middle))
            }
            Self::Sector { from_degrees, to_degrees } => {
                let half = (160.0..=200.0).contains(&(to_degrees - from_degrees));
                let part = if half { "half the hemisphere" } else { "some azimuths" };
                write!(f, "{part} (azimuths {from_degrees:.0} to {to_degrees:.0})")
            }
            Self::Parts => f.write_str("parts of the hemisphere"),
            Self::Whole => f.write_str("the whole hemisphere"),
        }
    }
}
